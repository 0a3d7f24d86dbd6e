// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/embedding/runner.hpp"
#include "host/core/vulkan/fibres_kernel.hpp"
#include "host/core/vulkan/march.hpp"

namespace dermis::vulkan {

// Steps a few nerve fibres on the device and on the CPU path, once for each device. Throws Error::no_device where a bit
// differs, and Error::device.
void need_exact_fibres(const std::shared_ptr<Context>&);

// The backend on a Vulkan device that the library has opened: it presses skins by a SkinProgram.
class VulkanBackend : public plan::Backend {
  public:
    explicit VulkanBackend(std::shared_ptr<Context> context) : context_(std::move(context)) {}
    std::string name() const override { return context_->physical().info.name; }
    int threads() const override { return 0; }
    std::unique_ptr<plan::Stream> stream(const plan::StreamedSkin& skin) override {
        const Use use = context_->need_working();
        return std::make_unique<SkinRunner>(context_, skin);
    }
    std::unique_ptr<plan::March> march(const plan::MarchPlan& plan) override {
        const Use use = context_->need_working();
        return vulkan::march(plan, context_);
    }
    std::unique_ptr<plan::FibrePopulation<f32>> fibres(const std::vector<plan::FibreKind>& kinds,
                                                       size_t pads) override {
        const Use use = context_->need_working();
        need_exact_fibres(context_);
        return std::make_unique<Fibres>(context_, kinds, pads);
    }
    const std::shared_ptr<Context>& context() const { return context_; }

  private:
    std::shared_ptr<Context> context_;
};

// The context of a backend that is a VulkanBackend.
inline const std::shared_ptr<Context>& context_of(const plan::Backend& backend) {
    return dynamic_cast<const VulkanBackend&>(backend).context();
}

} // namespace dermis::vulkan
