// SPDX-License-Identifier: MIT
// The list of keys as texts, for help, units, Python and the page of keys.
#pragma once

#include <string>
#include <vector>

namespace dermis::scene {

struct KeyRow {
    std::string table, name;                     // "load." and "radius"; the table is empty for the top of a file
    std::string unit, by_default, allowed, says; // empty: none
    std::string type;                            // in Python
};

// Every key of a scene file, table by table.
const std::vector<KeyRow>& key_rows();

} // namespace dermis::scene
