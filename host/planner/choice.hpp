// SPDX-License-Identifier: MIT
// Which model and precision serve a scene, cheapest first, and which is taken.
#pragma once

#include "host/plan/backend.hpp"

namespace dermis::planner {

// What the caller has settled already.
struct Request {
    std::optional<Model> model;
    std::optional<Precision> precision;
    std::optional<double> tolerance; // binds; without it a default binds what is chosen freely
    bool baseline = false;           // the method has an error in time
    bool check = false;              // two backends are compared, so both march in f32
    bool on_device = false;          // a device was asked for: it marches unless a model is named
};

// What computes: the backend that was opened, and the CPU path, which reduced models and double need. They may be one.
struct Backends {
    plan::Capabilities opened, cpu;
};

// Explanation::chosen is the decision. everything: also the costs and errors of what was not taken. Throws
// Error::bad_input for a model, precision or tolerance that cannot be had.
Explanation choose(const plan::PreparedSkin&, const plan::Schedule&, const Request&, const Backends&, bool everything);

} // namespace dermis::planner
