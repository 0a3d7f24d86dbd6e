// SPDX-License-Identifier: MIT
#include "tests/allocations.hpp"

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <new>

namespace {

std::atomic<size_t> count{0};
thread_local test::FailingAllocation* failing = nullptr;
thread_local bool in_driver = false;
thread_local long left = 0;

} // namespace

size_t test::allocations() { return count; }

long test::allocations_left() { return left; }

test::FailingAllocation::FailingAllocation(long before, bool sticky) : before_(before), sticky_(sticky) {
    failing = this;
}

test::FailingAllocation::~FailingAllocation() { failing = nullptr; }

bool test::FailingAllocation::strikes() {
    if (struck_) return sticky_;
    if (before_-- > 0) return false;
    return struck_ = true;
}

test::InDriver::InDriver() : before_(in_driver) { in_driver = true; }

test::InDriver::~InDriver() { in_driver = before_; }

// A sanitizer's own stay: it matches them with their deletes, and by their callers it knows what leaks elsewhere. There
// nothing is counted, and nothing fails.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
bool test::allocations_fail() { return false; }
#else
bool test::allocations_fail() { return true; }

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
void __libc_free(void*);
}

namespace {

bool fails() {
    if (!failing || in_driver || !failing->strikes()) return false;
    errno = ENOMEM;
    return true;
}

void* counted(void* memory) {
    left += memory && !in_driver;
    return memory;
}

void* new_memory(size_t bytes, size_t alignment) {
    ++count;
    void* p = fails() ? nullptr : counted(__libc_memalign(alignment, bytes ? bytes : 1));
    if (!p) throw std::bad_alloc();
    return p;
}

} // namespace

extern "C" {
void* malloc(size_t bytes) { return fails() ? nullptr : counted(__libc_malloc(bytes)); }
void* calloc(size_t n, size_t bytes) { return fails() ? nullptr : counted(__libc_calloc(n, bytes)); }
void* realloc(void* old, size_t bytes) {
    if (fails()) return nullptr;
    left += !old && !in_driver;
    return __libc_realloc(old, bytes);
}
void* aligned_alloc(size_t alignment, size_t bytes) {
    return fails() ? nullptr : counted(__libc_memalign(alignment, bytes));
}
int posix_memalign(void** memory, size_t alignment, size_t bytes) {
    if (fails()) return ENOMEM;
    *memory = counted(__libc_memalign(alignment, bytes));
    return *memory ? 0 : ENOMEM;
}
void free(void* memory) {
    left -= memory && !in_driver;
    __libc_free(memory);
}
}

void* operator new(size_t bytes) { return new_memory(bytes, __STDCPP_DEFAULT_NEW_ALIGNMENT__); }
void* operator new(size_t bytes, std::align_val_t alignment) { return new_memory(bytes, size_t(alignment)); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, size_t, std::align_val_t) noexcept { std::free(p); }
#endif
