// SPDX-License-Identifier: MIT
// Whether a backend's bits are the CPU path's.
#pragma once

#include "host/plan/backend.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>

namespace dermis {

// Each kernel on small grids in every variant, on a backend and on the plain loops of the CPU path.
struct SelfTest {
    struct Kernel {
        const char* name;
        uint64_t hash = 14695981039346656037u; // of the backend's values
        long long values = 0, different = 0;
    };
    enum { press, fields, reduce, sites };
    Kernel kernels[4] = {{"press"}, {"fields"}, {"reduce"}, {"sites"}};
    bool exact() const {
        return std::all_of(std::begin(kernels), std::end(kernels), [](auto& k) { return k.different == 0; });
    }
};
// every_variant: otherwise the plain march alone.
SelfTest self_test(plan::Backend&, bool every_variant = true);

// A small skin of odd size, pressed twice frame by frame; its maps are noise from below the flush to about 1.
class SampleStream {
  public:
    static constexpr int presses = 2;
    static constexpr double dt = 0.125; // s

    // sites: it has receptors of the classes wanted; otherwise fields.
    SampleStream(Stencil, Edges, bool materials, bool sites, Precision, const plan::Wanted&);
    // Of the same kernels as another skin.
    explicit SampleStream(const plan::StreamedSkin& like);

    const plan::StreamedSkin& skin() const { return streamed_; }
    const plan::ResponseLayout& layout() const { return layout_; }
    // Pressure at the end of press i = 1, 2, or before the first: at rest; pitch*height.
    std::vector<float> pressure(int i) const;
    // Two cells whose pressure some response depends on, in a map of pitch*height.
    std::array<size_t, 2> read_cells() const;
    // The responses after each press by the plain loops, laid out as layout() says; pressures: before, then after each.
    std::vector<std::vector<float>> expected(const std::vector<std::vector<float>>& pressures) const;
    // Whether two responses are the same to the bit; what lies beyond the width of a field is nobody's.
    bool same(const float* a, const float* b) const;

  private:
    plan::StreamedSkin streamed_;
    plan::ResponseLayout layout_;
};

} // namespace dermis
