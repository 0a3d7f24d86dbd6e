// SPDX-License-Identifier: MIT
// What the planner knows of a device.
#pragma once

#include "host/core/model/stream.hpp"

namespace dermis::plan {

// The properties of a backend that the planner uses. Costs serve to choose, they are no promise.
struct Capabilities {
    std::string name;
    bool f64 = false;             // marches in double too
    int threads = 0;              // host threads that share the work; 0: one per core
    bool double_buffered = false; // holds each state twice and stores every response; otherwise it steps in place
    double cell_step = 0;         // seconds per cell and step in f32, on all threads
    double dispatch = 0;          // seconds per dispatch; 0: no dispatches
};

Capabilities capabilities_of(const Backend&);

} // namespace dermis::plan
