// SPDX-License-Identifier: MIT
// The values of --set: key=value, with several values for a sweep.
#pragma once

#include <string>
#include <vector>

namespace dermis::cli {

// Repeats --set before each key=value that follows another one, so that one --set takes several keys.
std::vector<std::string> with_each_set(const std::vector<std::string>& words);

struct Setting {
    std::string key;
    std::vector<std::string> values; // at least one
};

// Reads key=value,value .. of each override. A value is a number, a text, a list in brackets, or a range
// first:last:count, which is `count` numbers at equal distances with both ends. Throws Error::bad_input.
std::vector<Setting> settings_of(const std::vector<std::string>& overrides);

// Returns the overrides of each run: every combination of the values; the last key varies fastest.
std::vector<std::vector<std::string>> combinations(const std::vector<Setting>&);

} // namespace dermis::cli
