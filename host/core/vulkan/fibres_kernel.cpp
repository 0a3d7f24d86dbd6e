// SPDX-License-Identifier: MIT
#include "host/core/vulkan/fibres_kernel.hpp"

#include "host/core/base/float_environment.hpp"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {
namespace {

constexpr size_t spikes_offset = 2 * sizeof(uint32_t), line = 64; // numbers at whose multiples a device may bind

VkDeviceSize at_least_some(size_t bytes) { return std::max<VkDeviceSize>(bytes, 4); }

} // namespace

Fibres::Fibres(std::shared_ptr<Context> context, const std::vector<plan::FibreKind>& kinds, size_t pads)
    : plan::FibrePopulation<f32>(kinds, pads, line), context_(std::move(context)),
      kernel_(context_->pipelines(), fibres_module(),
              {.bindings = FIBRES_BINDINGS,
               .constants_bytes = sizeof(f32::FibreDispatch),
               .specialization = {},
               .max_sets = 1}),
      constants_(*context_, at_least_some(kinds.size() * sizeof(f32::FibreConstants)), Buffer::Location::host),
      memory_(*context_, at_least_some((FIBRE_PLANES + 1) * plane_ * sizeof(float)), Buffer::Location::host),
      recording_(*context_) {
    std::memset(memory_.data(), 0, memory_.bytes());
    state_ = static_cast<float*>(memory_.data());
    input_ = state_ + FIBRE_PLANES * plane_;
}

void Fibres::grow(size_t most) {
    recording_.wait();
    spikes_.emplace(*context_, spikes_offset + plane_ * most * sizeof(f32::FibreEntry), Buffer::Location::host);
    sorted_.reserve(plane_ * most);
    const VkDeviceSize inputs = FIBRE_PLANES * plane_ * sizeof(float);
    kernel_.bind(0, {{FIBRES_CONSTANTS, constants_.all()},
                     {FIBRES_STATE, {memory_.handle(), 0, inputs}},
                     {FIBRES_INPUT, {memory_.handle(), inputs, plane_ * sizeof(float)}},
                     {FIBRES_SPIKES, spikes_->all()}});
}

void Fibres::take_constants() {
    for (size_t k = 0; k < kinds_.size(); ++k)
        std::memcpy(static_cast<f32::FibreConstants*>(constants_.data()) + k, &kinds_[k].constants,
                    sizeof(f32::FibreConstants));
}

void Fibres::step(size_t first_pad, size_t pads) {
    const DefaultFloats guard; // a software driver's threads inherit the floating-point environment
    constexpr uint32_t most_groups = 65535;
    std::memset(spikes_->data(), 0, spikes_offset);
    const VkCommandBuffer commands = recording_.begin();
    for (size_t k = 0; k < kinds_.size(); ++k) {
        const f32::FibreDispatch dispatch{.fibres = int(pads * kinds_[k].padded),
                                          .first = int(at(first_pad, kinds_[k], 0)),
                                          .of_pad = int(kinds_[k].padded),
                                          .pad = int(padded_),
                                          .endings = int(kinds_[k].endings),
                                          .plane = int(plane_),
                                          .kind = int(k)};
        const uint32_t groups = uint32_t(dispatch.fibres + FIBRES_X - 1) / FIBRES_X, x = std::min(groups, most_groups);
        if (groups > 0) kernel_.record(commands, 0, &dispatch, x, (groups + x - 1) / x);
    }
    recording_.submit();
    uint32_t fired = 0;
    std::memcpy(&fired, spikes_->data(), sizeof fired);
    const auto* entries = reinterpret_cast<const f32::FibreEntry*>(static_cast<char*>(spikes_->data()) + spikes_offset);
    sorted_.assign(entries, entries + fired);
    std::ranges::sort(sorted_, [](const f32::FibreEntry& a, const f32::FibreEntry& b) {
        return a.fibre != b.fibre ? a.fibre < b.fibre : a.share < b.share;
    });
    for (const f32::FibreEntry& e : sorted_) {
        const size_t pad = size_t(e.fibre) / padded_, in_pad = size_t(e.fibre) % padded_;
        const auto kind = std::ranges::upper_bound(kinds_, in_pad, {}, &Kind::offset) - 1;
        fire(pad, *kind, in_pad - kind->offset, e.share);
    }
}

} // namespace dermis::vulkan
