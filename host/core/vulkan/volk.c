/* SPDX-License-Identifier: MIT */
/* volk, compiled into the library under names of our own (see volk.cmake). */
#include "volk_names.h"

#define VOLK_IMPLEMENTATION
#include <volk.h>
