// SPDX-License-Identifier: MIT
#define DERMIS_ISA avx512
#define DERMIS_SUPPORTED                                                                                               \
    __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")
#include "host/core/simd/isa.inl"
