// SPDX-License-Identifier: MIT
// DERMIS_API marks the symbols that a shared library exports; all others are hidden. DERMIS_HIDDEN hides a member of an
// exported class.
#pragma once

#ifdef __GNUC__
#define DERMIS_API __attribute__((visibility("default")))
#define DERMIS_HIDDEN __attribute__((visibility("hidden")))
#else
#define DERMIS_API
#define DERMIS_HIDDEN
#endif
