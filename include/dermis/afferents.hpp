// SPDX-License-Identifier: MIT
// Afferents, nerve fibres of the skin, which turn what acts at their endings into spikes. Part of dermis.hpp.
//
//     w = s*(value*q + sensitivity*rate*q')   q: the strain at the ending, or the stress over the modulus at rest
//     y = F(w)                              F: a low-pass of 1 to 3 poles, whose gain is 1 at frequency 0
//     I = sum over j = 0, 1, 2 of  gains[j][0]*max(y_j, 0) + gains[j][1]*max(-y_j, 0)       y_j: the j-th derivative
//     membrane_time*V' = -V + I + after     V = 1: a spike; then V = reset for refractory_time
//
// s differs among the afferents: it is e^(spread*n), with a standard normal number n that is drawn by a seed. An
// afferent with several endings has such a q, y and V for each of them. It fires when the first V reaches 1, and a
// spike sets the V of all endings back. In a Skin an s*q beyond 1e12 counts as 1e12.
//
// Between frames q runs along a line, for which the filter is exact at the end of a step. A spike's time is the time at
// which V of this continuous model reaches 1: to about 1 us in a Skin; in a scene to 1e-10 s where q runs along lines,
// as at viscosity 0, else to about 1e-5 s, because lines stand in for q (kernels/NUMERICS.md, "Spikes").
#pragma once

#include <dermis/description.hpp>

namespace dermis {

// A current that a spike starts: amplitude*exp(-t/time), t seconds after the spike. The next spike starts it anew.
struct AfterCurrent {
    double amplitude = 0; // any finite number; negative: the next spike is harder to trigger
    double time = 1;      // s, > 0
};

// How afferents of one kind turn q into spikes. The filter F has a real pole for each time constant, 1/(1 + s*time),
// and, if a frequency f is given, the pair 1/(1 + s/(Q*w) + (s/w)^2) with w = 2*pi*f and Q = quality: 1 to 3 poles.
struct AfferentModel {
    std::vector<double> time_constants; // s, > 0
    std::optional<double> frequency;    // Hz, > 0
    std::optional<double> quality;      // > 0; only with a frequency, which needs it
    double value = 1;                   // of q; any finite number
    double rate = 0;                    // of q', s; any finite number
    // Gains of y (a number), y' (s) and y'' (s2), each for positive and for negative values; finite. A derivative whose
    // order is the number of poles or greater has gains of 0.
    std::array<std::array<double, 2>, 3> gains = {{{1, 0}, {0, 0}, {0, 0}}};
    double membrane_time = 0;   // s, > 0
    double refractory_time = 0; // s, > 0
    double reset = 0;           // < 1
    std::array<AfterCurrent, 2> after;
    // A factor of the rate, > 0, at most 1e6: how much smaller a change may be than for the median afferent. And the
    // standard deviation of the natural logarithm of s among the afferents, 0 to 5. 0: all are alike.
    double sensitivity = 1, spread = 0;
};

// The parameters of a class, fitted to published thresholds and rates (bench/evidence/afferents.csv): sa1, fa1 (called
// RA in monkeys) and fa2 (PC). The sensitivity is that of the afferents whose thresholds for vibrations were measured,
// with which gentle presses make afferents fire; 1 gives the median afferent of a study of rates. Throws
// Error::bad_input for any other quantity.
DERMIS_API AfferentModel afferent_model(Quantity);

// Afferents of one class, each with one ending or with several that follow each other in the list. Afferents are
// numbered in the order given, from 0 on, through all entries of a list.
struct Afferents {
    Quantity type = Quantity::sa1;      // sa1, sa2, fa1 or fa2
    std::optional<AfferentModel> model; // default: afferent_model(type); SA2 has none
    // The cells of the endings, inside the grid; in a Skin with sites and without depths, cells of these sites. Empty:
    // the description's sites of this class, of which there is one at least; `endings` above 1 then needs a radius.
    std::vector<Cell> cells;
    // What q is: the strain of the cell, or its pressure divided by the modulus at which the material comes to rest, as
    // Receptors::follow says too for all fibres of a class. The latter needs a material without a dashpot in series
    // that is the same in every cell. If Receptors::depth gives the class a depth, q is what the strains or pressures
    // of all cells cause there, without the gain 1 + l*C.
    Signal follow = Signal::strain;
    // Endings of each afferent, 1 to 64. The number of cells is a multiple of it: afferent n has the cells n*endings to
    // n*endings + endings - 1. An afferent with fewer endings than others names one of its cells again; a cell that is
    // named twice fires the afferent as one that is named once.
    int endings = 1;
    // m, or cells without Grid::spacing; > 0, and only where `cells` is empty: each site of the class is then the
    // middle of an afferent. Its endings are the cells of points that are drawn, with equal probability, from the part
    // of the circle with this radius that lies on the grid.
    std::optional<double> radius;
    // Of the endings and factors s that are drawn, -1e9..1e9. A seed gives the same ones on every machine. What is
    // drawn for an afferent follows from the seed, its class and its place in this entry alone.
    int seed = 1;
};

// A spike of a press: an afferent of a pad fires at `share` of the step, 0 < share <= 1, that is (1 - share)*dt seconds
// before the step ends. afferent: its number. frame: of press_frames(), from 0 on; of one frame 0.
struct Spike {
    int pad;
    int afferent;
    int frame;
    float share;
};

} // namespace dermis
