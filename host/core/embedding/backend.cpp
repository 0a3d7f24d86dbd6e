// SPDX-License-Identifier: MIT
#include "host/core/embedding/backend.hpp"

#include "host/core/embedding/runner.hpp"
#include "host/lab/march/vulkan_march.hpp"

namespace dermis::vulkan {

plan::Capabilities VulkanBackend::capabilities() const {
    const DeviceInfo& info = context_->physical().info;
    plan::Capabilities c;
    c.name = info.name;
    c.double_buffered = true;
    // Measured on lavapipe; for a GPU estimated from its memory bandwidth.
    c.cell_step = info.kind == "software" ? 28e-9 : 3e-10;
    c.dispatch = 5e-6;
    return c;
}

std::unique_ptr<plan::Stepper> VulkanBackend::stepper(const plan::PreparedSkin& skin, const plan::Schedule& schedule,
                                                      Precision precision, plan::Stepper::Sink sink) {
    context_->need_working();
    return vulkan::stepper(skin, schedule, precision, context_, std::move(sink));
}

std::unique_ptr<plan::Stream> VulkanBackend::stream(const plan::StreamedSkin& skin) {
    context_->need_working();
    return std::make_unique<SkinRunner>(context_, skin);
}

std::shared_ptr<plan::Backend> backend(std::shared_ptr<Context> context) {
    return std::make_shared<VulkanBackend>(std::move(context));
}

} // namespace dermis::vulkan
