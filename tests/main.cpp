// SPDX-License-Identifier: MIT
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <dlfcn.h>

// Validation layer 1.3.239 with synchronization validation leaks some 3 KB for each command buffer allocated, freed or
// not.
extern "C" const char* __lsan_default_suppressions() { return "leak:libVkLayer_khronos_validation.so\n"; }

// ThreadSanitizer sees nothing of drivers and layers, which are not built with it. lavapipe's compiler, LLVM, is set up
// by two threads at once. The validation layer frees in a thread of its own what it has made in a caller's, and the
// sanitizer does not see what it waits for.
extern "C" const char* __tsan_default_suppressions() {
    return "race:llvm::sys::DynamicLibrary\nrace:libVkLayer_khronos_validation.so\n";
}

int main(int argc, char** argv) {
    // The loader unloads drivers and layers with each instance; what their globals still point to would then count as
    // leaked. Kept loaded, a leak report is a leak of ours.
    for (const char* library : {"libvulkan_lvp.so", "libVkLayer_khronos_validation.so"})
        dlopen(library, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    return doctest::Context(argc, argv).run();
}
