// SPDX-License-Identifier: MIT
#include "host/core/embedding/runner.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/embedding/skin_program.hpp"
#include "host/core/vulkan/windows.hpp"

#include <algorithm>
#include <cstring>
#include <tuple>

namespace dermis::vulkan {
namespace {

VkDescriptorBufferInfo info(const Buffer& b) { return {b.handle(), 0, b.bytes()}; }

// Makes the program; throws Error::bad_input where its memory exceeds the device's, before anything is allocated.
SkinProgram fitting(Context& context, const plan::StreamedSkin& skin) {
    SkinProgram program = program_of(context, skin, 2);
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
    : pads_(size_t(skin.pads)), width_(size_t(skin.skin.width())), pitch_(size_t(skin.skin.pitch)),
      height_(skin.skin.height()), layout_(state_layout_of(skin)), variant_(specialization(skin.variant())),
      sites_(!skin.skin.description.sites.empty()), context_(std::move(context)), recording_(*context_),
      program_(fitting(*context_, skin)), constants_(buffer(program_.memory().constants, Buffer::Location::device)),
      state_{buffer(program_.memory().state, Buffer::Location::device),
             buffer(program_.memory().state, Buffer::Location::device)},
      pressure_{buffer(program_.memory().pressure, Buffer::Location::device),
                buffer(program_.memory().pressure, Buffer::Location::device)},
      response_(buffer(program_.memory().response, Buffer::Location::device)),
      invalid_(buffer(program_.memory().invalid, Buffer::Location::device)),
      upload_(buffer(program_.memory().pressure, Buffer::Location::host)),
      download_(buffer(program_.memory().response, Buffer::Location::host)), tables_(skin, skin.skin.materials),
      pad_(pads_), numbers_(pads_), steps_(pads_) {
    listed_.reserve(pads_);
    variant_.push_back(sites_);
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
        if (!sites_ && width_ != pitch_ && skin.wanted[q])
            dense_[q - QUANTITY_SA1].resize(pads_ * width_ * size_t(height_));
    std::memset(upload_.data(), 0, upload_.bytes()); // cells beyond the width stay 0
    reset({.count = pads_});
}

Buffer SkinRunner::buffer(const Memory& m, Buffer::Location location) {
    return Buffer(*context_, std::max<VkDeviceSize>(m.bytes, 4), location);
}

void SkinRunner::fill(Buffer& buffer, const Memory& m) {
    const VkCommandBuffer commands = recording_.begin();
    if (m.initial.empty()) {
        context_->calls().vkCmdFillBuffer(commands, buffer.handle(), 0, VK_WHOLE_SIZE, 0);
        recording_.barrier();
        recording_.submit();
        return;
    }
    Buffer staging(*context_, m.initial.size(), Buffer::Location::host);
    std::memcpy(staging.data(), m.initial.data(), m.initial.size());
    const VkBufferCopy region{0, 0, m.initial.size()};
    context_->calls().vkCmdCopyBuffer(commands, staging.handle(), buffer.handle(), 1, &region);
    recording_.barrier();
    recording_.submit();
}

bool SkinRunner::exact() {
    auto& known = context_->exact_variants();
    if (const auto found = known.find(variant_); found != known.end()) return found->second;
    const bool exact = passes_check();
    known[variant_] = exact;
    return exact;
}

bool SkinRunner::passes_check() {
    make_check(program_);
    const Memory& m = program_.memory().check;
    Buffer check(*context_, m.bytes, Buffer::Location::device), back(*context_, m.bytes, Buffer::Location::host);
    fill(check, m);
    program_.bind_check(info(check));
    const VkCommandBuffer commands = recording_.begin();
    if (!program_.record_check(commands)) return false;
    recording_.barrier();
    const VkBufferCopy region{0, 0, m.bytes};
    context_->calls().vkCmdCopyBuffer(commands, check.handle(), back.handle(), 1, &region);
    recording_.barrier();
    recording_.submit();
    return program_.check_passed(back.data(), back.bytes());
}

bool SkinRunner::take(const plan::PadList& pads, const float* pressures) {
    context_->need_working();
    const size_t rows = size_t(height_), cells = rows * width_;
    bool finite = true;
    for (size_t i = 0; i < pads.count; ++i, pressures += cells) {
        Pad& pad = pad_[size_t(pads[i])];
        pad.stays_at_rest = pad.rests && pads_ > 1 && plan::all_bits_zero(pressures, cells);
        if (pad.stays_at_rest) continue;
        finite &= plan::copy_rows({.from = pressures,
                                   .stride = width_,
                                   .width = width_,
                                   .to = static_cast<float*>(upload_.data()) + size_t(pads[i]) * rows * pitch_,
                                   .pitch = pitch_},
                                  0, height_);
    }
    return finite;
}

// Lists the pads to press in ascending order, without pads that stay at rest.
void SkinRunner::sort(const plan::PadList& pads, const plan::StepLengths& dt) {
    listed_.clear();
    for (size_t i = 0; i < pads.count; ++i)
        if (!pad_[size_t(pads[i])].stays_at_rest) listed_.emplace_back(pads[i], dt[i]);
    std::ranges::sort(listed_);
    for (size_t i = 0; i < listed_.size(); ++i) std::tie(numbers_[i], steps_[i]) = listed_[i];
}

template <class F> void SkinRunner::each_part(const plan::PadList& pads, VkDeviceSize bytes, F f) const {
    for (size_t i = 0; i < pads.count;) {
        size_t n = 1;
        while (i + n < pads.count && pads[i + n] == pads[i] + int(n)) ++n;
        f(VkDeviceSize(pads[i]) * bytes, n * bytes);
        i += n;
    }
}

const double* SkinRunner::press(const plan::PadList& all, const plan::StepLengths& dt, bool answers) {
    const DefaultFloats guard; // a software driver's threads inherit the floating-point environment
    if (pads_ > 1)
        if (const double* refused = tables_.fill(all, dt)) return refused;
    sort(all, dt);
    const plan::PadList pads{.ids = numbers_.data(), .count = listed_.size()};
    if (pads.count == 0) return nullptr;
    const VolkDeviceTable& vk = context_->calls();
    const VkCommandBuffer commands = recording_.begin();
    each_part(pads, upload_.bytes() / pads_, [&](VkDeviceSize first, VkDeviceSize bytes) {
        const VkBufferCopy in{first, first, bytes};
        vk.vkCmdCopyBuffer(commands, upload_.handle(), pressure_[1 - from_].handle(), 1, &in);
    });
    recording_.barrier();
    const plan::StepLengths steps{.dt = steps_.data(), .each = dt.each, .before = dt.before, .bent = dt.bent};
    if (!record_press(program_, recording_, bindings_[from_], pads, steps)) return &dt[0]; // begin() drops it
    recording_.barrier();
    if (answers) {
        const VkBufferCopy out{0, 0, program_.memory().response.bytes};
        vk.vkCmdCopyBuffer(commands, response_.handle(), download_.handle(), 1, &out);
        recording_.barrier();
    }
    recording_.submit();
    from_ = 1 - from_;
    for (size_t i = 0; i < pads.count; ++i) pad_[size_t(pads[i])].rests = false;
    if (answers) read_responses(pads);
    return nullptr;
}

// Copies the fields of these pads from rows of the pitch to rows of the width.
void SkinRunner::read_responses(const plan::PadList& pads) {
    const size_t rows = size_t(height_);
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
        std::vector<float>& dense = dense_[size_t(q - QUANTITY_SA1)];
        const float* response = static_cast<const float*>(download_.data()) + program_.range(Quantity(q)).first;
        for (size_t i = 0; !dense.empty() && i < pads.count; ++i)
            for (size_t y = size_t(pads[i]) * rows, end = y + rows; y < end; ++y)
                std::copy_n(response + y * pitch_, width_, dense.data() + y * width_);
    }
}

const float* SkinRunner::response(Quantity q) const {
    context_->need_working(); // a press that failed may have written half of a response
    const std::vector<float>& dense = dense_[size_t(q) - QUANTITY_SA1];
    return dense.empty() ? static_cast<const float*>(download_.data()) + program_.range(q).first : dense.data();
}

void SkinRunner::reset(const plan::PadList& pads) {
    const VkCommandBuffer commands = recording_.begin();
    const auto clear = [&](const Buffer& b, VkDeviceSize offset, VkDeviceSize bytes) {
        if (bytes > 0) context_->calls().vkCmdFillBuffer(commands, b.handle(), offset, bytes, 0);
    };
    const auto each_response = [&](const plan::PadList& list, auto f) { // f(first byte, bytes)
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
            const SkinProgram::Range r = program_.range(Quantity(q));
            each_part(list, r.count / pads_ * sizeof(float), [&](VkDeviceSize first, VkDeviceSize bytes) {
                f(VkDeviceSize(r.first) * sizeof(float) + first, bytes);
            });
        }
    };
    for (const Buffer* b : {&state_[0], &state_[1], &pressure_[0], &pressure_[1]})
        each_part(pads, b->bytes() / pads_, [&](VkDeviceSize first, VkDeviceSize bytes) { clear(*b, first, bytes); });
    each_response(pads, [&](VkDeviceSize first, VkDeviceSize bytes) { clear(response_, first, bytes); });
    recording_.barrier();
    recording_.submit();
    // Only after the submission: if that fails, nothing has changed.
    each_response(pads, [&](VkDeviceSize first, VkDeviceSize bytes) {
        std::memset(static_cast<char*>(download_.data()) + first, 0, bytes);
    });
    for (size_t i = 0; i < pads.count; ++i) pad_[size_t(pads[i])] = {};
    read_responses(pads);
}

template <class F> void SkinRunner::each_run(F f) const {
    const size_t planes = layout_.planes;
    for (size_t p = 0; p < planes; ++p)
        if (sites_)
            for (size_t i = 0; i < layout_.cells; ++i) f(i * planes + p, p * layout_.cells + i, 1);
        else
            for (size_t y = 0; y < size_t(height_); ++y)
                f((y * planes + p) * pitch_, p * layout_.cells + y * width_, width_);
}

void SkinRunner::set_elements(const plan::PadList& pads, const std::vector<plan::Element>& elements) {
    tables_.set_elements(pads, elements);
    vulkan::set_elements(program_, pads, elements);
}

void SkinRunner::save(const plan::PadList& pads, const plan::StateMemory<char>& to) {
    context_->need_working();
    const VkDeviceSize of_state = program_.memory().state.bytes / pads_,
                       of_pressure = program_.memory().pressure.bytes / pads_;
    Buffer back(*context_, std::max<VkDeviceSize>(pads.count * (of_state + of_pressure), 4), Buffer::Location::host);
    const VkCommandBuffer commands = recording_.begin();
    VkDeviceSize end = 0;
    for (const auto& [buffer, bytes] : {std::pair{&state_[from_], of_state}, {&pressure_[from_], of_pressure}})
        each_part(pads, bytes, [&, from = buffer->handle()](VkDeviceSize first, VkDeviceSize all) {
            const VkBufferCopy region{first, end, all};
            context_->calls().vkCmdCopyBuffer(commands, from, back.handle(), 1, &region);
            end += all;
        });
    recording_.barrier();
    recording_.submit();
    const auto* state = static_cast<const float*>(back.data());
    const float* pressure = state + pads.count * of_state / sizeof(float);
    const size_t row = width_ * sizeof(float);
    for (size_t i = 0; i < pads.count; ++i, state += of_state / sizeof(float)) {
        each_run([&](size_t there, size_t here, size_t n) {
            std::memcpy(to.strains_of(i) + here * sizeof(float), state + there, n * sizeof(float));
        });
        for (size_t y = 0; y < size_t(height_); ++y, pressure += pitch_)
            std::memcpy(to.pressure_of(i) + y * row, pressure, row);
    }
}

void SkinRunner::load(const plan::PadList& pads, const plan::StateMemory<const char>& saved) {
    context_->need_working();
    const VkDeviceSize of_state = program_.memory().state.bytes / pads_,
                       of_pressure = program_.memory().pressure.bytes / pads_;
    Buffer staging(*context_, std::max<VkDeviceSize>(pads.count * (of_state + of_pressure), 4), Buffer::Location::host);
    auto* state = static_cast<float*>(staging.data());
    std::memset(state, 0, staging.bytes());
    float* pressure = state + pads.count * of_state / sizeof(float);
    const size_t row = width_ * sizeof(float);
    for (size_t i = 0; i < pads.count; ++i, state += of_state / sizeof(float)) {
        each_run([&](size_t there, size_t here, size_t n) {
            std::memcpy(state + there, saved.strains_of(i) + here * sizeof(float), n * sizeof(float));
        });
        for (size_t y = 0; y < size_t(height_); ++y, pressure += pitch_)
            std::memcpy(pressure, saved.pressure_of(i) + y * row, row);
    }
    const VkCommandBuffer commands = recording_.begin();
    VkDeviceSize begin = 0;
    for (const auto& [buffer, bytes] : {std::pair{&state_[from_], of_state}, {&pressure_[from_], of_pressure}})
        each_part(pads, bytes, [&, to = buffer->handle()](VkDeviceSize first, VkDeviceSize all) {
            const VkBufferCopy region{begin, first, all};
            context_->calls().vkCmdCopyBuffer(commands, staging.handle(), to, 1, &region);
            begin += all;
        });
    recording_.barrier();
    recording_.submit();
    for (size_t i = 0; i < pads.count; ++i) pad_[size_t(pads[i])].rests = false;
}

} // namespace dermis::vulkan
