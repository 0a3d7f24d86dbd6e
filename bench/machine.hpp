// SPDX-License-Identifier: MIT
// The machine that a table is measured on, and the compiler that built the program.
#pragma once

#include <string>

namespace bench {

struct Machine {
    std::string cpu; // model, family and stepping, as the system tells them
    int cores = 0;
    std::string compiler;
};
Machine this_machine();

} // namespace bench
