// SPDX-License-Identifier: MIT
// A streamed skin on the library's own device: a SkinProgram with memory and submissions of its own, as an embedding
// host would have them.
#include "host/core/base/float_environment.hpp"
#include "host/core/base/pool.hpp"
#include "host/core/embedding/backend.hpp"
#include "host/core/embedding/skin_program.hpp"
#include "host/core/model/site_cells.hpp"
#include "host/core/vulkan/recording.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>
#include <tuple>

namespace dermis::vulkan {
namespace {

VkDescriptorBufferInfo info(const Buffer& b) { return {b.handle(), 0, b.bytes()}; }

// Makes the program; throws Error::bad_input where its memory exceeds the device's, before anything is allocated.
SkinProgram fitting(Context& context, const model::StreamedSkin& skin) {
    SkinProgram program = program_of(context, skin, 2);
    const MemoryNeeds& n = program.memory();
    const VkDeviceSize all =
        n.constants.bytes + 2 * n.state.bytes + 2 * n.pressure.bytes + n.response.bytes + n.scratch.bytes;
    if (all > context.heap_bytes())
        throw Error(Error::Code::bad_input, "grid.width",
                    "a skin of " + std::to_string(skin.skin.width()) + " x " + std::to_string(skin.skin.height()) +
                        " needs " + std::to_string(all) + " bytes; allowed on this device: device memory = " +
                        std::to_string(context.heap_bytes()) + "; or device cpu");
    return program;
}

class SkinRunner : public model::Stream {
  public:
    SkinRunner(std::shared_ptr<Context> context, const model::StreamedSkin& skin)
        : pads_(size_t(skin.pads)), width_(size_t(skin.skin.width())), pitch_(size_t(skin.skin.pitch)),
          height_(skin.skin.height()), planes_(size_t(skin.variant().state().planes())),
          held_(model::site_cells_of(skin.skin).cells), context_(std::move(context)),
          program_(fitting(*context_, skin)), together_(frames_together()),
          constants_(on_device(program_.memory().constants)), state_{on_device(program_.memory().state),
                                                                     on_device(program_.memory().state)},
          pressure_{on_device(program_.memory().pressure), on_device(program_.memory().pressure)},
          response_(on_device(program_.memory().response)), invalid_(on_device(program_.memory().invalid)),
          scratch_(on_device(program_.memory().scratch)), upload_{on_host(together_ * frame_bytes()),
                                                                  on_host(together_ * frame_bytes())},
          download_(on_host(program_.memory().response.bytes)), recordings_{Recording(*context_), Recording(*context_)},
          tables_(skin, skin.skin.materials), pad_(pads_), numbers_(pads_), steps_(pads_),
          pool_(simd::useful_threads(pads_ * width_ * size_t(height_), 0)) {
        listed_.reserve(pads_);
        fill(constants_, program_.memory().constants);
        fill(invalid_, program_.memory().invalid);
        for (int i = 0; i < 2; ++i)
            bindings_[i] = program_.bind({.constants = info(constants_),
                                          .state_from = info(state_[i]),
                                          .state_to = info(state_[1 - i]),
                                          .pressure_from = info(pressure_[i]),
                                          .pressure_to = info(pressure_[1 - i]),
                                          .response = info(response_),
                                          .invalid = info(invalid_),
                                          .scratch = info(scratch_)});
        for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
            if (skin.sites().empty() && width_ != pitch_ && skin.wanted[q])
                dense_[q - QUANTITY_SA1].resize(pads_ * width_ * size_t(height_));
        context_->calls().vkCmdFillBuffer(recording().begin(), scratch_.handle(), 0, VK_WHOLE_SIZE, 0);
        recording().submit();
        reset({.count = pads_});
    }
    // All functions throw Error::device if the device is lost.
    bool take(const model::PadList& pads, const float* pressures, bool by_number) override {
        recording().wait(); // it reads the upload
        float* const upload = static_cast<float*>(upload_[slot_].data()) + recorded_ * frame_bytes() / sizeof(float);
        const size_t rows = size_t(height_), cells = rows * width_;
        const auto pressure_of = [&](size_t i) { return pressures + (by_number ? size_t(pads[i]) : i) * cells; };
        for (size_t i = 0; i < pads.count; ++i) {
            Pad& pad = pad_[size_t(pads[i])];
            pad.stays_at_rest = pad.rests && pads_ > 1 && model::all_bits_zero(pressure_of(i), cells);
        }
        std::atomic<bool> finite = true;
        const auto some = [&](size_t first, size_t last) { // rows, counted through all these pads
            for (size_t i = first / rows; first < last; ++i) {
                const size_t end = std::min(last, (i + 1) * rows), pad = size_t(pads[i]);
                const model::PressureCopy copy{.from = pressure_of(i),
                                               .stride = width_,
                                               .width = width_,
                                               .to = upload + pad * rows * pitch_,
                                               .pitch = pitch_};
                if (!pad_[pad].stays_at_rest && !model::copy_rows(copy, int(first - i * rows), int(end - i * rows)))
                    finite = false;
                first = end;
            }
        };
        pool_.share(static_cast<long long>(pads.count * rows), std::ref(some)); // a reference: nothing is allocated
        return finite;
    }
    bool rests(int pad) const override { return pads_ > 1 && pad_[size_t(pad)].rests; }
    const double* prepare(const model::PadList& pads, const model::StepLengths& dt) override {
        const DefaultFloats guard;
        return tables_.fill(pads, dt);
    }
    // A press that does not answer is recorded, and submitted with a later one.
    void press(const model::PadList& all, const model::StepLengths& dt, bool answers) override {
        const Use use = context_->need_working();
        const DefaultFloats guard; // a software driver's threads inherit the floating-point environment
        sort(all, dt);
        const model::PadList pads{.ids = numbers_.data(), .count = listed_.size()};
        if (pads.count == 0) return;
        const VolkDeviceTable& vk = context_->calls();
        size_t n = std::exchange(recorded_, 0); // if something fails, begin() drops what is recorded
        const int from = (from_ + int(n)) % 2;
        const VkCommandBuffer commands = n > 0 ? recording().commands() : recording().begin();
        each_part(pads, frame_bytes() / pads_, [&](VkDeviceSize first, VkDeviceSize bytes) {
            const VkBufferCopy in{n * frame_bytes() + first, first, bytes};
            vk.vkCmdCopyBuffer(commands, upload_[slot_].handle(), pressure_[1 - from].handle(), 1, &in);
        });
        recording().barrier();
        const model::StepLengths steps{
            .dt = steps_.data(), .each = dt.each, .before = dt.before, .parabolic = dt.parabolic};
        (void)record_press(program_, recording(), bindings_[from], pads, steps,
                           answers); // true: prepare() has checked it
        recording().barrier();
        for (size_t i = 0; i < pads.count; ++i) pad_[size_t(pads[i])].rests = false;
        if (++n < together_ && !answers) {
            recorded_ = n;
            return;
        }
        const bool reads = answers && read_ != model::Wanted{};
        if (reads) download(commands, pads, read_);
        recording().start();
        from_ = (from_ + int(n)) % 2;
        if (reads) {
            recording().wait();
            spread(pads, read_);
        }
        slot_ = 1 - slot_;
    }
    const float* response(Quantity q) override {
        const Use use = context_->need_working(); // a press that failed may have written half of a response
        if (model::Wanted first{}; !read_[size_t(q)]) {
            first[size_t(q)] = true;
            download(recording().begin(), {.count = pads_}, first);
            recording().submit();
            spread({.count = pads_}, first);
            read_[size_t(q)] = true;
        }
        const std::vector<float>& dense = dense_[size_t(q) - QUANTITY_SA1];
        return dense.empty() ? static_cast<const float*>(download_.data()) + program_.range(q).first : dense.data();
    }
    void reset(const model::PadList& pads) override {
        const Use use = context_->need_working();
        const VkCommandBuffer commands = recording().begin();
        const auto clear = [&](const Buffer& b, VkDeviceSize first, VkDeviceSize bytes) {
            if (bytes > 0) context_->calls().vkCmdFillBuffer(commands, b.handle(), first, bytes, 0);
        };
        for (const auto& [buffers, bytes] :
             {std::pair{state_, program_.memory().state.bytes}, {pressure_, frame_bytes()}})
            for (int i : {0, 1})
                each_part(pads, bytes / pads_, [&, &b = buffers[i]](auto first, auto n) { clear(b, first, n); });
        model::Wanted all;
        all.fill(true);
        each_response(pads, all, [&](VkDeviceSize first, VkDeviceSize bytes) { clear(response_, first, bytes); });
        recording().barrier();
        download(commands, pads, read_);
        recording().submit();
        for (size_t i = 0; i < pads.count; ++i) pad_[size_t(pads[i])] = {};
        spread(pads, read_);
    }
    void save(const model::PadList& pads, const model::StateMemory<char>& to) override { transfer(pads, to); }
    void load(const model::PadList& pads, const model::StateMemory<const char>& saved) override {
        transfer(pads, saved);
        for (size_t i = 0; i < pads.count; ++i) pad_[size_t(pads[i])].rests = false;
    }
    // Downloads the rows of pressure and of a state that hold these cells.
    void read(const model::PadList& pads, const std::vector<model::HeldCell>& cells, size_t planes,
              float* to) override {
        const Use use = context_->need_working();
        const VkDeviceSize of_state = program_.memory().state.bytes / pads_, of_pressure = frame_bytes() / pads_;
        const auto *state = static_cast<const float*>(staging_->data()),
                   *pressure = state + pads_ * of_state / sizeof(float);
        const VkCommandBuffer commands = recording().begin();
        const auto row_of = [this](const model::HeldCell& c) { return c.cell / width_; };
        const auto download = [&](const Buffer& from, VkDeviceSize at, VkDeviceSize of_pad, size_t of_row) {
            for (size_t i = 0; i < pads.count; ++i)
                for (size_t k = 0, n; k < cells.size(); k += n) { // ascending cells: rows side by side at once
                    const size_t first = row_of(cells[k]);
                    size_t last = first;
                    for (n = 1; k + n < cells.size() && row_of(cells[k + n]) <= last + 1; ++n)
                        last = row_of(cells[k + n]);
                    const VkDeviceSize bytes = of_row * sizeof(float), source = VkDeviceSize(pads[i]) * of_pad;
                    const VkBufferCopy region{source + first * bytes, at + i * of_pad + first * bytes,
                                              (last + 1 - first) * bytes};
                    context_->calls().vkCmdCopyBuffer(commands, from.handle(), staging_->handle(), 1, &region);
                }
        };
        download(state_[from_], 0, of_state, planes_ * pitch_);
        download(pressure_[from_], pads_ * of_state, of_pressure, pitch_);
        recording().submit();
        for (size_t i = 0; i < pads.count;
             ++i, state += of_state / sizeof(float), pressure += of_pressure / sizeof(float)) {
            for (size_t p = 0; p < planes; ++p)
                for (const model::HeldCell& c : cells)
                    *to++ = state[(row_of(c) * planes_ + p) * pitch_ + c.cell % width_];
            for (const model::HeldCell& c : cells) *to++ = pressure[row_of(c) * pitch_ + c.cell % width_];
        }
    }
    void reserve_states() override {
        const Use use = context_->need_working();
        staging_.emplace(on_host(state_bytes(pads_)));
    }
    void set_elements(const model::PadList& pads, const std::vector<model::Element>& elements) override {
        tables_.set_elements(pads, elements);
        vulkan::set_elements(program_, pads, elements);
    }

