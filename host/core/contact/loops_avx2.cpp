// SPDX-License-Identifier: MIT
#define DERMIS_LOOPS avx2_loops
#include "host/core/contact/loops.inl"
