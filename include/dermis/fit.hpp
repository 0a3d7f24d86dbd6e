// SPDX-License-Identifier: MIT
// Chains of Kelvin-Voigt elements from measured curves. This header is the manual.
//
//     E(t) = equilibrium + sum moduli_k*e^(-t/times_k)        relaxation: stress per strain after a step of strain
//     J(t) = sum (1 - e^(-t*modulus_k/viscosity_k))/modulus_k   creep: strain per stress after a step of stress;
//            the term of a spring is 1/modulus_k, the term of a dashpot t/viscosity_k
//
// A relaxation and a chain describe the same material, but relaxation times are shorter than retardation times
// viscosity_k/modulus_k. Functions throw Error::bad_input.
#pragma once

#include <dermis/description.hpp>

#include <string>
#include <vector>

namespace dermis {

// The generalized Maxwell model: what papers call a Prony series.
struct Relaxation {
    std::vector<double> moduli, times; // Pa, s; > 0; equally many, 0..7; moduli of equal times are added up
    double equilibrium = 0;            // Pa, >= 0; > 0 where there are no times
};

// Returns the chain with this relaxation: a spring, then elements by ascending retardation time, then, if the
// equilibrium is 0, a dashpot. The numbers are exact up to a few roundings of the last digit.
DERMIS_API std::vector<KelvinVoigt> chain_of(const Relaxation&);

// Returns the relaxation of a chain of 1 to 8 elements, times ascending. A chain without a spring is refused: a step of
// strain takes an infinite stress.
DERMIS_API Relaxation relaxation_of(const std::vector<KelvinVoigt>&);

// A fit minimizes the mean square of this difference between curve and data.
enum class Residual {
    relative, // relative to each value; for curves over decades, and errors in percent
    absolute  // relative to the greatest value
};

struct Fit {
    // At most n: a spring, elements by ascending retardation time, a dashpot; spring and dashpot where the data need
    // them.
    std::vector<KelvinVoigt> elements;
    // The error of the logarithm of each number of the elements; 0 where the number is 0. In some 95 of 100 data sets
    // the true number is within a factor of exp(2*error). With many points it is the standard error; with few points
    // Student's quantile widens it, down to one point more than there are numbers. From few points with much noise
    // `undetermined` is seldom empty; where it is, the factor holds less often (in 85 of 100 data sets with one point
    // more than numbers and 1 % of noise). Data are taken to be exact to 1e-7 at best.
    std::vector<KelvinVoigt> errors;
    double residual = 0;       // root mean square of the residual; 0.01 is 1 %
    std::vector<double> model; // the curve at the times of the data, in their order, in the unit of the data
    std::string choice;        // of fits with n = 0: why there are so many elements, in a sentence; else empty
    // Sentences about what the data leave open: a curve that falls as no creep does, or rises as no relaxation does,
    // elements that they cannot tell apart or do not need, numbers that they fix to a factor of 2 or worse. Empty if
    // all is determined.
    std::vector<std::string> undetermined;
};

// Fits a chain to a measured curve. n: its elements at most, 1..8; 0: as few as describe the data, at most 8: each must
// lower the residual by more than noise would, by the Bayesian information criterion, and by more than a twentieth.
// times in s, >= 0, in any order; compliances in 1/Pa or moduli in Pa, > 0, or any finite numbers with
// Residual::absolute. At least 2*n + 1 points, and 3 with n = 0. Several curves of one material may follow one another.
// The search covers retardation or relaxation times from a tenth of the shortest time to ten times the longest.
// Elements that add nothing, or less than 1e-7 of each value, are left out. With more than 10,000 points, points at
// times that agree to 0.1 % are replaced by their mean for the fit, which changes a curve by less than 1e-7; residual
// and errors count all points.
DERMIS_API Fit fit_creep(const std::vector<double>& times, const std::vector<double>& compliances, int n = 0,
                         Residual = Residual::relative);
DERMIS_API Fit fit_relaxation(const std::vector<double>& times, const std::vector<double>& moduli, int n = 0,
                              Residual = Residual::relative);

// The stress that a strain of any course causes. times: s, in ascending order; two that are equal are a step of the
// strain. strains: of the material at rest until the first time, and along lines from one time to the next. stresses:
// Pa. All are finite, and equally many.
struct History {
    std::vector<double> times, strains, stresses;
};
// Fits a chain to one or several histories at once: the stress of each is the hereditary integral of its strain, in
// closed form. The search covers relaxation times from a tenth of the shortest step in time to ten times the longest
// history. n as above; at least 2*n + 1 points, and at most 20,000, in all histories. Fit::model is the stress, of one
// history after another.
DERMIS_API Fit fit_histories(const std::vector<History>&, int n = 0, Residual = Residual::absolute);

} // namespace dermis
