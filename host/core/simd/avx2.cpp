// SPDX-License-Identifier: MIT
#define DERMIS_ISA avx2
#define DERMIS_SUPPORTED __builtin_cpu_supports("avx2")
#include "host/core/simd/isa.inl"
