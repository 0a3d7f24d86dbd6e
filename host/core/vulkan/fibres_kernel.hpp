// SPDX-License-Identifier: MIT
// Nerve fibres on the library's own device. States and inputs lie where the host reads and writes them.
#pragma once

#include "host/core/model/fibres.hpp"
#include "host/core/vulkan/recording.hpp"

#include <optional>

namespace dermis::vulkan {

class Fibres : public model::FibrePopulation<f32> {
  public:
    // Throws Error::device.
    Fibres(std::shared_ptr<Context>, const std::vector<model::FibreKind>&, size_t pads);

  private:
    void grow(size_t most) override;
    void take_constants() override;
    void step(size_t first_pad, size_t pads, int part, int parts) override;
    void record(size_t kind, size_t first_pad, size_t pads, int part, int parts);

    std::shared_ptr<Context> context_;
    Kernel kernel_;
    Buffer constants_, memory_;    // planes, those of dispatches, then inputs
    std::optional<Buffer> spikes_; // their number, then entries
    Recording recording_;
};

} // namespace dermis::vulkan
