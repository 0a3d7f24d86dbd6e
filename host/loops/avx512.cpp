// SPDX-License-Identifier: MIT
#define DERMIS_SET avx512
#define DERMIS_HERE                                                                                                    \
    __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")
#include "host/loops/loops.inl"
