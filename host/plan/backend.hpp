// SPDX-License-Identifier: MIT
// The interface of what computes, the CPU path or a Vulkan device, to runs and skins.
#pragma once

#include "host/plan/stepper.hpp"
#include "host/plan/streamed_skin.hpp"

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

// A skin that is pressed frame by frame. Nothing is allocated from press to press.
class Stream {
  public:
    virtual ~Stream() = default;
    // Takes in the next pressure, Pa, whose rows of `width` begin `stride` numbers apart. Returns false if a number is
    // not finite; another one must then be taken in before the next press.
    virtual bool take(const float* pressure, size_t stride) = 0;
    // Steps dt seconds, over which the pressure runs linearly from that of the previous press to this one. Returns
    // false, and changes nothing, if a coefficient of the step is beyond float.
    virtual bool press(double dt) = 0;
    // The response of the last press, a field of width*height or sites in the order given; the same memory after every
    // press.
    virtual const float* response(Quantity) const = 0;
    virtual void reset() = 0; // back to a skin at rest
    // Copies the state, laid out by StateLayout, to and from memory of the caller's.
    virtual void save(float* state) = 0;
    virtual void load(const float* state) = 0;
    // Returns whether a test of these very kernels gives the CPU path's bits.
    virtual bool exact() { return true; }
};

class Backend {
  public:
    virtual ~Backend() = default;
    virtual Capabilities capabilities() const = 0;
    // Skin and schedule outlive the stepper. Throws Error::bad_input if a value or size is beyond the
    // backend's limits.
    virtual std::unique_ptr<Stepper> stepper(const PreparedSkin&, const Schedule&, Precision, Stepper::Sink) = 0;
    virtual std::unique_ptr<Stream> stream(const StreamedSkin&) = 0;
};

} // namespace dermis::plan
