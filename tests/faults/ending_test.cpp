// SPDX-License-Identifier: MIT
// labels: device command
// The end of a process that still has skins on a Vulkan device. The driver compiles each kernel anew, because a warm
// cache hides what a compiler does when its static objects are gone.
#include "tests/support.hpp"

#include <sys/wait.h>

using namespace test;

namespace {

// Returns what wait() says of the program. One that hangs is ended, which fails the test.
int ends(const std::string& way) {
    return std::system(("MESA_SHADER_CACHE_DISABLE=true timeout -k 1 300 " DERMIS_ENDING " " + way).c_str());
}

} // namespace

TEST_CASE("a program ends well with a Vulkan skin that is static, made before or after its device, pressed or not") {
    for (const char* way : {"global", "local", "late", "unpressed", "twice", "exit"})
        for (int i = 0; i < 3; ++i) CHECK_MESSAGE(ends(way) == 0, way);
}

TEST_CASE("a skin works as long as the process lasts, after the library's static objects have ended too") {
    CHECK(ends("later") == 0);
}

TEST_CASE("a program ends well while a thread opens a device, makes a skin, or presses and reads it") {
    for (const char* way : {"thread2", "thread3", "thread4", "thread5"})
        for (int i = 0; i < 5; ++i) CHECK_MESSAGE(ends(way) == 0, way);
}

TEST_CASE(
    "a program ends well out of the progress of a run, and as the child of a fork with the parent's skin or its own") {
    for (const char* way : {"progress", "forked", "own"})
        for (int i = 0; i < 3; ++i) CHECK_MESSAGE(ends(way) == 0, way);
}
