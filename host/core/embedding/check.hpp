// SPDX-License-Identifier: MIT
// The skin that every test of bits presses.
#pragma once

#include "host/core/model/stream.hpp"

#include <array>

namespace dermis {

// Its size is odd; its maps are noise from below the flush limit to about 1. chain: its elements.
SkinDescription sample_skin(Stencil, Edges, bool materials, const model::Chain&);
Map sample_pressure(); // Pa

// The sample skin, pressed twice frame by frame.
class SampleStream {
  public:
    static constexpr int presses = 2;
    static constexpr double dt = 0.125; // s

    static constexpr model::Wanted every = {true, true, true, true, true};
    struct Options {
        Stencil stencil = Stencil::five_point;
        Edges edges = Edges::mirror;
        Precision precision = Precision::f32;
        bool materials = false, sites = false; // sites: receptors of the wanted classes respond, otherwise every cell
        bool pads = false;                     // a batch of two
        Hold hold = Hold::linear;
        bool gains = true;  // FA2's
        model::Chain chain; // elements in series, at most 10
        model::Wanted wanted = every;
        Depths depth; // of classes, in cells
        DepthKernels kernel;
    };
    explicit SampleStream(const Options&);
    // Makes a sample that runs the same kernels as another skin.
    explicit SampleStream(const model::StreamedSkin& like);

    const model::StreamedSkin& skin() const { return streamed_; }
    const model::ResponseLayout& layout() const { return layout_; }
    // The pressures at rest and at the end of each press: pitch*height values of each pad.
    std::vector<std::vector<float>> pressures() const;
    // The steps of press i = 0, 1. The second press of a batch has a step for each pad, which is another kernel.
    // before: of each pad.
    model::StepLengths steps(int i, double* before) const {
        static constexpr double of_pads[] = {dt, dt};
        return {.dt = of_pads,
                .each = streamed_.pads > 1 && i > 0,
                .before = before,
                .parabolic = streamed_.hold == Hold::parabolic};
    }
    // The indices, in a map of pitch*height, of two cells on whose pressure some response depends.
    std::array<size_t, 2> read_cells() const;
    // Presses a stream of the sample. Returns the responses after each press, laid out as layout() says. pressures: as
    // pressures() has them.
    std::vector<std::vector<float>> pressed(model::Stream&, const std::vector<std::vector<float>>& pressures) const;
    // The same by the plain loops.
    std::vector<std::vector<float>> expected(const std::vector<std::vector<float>>& pressures) const;
    // Whether two responses have the same bits; cells beyond the width of a field do not count.
    bool same(const float* a, const float* b) const;

  private:
    model::StreamedSkin streamed_;
    model::ResponseLayout layout_;
};

// Whether presses of a skin like this one have the bits of the CPU path's plain loops.
bool presses_exactly(model::Backend&, const model::StreamedSkin&);

} // namespace dermis
