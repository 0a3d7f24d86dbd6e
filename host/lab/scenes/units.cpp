// SPDX-License-Identifier: MIT
#include "host/lab/scenes/units.hpp"

#include "host/core/base/text.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace dermis::scene {
namespace {

struct KeyUnit {
    std::string_view keys, unit; // keys: each between blanks, without their tables
};
constexpr KeyUnit key_units[] = {
    {" modulus spring intensity ", "Pa"},
    {" viscosity dashpot ", "Pa s"},
    {" spacing ridge_period relief thickness curvature_length ", "m"},
    {" step duration start rise length period times interval sa2_adaptation at ", "s"},
    {" frequency ", "Hz"},
    {" phase ", "rad"},
};

struct Prefix {
    std::string_view text;
    int exponent;
};
constexpr Prefix prefixes[] = {{"", 0},   {"G", 9},         {"M", 6},         {"k", 3}, {"c", -2}, {"m", -3},
                               {"u", -6}, {"\xc2\xb5", -6}, {"\xce\xbc", -6}, {"n", -9}}; // both signs for micro

// Returns the unit of a key, or nothing.
std::string_view unit_of(const std::string& parameter) {
    const std::string key = " " + parameter.substr(parameter.rfind('.') + 1) + " ";
    for (const KeyUnit& k : key_units)
        if (k.keys.find(key) != k.keys.npos) return k.unit;
    return {};
}

// Removes blanks and the signs of a product, so that "Pa s", "Pa*s" and "Pa.s" are one; the last sign is the raised
// dot.
std::string joined(std::string_view unit) {
    std::string text(unit);
    for (std::string_view sign : {" ", "*", ".", "\xc2\xb7"})
        for (size_t at; (at = text.find(sign)) != text.npos;) text.erase(at, sign.size());
    return text;
}

// Returns the power of ten of a prefix with which `text` is `unit`; nothing if it is another unit.
std::optional<int> exponent_of(const std::string& text, std::string_view unit) {
    for (const Prefix& p : prefixes)
        if (text == std::string(p.text) + joined(unit)) return p.exponent;
    return {};
}

} // namespace

std::optional<std::string> plain_number(const std::string& parameter, const std::string& text) {
    const size_t first = text.find_first_not_of(' ');
    if (first == text.npos || std::string_view("+-.0123456789").find(text[first]) == std::string_view::npos) return {};
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data() + first + (text[first] == '+'), end, value);
    if (error != std::errc()) return {};
    const std::string_view unit = unit_of(parameter);
    const std::string wanted = "a plain number" + (unit.empty() ? "" : " in " + std::string(unit));
    const std::string given = joined(std::string_view(rest, size_t(end - rest)));
    if (given.empty()) return wanted + ", without quotes: " + shortest(value);
    const std::optional<int> exponent = unit.empty() ? std::nullopt : exponent_of(given, unit);
    if (!exponent) return wanted;
    const double power = std::pow(10.0, std::abs(*exponent)); // exact, so that 60 um is 6e-05
    const double plain = *exponent < 0 ? value / power : value * power;
    const bool whole = plain == std::floor(plain) && std::abs(plain) < 1e15; // 100000 is plainer than 1e+05
    return wanted + ": " + (whole ? std::to_string(static_cast<long long>(plain)) : shortest(plain));
}

} // namespace dermis::scene
