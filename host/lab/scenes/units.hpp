// SPDX-License-Identifier: MIT
// Recognises numbers that were written with a unit, where a scene file wants plain numbers.
#pragma once

#include <optional>
#include <string>

namespace dermis::scene {

// Returns what is allowed for a key in place of a text that begins with a number, as in "100 kPa": a plain number in
// the key's unit, and which one where that can be told. Nothing if the text begins with anything else.
std::optional<std::string> plain_number(const std::string& parameter, const std::string& text);

} // namespace dermis::scene
