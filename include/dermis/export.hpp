// SPDX-License-Identifier: MIT
// What a shared library shows of itself; everything else is hidden.
#pragma once

#ifdef __GNUC__
#define DERMIS_API __attribute__((visibility("default")))
#else
#define DERMIS_API
#endif
