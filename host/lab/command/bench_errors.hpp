// SPDX-License-Identifier: MIT
// dermis bench --errors: what each way to compute a scene takes, and how far it is off.
#pragma once

#include <string>

namespace dermis::cli {

// Runs the scene by every candidate of its plan, and by every other method at its step, a half and a quarter of it.
// Writes errors.csv and errors.png into a folder. device: of the candidates on Vulkan, beside the CPU's;
// "cpu": none. Returns whether no error is above its bound.
bool bench_errors(const std::string& scene, const std::string& out, const std::string& device);

} // namespace dermis::cli
