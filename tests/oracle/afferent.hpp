// SPDX-License-Identifier: MIT
// When an afferent fires, from the definition alone (dermis/afferents.hpp) and in many bits; and random afferents.
//
// Between events the model is linear with constant coefficients, so all that it moves is given by Taylor series over
// cells of at most its shortest time constant. Events are roots of these series: the least root in a cell is isolated
// by Descartes' rule of signs in the Bernstein basis, which also finds two roots however close, and refined by Newton's
// method between bounds.
#pragma once

#include "tests/oracle/real.hpp"

#include <dermis/afferents.hpp>

#include <vector>

namespace oracle {

// What acts at a receptor that has been at rest until t = 0:
//     q = polygon + amplitude*(sin(2*pi*frequency*t + phase) - sin(phase))
// The polygon runs from 0 at t = 0 to values[0] at times[0], from there to the next value, and holds the last one.
struct AfferentInput {
    std::vector<double> times, values; // as many of each; times in s, ascending, the first one > 0
    double amplitude = 0;              // of the sine
    double frequency = 1;              // Hz, > 0
    double phase = 0;                  // radians
};

// The times of all spikes up to `seconds` of a fibre whose V is 0 at t = 0, in s, in numbers of `bits` bits. cell: the
// length of a cell over the shortest time constant, at most 1; it changes no more than the last bits. Leaves Real::bits
// at `bits`.
std::vector<Real> spikes(const dermis::AfferentModel&, const AfferentInput&, double seconds, long bits = 160,
                         double cell = 1);
// The same of a fibre with an ending for each input.
std::vector<Real> spikes(const dermis::AfferentModel&, const std::vector<AfferentInput>&, double seconds,
                         long bits = 160, double cell = 1);

struct AfferentCase {
    dermis::AfferentModel model;
    AfferentInput input;
    double seconds;
};
// A random fibre and what acts on it, the same for the same seed. The greatest drive I is about 0.5 to 6, and more
// than 9 of 10 fibres fire. Leaves Real::bits at 64.
AfferentCase afferent_case(unsigned seed);

} // namespace oracle
