// SPDX-License-Identifier: MIT
// Draws pictures with Python's matplotlib.
#pragma once

#include "host/lab/output/output.hpp"

#include <string_view>

namespace dermis::output {

// Runs a Python script that draws pictures of a folder's files. Its arguments are the folder and then `more`. Returns
// why there can be no pictures, as Python says it; empty: they are drawn. Throws Error::io if the script fails.
std::string draw(std::string_view script, const Path& folder, const std::vector<std::string>& more);

} // namespace dermis::output
