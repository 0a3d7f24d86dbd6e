// SPDX-License-Identifier: MIT
// A search for scenes whose bound is below their error: scenes are changed at random, and a change is kept if it lowers
// the bound over the error.
#pragma once

#include "tests/oracle/survey.hpp"

namespace oracle {

// A model and a precision, and the scene in which its bound is nearest to its error.
struct Found {
    dermis::Model model{};
    dermis::Precision precision{};
    double ratio = HUGE_VAL; // of bound to error
    Case scene;
    unsigned seed = 0; // of the climb
    long long scenes = 0;
};

// Climbs from random scenes for so many seconds on all threads. A seed makes the same climbs again, as many as the time
// allows.
std::vector<Found> search(double seconds, unsigned seed);

// The bound of a scene over its error; infinite where it is refused, or has no error.
double ratio_of(Case);
// Makes a scene simpler as long as its bound stays below its error.
Case shrunk(Case);

} // namespace oracle
