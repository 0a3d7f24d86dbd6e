// SPDX-License-Identifier: MIT
#include "host/lab/scenes/curve_file.hpp"
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/table_file.hpp"

#include <algorithm>

namespace dermis::scene {
namespace {

using Columns = std::vector<std::string>; // the names of a file's columns

Columns read_names(const TableFile& line) {
    for (std::string_view name : line.words())
        if (name.find_first_of("([") != name.npos)
            line.refuse_line("names without units, as time,modulus: times in s, moduli and stresses in Pa, compliances "
                             "in 1/Pa, strains without a unit");
    if (line.words().size() != 3) line.need_columns(2);
    return {line.words().begin(), line.words().end()};
}

// Returns the kind of a curve by the names of its columns.
std::string kind_of(const TableFile& line, const Columns& names, const CurveOptions& options) {
    const std::string& name = names[1];
    const auto need = [&](bool right, const char* allowed) {
        if (!right) line.refuse("second column", name, allowed);
    };
    if (names[0] != "time") line.refuse("first column", names[0], "a line of names that begins with time");
    if (names.size() == 3) {
        if (name != "strain" || names[2] != "stress") line.refuse_line("time,strain,stress in three columns");
        need(!options.stress && !options.strain && options.kind.empty(),
             "two columns with --stress, --strain or --kind");
        return "history";
    }
    need(name != "force" && name != "load", "stress, which is force over area, in Pa, with --strain");
    const bool creeps = name == "compliance" || name == "strain", relaxes = name == "modulus" || name == "stress";
    const std::string kind = creeps ? "creep" : relaxes ? "relaxation" : options.kind;
    need(!kind.empty(), "modulus or stress (relaxation), compliance or strain (creep); any other name with --kind");
    need(options.kind.empty() || options.kind == kind,
         creeps ? "modulus or stress with --kind relaxation" : "compliance or strain with --kind creep");
    need(name != "strain" || options.stress, "strain with --stress, the stress in Pa");
    need(name != "stress" || options.strain, "stress with --strain, the strain that causes it");
    need(!options.stress || (kind == "creep" && name != "compliance"), "strain with --stress");
    need(!options.strain || (kind == "relaxation" && name != "modulus"), "stress with --strain");
    return kind;
}

void read_point(const TableFile& line, const Columns& names, const Curves& all, double divisor, Curve& curve) {
    const bool relative = all.residual == "relative", history = all.kind == "history";
    const char* allowed =
        relative ? "a finite number > 0; any finite number with --residual absolute" : "a finite number";
    line.need_columns(names.size());
    const char* of_time = history ? "a finite number" : "a finite number >= 0";
    const double time = line.number(0, "time", of_time), before = curve.times.empty() ? time : curve.times.back();
    curve.times.push_back(time);
    curve.strains.push_back(history ? line.number(1, "strain") : 0);
    const double value = line.number(names.size() - 1, names.back(), allowed);
    if (time < (history ? before : 0))
        line.refuse("time", line.words()[0], history ? "no time before the one before it" : of_time);
    if (relative && value <= 0) line.refuse(names.back(), line.words().back(), allowed);
    curve.values.push_back(value / divisor);
}

} // namespace

Curves read_curves(const std::vector<std::string>& paths, const CurveOptions& options) {
    if (options.stress) need_positive("stress", *options.stress);
    if (options.strain) need_positive("strain", *options.strain);
    if (paths.empty()) refuse("data", "no file", "at least one");
    const std::string kinds[] = {"", "creep", "relaxation"}, residuals[] = {"", "relative", "absolute"};
    if (!std::ranges::count(kinds, options.kind))
        refuse("kind", "\"" + options.kind + "\"", "\"creep\", \"relaxation\"");
    if (!std::ranges::count(residuals, options.residual))
        refuse("residual", "\"" + options.residual + "\"", "\"absolute\", \"relative\"");
    Curves all;
    for (const std::string& path : paths) {
        TableFile file(path, "", 64 << 20);
        Curve& curve = all.list.emplace_back();
        Columns names;
        if (file.next()) {
            names = read_names(file);
            const std::string kind = kind_of(file, names, options);
            if (all.list.size() > 1 && kind != all.kind)
                file.refuse_file("is a curve of " + kind + "; allowed: curves of one kind, and " + paths[0] +
                                 " is of " + all.kind);
            all.kind = kind;
            all.residual = !options.residual.empty() ? options.residual : kind == "history" ? "absolute" : "relative";
        }
        while (file.next()) read_point(file, names, all, options.stress.value_or(options.strain.value_or(1)), curve);
        if (curve.times.empty())
            file.refuse_file(
                "holds no numbers; allowed: a line of names, as time,modulus, then two numbers in each line");
    }
    return all;
}

} // namespace dermis::scene
