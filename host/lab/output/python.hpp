// SPDX-License-Identifier: MIT
// Runs scripts by Python; draws pictures with its matplotlib.
#pragma once

#include "host/lab/output/output.hpp"

#include <string_view>

namespace dermis::output {

struct Python {
    std::string path, why_not; // path: empty if no Python has the modules; why_not: then what it said
};

// Returns a Python that has these modules, "a, b": the one of the environment that the command is installed in, else
// the one that the variable DERMIS_PYTHON names, else python3, or Debian's if python3 does not have them.
Python python_with(const std::string& modules);

// Runs a script with arguments and an input, in the folder /. Its output is the command's. Returns its exit status.
// Throws Error::io if it cannot be started.
int run(const Python&, std::string_view script, const std::vector<std::string>& arguments, std::string_view input);

// Runs a script that draws pictures of a folder's files. Its arguments are the folder and then `more`. Returns why
// there can be no pictures, as Python says it; empty: they are drawn. Throws Error::io if the script fails.
std::string draw(std::string_view script, const Path& folder, std::vector<std::string> more);

} // namespace dermis::output
