// SPDX-License-Identifier: MIT
// DERMIS_API marks the symbols that a shared library exports; all others are hidden.
#pragma once

#ifdef __GNUC__
#define DERMIS_API __attribute__((visibility("default")))
#else
#define DERMIS_API
#endif
