/* SPDX-License-Identifier: MIT */
/* Preloaded before a program, makes one of its allocations fail, by malloc and what C and C++ build on it.
   DERMIS_ALLOCATION: how many succeed before; with + behind it all later ones fail too.
   DERMIS_ALLOCATIONS_FILE: where the number of allocations is written at the end. */
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);

static long before = -1, start; /* start: allocations before the program's own */
static int sticky;
static atomic_long count;

__attribute__((constructor)) static void begin(void) {
    start = count;
    const char* text = getenv("DERMIS_ALLOCATION");
    if (!text) return;
    before = start + atol(text);
    sticky = strchr(text, '+') != NULL;
}

__attribute__((destructor)) static void end(void) {
    const char* path = getenv("DERMIS_ALLOCATIONS_FILE");
    if (!path) return;
    char text[32];
    const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0644),
              length = snprintf(text, sizeof text, "%ld\n", count - start);
    if (write(file, text, (size_t)length) != length) abort();
    close(file);
}

static int fails(void) {
    const long number = atomic_fetch_add(&count, 1);
    if (before < 0 || number < before || (number > before && !sticky)) return 0;
    errno = ENOMEM;
    return 1;
}

void* malloc(size_t bytes) { return fails() ? NULL : __libc_malloc(bytes); }
void* calloc(size_t n, size_t bytes) { return fails() ? NULL : __libc_calloc(n, bytes); }
void* realloc(void* old, size_t bytes) { return fails() ? NULL : __libc_realloc(old, bytes); }
void* aligned_alloc(size_t alignment, size_t bytes) { return fails() ? NULL : __libc_memalign(alignment, bytes); }
int posix_memalign(void** memory, size_t alignment, size_t bytes) {
    if (fails()) return ENOMEM;
    *memory = __libc_memalign(alignment, bytes);
    return *memory ? 0 : ENOMEM;
}
