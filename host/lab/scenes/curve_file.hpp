// SPDX-License-Identifier: MIT
// Measured curves of a material, from CSV files, and the chain of elements that describes them.
#pragma once

#include "dermis/fit.hpp"

#include <optional>

namespace dermis::scene {

struct Curve {
    enum class Kind { creep, relaxation, history } kind = Kind::creep;
    std::vector<double> times, values; // s; 1/Pa, Pa, or of a history the stress in Pa
    std::vector<double> strains;       // of a history
};

struct CurveOptions {
    std::optional<Curve::Kind> kind;  // default: told by the names of the columns
    std::optional<double> stress;     // Pa: the second column is the strain under this stress
    std::optional<Residual> residual; // default: relative, of a history absolute
};

inline Residual residual_of(Curve::Kind kind, const CurveOptions& options) {
    return options.residual.value_or(kind == Curve::Kind::history ? Residual::absolute : Residual::relative);
}

// The file: a line of names, time and one of modulus (relaxation), compliance or strain (creep), or time, strain and
// stress (a history); then a number for each in each line. Empty lines and lines that begin with # are skipped. Throws
// Error::bad_input, naming file, line and value.
Curve read_curve(const std::string& path, const CurveOptions&);

// Fits a chain to curves of one kind. n, residual: as of the functions of dermis/fit.hpp.
Fit fit_curves(const std::vector<Curve>&, int n, Residual);

} // namespace dermis::scene
