// SPDX-License-Identifier: MIT
// Words of scenes: numbers with a unit, as "20 kPa", in the places where a scene has numbers; and which of the known
// words somebody meant who misspelt one.
#pragma once

#include "dermis/description.hpp"

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dermis::scene {

// Returns a text without the blanks around it.
inline std::string trimmed(const std::string& text, const char* blanks = " ") {
    const size_t first = text.find_first_not_of(blanks);
    return first == text.npos ? "" : text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

// Returns a number's text without the + before it.
inline std::string_view without_plus(std::string_view text) {
    return text.substr(text.starts_with('+') && !text.starts_with("+-"));
}

// Reads the number that a text begins with, as std::from_chars does, which libc++ has for double from LLVM 20 on.
std::from_chars_result leading_number(std::string_view text, double& value);

// Reads a finite number, without blanks around it. Returns false where the text is something else.
bool read_number(std::string_view text, double& value);

// Whether a text begins as a number does.
bool begins_as_number(const std::string& text);
// Whether numbers may have this unit with them, as "Pa" and unlike "cells".
bool can_be_in(std::string_view unit);
// Returns the number in a unit: the double nearest to the decimal number, as 0.005 for "5 ms" in "s". Nothing if the
// text is something else, or its unit is another one, or no number can have this unit with it.
std::optional<double> number_in_unit(std::string_view unit, const std::string& text);
// What a number in a unit takes, in words.
std::string allowed_in_unit(std::string_view unit);
constexpr char whole_or_length[] = "whole cells, or a length with its unit, as \"3 mm\"";
constexpr char allowed_unit[] = // of a recording
    "what 1 in the file is, as unit = \"kPa\", \"12 Pa\" for counts of 12 Pa, \"-12 Pa\" for counts that fall with "
    "pressure, \"mN\" for the forces of taxels in a grid with spacing; with load.control = \"depth\" as \"mm\"";
// Returns the cell of a row or a column that has a place, m from its beginning; of a place between two cells, the one
// behind it. nearest_cells: how many cells a length has, rounded. Nothing where that is no int. The grid has a spacing.
std::optional<int> cell_at(double place, const Grid&);
std::optional<int> nearest_cells(double length, const Grid&);
// Returns of_length() of a length with its unit. Throws Error::bad_input for another text, with the value as it is
// shown.
int cells_of(const std::string& text, const std::string& parameter, const std::string& shown, const Grid&,
             std::optional<int> (*of_length)(double, const Grid&));
// Returns the unit of a key, by its dotted name, in which places in lists do not count, as in load[1].radius; empty if
// it has none. A length without a spacing has none either.
std::string unit_of_key(const std::string& key);

// Returns the known word at the least edit distance: letters left out, added, replaced, or two neighbours swapped, in
// either case. Near is one edit for every three letters, or one in a shorter word; empty if no word is near.
std::string nearest(const std::string& word, const std::vector<std::string>& known);

// Returns "; did you mean KNOWN?", or nothing if no known word is near.
std::string suggestion(const std::string& word, const std::vector<std::string>& known);

} // namespace dermis::scene
