// SPDX-License-Identifier: MIT
#define DERMIS_ISA plain
#define DERMIS_SUPPORTED true
#include "host/core/simd/isa.inl"
