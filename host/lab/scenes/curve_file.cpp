// SPDX-License-Identifier: MIT
#include "host/lab/scenes/curve_file.hpp"
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/units.hpp"

#include <sstream>

namespace dermis::scene {
namespace {

using Kind = Curve::Kind;

std::string without_quotes(const std::string& text) { return trimmed(text, " \t\r\""); }

// A line of a file, which its errors name.
struct Line {
    std::string path, text;
    int number = 0;

    [[noreturn]] void refuse(const std::string& what, const std::string& value, const std::string& allowed) const {
        throw Error(Error::Code::bad_input, what,
                    path + ":" + std::to_string(number) + ": " + what + " = " + value + "; allowed: " + allowed);
    }
    // Splits the line at its commas. count: of columns; 0: two or three.
    std::vector<std::string> columns(size_t count) const {
        std::vector<std::string> parts;
        for (size_t at = 0; at != text.npos;) {
            const size_t comma = text.find(',', at);
            parts.push_back(without_quotes(text.substr(at, comma - at)));
            at = comma == text.npos ? comma : comma + 1;
        }
        const bool fits = count ? parts.size() == count : parts.size() == 2 || parts.size() == 3;
        if (!fits)
            refuse("line", "\"" + text + "\"",
                   count == 3 ? "three columns with commas between them; decimals with a point"
                              : "two columns with one comma between them; decimals with a point");
        return parts;
    }
    double number_of(const std::string& name, const std::string& word, const char* allowed) const {
        double x = 0;
        if (!read_number(std::string_view(word).substr(word[0] == '+'), x)) refuse(name, "\"" + word + "\"", allowed);
        return x;
    }
};

// Reads the names of the columns; returns the kind and the names.
std::pair<Kind, std::vector<std::string>> read_names(const Line& line, const CurveOptions& options) {
    const std::vector<std::string> names = line.columns(0);
    const std::string& name = names[1];
    const auto refuse_second = [&](const char* allowed) { line.refuse("second column", "\"" + name + "\"", allowed); };
    if (names[0] != "time")
        line.refuse("first column", "\"" + names[0] + "\"", "a line of names that begins with time");
    if (names.size() == 3) {
        if (name != "strain" || names[2] != "stress")
            line.refuse("line", "\"" + line.text + "\"", "time,strain,stress in three columns");
        if (options.stress || options.kind) refuse_second("two columns with --stress or --kind");
        return {Kind::history, names};
    }
    std::optional<Kind> named;
    if (name == "modulus") named = Kind::relaxation;
    else if (name == "compliance" || name == "strain") named = Kind::creep;
    if (!named && !options.kind)
        refuse_second("modulus (relaxation), compliance or strain (creep); any other name with --kind");
    const Kind kind = options.kind.value_or(named.value_or(Kind::creep));
    if (named.value_or(kind) != kind)
        refuse_second(kind == Kind::creep ? "compliance or strain with --kind creep"
                                          : "modulus with --kind relaxation");
    if (name == "strain" && !options.stress) refuse_second("strain with --stress, the stress in Pa");
    if (options.stress && (kind == Kind::relaxation || name == "compliance")) refuse_second("strain with --stress");
    return {kind, names};
}

std::string content_of(const std::string& path) {
    std::string content;
    if (const std::string why = read_file(path, content, 64 << 20); !why.empty())
        throw Error(Error::Code::bad_input, "data", path + ": " + why + "; allowed: a CSV file of at most 64 MiB");
    return content;
}

void read_point(const Line& line, const std::vector<std::string>& names, const CurveOptions& options, Curve& curve) {
    const bool relative = residual_of(curve.kind, options) == Residual::relative;
    const char* allowed =
        relative ? "a finite number > 0; any finite number with --residual absolute" : "a finite number";
    const std::vector<std::string> words = line.columns(names.size());
    const bool history = curve.kind == Kind::history;
    const char* of_time = history ? "a finite number" : "a finite number >= 0";
    curve.times.push_back(line.number_of("time", words[0], of_time));
    if (history) curve.strains.push_back(line.number_of("strain", words[1], "a finite number"));
    curve.values.push_back(line.number_of(names.back(), words.back(), allowed));
    if (!history && curve.times.back() < 0) line.refuse("time", words[0], of_time);
    if (relative && curve.values.back() <= 0) line.refuse(names.back(), words.back(), allowed);
    if (options.stress) curve.values.back() /= *options.stress;
}

} // namespace

Curve read_curve(const std::string& path, const CurveOptions& options) {
    auto in = throwing(std::istringstream(content_of(path)));
    Curve curve;
    std::vector<std::string> names;
    for (Line line{.path = path}; std::getline(in, line.text);) {
        if (++line.number == 1 && line.text.rfind("\xef\xbb\xbf", 0) == 0) line.text.erase(0, 3); // byte order mark
        line.text = without_quotes(line.text);
        if (line.text.empty() || line.text[0] == '#') continue;
        if (names.empty()) std::tie(curve.kind, names) = read_names(line, options);
        else read_point(line, names, options, curve);
    }
    if (curve.times.empty())
        throw Error(Error::Code::bad_input, "data",
                    path +
                        ": holds no numbers; allowed: a line of names, as time,modulus, then two numbers in each line");
    return curve;
}

Fit fit_curves(const std::vector<Curve>& curves, int n, Residual residual) {
    const Kind kind = curves[0].kind;
    if (kind == Kind::history) {
        std::vector<History> histories;
        for (const Curve& c : curves) histories.push_back({c.times, c.strains, c.values});
        return fit_histories(histories, n, residual);
    }
    Curve all = curves[0];
    for (size_t i = 1; i < curves.size(); ++i) {
        all.times.insert(all.times.end(), curves[i].times.begin(), curves[i].times.end());
        all.values.insert(all.values.end(), curves[i].values.begin(), curves[i].values.end());
    }
    return (kind == Kind::creep ? fit_creep : fit_relaxation)(all.times, all.values, n, residual);
}

} // namespace dermis::scene
