// SPDX-License-Identifier: MIT
#pragma once

#include "host/cli/output.hpp"

namespace dermis::cli {

// The published study, whole: returns the exit status.
int study(const Path& out);

} // namespace dermis::cli
