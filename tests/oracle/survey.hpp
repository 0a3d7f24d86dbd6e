// SPDX-License-Identifier: MIT
// Runs random scenes and compares what was promised with what is true.
#pragma once

#include "tests/oracle/family.hpp"

#include <map>
#include <string>

namespace oracle {

// The outcome of one scene. Without a tolerance it is accepted.
struct Verdict {
    bool accepted = false;
    bool free = false; // the scene asks for the exact method, for no precision and for a tolerance from 1e-9 on
    double tolerance = 0, predicted = 0, attainable = 0;
    Distance measured; // of the run, or where it was refused of a run in f64 without a tolerance
    dermis::Model model{};
    dermis::Precision precision{};
    bool spread = false;     // to receptors at depths, whose bound is that of all depths and grids
    bool unmeasured = false; // it is accepted, and Result::measured_error is NaN
    std::string failure;     // an error that is not about the tolerance, or a run that is not what was asked for

    bool kept() const { return measured.value <= tolerance; }
    bool below_prediction() const { return measured.value <= predicted; }
};
Verdict judge(const Case&);

// One line: the promise, the truth and the scene.
std::string text(const Verdict&, const dermis::Scene&);

struct Survey {
    int scenes = 0, accepted = 0, kept = 0, below_prediction = 0;
    int refused = 0, free = 0, refused_free = 0, unmeasured = 0;
    std::vector<std::string> broken, exceeded, wrongly_refused, failed;
    std::map<std::string, std::vector<double>> ratios; // of prediction to measurement, where it is not 0, by arithmetic

    void take(const Verdict&, const std::string& line);
    double median_ratio() const;       // of all but those that spread
    std::string median_ratios() const; // of each arithmetic
    std::string summary() const;
};
// Scenes that once broke a promise: those in a folder, each with its maps in a folder of its own.
Survey survey(const std::filesystem::path& found);
// The scenes of the seeds first .. first + count - 1.
Survey survey(unsigned first, int count, Case (Family::*next)() = &Family::next);

} // namespace oracle
