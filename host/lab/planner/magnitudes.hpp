// SPDX-License-Identifier: MIT
// The greatest pressures, curvatures and differences of what a run reads, and where its outputs are likely to be
// greatest.
#pragma once

#include "host/lab/planner/bound.hpp"

#include <cmath>

namespace dermis::planner {

// The sum of a stencil's absolute weights: the factor from an error of the strain to an error of its Laplacian.
double weight_of(int stencil);

double largest_of(const std::vector<double>& map);
// The index of the cell where |map| is greatest.
size_t greatest_cell(const std::vector<double>& map);

// The greatest |L(S)| over all cells, or over the schedule's points alone.
double rest_peak(const model::PreparedSkin&, const model::Schedule&, bool points_only);

// A bound of the roundings of a map's differences and of their sums in a Laplacian without spacing, in units: each term
// is rounded three times, with a factor of the fourth-order stencil six times.
double roundings_of(const model::PreparedSkin&, const std::vector<double>& map);

// Greatest Laplacian of a strain with maximum 1, and roundings_of it. A uniform skin's strain has the load's shape,
// which gives a tighter bound. peak: the load's greatest |pressure|. of_error: the greatest Laplacian of the strain's
// error of 1; 0 where all cells are pressed alike and so are off alike.
struct Roughness {
    double laplacian, roundings, of_error;
};
Roughness roughness_of(const model::PreparedSkin&, const model::Schedule&, double peak);

// A material, and the greatest |pressure| on the cells of it that are read.
struct PressedMaterial {
    model::Element element;
    double peak = 0;
    double around = 0; // the greatest |pressure| on these cells and on the cells that their stencils read
    // The greatest |1 + l*L(S)| of the cells that are read, times the cell's share of the most pressed cell's rounding
    // error (gain) or of its pressure (value_gain).
    double gain = INFINITY, value_gain = INFINITY;
};

// The cells that an analysis covers: all of them, or the sites of one class.
struct Read {
    bool everything;
    int quantity; // the class of the sites; ignored with everything
};

std::vector<PressedMaterial> pressed_materials(const model::PreparedSkin&, const model::Schedule&, const Read&);

// Sets the gains of materials. Of products, errors are proportional to pressure; otherwise, half a unit in the last
// place of a smaller value is up to twice as much of it.
void take_gains(const model::PreparedSkin&, const model::Schedule&, const Read&, const Arithmetic&,
                std::vector<PressedMaterial>&);

// Where the planner looks for the greatest |X_exact|, and a witness for errors. Cells: in turn those that are strained
// most, strained fastest and bent most, pressed ones from all over, and a few that need not be pressed.
std::vector<Cell> telling_cells(const model::PreparedSkin&, const model::Schedule&);
// The same of sites, as indices, up to 64 of each class: in turn those pressed most, pressed ones, and any.
std::vector<size_t> telling_sites(const model::PreparedSkin&, const model::Schedule&);
// The outputs at which strain and each response are likely to be greatest: under an envelope, in the cell pressed most
// and among some hundreds of outputs; under frames, after the greatest pressure or change of it.
std::array<long long, REDUCED_MAPS> telling_outputs(const model::PreparedSkin&, const model::Schedule&);

} // namespace dermis::planner
