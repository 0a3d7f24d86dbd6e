// SPDX-License-Identifier: MIT
// Numbers with a unit, as "20 kPa", in the places where a scene has numbers.
#pragma once

#include <optional>
#include <string>

namespace dermis::scene {

// Whether a text begins as a number does.
bool begins_as_number(const std::string& text);
// Returns the number in the key's unit: the double nearest to the decimal number, as 0.005 for "5 ms". Nothing if the
// text is something else, or its unit is not the key's, or the key has no unit.
std::optional<double> number_with_unit(const std::string& parameter, const std::string& text);
// What a key of numbers takes, in words.
std::string allowed_number(const std::string& parameter);

} // namespace dermis::scene
