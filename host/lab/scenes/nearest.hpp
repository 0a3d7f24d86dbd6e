// SPDX-License-Identifier: MIT
// Guesses which of the known words somebody meant who misspelt one.
#pragma once

#include <string>
#include <vector>

namespace dermis::scene {

// Returns the known word at the least edit distance: letters left out, added, replaced, or two neighbours swapped, in
// either case. Near is one edit for every three letters, or one in a shorter word; empty if no word is near.
std::string nearest(const std::string& word, const std::vector<std::string>& known);

// Returns "; did you mean KNOWN?", or nothing if no known word is near.
std::string suggestion(const std::string& word, const std::vector<std::string>& known);

} // namespace dermis::scene
