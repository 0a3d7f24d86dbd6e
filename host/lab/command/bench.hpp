// SPDX-License-Identifier: MIT
// dermis bench: how long a press of a scene's skin takes on this machine.
#pragma once

#include <string>

namespace dermis::cli {

// Presses `pads` pads of the scene's skin on one thread of the CPU path and on all threads, and on a Vulkan device if
// Device::open(device) gives one, each for a quarter of a second. Prints the times of a press and their shares of the
// scene's step.
int bench_scene(const std::string& path, int pads, const std::string& device);

// The time of a clock that runs evenly, s.
double seconds_now();

} // namespace dermis::cli
