// SPDX-License-Identifier: MIT
// volk under names of our own; the only way in which this library reaches Vulkan.
#pragma once

#include "volk_names.h"

#include <volk.h>
