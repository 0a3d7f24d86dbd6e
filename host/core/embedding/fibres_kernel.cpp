// SPDX-License-Identifier: MIT
// Nerve fibres on the library's own device. States and inputs lie where the host reads and writes them.
#include "host/core/embedding/backend.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/model/fibres.hpp"
#include "host/core/vulkan/recording.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

namespace dermis::vulkan {
namespace {

constexpr size_t spikes_offset = 2 * sizeof(uint32_t), line = 64; // numbers at whose multiples a device may bind

class Fibres : public model::FibrePopulation<f32> {
  public:
    // Throws Error::device.
    Fibres(std::shared_ptr<Context> context, const std::vector<model::FibreKind>& kinds, size_t pads)
        : model::FibrePopulation<f32>(kinds, pads, line), context_(std::move(context)),
          kernel_(context_->pipelines(), fibres_module(), {}, 1),
          constants_(*context_, kinds.size() * sizeof(f32::FibreConstants), Buffer::Location::host),
          memory_(*context_, (FIBRE_DISPATCH_PLANES + 1) * plane_ * sizeof(float), Buffer::Location::host),
          recording_(*context_) {
        std::memset(memory_.data(), 0, memory_.bytes());
        state_ = static_cast<float*>(memory_.data());
        input_ = state_ + FIBRE_DISPATCH_PLANES * plane_;
    }

  private:
    void grow(size_t most) override {
        const Use use = context_->need_working();
        recording_.wait();
        spikes_.emplace(*context_, spikes_offset + plane_ * most * sizeof(f32::FibreEntry), Buffer::Location::host);
        const VkDeviceSize inputs = FIBRE_DISPATCH_PLANES * plane_ * sizeof(float);
        kernel_.bind(0, {{FIBRES_CONSTANTS, constants_.all()},
                         {FIBRES_STATE, {memory_.handle(), 0, inputs}},
                         {FIBRES_INPUT, {memory_.handle(), inputs, plane_ * sizeof(float)}},
                         {FIBRES_SPIKES, spikes_->all()}});
    }
    void take_constants() override {
        for (size_t k = 0; k < kinds_.size(); ++k)
            std::memcpy(static_cast<f32::FibreConstants*>(constants_.data()) + k, &kinds_[k].constants,
                        sizeof(f32::FibreConstants));
    }
    void step(size_t first_pad, size_t pads, int part, int parts) override {
        const DefaultFloats guard; // a software driver's threads inherit the floating-point environment
        const Use use = context_->need_working();
        std::memset(spikes_->data(), 0, spikes_offset);
        recording_.begin();
        for (size_t k = 0; k < kinds_.size(); ++k) record(k, first_pad, pads, part, parts);
        recording_.submit();
        uint32_t fired = 0;
        std::memcpy(&fired, spikes_->data(), sizeof fired);
        const auto* entries =
            reinterpret_cast<const f32::FibreEntry*>(static_cast<char*>(spikes_->data()) + spikes_offset);
        for (const f32::FibreEntry& e : std::span(entries, fired)) {
            const size_t pad = size_t(e.fibre) / padded_, in_pad = size_t(e.fibre) % padded_;
            const auto kind = std::ranges::upper_bound(kinds_, in_pad, {}, &Kind::offset) - 1;
            fire(pad, *kind, in_pad - kind->offset, e.share);
        }
    }
    // Records substeps of the fibres of a kind, in dispatches of a limited length and work.
    void record(size_t number, size_t first_pad, size_t pads, int part, int parts) {
        constexpr double work_of_substep = 60; // of an ending, see DeviceTable::most_work
        constexpr int most_groups = 65535;
        const Kind& kind = kinds_[number];
        const int fibres = int(pads * kind.padded), endings = int(kind.endings),
                  last = std::min(part + parts, kind.constants.substeps) * endings,
                  length = std::max(FIBRE_PASSES / model::passes_of_substep(kind.constants), 1),
                  most = int(std::clamp(context_->pipelines().device().most_work / (work_of_substep * length), 1.0,
                                        double(fibres)));
        for (int begin = part * endings, end = 0; begin < last; begin = end, recording_.barrier()) {
            end = std::min(begin + length, last);
            for (int from = 0, to = 0; from < fibres; from = to) {
                to = from + std::min(most, fibres - from);
                const f32::FibreDispatch d{.from = from,
                                           .to = to,
                                           .first = int(at(first_pad, kind, 0)),
                                           .of_pad = int(kind.padded),
                                           .pad = int(padded_),
                                           .endings = endings,
                                           .plane = int(plane_),
                                           .kind = int(number),
                                           .begin = begin,
                                           .end = end};
                recording_.add(work_of_substep * (to - from) * (end - begin));
                const int groups = (to - from + FIBRES_X - 1) / FIBRES_X, x = std::min(groups, most_groups);
                kernel_.record(recording_.commands(), 0, &d, uint32_t(x), uint32_t((groups + x - 1) / x));
            }
        }
    }

    std::shared_ptr<Context> context_;
    Kernel kernel_;
    Buffer constants_, memory_;    // planes, those of dispatches, then inputs
    std::optional<Buffer> spikes_; // their number, then entries
    Recording recording_;
};

} // namespace

std::unique_ptr<model::FibrePopulation<f32>> fibres(std::shared_ptr<Context> context,
                                                    const std::vector<model::FibreKind>& kinds, size_t pads) {
    return std::make_unique<Fibres>(std::move(context), kinds, pads);
}

} // namespace dermis::vulkan
