// SPDX-License-Identifier: MIT
// Preloaded before the programs, writes down who throws: each distinct stack of a thrown exception, as one line of
// offsets in the program, the innermost first, in the folder $DERMIS_THROWS. Nothing is allocated, because allocations
// may be what fails; each process has a file of its own, named after its program, because files may not be allowed to
// grow.
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <typeinfo>

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <unistd.h>
#include <unwind.h>

namespace {

constexpr int depth = 16;
uintptr_t first = 0, end = 0; // addresses of the program; none where nothing is written down
std::atomic<uint64_t> seen[1 << 16];

struct Stack {
    uintptr_t frames[depth];
    int size = 0;
};

_Unwind_Reason_Code add(_Unwind_Context* context, void* stack_) {
    Stack& stack = *static_cast<Stack*>(stack_);
    const uintptr_t at = _Unwind_GetIP(context);
    if (at >= first && at < end) stack.frames[stack.size++] = at - 1 - first; // within the call, not behind it
    return stack.size == depth ? _URC_END_OF_STACK : _URC_NO_REASON;
}

bool is_new(const Stack& stack) {
    uint64_t hash = 14695981039346656037u;
    for (int i = 0; i < stack.size; ++i) hash = (hash ^ stack.frames[i]) * 1099511628211u;
    for (uint64_t i = hash % std::size(seen), n = 0; n < std::size(seen); i = (i + 1) % std::size(seen), ++n) {
        uint64_t before = 0;
        if (seen[i].compare_exchange_strong(before, hash)) return true;
        if (before == hash) return false;
    }
    return true;
}

int opened() {
    char path[4096];
    std::snprintf(path, sizeof path, "%s/%s.%d", std::getenv("DERMIS_THROWS"), program_invocation_short_name,
                  ::getpid());
    return ::open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
}

void write_down(const char* type) {
    if (first == end) return;
    const int error = errno;
    static const int file = opened();
    Stack stack;
    _Unwind_Backtrace(add, &stack);
    if (stack.size && is_new(stack)) {
        char line[depth * 18 + 40];
        int length = std::snprintf(line, 40, "%.32s ", type);
        for (int i = 0; i < stack.size; ++i)
            length +=
                std::snprintf(line + length, sizeof line - size_t(length), "%lx ", (unsigned long)(stack.frames[i]));
        line[length++] = '\n';
        [[maybe_unused]] const ssize_t n = ::write(file, line, size_t(length)); // less where the test allows no more
    }
    errno = error;
}

[[gnu::constructor]] void begin() {
    const bool ours = std::strncmp(program_invocation_short_name, "dermis", 6) == 0 ||
                      std::strncmp(program_invocation_short_name, "c_", 2) == 0;
    if (!ours || !std::getenv("DERMIS_THROWS")) return;
    dl_iterate_phdr(
        [](dl_phdr_info* program, size_t, void*) {
            first = program->dlpi_addr;
            for (int i = 0; i < program->dlpi_phnum; ++i)
                if (const auto& part = program->dlpi_phdr[i]; part.p_type == PT_LOAD)
                    end = first + part.p_vaddr + part.p_memsz;
            return 1; // the program is the first
        },
        nullptr);
}

} // namespace

extern "C" {
[[noreturn]] void __cxa_throw(void* object, std::type_info* type, void (*destroy)(void*)) {
    using Throw = void (*)(void*, std::type_info*, void (*)(void*));
    static const auto real = reinterpret_cast<Throw>(dlsym(RTLD_NEXT, "__cxa_throw"));
    write_down(type->name());
    real(object, type, destroy);
    std::abort();
}
[[noreturn]] void __cxa_rethrow() {
    static const auto real = reinterpret_cast<void (*)()>(dlsym(RTLD_NEXT, "__cxa_rethrow"));
    write_down("rethrown");
    real();
    std::abort();
}
}
