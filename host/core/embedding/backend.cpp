// SPDX-License-Identifier: MIT
#include "host/core/embedding/backend.hpp"

#include "host/core/embedding/runner.hpp"

namespace dermis::vulkan {

std::unique_ptr<plan::Stream> VulkanBackend::stream(const plan::StreamedSkin& skin) {
    context_->need_working();
    return std::make_unique<SkinRunner>(context_, skin);
}

std::shared_ptr<plan::Backend> backend(std::shared_ptr<Context> context) {
    return std::make_shared<VulkanBackend>(std::move(context));
}

} // namespace dermis::vulkan
