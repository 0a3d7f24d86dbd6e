// SPDX-License-Identifier: MIT
// The answers of the command as JSON. Programs read them.
#pragma once

#include "dermis/dermis.hpp"
#include "host/lab/march/self_test.hpp"

#include <string>
#include <vector>

namespace dermis::cli {

// Elements of a list, in brackets, each on a line.
std::string json_list(const std::vector<std::string>& items);

// A plan. overrides: the keys that are set, one by one.
std::string json_of(const Scene&, const std::vector<std::string>& overrides, const Explanation&);
std::string json_of(const DeviceInfo&);
// The bits of a device's kernels, beside the CPU path's.
std::string json_of(const DeviceInfo&, const std::vector<SelfTest::Kernel>&);

} // namespace dermis::cli
