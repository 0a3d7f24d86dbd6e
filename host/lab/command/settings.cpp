// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

#include "dermis/dermis.hpp"
#include "host/lab/scenes/units.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

#include <fmt/format.h>

namespace dermis::cli {
namespace {

constexpr size_t most_runs = 100000;

[[noreturn]] void refuse(const std::string& override_, const std::string& allowed) {
    throw Error(Error::Code::bad_input, "--set", fmt::format("--set {}; allowed: {}", override_, allowed));
}

bool is_assignment(const std::string& word) {
    const size_t equals = word.find('=');
    return equals != std::string::npos && equals > 0 && word[0] != '-' &&
           std::all_of(word.begin(), word.begin() + std::ptrdiff_t(equals),
                       [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '.' || c == '-' || c == ' '; });
}

// Splits at each `separator` that stands in no brackets and no quotes.
std::vector<std::string> split(const std::string& override_, const std::string& text, char separator) {
    std::vector<std::string> parts(1);
    int depth = 0;
    char quote = 0;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quote) {
            if (c == '\\' && quote == '"' && i + 1 < text.size()) parts.back() += text[i++];
            else if (c == quote) quote = 0;
        } else if (c == '"' || c == '\'') quote = c;
        else if (c == '[' || c == '{') ++depth;
        else if (c == ']' || c == '}') --depth;
        if (c == separator && depth == 0 && !quote) parts.emplace_back();
        else parts.back() += text[i];
    }
    if (depth != 0 || quote) refuse(override_, "brackets and quotes that are closed");
    return parts;
}

// A whole number is written without a fraction or exponent, so that keys of whole numbers take it.
std::string number_text(double x) {
    return x == std::floor(x) && std::abs(x) < 1e15 ? fmt::format("{:.0f}", x) : fmt::format("{}", x);
}

// Appends the numbers of a range, or the value as it stands.
void append_values(const std::string& override_, const std::string& value, std::vector<std::string>& values) {
    std::vector<std::string> parts = split(override_, value, ':');
    const bool logarithmic = parts.size() > 1 && parts.back() == "log";
    if (logarithmic) parts.pop_back();
    std::vector<double> numbers(parts.size());
    bool range = parts.size() > 1 || logarithmic;
    for (size_t i = 0; i < parts.size(); ++i) range = range && scene::read_number(parts[i], numbers[i]);
    if (!range) return values.push_back(value);
    const double count = numbers.back();
    if (parts.size() != 3 || count != std::floor(count) || count < 2 || count > double(most_runs))
        refuse(override_, fmt::format("first:last:count as a range, with a whole count in 2..{}", most_runs));
    const double first = numbers[0], last = numbers[1], steps = count - 1;
    if (logarithmic && !(first > 0 && last > 0)) refuse(override_, "first:last:count:log with first and last > 0");
    for (double i = 0; i <= steps; ++i) {
        const double share = i / steps;
        const double inside = logarithmic ? first * std::pow(last / first, share) : first + (last - first) * i / steps;
        values.push_back(number_text(i == steps ? last : i == 0 ? first : inside));
    }
}

} // namespace

std::vector<std::string> with_each_set(const std::vector<std::string>& words) {
    std::vector<std::string> all;
    bool after_set = false;
    for (const std::string& word : words) {
        const bool value = !all.empty() && all.back() == "--set";
        if (after_set && !value && is_assignment(word)) all.push_back("--set");
        after_set = word == "--set" || word.rfind("--set=", 0) == 0 || (after_set && is_assignment(word));
        all.push_back(word);
    }
    return all;
}

std::vector<Setting> settings_of(const std::vector<std::string>& overrides) {
    std::vector<Setting> all;
    for (const std::string& o : overrides) {
        const size_t equals = o.find('=');
        if (equals == std::string::npos || equals == 0) refuse(o, "key=value, as in time.step=0.001");
        Setting setting{.key = o.substr(0, equals), .values = {}};
        setting.key.erase(std::remove(setting.key.begin(), setting.key.end(), ' '), setting.key.end());
        if (std::ranges::any_of(all, [&](const Setting& other) { return other.key == setting.key; }))
            refuse(o, fmt::format("{} once; several values are {}=a,b", setting.key, setting.key));
        for (const std::string& value : split(o, o.substr(equals + 1), ',')) {
            if (value.find_first_not_of(' ') == value.npos)
                refuse(o, "a value after = and after each comma; a text without letters is \"\"");
            append_values(o, value, setting.values);
        }
        all.push_back(std::move(setting));
    }
    return all;
}

std::vector<std::vector<std::string>> combinations(const std::vector<Setting>& settings) {
    size_t runs = 1;
    for (const Setting& s : settings)
        if ((runs *= s.values.size()) > most_runs)
            refuse(s.key + "=..", fmt::format("at most {} runs in all combinations", most_runs));
    std::vector<std::vector<std::string>> all(runs);
    for (size_t run = 0, each = runs; run < runs; ++run, each = runs)
        for (const Setting& s : settings)
            all[run].push_back(s.key + "=" + s.values[run / (each /= s.values.size()) % s.values.size()]);
    return all;
}

} // namespace dermis::cli
