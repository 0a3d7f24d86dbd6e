// SPDX-License-Identifier: MIT
// The interface of a backend, the CPU path or a Vulkan device: its Stream presses frames.
#pragma once

#include "host/core/model/fibres.hpp"
#include "host/core/model/streamed_skin.hpp"

#include <memory>
#include <vector>

namespace dermis::model {

// A cell that a state holds: its number there, and in the grid.
struct HeldCell {
    size_t held, cell;
};

// A batch of pads, skins of one description, that is pressed frame by frame; a single skin is a batch of one. A press
// is take() or take_cells(), then prepare(), then press(). The first two change no state; press() refuses and allocates
// nothing.
class Stream {
  public:
    virtual ~Stream() = default;
    // Copies the next pressures of these pads, Pa, width*height numbers for each pad: of the listed pads in their
    // order, or, by_number, of all pads from 0 on. Returns false if a number is not finite; other pressures must then
    // be taken before the next press.
    virtual bool take(const PadList&, const float* pressures, bool by_number = false) = 0;
    // The same with the pressures of some cells alone, which are all that the sites read. cells: of a frame of so many
    // cells, ascending.
    virtual bool take_cells(const PadList& pads, const float* pressures, const std::vector<size_t>& cells,
                            size_t frame) {
        frames_.assign(pads.count * frame, 0);
        for (size_t i = 0; i < pads.count; ++i)
            for (size_t cell : cells) frames_[i * frame + cell] = *pressures++;
        return take(pads, frames_.data());
    }
    // Whether a press of pressures that are all 0 leaves a pad as it is.
    virtual bool rests(int pad) const = 0;
    // Makes the coefficients of these pads' steps. Returns null, or a pointer to a step for which a coefficient does
    // not fit a float.
    virtual const double* prepare(const PadList&, const StepLengths&) = 0;
    // Steps the same pads by the same steps. Pressures run from the pressures of the previous press to the pressures
    // that were taken. answers: otherwise others follow; its responses need not be computed, and it may wait for them.
    virtual void press(const PadList&, const StepLengths&, bool answers = true) = 0;
    // Copies numbers. Returns whether all of them are finite.
    virtual bool copy(const float* numbers, size_t count, float* to) {
        return copy_rows({.from = numbers, .stride = count, .width = count, .to = to, .pitch = count}, 0, 1);
    }
    // Whether press_frames() presses several frames in one pass; if not, it is not called.
    virtual bool joins_frames() const { return false; }
    // Presses `count` frames; the first step is prepared, and only the last press answers. frames: the library's
    // memory, one after another, each of `numbers` finite numbers.
    virtual void press_frames(const PadList&, const float* /*frames*/, size_t /*count*/, size_t /*numbers*/,
                              const StepLengths&) {}
    // The responses of the last press of each pad, fields of width*height or sites in the order given, pad by pad; the
    // same memory, which every press fills again once a response has been asked for.
    virtual const float* response(Quantity) = 0;
    virtual void reset(const PadList&) = 0; // back to skins at rest
    // Copies the states of pads, laid out by StateLayout, to and from memory of the caller's. Where there are sites,
    // the pressure of a cell that no site reads may be any number.
    virtual void save(const PadList&, const StateMemory<char>&) = 0;
    virtual void load(const PadList&, const StateMemory<const char>&) = 0;
    // Copies what the states of pads hold of some cells, ascending: for each pad the first `planes` planes, in the
    // order of save(), then their pressures. Needs reserve_states().
    virtual void read(const PadList&, const std::vector<HeldCell>&, size_t planes, float* to) = 0;
    // Keeps memory in which the states of all pads are copied, so that save(), load() and read() allocate nothing.
    virtual void reserve_states() {}
    // Gives pads other elements in series, the same number as before; strains are kept.
    virtual void set_elements(const PadList&, const std::vector<Element>&) = 0;

  private:
    std::vector<float> frames_; // of take_cells()
};

// The properties of a backend that the planner uses. Costs serve to choose, they are no promise.
struct Capabilities {
    std::string name;
    bool f64 = false;             // marches in double too
    int threads = 0;              // host threads that share the work; 0: none
    bool double_buffered = false; // holds each state twice and stores every response; otherwise it steps in place
    double cell_step = 0;         // seconds per cell and step in f32, on all threads
    double dispatch = 0;          // seconds per dispatch; 0: no dispatches
};

class Backend {
  public:
    virtual ~Backend() = default;
    virtual Capabilities capabilities() const = 0;
    int threads() const { return capabilities().threads; }
    virtual std::unique_ptr<Stream> stream(const StreamedSkin&) = 0;
    // Returns whether streams of a skin like this one have the CPU path's bits. The first call for a kernel tests it.
    virtual bool exact(const StreamedSkin&) { return true; }
    // Nerve fibres in each of so many pads. Throws Error::device, and Error::no_device where they have other bits than
    // on the CPU path.
    virtual std::unique_ptr<FibrePopulation<f32>> fibres(const std::vector<FibreKind>&, size_t pads) = 0;
};

} // namespace dermis::model
