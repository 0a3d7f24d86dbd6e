// SPDX-License-Identifier: MIT
// The control groups of this process, and the cores that it may use.
#pragma once

#include <string>
#include <vector>

namespace dermis::simd {

// Returns the number of cores that the process may use, at least 1: the number that it may run on, or the number that
// its control groups grant it as time, rounded up, if that is smaller. It is found out at the first call.
int cores();

// Returns the folders of this process's control groups and of those around them, which may have files of a controller,
// as "cpu". In a container paths may be the host's: folders that do not exist limit nothing, and the root is its own
// group. root: "", or a folder in place of the system's root, with proc/self/cgroup and sys/fs/cgroup.
std::vector<std::string> control_groups(const std::string& controller, const std::string& root = "");
int cores_of_quota(const std::string& root); // by the control groups alone; 0: no limit is known

} // namespace dermis::simd
