// SPDX-License-Identifier: MIT
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <dlfcn.h>

int main(int argc, char** argv) {
    // The loader unloads drivers and layers with each instance; what their globals still point to would then count as
    // leaked. Kept loaded, a leak report is a leak of ours.
    for (const char* library : {"libvulkan_lvp.so", "libVkLayer_khronos_validation.so"})
        dlopen(library, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    return doctest::Context(argc, argv).run();
}
