// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/embedding/check.hpp"
#include "host/core/model/stream.hpp"
#include "host/core/vulkan/context.hpp"
#include "host/core/vulkan/windows.hpp"

namespace dermis::vulkan {

// A skin, or nerve fibres, on the device. Throws Error::device.
std::unique_ptr<model::Stream> runner(std::shared_ptr<Context>, const model::StreamedSkin&);
std::unique_ptr<model::FibrePopulation<f32>> fibres(std::shared_ptr<Context>, const std::vector<model::FibreKind>&,
                                                    size_t pads);

// Steps a few nerve fibres on the device and on the CPU path, once for each device. Throws Error::no_device where a bit
// differs, and Error::device.
void need_exact_fibres(const std::shared_ptr<Context>&);

// The backend on a Vulkan device that the library has opened: it presses skins by a SkinProgram.
class VulkanBackend : public model::Backend {
  public:
    explicit VulkanBackend(std::shared_ptr<Context> context) : context_(std::move(context)) {}
    model::Capabilities capabilities() const override {
        const DeviceInfo& info = context_->physical().info;
        return {.name = info.name,
                .double_buffered = true,
                .cell_step = info.kind == "software" ? 28e-9 : 3e-10, // measured on lavapipe; from a GPU's bandwidth
                .dispatch = 5e-6};
    }
    std::unique_ptr<model::Stream> stream(const model::StreamedSkin& skin) override {
        const Use use = context_->need_working();
        return runner(context_, skin);
    }
    bool exact(const model::StreamedSkin& skin) override {
        std::vector<uint32_t> key = specialization(skin.variant());
        for (const auto& spread : skin.spread) key.push_back(spread ? uint32_t(spread->size()) : 0);
        key.push_back(!skin.sites().empty());
        return context_->exact(key, [&] { return presses_exactly(*this, skin); });
    }
    std::unique_ptr<model::FibrePopulation<f32>> fibres(const std::vector<model::FibreKind>& kinds,
                                                        size_t pads) override {
        const Use use = context_->need_working();
        need_exact_fibres(context_);
        return vulkan::fibres(context_, kinds, pads);
    }
    const std::shared_ptr<Context>& context() const { return context_; }

  private:
    std::shared_ptr<Context> context_;
};

// The context of a backend that is a VulkanBackend.
inline const std::shared_ptr<Context>& context_of(const model::Backend& backend) {
    return dynamic_cast<const VulkanBackend&>(backend).context();
}

} // namespace dermis::vulkan
