// SPDX-License-Identifier: MIT
// What every backend does: press the skin step by step and hand over what each step's end holds.
#pragma once

#include "host/plan/plan.hpp"
#include "host/scene/text.hpp"

namespace dermis::plan {

struct Totals {
    double mean, min, max;
};

// Of one responding step: strain, SA1, SA2, FA1, FA2 over all cells, and in the probes.
struct Sample {
    std::array<Totals, REDUCED_MAPS> totals;
    std::vector<double> probes; // [quantity][probe]
};

class Stepper {
  public:
    // Called once for each step that responds, in order, perhaps some steps later.
    using Sink = std::function<void(const Step&, const Sample&)>;

    virtual ~Stepper() = default;
    // With Plan::framed: the pressure runs to this map (width*height) from the one handed over before, at first from 0.
    virtual void frame(const std::vector<double>& pressure) = 0;
    virtual void press(const Step&) = 0;
    virtual void finish() = 0; // every sample has been handed over
    // Maps at the end of the last press: width*height values for each quantity, into vectors that may be used again.
    virtual void read(const std::vector<Quantity>&, std::vector<std::vector<double>>& maps) = 0;
    virtual long long dispatches() const { return 0; }
    virtual long long left_out() const { return 0; } // steps that could change nothing any more
    // Of the skin at the end of the last press.
    virtual StencilEstimate estimate(const Plan& plan) {
        std::vector<std::vector<double>> strain;
        read({Quantity::strain}, strain);
        return stencil_estimate(plan, strain[0], 1);
    }
};

// Tiles in row order, in double (see kernels/reduce.h).
template <class Summary> Totals total_of(const Summary* tiles, size_t count, size_t cells) {
    double sum = 0;
    Summary all = tiles[0];
    for (size_t i = 0; i < count; ++i) {
        sum += tiles[i].sum;
        all.low = tiles[i].low < all.low ? tiles[i].low : all.low;
        all.high = all.high < tiles[i].high ? tiles[i].high : all.high;
    }
    return {sum / double(cells), double(all.low), double(all.high)};
}

// A map in the precision of a backend, rows padded to the pitch with zeros. Throws Error::bad_input naming `parameter`
// where a value is too large for it.
template <class real>
std::vector<real> padded(const std::vector<double>& map, const Plan& plan, const char* parameter) {
    const int width = plan.constants.width, height = plan.constants.height;
    std::vector<real> out(size_t(plan.pitch) * height, real(0));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double v = map[size_t(y) * width + x];
            if (!(v <= double(std::numeric_limits<real>::max()) && v >= double(std::numeric_limits<real>::lowest())))
                throw Error(Error::Code::bad_input, parameter,
                            std::string(parameter) + " = " + shortest(v) + " in cell [" + std::to_string(x) + ", " +
                                std::to_string(y) + "]; allowed: up to " +
                                shortest(double(std::numeric_limits<real>::max())) + " (f32: 3.4e38, f64: 1.8e308)");
            out[size_t(y) * plan.pitch + x] = real(v);
        }
    return out;
}

} // namespace dermis::plan
