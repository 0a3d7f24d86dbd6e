// SPDX-License-Identifier: MIT
// What `dermis check` compares beside the kernels: whole runs.
#pragma once

#include "host/lab/march/self_test.hpp"

#include <dermis/device.hpp>

namespace dermis::cli {

// Compares receptors of a surface, and below it, under a sliding texture with those of one thread of the CPU path.
SelfTest::Kernel touch(const Device&);

} // namespace dermis::cli