  private:
    Recording& recording() { return recordings_[slot_]; }
    // A submission is not cut between two presses of several: if its second part failed, the state would be of no
    // frame.
    size_t frames_together() const {
        constexpr double most_frames = 64, most_bytes = 4 << 20;
        const double work = work_of_press(program_) * double(pads_), most = context_->pipelines().device().most_work;
        return size_t(std::max(1.0, std::min({most_frames, most_bytes / double(frame_bytes()), most / work})));
    }
    VkDeviceSize frame_bytes() const { return program_.memory().pressure.bytes; }
    Buffer on_device(const Memory& m) {
        return Buffer(*context_, std::max<VkDeviceSize>(m.bytes, 4), Buffer::Location::device);
    }
    // zeros
    Buffer on_host(VkDeviceSize bytes) {
        Buffer buffer(*context_, std::max<VkDeviceSize>(bytes, 4), Buffer::Location::host);
        std::memset(buffer.data(), 0, buffer.bytes());
        return buffer;
    }
    VkDeviceSize state_bytes(size_t pads) const { // of their states on the device, with the pressures
        return pads * ((program_.memory().state.bytes + frame_bytes()) / pads_);
    }
    void fill(Buffer& buffer, const Memory& m) {
        const Buffer staging = on_host(m.bytes);
        std::ranges::copy(m.initial, static_cast<unsigned char*>(staging.data()));
        const VkBufferCopy region{0, 0, staging.bytes()};
        context_->calls().vkCmdCopyBuffer(recording().begin(), staging.handle(), buffer.handle(), 1, &region);
        recording().submit();
    }
    // Copies states to the caller's memory or, where that is const, from there.
    template <class Byte> void transfer(const model::PadList& pads, const model::StateMemory<Byte>& saved) {
        constexpr bool saves = !std::is_const_v<Byte>;
        const Use use = context_->need_working();
        const VkDeviceSize of_state = program_.memory().state.bytes / pads_, of_pressure = frame_bytes() / pads_;
        std::optional<Buffer> own;
        if (!staging_) own.emplace(on_host(state_bytes(pads.count)));
        const Buffer& staging = staging_ ? *staging_ : *own;
        const auto move = [&] { // between the staging buffer and the caller's memory
            auto *state = static_cast<float*>(staging.data()),
                 *pressure = state + pads.count * of_state / sizeof(float);
            // A plane of a state: rows of cells, or single cells that sites read.
            const size_t rows = size_t(height_), row = planes_ * pitch_;
            for (size_t i = 0; i < pads.count; ++i, state += of_state / sizeof(float)) {
                Byte *strains = saved.strains_of(i), *pressed = saved.pressure_of(i);
                for (size_t p = 0; p < planes_; ++p) {
                    float* const plane = state + p * pitch_;
                    for (size_t y = 0; held_.empty() && y < rows; ++y)
                        model::copy_state(strains, plane + y * row, width_);
                    for (const size_t cell : held_)
                        model::copy_state(strains, plane + cell / width_ * row + cell % width_, 1);
                }
                for (size_t y = 0; y < rows; ++y, pressure += pitch_) model::copy_state(pressed, pressure, width_);
            }
        };
        if (!saves) move();
        const VkCommandBuffer commands = recording().begin();
        VkDeviceSize at = 0;
        for (const auto& [buffer, bytes] : {std::pair{&state_[from_], of_state}, {&pressure_[from_], of_pressure}})
            each_part(pads, bytes, [&, held = buffer->handle()](VkDeviceSize first, VkDeviceSize all) {
                const VkBufferCopy region{saves ? first : at, saves ? at : first, all};
                context_->calls().vkCmdCopyBuffer(commands, saves ? held : staging.handle(),
                                                  saves ? staging.handle() : held, 1, &region);
                at += all;
            });
        recording().submit();
        if (saves) move();
    }
    // Calls f(first byte, bytes) for each run of neighbouring pads of a list. bytes: the size of one pad's part of a
    // buffer.
    template <class F> void each_part(const model::PadList& pads, VkDeviceSize bytes, F f) const {
        for (size_t i = 0; i < pads.count;) {
            size_t n = 1;
            while (i + n < pads.count && pads[i + n] == pads[i] + int(n)) ++n;
            f(VkDeviceSize(pads[i]) * bytes, n * bytes);
            i += n;
        }
    }
    // Calls f(first byte, bytes) for each run of neighbouring pads in each of these responses.
    template <class F> void each_response(const model::PadList& pads, const model::Wanted& which, F f) const {
        for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
            const SkinProgram::Range r = program_.range(Quantity(q));
            if (!which[q] || r.count == 0) continue;
            each_part(pads, r.count / pads_ * sizeof(float), [&](VkDeviceSize first, VkDeviceSize bytes) {
                f(VkDeviceSize(r.first) * sizeof(float) + first, bytes);
            });
        }
    }
    // Lists the pads to press in ascending order, without pads that stay at rest.
    void sort(const model::PadList& pads, const model::StepLengths& dt) {
        listed_.clear();
        for (size_t i = 0; i < pads.count; ++i)
            if (!pad_[size_t(pads[i])].stays_at_rest) listed_.emplace_back(pads[i], dt[i]);
        std::ranges::sort(listed_);
        for (size_t i = 0; i < listed_.size(); ++i) std::tie(numbers_[i], steps_[i]) = listed_[i];
    }
    // Records the download of these responses of these pads; after it has run, spread() them.
    void download(VkCommandBuffer commands, const model::PadList& pads, const model::Wanted& which) {
        each_response(pads, which, [&](VkDeviceSize first, VkDeviceSize bytes) {
            const VkBufferCopy out{first, first, bytes};
            context_->calls().vkCmdCopyBuffer(commands, response_.handle(), download_.handle(), 1, &out);
        });
    }
    // Copies fields from rows of the pitch to rows of the width.
    void spread(const model::PadList& pads, const model::Wanted& which) {
        const size_t rows = size_t(height_);
        for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
            std::vector<float>& dense = dense_[q - QUANTITY_SA1];
            const float* response = static_cast<const float*>(download_.data()) + program_.range(Quantity(q)).first;
            for (size_t i = 0; which[q] && !dense.empty() && i < pads.count; ++i)
                for (size_t y = size_t(pads[i]) * rows, end = y + rows; y < end; ++y)
                    std::copy_n(response + y * pitch_, width_, dense.data() + y * width_);
        }
    }

