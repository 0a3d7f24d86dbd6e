// SPDX-License-Identifier: MIT
#include "host/lab/scenes/units.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string_view>

namespace dermis::scene {
namespace {

struct KeyUnit {
    std::string_view keys; // each between blanks, without their tables
    std::string_view unit, example;
};
constexpr KeyUnit key_units[] = {
    {" modulus moduli equilibrium spring intensity ", "Pa", "20 kPa"},
    {" viscosity dashpot ", "Pa s", "3 kPa s"},
    {" spacing ridge_period relief thickness curvature_length contact_length wavelength ball_radius depth ", "m",
     "0.4 mm"},
    {" step duration start rise until fall length period times interval sa2_adaptation at time_constants rate "
     "membrane_time refractory_time time ",
     "s", "5 ms"},
    {" frequency sampling_rate ", "Hz", "0.25 kHz"},
    {" phase phases direction ", "rad", "0.5 rad"},
    {" velocity ", "m/s", "40 mm/s"},
    {" force ", "N", "5 mN"},
};

struct Prefix {
    std::string_view text;
    int exponent;
};
constexpr Prefix prefixes[] = {{"", 0},   {"G", 9},         {"M", 6},         {"k", 3}, {"c", -2}, {"m", -3},
                               {"u", -6}, {"\xc2\xb5", -6}, {"\xce\xbc", -6}, {"n", -9}}; // both signs for micro

const KeyUnit* unit_of(const std::string& parameter) {
    for (size_t end = parameter.size(); end != parameter.npos;) { // the key, else the table it is in
        const size_t dot = parameter.rfind('.', end - 1);
        const std::string key = " " + parameter.substr(dot + 1, end - dot - 1) + " ";
        for (const KeyUnit& k : key_units)
            if (k.keys.find(key) != k.keys.npos) return &k;
        end = dot;
    }
    return nullptr;
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

} // namespace

bool read_number(std::string_view text, double& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

bool begins_as_number(const std::string& text) {
    const size_t first = text.find_first_not_of(' ');
    return first != text.npos && std::string_view("+-.0123456789").find(text[first]) != std::string_view::npos;
}

std::optional<double> number_with_unit(const std::string& parameter, const std::string& text) {
    const KeyUnit* key = unit_of(parameter);
    if (!key || !begins_as_number(text)) return {};
    const size_t unit = text.find_first_not_of("+-.0123456789eE", text.find_first_not_of(' '));
    if (unit == text.npos) return {};
    const std::optional<int> power = exponent_of(with_blanks(text.substr(unit)), key->unit);
    if (!power) return {};
    // The prefix joins the decimal exponent, so that the number is rounded once.
    const std::string number(without_plus(trimmed(text.substr(0, unit))));
    const size_t e = number.find_first_of("eE");
    const long written = e == number.npos ? 0 : std::strtol(number.c_str() + e + 1, nullptr, 10);
    const std::string shifted = number.substr(0, e) + "e" + std::to_string(written + *power);
    double value = 0;
    const char* const end = shifted.data() + shifted.size();
    const auto [rest, error] = std::from_chars(shifted.data(), end, value);
    if (error != std::errc() || rest != end) return {};
    return value;
}

namespace {

std::optional<int> whole(double cells) {
    if (!(std::abs(cells) <= 1e9)) return {};
    return int(cells);
}

} // namespace

// The quotient is rounded: without this a border could fall into the cell before it.
std::optional<int> cell_at(double place, const Grid& grid) {
    const double cells = place / *grid.spacing;
    return whole(std::floor(cells + 1e-9 * std::max(1.0, std::abs(cells))));
}

std::optional<int> nearest_cells(double length, const Grid& grid) { return whole(std::round(length / *grid.spacing)); }

std::string unit_of_key(const std::string& key) {
    const KeyUnit* of = unit_of(key);
    return std::string(of ? of->unit : "");
}

std::string allowed_number(const std::string& parameter) {
    const KeyUnit* key = unit_of(parameter);
    if (!key) return "a number";
    return "a number in " + std::string(key->unit) + ", or with its unit, as \"" + std::string(key->example) + "\"";
}

} // namespace dermis::scene
