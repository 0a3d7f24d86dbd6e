// SPDX-License-Identifier: MIT
// What computes: the CPU path, or a Vulkan device. Runs and skins know no more of it than this.
#pragma once

#include "host/plan/stepper.hpp"
#include "host/plan/streamed_skin.hpp"

namespace dermis::plan {

// What the planner needs to know of a backend. Costs are to choose by, no promise.
struct Capabilities {
    std::string name;
    bool f64 = false;             // marches in double too
    int threads = 1;              // of the host, that share the work
    bool double_buffered = false; // holds each state twice and stores every response; otherwise it steps in place
    double cell_step = 0;         // seconds per cell and step in f32, on all threads
    double dispatch = 0;          // seconds per dispatch; 0: there are none
};

// A skin that is pressed frame by frame. Nothing is allocated from press to press.
class Stream {
  public:
    virtual ~Stream() = default;
    // Where the next pressure goes, pitch*height; what lies beyond the width stays 0.
    virtual float* pressure() = 0;
    // The pressure runs from that of the press before to this one in dt seconds. False, and nothing has happened, where
    // a coefficient of the step is beyond float.
    virtual bool press(double dt) = 0;
    // Where a response of the last press stands, laid out as ResponseLayout says; the same memory after every press.
    virtual const float* response(Quantity) const = 0;
    virtual void reset() = 0; // to a skin at rest
    // Whether a test of these very kernels gives the CPU path's bits.
    virtual bool exact() { return true; }
};

class Backend {
  public:
    virtual ~Backend() = default;
    virtual Capabilities capabilities() const = 0;
    // Skin and schedule outlive the stepper. Throws Error::bad_input where something does not fit.
    virtual std::unique_ptr<Stepper> stepper(const PreparedSkin&, const Schedule&, Precision, Stepper::Sink) = 0;
    virtual std::unique_ptr<Stream> stream(const StreamedSkin&) = 0;
};

} // namespace dermis::plan
