// SPDX-License-Identifier: MIT
#define DERMIS_SET plain
#define DERMIS_HERE true
#include "host/loops/loops.inl"
