// SPDX-License-Identifier: MIT
// Preloaded before Python, lets a test fail each operator new of a thread in turn. Python itself allocates without it.
#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

thread_local long before = -1; // allocations that succeed before one fails; -1: none fails
thread_local bool sticky = false, struck = false;

void* allocate(std::size_t bytes, std::size_t alignment) {
    if (before == 0) {
        struck = true;
        if (!sticky) before = -1;
        throw std::bad_alloc();
    }
    if (before > 0) --before;
    void* memory = nullptr;
    if (posix_memalign(&memory, alignment, bytes ? bytes : 1) != 0) throw std::bad_alloc();
    return memory;
}

} // namespace

// all_later: whether all later allocations fail too.
extern "C" void fail_after(long allocations, int all_later) {
    before = allocations;
    sticky = all_later != 0;
    struck = false;
}

// Lets all allocations succeed again, and returns whether one has failed.
extern "C" int end_of_failing() {
    before = -1;
    return struck;
}

void* operator new(std::size_t bytes) { return allocate(bytes, alignof(std::max_align_t)); }
void* operator new[](std::size_t bytes) { return allocate(bytes, alignof(std::max_align_t)); }
void* operator new(std::size_t bytes, std::align_val_t alignment) { return allocate(bytes, std::size_t(alignment)); }
void* operator new[](std::size_t bytes, std::align_val_t alignment) { return allocate(bytes, std::size_t(alignment)); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
