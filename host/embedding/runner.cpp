// SPDX-License-Identifier: MIT
#include "host/embedding/runner.hpp"

#include "host/embedding/skin_program.hpp"
#include "host/plan/float_environment.hpp"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {
namespace {

VkDescriptorBufferInfo info(const Buffer& b) { return {b.handle(), 0, b.bytes()}; }

// Makes the program; throws Error::bad_input where its memory exceeds the device's, before anything is allocated.
SkinProgram fitting(const Context& context, const plan::StreamedSkin& skin) {
    SkinProgram program = program_of(context.handles(), skin, 2);
    const MemoryNeeds& n = program.memory();
    const VkDeviceSize all = n.constants.bytes + 2 * n.state.bytes + 2 * n.pressure.bytes + n.response.bytes;
    if (all > context.heap_bytes())
        throw Error(Error::Code::bad_input, "grid.width",
                    "a skin of " + std::to_string(skin.skin.width()) + " x " + std::to_string(skin.skin.height()) +
                        " needs " + std::to_string(all) + " bytes; allowed on this device: device memory = " +
                        std::to_string(context.heap_bytes()) + "; or device cpu");
    return program;
}

} // namespace

SkinRunner::SkinRunner(std::shared_ptr<Context> context, const plan::StreamedSkin& skin)
    : width_(size_t(skin.skin.width())), pitch_(size_t(skin.skin.pitch)), height_(skin.skin.height()),
      layout_(state_layout_of(skin)), sites_(!skin.skin.description.sites.empty()),
      strain_(skin.variant().keeps_strain), context_(std::move(context)), program_(fitting(*context_, skin)),
      constants_(buffer(program_.memory().constants, Buffer::Location::device)),
      state_{buffer(program_.memory().state, Buffer::Location::device),
             buffer(program_.memory().state, Buffer::Location::device)},
      pressure_{buffer(program_.memory().pressure, Buffer::Location::device),
                buffer(program_.memory().pressure, Buffer::Location::device)},
      response_(buffer(program_.memory().response, Buffer::Location::device)),
      invalid_(buffer(program_.memory().invalid, Buffer::Location::device)),
      upload_(buffer(program_.memory().pressure, Buffer::Location::host)),
      download_(buffer(program_.memory().response, Buffer::Location::host)) {
    fill(constants_, program_.memory().constants);
    fill(invalid_, program_.memory().invalid);
    for (int i = 0; i < 2; ++i)
        bindings_[i] = program_.bind({.constants = info(constants_),
                                      .state_from = info(state_[i]),
                                      .state_to = info(state_[1 - i]),
                                      .pressure_from = info(pressure_[i]),
                                      .pressure_to = info(pressure_[1 - i]),
                                      .response = info(response_),
                                      .invalid = info(invalid_)});
    for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
        if (!sites_ && width_ != pitch_ && skin.wanted[q]) dense_[q - QUANTITY_SA1].resize(width_ * size_t(height_));
    std::memset(upload_.data(), 0, upload_.bytes()); // cells beyond the width stay 0
    reset({});
}

SkinRunner::~SkinRunner() {
    if (context_->lost()) new SkinProgram(std::move(program_)); // the driver may still use it
}

Buffer SkinRunner::buffer(const Memory& m, Buffer::Location location) {
    return Buffer(*context_, std::max<VkDeviceSize>(m.bytes, 4), location);
}

void SkinRunner::fill(Buffer& buffer, const Memory& m) {
    const VkCommandBuffer commands = context_->begin();
    if (m.initial.empty()) {
        context_->calls().vkCmdFillBuffer(commands, buffer.handle(), 0, VK_WHOLE_SIZE, 0);
        context_->barrier(commands);
        context_->submit();
        return;
    }
    Buffer staging(*context_, m.initial.size(), Buffer::Location::host);
    std::memcpy(staging.data(), m.initial.data(), m.initial.size());
    const VkBufferCopy region{0, 0, m.initial.size()};
    context_->calls().vkCmdCopyBuffer(commands, staging.handle(), buffer.handle(), 1, &region);
    context_->barrier(commands);
    context_->submit();
}

bool SkinRunner::exact() {
    const Memory& m = program_.memory().check;
    Buffer check(*context_, m.bytes, Buffer::Location::device), back(*context_, m.bytes, Buffer::Location::host);
    fill(check, m);
    program_.bind_check(info(check));
    const VkCommandBuffer commands = context_->begin();
    if (!program_.record_check(commands)) return false;
    context_->barrier(commands);
    const VkBufferCopy region{0, 0, m.bytes};
    context_->calls().vkCmdCopyBuffer(commands, check.handle(), back.handle(), 1, &region);
    context_->barrier(commands);
    context_->submit();
    return program_.check_passed(back.data());
}

bool SkinRunner::take(const plan::PadList&, const float* pressures) {
    context_->need_working();
    return plan::copy_rows({.from = pressures,
                            .stride = width_,
                            .width = width_,
                            .to = static_cast<float*>(upload_.data()),
                            .pitch = pitch_},
                           0, height_);
}

