// SPDX-License-Identifier: MIT
#include "host/core/base/cores.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <thread>

#ifdef __linux__
#include <sched.h>
#endif

namespace dermis::simd {
namespace {

// The number of cores that a quota per period is, both in microseconds. 0: no limit, which version 1 of control groups
// writes as -1 and version 2 as "max".
int cores_of(double quota, double period) {
    if (!(quota > 0 && period > 0)) return 0;
    return int(std::clamp(std::ceil(quota / period), 1.0, 1e6));
}

// The limit of one control group, in cores; 0: none. group: its folder.
int cores_of_group(const std::string& group) {
    double quota = 0, period = 0;
    if (std::ifstream max(group + "/cpu.max"); max >> quota >> period) return cores_of(quota, period);
    std::ifstream(group + "/cpu.cfs_quota_us") >> quota;
    std::ifstream(group + "/cpu.cfs_period_us") >> period;
    return cores_of(quota, period);
}

int fewer(int a, int b) { return a == 0 || b == 0 ? std::max(a, b) : std::min(a, b); }

} // namespace

std::vector<std::string> control_groups(const std::string& controller, const std::string& root) {
    std::ifstream groups(root + "/proc/self/cgroup");
    std::vector<std::string> folders;
    for (std::string line; std::getline(groups, line);) { // "4:cpu,cpuacct:/path" of version 1, "0::/path" of 2
        const size_t first = line.find(':'), second = line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string listed = line.substr(first + 1, second - first - 1);
        if (!listed.empty() && ("," + listed + ",").find("," + controller + ",") == std::string::npos) continue;
        for (const std::string& name : {listed, listed.empty() ? "unified" : controller})
            for (std::string path = line.substr(second + 1);; path.erase(path.rfind('/'))) {
                folders.push_back(root + "/sys/fs/cgroup/" + name + path);
                if (path.find('/') == std::string::npos) break;
            }
    }
    return folders;
}

int cores_of_quota(const std::string& root) {
    int least = 0;
    for (const std::string& group : control_groups("cpu", root)) least = fewer(least, cores_of_group(group));
    return least;
}

int cores() {
    static const int count = [] {
        int affine = int(std::thread::hardware_concurrency());
#ifdef __linux__
        if (cpu_set_t set; sched_getaffinity(0, sizeof set, &set) == 0) affine = CPU_COUNT(&set);
#endif
        return std::max(fewer(affine, cores_of_quota("")), 1);
    }();
    return count;
}

} // namespace dermis::simd
