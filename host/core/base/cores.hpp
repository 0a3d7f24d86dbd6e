// SPDX-License-Identifier: MIT
// The cores that this process may use.
#pragma once

#include <string>

namespace dermis::simd {

// Returns the number of cores that the process may use, at least 1: the number that it may run on, or the number that
// its control groups grant it as time, rounded up, if that is smaller. It is found out at the first call.
int cores();

// Returns the number of cores that the control groups of this process grant it as time, rounded up, at least 1; 0: no
// limit is known. root: "", or a folder in place of the system's root, with proc/self/cgroup and sys/fs/cgroup, of
// version 1, 2 or both.
int cores_of_quota(const std::string& root);

} // namespace dermis::simd