const double* SkinRunner::press(const plan::PadList&, const plan::StepLengths& dt) {
    const DefaultFloats guard; // a software driver's threads inherit the floating-point environment
    const VolkDeviceTable& vk = context_->calls();
    const VkCommandBuffer commands = context_->begin();
    const VkBufferCopy in{0, 0, program_.memory().pressure.bytes}, out{0, 0, program_.memory().response.bytes};
    vk.vkCmdCopyBuffer(commands, upload_.handle(), pressure_[1 - from_].handle(), 1, &in);
    context_->barrier(commands);
    if (!program_.record_press(commands, bindings_[from_], dt[0])) return &dt[0]; // gives the recording up
    context_->barrier(commands);
    vk.vkCmdCopyBuffer(commands, response_.handle(), download_.handle(), 1, &out);
    context_->barrier(commands);
    context_->submit();
    from_ = 1 - from_;
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
        std::vector<float>& dense = dense_[size_t(q - QUANTITY_SA1)];
        const float* response = static_cast<const float*>(download_.data()) + program_.range(Quantity(q)).first;
        for (size_t y = 0; !dense.empty() && y < size_t(height_); ++y)
            std::copy_n(response + y * pitch_, width_, dense.data() + y * width_);
    }
    return nullptr;
}

const float* SkinRunner::response(Quantity q) const {
    context_->need_working(); // a press that failed may have written half of a response
    const std::vector<float>& dense = dense_[size_t(q) - QUANTITY_SA1];
    return dense.empty() ? static_cast<const float*>(download_.data()) + program_.range(q).first : dense.data();
}

void SkinRunner::reset(const plan::PadList&) {
    const VkCommandBuffer commands = context_->begin();
    for (const Buffer* b : {&state_[0], &state_[1], &pressure_[0], &response_})
        context_->calls().vkCmdFillBuffer(commands, b->handle(), 0, VK_WHOLE_SIZE, 0);
    context_->barrier(commands);
    context_->submit();
    from_ = 0; // after the submission: where that fails, nothing has happened
    std::memset(download_.data(), 0, download_.bytes());
    for (std::vector<float>& dense : dense_) std::fill(dense.begin(), dense.end(), 0.0f);
}

template <class F> void SkinRunner::each_run(F f) const {
    const size_t planes = layout_.planes + strain_;
    for (size_t p = 0; p < layout_.planes; ++p)
        if (sites_)
            for (size_t i = 0; i < layout_.cells; ++i) f(i * planes + strain_ + p, p * layout_.cells + i, 1);
        else
            for (size_t y = 0; y < size_t(height_); ++y)
                f((y * planes + strain_ + p) * pitch_, p * layout_.cells + y * width_, width_);
}

void SkinRunner::set_elements(const plan::PadList&, const std::vector<plan::Element>&) {}

void SkinRunner::save(int, void* saved) {
    float* state = static_cast<float*>(saved);
    context_->need_working();
    const Memory &of_state = program_.memory().state, &of_pressure = program_.memory().pressure;
    Buffer back(*context_, of_state.bytes + of_pressure.bytes, Buffer::Location::host);
    const VkCommandBuffer commands = context_->begin();
    const VkBufferCopy planes{0, 0, of_state.bytes}, pressure{0, of_state.bytes, of_pressure.bytes};
    context_->calls().vkCmdCopyBuffer(commands, state_[from_].handle(), back.handle(), 1, &planes);
    context_->calls().vkCmdCopyBuffer(commands, pressure_[from_].handle(), back.handle(), 1, &pressure);
    context_->barrier(commands);
    context_->submit();
    const auto* from = static_cast<const float*>(back.data());
    each_run([&](size_t there, size_t here, size_t n) { std::copy_n(from + there, n, state + here); });
    from += of_state.bytes / sizeof(float);
    state += layout_.cells * layout_.planes;
    for (size_t y = 0; y < size_t(height_); ++y) std::copy_n(from + y * pitch_, width_, state + y * width_);
}

void SkinRunner::load(int, const void* saved) {
    const float* state = static_cast<const float*>(saved);
    context_->need_working();
    const Memory &of_state = program_.memory().state, &of_pressure = program_.memory().pressure;
    Buffer staging(*context_, of_state.bytes + of_pressure.bytes, Buffer::Location::host);
    auto* to = static_cast<float*>(staging.data());
    std::memset(to, 0, staging.bytes());
    each_run([&](size_t there, size_t here, size_t n) { std::copy_n(state + here, n, to + there); });
    to += of_state.bytes / sizeof(float);
    state += layout_.cells * layout_.planes;
    for (size_t y = 0; y < size_t(height_); ++y) std::copy_n(state + y * width_, width_, to + y * pitch_);
    const VkCommandBuffer commands = context_->begin();
    const VkBufferCopy planes{0, 0, of_state.bytes}, pressure{of_state.bytes, 0, of_pressure.bytes};
    context_->calls().vkCmdCopyBuffer(commands, staging.handle(), state_[from_].handle(), 1, &planes);
    context_->calls().vkCmdCopyBuffer(commands, staging.handle(), pressure_[from_].handle(), 1, &pressure);
    context_->barrier(commands);
    context_->submit();
}

} // namespace dermis::vulkan
