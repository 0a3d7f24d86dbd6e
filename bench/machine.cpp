// SPDX-License-Identifier: MIT
#include "bench/machine.hpp"

#include <algorithm>
#include <fstream>
#include <thread>

#include <sys/utsname.h>

namespace bench {
namespace {

// Returns the text after the colon of the first line of the file that begins with `name`; empty if there is none.
std::string value_of(const char* file, const std::string& name) {
    std::ifstream lines(file);
    for (std::string line; std::getline(lines, line);) {
        const size_t colon = line.find(':');
        if (colon == std::string::npos || line.substr(0, line.find_last_not_of(" \t", colon - 1) + 1) != name) continue;
        const size_t begin = line.find_first_not_of(" \t", colon + 1);
        return begin == std::string::npos ? "" : line.substr(begin);
    }
    return "";
}

// A virtual machine may call every generation of a processor by one name, so that the numbers stand beside it.
std::string cpu_model() {
    const char* file = "/proc/cpuinfo";
    std::string model;
    for (const char* name : {"model name", "cpu family", "model", "stepping", "CPU implementer", "CPU part"}) {
        const std::string value = value_of(file, name);
        if (value.empty()) continue;
        model += (model.empty() ? "" : " ") + (name == std::string("model name") ? value : name + (" " + value));
    }
    if (!model.empty()) return model;
    utsname system{};
    return uname(&system) == 0 ? system.machine : "unknown";
}

} // namespace

Machine this_machine() {
#ifdef __clang__
    const char* compiler = "Clang " __clang_version__;
#else
    const char* compiler = "GCC " __VERSION__;
#endif
    return {cpu_model(), std::max(int(std::thread::hardware_concurrency()), 1), compiler};
}

} // namespace bench
