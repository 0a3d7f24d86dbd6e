// SPDX-License-Identifier: MIT
// Measured curves of a material, from CSV files.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dermis::scene {

// Each member may be empty: kind, "creep" or "relaxation", is then told by the names of the columns; residual,
// "relative" or "absolute", is relative, of histories absolute.
struct CurveOptions {
    std::string kind, residual;
    std::optional<double> stress; // Pa, > 0: the second column is the strain under this stress
    std::optional<double> strain; // > 0: the second column is the stress, in Pa, under this strain
};

struct Curve {
    std::vector<double> times, strains, values; // s; 0 unless it is a history; 1/Pa, Pa, or of a history the stress
};
struct Curves {
    std::string kind, residual; // kind: "creep", "relaxation" or "history"
    std::vector<Curve> list;
};

// Reads files of one kind, at least one. A file has a line of names: time and one of modulus (relaxation), stress
// (relaxation, with `strain`), compliance (creep) or strain (creep, with `stress`), or with `kind` another name; or
// time, strain and stress (a history). Then follows a number for each in each line. Empty lines and lines that begin
// with # are skipped. Throws Error::bad_input, naming file, line and value.
Curves read_curves(const std::vector<std::string>& paths, const CurveOptions&);

} // namespace dermis::scene
