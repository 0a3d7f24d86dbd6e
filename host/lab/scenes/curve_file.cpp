// SPDX-License-Identifier: MIT
#include "host/lab/scenes/curve_file.hpp"
#include "host/lab/scenes/table_file.hpp"

#include <tuple>

namespace dermis::scene {
namespace {

using Kind = Curve::Kind;

// Reads the names of the columns; returns the kind and the names.
std::pair<Kind, std::vector<std::string>> read_names(const TableFile& line, const CurveOptions& options) {
    if (line.words().size() != 3) line.need_columns(2);
    const std::vector<std::string> names(line.words().begin(), line.words().end());
    const std::string& name = names[1];
    const auto refuse_second = [&](const char* allowed) { line.refuse("second column", name, allowed); };
    if (names[0] != "time") line.refuse("first column", names[0], "a line of names that begins with time");
    if (names.size() == 3) {
        if (name != "strain" || names[2] != "stress") line.refuse_line("time,strain,stress in three columns");
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

void read_point(const TableFile& line, const std::vector<std::string>& names, const CurveOptions& options,
                Curve& curve) {
    const bool relative = residual_of(curve.kind, options) == Residual::relative;
    const char* allowed =
        relative ? "a finite number > 0; any finite number with --residual absolute" : "a finite number";
    line.need_columns(names.size());
    const bool history = curve.kind == Kind::history;
    const char* of_time = history ? "a finite number" : "a finite number >= 0";
    curve.times.push_back(line.number(0, "time", of_time));
    if (history) curve.strains.push_back(line.number(1, "strain"));
    curve.values.push_back(line.number(names.size() - 1, names.back(), allowed));
    if (!history && curve.times.back() < 0) line.refuse("time", line.words()[0], of_time);
    if (relative && curve.values.back() <= 0) line.refuse(names.back(), line.words().back(), allowed);
    if (options.stress) curve.values.back() /= *options.stress;
}

} // namespace

Curve read_curve(const std::string& path, const CurveOptions& options) {
    TableFile file(path, "", 64 << 20);
    Curve curve;
    std::vector<std::string> names;
    if (file.next()) std::tie(curve.kind, names) = read_names(file, options);
    while (file.next()) read_point(file, names, options, curve);
    if (curve.times.empty())
        file.refuse_file("holds no numbers; allowed: a line of names, as time,modulus, then two numbers in each line");
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
