// SPDX-License-Identifier: MIT
// The choice of a model and precision for a scene: the cheapest that keeps the tolerance.
#pragma once

#include "dermis/run.hpp"
#include "host/lab/march/capabilities.hpp"
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
    plan::Capabilities opened, cpu;
};

// What running a schedule by one model costs: steps, memory, traffic, seconds. It serves to choose, it is no promise.
Candidate costed(const plan::PreparedSkin&, const plan::Schedule&, Model, Precision, const plan::Capabilities&);

// Explanation::chosen is the decision. everything: also the costs and errors of candidates that are not chosen. Throws
// Error::bad_input for a model, precision or tolerance that cannot be had. peaks: where a bound was needed, it is set
// to the values that the bound is relative to.
Explanation choose(const plan::PreparedSkin&, const plan::Schedule&, const Request&, const Backends&, bool everything,
                   std::optional<Peaks>& peaks);

} // namespace dermis::planner
