// SPDX-License-Identifier: MIT
#define DERMIS_SET avx2
#define DERMIS_HERE __builtin_cpu_supports("avx2")
#include "host/loops/loops.inl"
