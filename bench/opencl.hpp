// SPDX-License-Identifier: MIT
// The OpenCL peer: one press of one skin on the CPU by PoCL.
#pragma once

#include "bench/frames.hpp"

#include <array>
#include <memory>
#include <string>

namespace bench {

class OpenclFrames {
  public:
    // Null where the program was built without OpenCL, or PoCL is not installed.
    static std::unique_ptr<OpenclFrames> make(const FrameScene&, bool past_caches);
    virtual ~OpenclFrames() = default;
    virtual void press(int frames) = 0;
    virtual std::array<const float*, 4> responses() = 0; // SA1, SA2, FA1, FA2 of the last frame, pitch*height each
    virtual std::string driver_version() const = 0;
};

} // namespace bench
