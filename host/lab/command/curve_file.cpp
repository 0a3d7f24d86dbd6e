// SPDX-License-Identifier: MIT
#include "host/lab/command/curve_file.hpp"
#include "host/lab/command/settings.hpp"
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/units.hpp"

#include <sstream>

#include <fmt/format.h>

namespace dermis::cli {
namespace {

using fit::Test;

std::string trimmed(const std::string& text) { return scene::trimmed(text, " \t\r\""); }

// A line of a file, which its errors name.
struct Line {
    std::string path, text;
    int number = 0;

    [[noreturn]] void refuse(const std::string& what, const std::string& value, const std::string& allowed) const {
        throw Error(Error::Code::bad_input, what,
                    fmt::format("{}:{}: {} = {}; allowed: {}", path, number, what, value, allowed));
    }
    // Splits the line at its one comma.
    std::pair<std::string, std::string> columns() const {
        const size_t comma = text.find(',');
        if (comma == std::string::npos || text.find(',', comma + 1) != std::string::npos)
            refuse("line", "\"" + text + "\"", "two columns with one comma between them; decimals with a point");
        return {trimmed(text.substr(0, comma)), trimmed(text.substr(comma + 1))};
    }
    double number_of(const std::string& name, const std::string& word, const char* allowed) const {
        double x = 0;
        if (!read_number(std::string_view(word).substr(word[0] == '+'), x)) refuse(name, "\"" + word + "\"", allowed);
        return x;
    }
};

// Reads the names of the columns; returns the test and the second name.
std::pair<Test, std::string> read_names(const Line& line, const CurveOptions& options) {
    const auto [time, name] = line.columns();
    if (time != "time") line.refuse("first column", "\"" + time + "\"", "a line of names that begins with time");
    std::optional<Test> named;
    if (name == "modulus") named = Test::relaxation;
    else if (name == "compliance" || name == "strain") named = Test::creep;
    if (!named && !options.test)
        line.refuse("second column", "\"" + name + "\"",
                    "modulus (relaxation), compliance or strain (creep); any other name with --kind");
    const Test test = options.test.value_or(named.value_or(Test::creep));
    if (named.value_or(test) != test)
        line.refuse("second column", "\"" + name + "\"",
                    test == Test::creep ? "compliance or strain with --kind creep" : "modulus with --kind relaxation");
    if (name == "strain" && !options.stress)
        line.refuse("second column", "\"strain\"", "strain with --stress, the stress in Pa");
    if (options.stress && (test == Test::relaxation || name == "compliance"))
        line.refuse("second column", "\"" + name + "\"", "strain with --stress");
    return {test, name};
}

std::string content_of(const std::string& path) {
    std::string content;
    if (const std::string why = scene::read_file(path, content, 64 << 20); !why.empty())
        throw Error(Error::Code::bad_input, "data", path + ": " + why + "; allowed: a CSV file of at most 64 MiB");
    return content;
}

} // namespace

Curve read_curve(const std::string& path, const CurveOptions& options) {
    auto in = scene::throwing(std::istringstream(content_of(path)));
    Curve curve;
    std::string name;
    const char* allowed = options.residual == Residual::relative
                              ? "a finite number > 0; any finite number with --residual absolute"
                              : "a finite number";
    for (Line line{.path = path}; std::getline(in, line.text);) {
        if (++line.number == 1 && line.text.rfind("\xef\xbb\xbf", 0) == 0) line.text.erase(0, 3); // byte order mark
        line.text = trimmed(line.text);
        if (line.text.empty() || line.text[0] == '#') continue;
        if (name.empty()) {
            std::tie(curve.test, name) = read_names(line, options);
            continue;
        }
        const auto [time, value] = line.columns();
        curve.times.push_back(line.number_of("time", time, "a finite number >= 0"));
        curve.values.push_back(line.number_of(name, value, allowed));
        if (curve.times.back() < 0) line.refuse("time", time, "a finite number >= 0");
        if (options.residual == Residual::relative && curve.values.back() <= 0) line.refuse(name, value, allowed);
        if (options.stress) curve.values.back() /= *options.stress;
    }
    if (curve.times.empty())
        throw Error(Error::Code::bad_input, "data",
                    path +
                        ": holds no numbers; allowed: a line of names, as time,modulus, then two numbers in each line");
    return curve;
}

} // namespace dermis::cli
