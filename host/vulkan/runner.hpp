// SPDX-License-Identifier: MIT
#pragma once

#include "dermis/vulkan.hpp"
#include "host/vulkan/context.hpp"

namespace dermis::vulkan {

// A skin on a device of ours: memory and submissions around a SkinProgram, as a stranger would write them.
class SkinRunner {
  public:
    SkinRunner(std::shared_ptr<Context>, const SkinDescription&, const SkinOptions&);
    ~SkinRunner();
    bool exact(); // gives the CPU path's bits
    // To be filled with the next pressure, pitch*height, before a press; the answers after it, as plan::response_layout_of has
    // them.
    float* pressure() { return static_cast<float*>(upload_.data()); }
    const float* answers() const { return static_cast<const float*>(download_.data()); }
    void press(double dt);
    void reset();

  private:
    Buffer buffer(const Memory&, Buffer::Location);
    void fill(Buffer&, const Memory&);

    std::shared_ptr<Context> context_;
    SkinProgram program_;
    Buffer constants_, state_[2], pressure_[2], response_, invalid_, upload_, download_;
    Binding bindings_[2];
    int from_ = 0; // state and pressure
};

} // namespace dermis::vulkan
