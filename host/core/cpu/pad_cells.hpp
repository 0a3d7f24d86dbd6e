// SPDX-License-Identifier: MIT
// The states of pads, skins of one description, and the press of one pad, in f32. The loops see a pad as one long row:
// all its cells, or only the cells that its sites read, one after another. Narrow rows then cost no more than wide
// ones.
#pragma once

#include "host/core/cpu/planes.hpp"
#include "host/core/cpu/site_readers.hpp"
#include "host/core/model/streamed_skin.hpp"

namespace dermis::cpu {

class PadCells {
  public:
    PadCells(const plan::StreamedSkin&, int threads, const simd::Isa&);

    // Whether a skin's sites read so few cells that it is faster to step only these cells, on one thread. threads: the
    // number of threads that would step all cells.
    static bool sparse(const plan::PreparedSkin&, const plan::SiteCells&, int threads);

    // cells(): the cells of a pad that are stepped. pitch(): numbers from pad to pad of a pressure, which are cells and
    // padding.
    size_t cells() const { return cells_; }
    size_t pitch() const { return pitch_; }
    // The cells of a frame that are stepped; empty: all of them.
    const std::vector<size_t>& read_cells() const { return read_; }
    // The number of cells that a saved state holds: all cells, or where there are sites the cells that sites read.
    size_t held() const { return held_.empty() ? cells_ : held_.size(); }
    // The elements in series of the cells that are stepped, for a pad without elements of its own.
    const std::vector<plan::Element>& elements() const { return elements_; }

    struct Press {
        const float *from, *to; // pressures of the cells
        const f32::Coefficients* table;
        std::array<float*, RESPONSE_MAPS> response; // null: not asked for
    };
    // Presses a pad. thread: the number of the calling thread, 0 .. threads - 1.
    void press(int thread, int pad, const Press&);

    void rest(int pad);
    // Copies the planes of a pad's state (plan::StateLayout), without the pressure.
    void save(int pad, char* planes) const;
    void load(int pad, const char* planes);

  private:
    // Rows in which every cell reads its neighbours at the same distances, or one row near an edge.
    struct RowGroup {
        int first, rows;
    };
    struct Worker {
        std::array<Plane<float>, STEP_SIGNALS> signals;
        Plane<float> strain, along;                     // of chains, the sum of its elements; second differences
        std::array<Plane<float>, RESPONSE_MAPS> fields; // fields from which sites are read
    };

    void find_row_groups();
    void answer(const Worker&, const simd::StateRow<float>&, const Press&, const f32::Constants&) const;
    simd::RespondArguments<f32> respond_arguments(const Worker&, const simd::StateRow<float>&, const Press&,
                                                  const RowGroup&) const;
    // The signal of each response, from a cell on. strain: the strain of the cells.
    static std::array<const float*, RESPONSE_MAPS> signals_of(const Worker&, const simd::StateRow<float>&,
                                                              const float* strain, size_t cell);
    // Calls f(first number, its place in a saved state in bytes, bytes) for each run of numbers that a state holds.
    template <class F> void each_run(int pad, F f) const;

    const int width_, height_, stencil_, edges_;
    const plan::Variant variant_;
    const simd::Loops<f32>& loops_;
    const std::vector<Site> sites_;
    std::vector<size_t> read_, held_; // held_: empty where all cells that are stepped are held
    std::vector<plan::Element> elements_;
    std::vector<int> material_; // index of each cell's first element; empty: the same in all
    size_t cells_ = 0, pitch_ = 0;
    f32::Constants constants_;
    Plane<float> rest_curvature_;
    std::vector<RowGroup> row_groups_;
    std::optional<SitesOfFields> of_fields_;
    std::optional<SitesOfCells> of_cells_;
    State<float> state_; // a row for each pad
    std::vector<Worker> workers_;
};

} // namespace dermis::cpu
