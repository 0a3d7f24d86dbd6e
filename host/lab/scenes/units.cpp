// SPDX-License-Identifier: MIT
#include "host/lab/scenes/units.hpp"

#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/key_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace dermis::scene {
namespace {

struct Example {
    std::string_view unit, text;
};
constexpr Example examples[] = {{"Pa", "20 kPa"},   {"Pa s", "3 kPa s"}, {"m", "0.4 mm"},    {"s", "5 ms"},
                                {"Hz", "0.25 kHz"}, {"rad", "0.5 rad"},  {"m/s", "40 mm/s"}, {"N", "5 mN"}};

struct Prefix {
    std::string_view text;
    int exponent;
};
constexpr Prefix prefixes[] = {{"", 0},   {"G", 9},         {"M", 6},         {"k", 3}, {"c", -2}, {"m", -3},
                               {"u", -6}, {"\xc2\xb5", -6}, {"\xce\xbc", -6}, {"n", -9}}; // both signs for micro

const Example* example_of(std::string_view unit) {
    const auto* found = std::ranges::find(examples, unit, &Example::unit);
    return found == std::end(examples) ? nullptr : found;
}

// Returns a unit with one blank for each sign of a product, so that "Pa s", "Pa*s" and "Pa.s" are one; the last sign is
// the raised dot.
std::string with_blanks(std::string text) {
    for (std::string_view sign : {"\xc2\xb7", "*", "."})
        for (size_t at; (at = text.find(sign)) != text.npos;) text.replace(at, sign.size(), " ");
    for (size_t at; (at = text.find("  ")) != text.npos;) text.erase(at, 1);
    return trimmed(text);
}

// Returns the power of ten of a prefix with which `text` is `unit`; nothing if it is another unit.
std::optional<int> exponent_of(const std::string& text, std::string_view unit) {
    for (const Prefix& p : prefixes)
        if (text == std::string(p.text) + std::string(unit)) return p.exponent;
    return {};
}

std::optional<int> whole(double cells) {
    if (!(std::abs(cells) <= 1e9)) return {};
    return int(cells);
}

} // namespace

std::from_chars_result leading_number(std::string_view text, double& value) {
    return std::from_chars(text.data(), text.data() + text.size(), value);
}

bool read_number(std::string_view text, double& value) {
    const auto [end, error] = leading_number(text, value);
    return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

bool begins_as_number(const std::string& text) {
    const size_t first = text.find_first_not_of(' ');
    return first != text.npos && std::string_view("+-.0123456789").find(text[first]) != std::string_view::npos;
}

bool can_be_in(std::string_view unit) { return example_of(unit) != nullptr; }

std::optional<double> number_in_unit(std::string_view of, const std::string& text) {
    const std::string all = trimmed(text);
    const std::string_view signless = without_plus(all);
    const char *const first = signless.data(), *const last = first + signless.size();
    double value = 0;
    const auto [unit, wrong] = leading_number(signless, value);
    const std::optional<int> power = exponent_of(with_blanks({unit, last}), of);
    if (!can_be_in(of) || wrong != std::errc() || unit == last || !std::isfinite(value) || !power) return {};
    // The prefix joins the decimal exponent, so that the number is rounded once.
    const std::string number = std::string(first, unit) + "e0"; // the exponent of a number without one
    const size_t e = number.find_first_of("eE");                // 0 may have one that is beyond a long
    const long written = std::clamp(std::strtol(number.c_str() + e + 1, nullptr, 10), -1000000000L, 1000000000L);
    const std::string shifted = number.substr(0, e) + "e" + std::to_string(written + *power);
    return read_number(shifted, value) ? std::optional(value) : std::nullopt;
}

// The quotient is rounded: without this a border could fall into the cell before it.
std::optional<int> cell_at(double place, const Grid& grid) {
    const double cells = place / *grid.spacing;
    return whole(std::floor(cells + 1e-9 * std::max(1.0, std::abs(cells))));
}

std::optional<int> nearest_cells(double length, const Grid& grid) { return whole(std::round(length / *grid.spacing)); }

int cells_of(const std::string& text, const std::string& parameter, const std::string& shown, const Grid& grid,
             std::optional<int> (*of_length)(double, const Grid&)) {
    const std::optional<double> length = number_in_unit("m", text);
    const std::optional<int> cells = length && grid.spacing ? of_length(*length, grid) : std::nullopt;
    if (!cells)
        refuse(parameter, shown, length && !grid.spacing ? "whole cells: the grid has no spacing" : whole_or_length);
    return *cells;
}

std::string unit_of_key(const std::string& parameter) {
    std::string key; // without the places in lists
    for (size_t at = 0, end; at < parameter.size(); at = end == parameter.npos ? end : parameter.find(']', end) + 1)
        end = parameter.find('[', at), key += parameter.substr(at, end - at);
    const auto& rows = key_rows();
    const auto row = std::ranges::find_if(rows, [&](const KeyRow& r) { return r.table + r.name == key; });
    return row == rows.end() ? "" : row->unit;
}

std::string allowed_in_unit(std::string_view unit) {
    const Example* example = example_of(unit);
    if (!example) return "a number";
    return "a number in " + std::string(unit) + ", or with its unit, as \"" + std::string(example->text) + "\"";
}

} // namespace dermis::scene
