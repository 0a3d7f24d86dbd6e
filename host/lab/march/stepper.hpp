// SPDX-License-Identifier: MIT
// The interface of every model in a run: it takes the steps of a schedule and delivers the samples at their ends.
#pragma once

#include "host/lab/march/totals.hpp"
#include "host/lab/schedule/timeline.hpp"

namespace dermis::model {

// The error |C5 - C4| of a five-point curvature, for the skin under the strain shape*scale.
struct StencilEstimate {
    double greatest = 0;  // greatest |C5 - C4|, 1/m
    double curvature = 0; // greatest |C| by the skin's own stencil, at rest or under the strain, 1/m
    long long kinks = 0;  // cells where |C5 - C4| exceeds |C|/2, which no refinement mends
};
StencilEstimate stencil_estimate(const PreparedSkin&, const std::vector<double>& shape, double scale);

// The number of steps that the CPU path takes at once in a march, while a band of rows is in a cache.
constexpr size_t steps_of_batch = 8;

// The strain and the responses at the end of one step, over all cells and in the points of a march.
struct Sample {
    std::array<Totals, REDUCED_MAPS> totals;
    std::vector<double> points; // [quantity][point]
};

class Stepper {
  public:
    // Called once for each step that responds, in order, perhaps some steps later.
    using Sink = std::function<void(const Step&, const Sample&)>;

    virtual ~Stepper() = default;
    // With Schedule::framed: from the next step on the pressure runs to this map (width*height, Pa) from the previous
    // one, at first from 0.
    virtual void frame(const std::vector<double>& pressure) = 0;
    virtual void press(const Step&) = 0;
    virtual void finish() {} // delivers all samples that are still due
    // Writes maps at the end of the last press, width*height for each quantity, into vectors that may be reused.
    virtual void read(const std::vector<Quantity>&, std::vector<std::vector<double>>& maps) = 0;
    virtual long long dispatches() const { return 0; }
    virtual long long left_out() const { return 0; } // steps skipped because they could not change any output
    // The stencil estimate of the skin at the end of the last press.
    virtual StencilEstimate estimate(const PreparedSkin& skin) {
        std::vector<std::vector<double>> strain;
        read({Quantity::strain}, strain);
        return stencil_estimate(skin, strain[0], 1);
    }
};

} // namespace dermis::model
