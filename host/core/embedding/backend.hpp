// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/model/stream.hpp"
#include "host/core/vulkan/context.hpp"

namespace dermis::vulkan {

// The backend on a Vulkan device that the library has opened: it presses skins by a SkinProgram.
class VulkanBackend : public plan::Backend {
  public:
    explicit VulkanBackend(std::shared_ptr<Context> context) : context_(std::move(context)) {}
    std::string name() const override { return context_->physical().info.name; }
    int threads() const override { return 0; }
    std::unique_ptr<plan::Stream> stream(const plan::StreamedSkin&) override;
    const std::shared_ptr<Context>& context() const { return context_; }

  private:
    std::shared_ptr<Context> context_;
};

std::shared_ptr<plan::Backend> backend(std::shared_ptr<Context>);

// The context of a backend that is a VulkanBackend.
inline const std::shared_ptr<Context>& context_of(const plan::Backend& backend) {
    return dynamic_cast<const VulkanBackend&>(backend).context();
}

} // namespace dermis::vulkan
