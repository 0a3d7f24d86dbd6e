// SPDX-License-Identifier: MIT
// DERMIS_API marks the symbols that a shared library exports; all others are hidden. DERMIS_HIDDEN hides a member of an
// exported class. On Windows nothing is marked: link the library statically.
#pragma once

#if defined(__GNUC__) && !defined(_WIN32)
#define DERMIS_API __attribute__((visibility("default")))
#define DERMIS_HIDDEN __attribute__((visibility("hidden")))
#else
#define DERMIS_API
#define DERMIS_HIDDEN
#endif
