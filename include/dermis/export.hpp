// SPDX-License-Identifier: MIT
// DERMIS_API marks the symbols that a shared library exports; all others are hidden. DERMIS_HIDDEN hides a member of an
// exported class. A Windows DLL is built with DERMIS_MAKES_DLL; a static library there needs no mark.
#pragma once

#if defined(__GNUC__) && !defined(_WIN32)
#define DERMIS_API __attribute__((visibility("default")))
#define DERMIS_HIDDEN __attribute__((visibility("hidden")))
#else
#ifdef DERMIS_MAKES_DLL
#define DERMIS_API __declspec(dllexport)
#else
#define DERMIS_API
#endif
#define DERMIS_HIDDEN
#endif