    const size_t pads_, width_, pitch_;
    const int height_;
    const size_t planes_;            // of a state
    const std::vector<size_t> held_; // the cells that sites read, which a saved state has alone; empty without sites
    std::shared_ptr<Context> context_;
    SkinProgram program_;
    const size_t together_; // the frames that are pressed in one submission, at most
    // Cells beyond the width stay 0 in an upload, which holds so many frames.
    Buffer constants_, state_[2], pressure_[2], response_, invalid_, scratch_, upload_[2], download_;
    // A press whose responses nobody reads is not waited for: the next one takes the other upload and recording. They
    // end before what they use.
    Recording recordings_[2];
    std::optional<Buffer> staging_;                       // for the states of all pads, if it is kept
    int slot_ = 0;                                        // the upload and the recording that come next
    size_t recorded_ = 0;                                 // the frames of the upload whose presses are recorded
    std::array<std::vector<float>, RESPONSE_MAPS> dense_; // fields of width*height, where the pitch is greater
    Binding bindings_[2];
    model::Wanted read_{}; // the responses that have been asked for: every press downloads them
    int from_ = 0;         // the index of the state and the pressure that the next submission starts from
    model::StepTables tables_;
    struct Pad {
        bool rests = true;         // nothing has ever pressed it
        bool stays_at_rest = true; // the pressure that was taken last does not press it either
    };
    std::vector<Pad> pad_;
    std::vector<std::pair<int, double>> listed_; // pads to press and their steps, ascending
    std::vector<int> numbers_;
    std::vector<double> steps_;
    simd::Pool pool_; // copies pressures: a GPU takes them faster than one thread copies them
};

} // namespace

std::unique_ptr<model::Stream> runner(std::shared_ptr<Context> context, const model::StreamedSkin& skin) {
    return std::make_unique<SkinRunner>(std::move(context), skin);
}

} // namespace dermis::vulkan
