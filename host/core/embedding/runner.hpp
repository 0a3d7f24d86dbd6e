// SPDX-License-Identifier: MIT
// A streamed skin on the library's own device: a SkinProgram with memory and submissions of its own, as an embedding
// host would have them.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/core/base/pool.hpp"
#include "host/core/model/stream.hpp"
#include "host/core/vulkan/recording.hpp"

namespace dermis::vulkan {

class SkinRunner : public model::Stream {
  public:
    SkinRunner(std::shared_ptr<Context>, const model::StreamedSkin&);
    // All functions throw Error::device if the device is lost.
    bool take(const model::PadList&, const float* pressures, bool by_number) override;
    bool rests(int pad) const override { return pads_ > 1 && pad_[size_t(pad)].rests; }
    const double* prepare(const model::PadList& pads, const model::StepLengths& dt) override;
    // A press that does not answer is recorded, and submitted with a later one.
    void press(const model::PadList&, const model::StepLengths&, bool answers) override;
    const float* response(Quantity) override;
    void reset(const model::PadList&) override;
    void save(const model::PadList&, const model::StateMemory<char>&) override;
    void load(const model::PadList&, const model::StateMemory<const char>&) override;
    void read(const model::PadList&, const std::vector<model::HeldCell>&, size_t planes, float* to) override;
    void reserve_states() override {
        const Use use = context_->need_working();
        staging_.emplace(on_host(state_bytes(pads_)));
    }
    void set_elements(const model::PadList&, const std::vector<model::Element>&) override;

  private:
    Recording& recording() { return recordings_[slot_]; }
    size_t frames_together() const;
    VkDeviceSize frame_bytes() const { return program_.memory().pressure.bytes; }
    Buffer on_device(const Memory&);
    Buffer on_host(VkDeviceSize bytes);           // zeros
    VkDeviceSize state_bytes(size_t pads) const { // of their states on the device, with the pressures
        return pads * ((program_.memory().state.bytes + frame_bytes()) / pads_);
    }
    void fill(Buffer&, const Memory&);
    // Copies states to the caller's memory or, where that is const, from there.
    template <class Byte> void transfer(const model::PadList&, const model::StateMemory<Byte>&);
    // Calls f(first byte, bytes) for each run of neighbouring pads of a list. bytes: the size of one pad's part of a
    // buffer.
    template <class F> void each_part(const model::PadList&, VkDeviceSize bytes, F f) const;
    // Calls f(first byte, bytes) for each run of neighbouring pads in each of these responses.
    template <class F> void each_response(const model::PadList&, const model::Wanted&, F f) const;
    void sort(const model::PadList&, const model::StepLengths&);
    // Records the download of these responses of these pads; after it has run, spread() them.
    void download(VkCommandBuffer, const model::PadList&, const model::Wanted&);
    void spread(const model::PadList&, const model::Wanted&);

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

} // namespace dermis::vulkan
