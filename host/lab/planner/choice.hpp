// SPDX-License-Identifier: MIT
// The choice of a model and precision for a scene: sites for receptors alone, else moments, else maps, else a march, in
// compensated float down to a tolerance of 1e-6 and in double below. The first of these whose bound keeps the tolerance
// is taken.
#pragma once

#include "dermis/run.hpp"
#include "host/core/model/stream.hpp"
#include "host/lab/planner/bound.hpp"

namespace dermis::planner {

// The caller's constraints on the choice.
struct Request {
    std::optional<Model> model;
    std::optional<Precision> precision;
    std::optional<double> tolerance; // if given, it binds; otherwise a default binds free choices
    bool baseline = false;           // the method has an error in time
    bool check = false;              // two backends are compared, so both march in f32
    bool on_device = false;          // a Vulkan device is asked for: it marches unless a model is named
};

// The backend that was opened, and the CPU path, which reduced models and double need. They may be the same.
struct Backends {
    model::Capabilities opened, cpu;
};

// Adds what running a schedule by a candidate costs: steps, memory, seconds. An estimate to show, by which nothing is
// chosen.
void estimate_cost(Candidate&, const model::PreparedSkin&, const model::Schedule&, const model::Capabilities&);

// Explanation::chosen is the decision. everything: also the costs and errors of all candidates. Throws
// Error::bad_input for a model, precision or tolerance that cannot be had. peaks: where a bound was needed, it is set
// to the values that the bound is relative to.
Explanation choose(const model::PreparedSkin&, const model::Schedule&, const Request&, const Backends&, bool everything,
                   std::optional<Peaks>& peaks);

} // namespace dermis::planner
