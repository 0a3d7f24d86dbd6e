// SPDX-License-Identifier: MIT
// The parts of a fit: the measured curve, the spectrum that is sought, and what the data say about it.
#pragma once

#include "dermis/fit.hpp"
#include "host/lab/fit/least_squares.hpp"

namespace dermis::fit {

// The tests of a viscoelastic material: a step of stress, a step of strain, a strain of any course.
enum class Test { creep, relaxation, history };

// A measured curve; a residual is weight*(model - value).
struct Problem {
    Test test;
    std::vector<double> times, values, weights;
    size_t points;      // number of measured points; several may stand here as one
    double scatter = 0; // sum of the squared residuals of measured points around the point that replaces them
    std::vector<double> strains = {}; // of histories: at the times
    std::vector<size_t> starts = {};  // of histories: the point that begins each
};

// Returns a problem of more than `most_points` with fewer points: points at times that agree to 0.1 % become one, with
// the weight of all of them. A smaller problem is returned as it is.
constexpr size_t most_points = 10000;
Problem condensed(Problem);

// Relative residuals below this count as rounding of the data.
constexpr double exact_data = 1e-7;

// Returns the curve of a chain at these times, after a step.
std::vector<double> curve_of(Test, const std::vector<KelvinVoigt>&, const std::vector<double>& times);
// Returns what a chain answers at the points of a problem.
std::vector<double> model_of(const Problem&, const std::vector<KelvinVoigt>&);

// The stress of a spring and a dashpot in series, of modulus 1 and this relaxation time, under the strains of
// histories: at the time t the integral of e^(-(t - s)/time) over the changes of the strain at all times s before t.
// slopes: the derivative by the logarithm of the relaxation time.
struct Hereditary {
    std::vector<double> values, slopes;
};
Hereditary hereditary(const Problem&, double time);

// The curve constant + ramp*t + sum of amplitude*(1 - e^(-t/time)), or in relaxation amplitude*e^(-t/time).
struct Spectrum {
    bool constant = false, ramp = false; // whether these terms are there
    std::vector<double> log_times;
    std::vector<double> amplitudes; // >= 0: of constant and ramp if they are there, then of the times
    double squares = 0;             // sum of the squared residuals

    size_t first_time() const { return size_t(constant) + size_t(ramp); } // its index in `amplitudes`
    size_t parameters() const { return amplitudes.size() + log_times.size(); }
};

// Times to begin the search at, with the triangle of constant, ramp, exponentials of all these times, and values: a
// small problem with the least squares of the whole.
struct StartTimes {
    std::vector<double> log_times;
    Matrix triangle;
};
StartTimes start_times_of(const Problem&);

// Returns the best spectra of chains of at most 1, 2 .. n elements: none has a greater residual than one before it.
std::vector<Spectrum> best_spectra(const Problem&, const StartTimes&, int n);

// Weighs the residual of a spectrum against its number of parameters (Bayesian information criterion); less is better.
double information(const Problem&, const Spectrum&, size_t parameters);

// A number with three digits, for sentences.
std::string shown(double);

// Student's quantile for 95 %: a normal deviate over an estimate of its standard deviation is within +- this in 95 of
// 100 cases. freedom: the estimate's degrees of freedom, >= 1.
double students_quantile(size_t freedom);

// Fills in Fit::errors, and describes what stays undetermined.
void judge(const Problem&, Fit&);

} // namespace dermis::fit
