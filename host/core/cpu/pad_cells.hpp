// SPDX-License-Identifier: MIT
// The states of pads, skins of one description, and the press of pads that stand side by side, in f32. The loops see a
// pad as one long row: all its cells, or only the cells that its sites read, one after another.
#pragma once

#include "host/core/cpu/planes.hpp"
#include "host/core/cpu/site_readers.hpp"
#include "host/core/model/stream.hpp"

namespace dermis::cpu {

class PadCells {
  public:
    PadCells(const model::StreamedSkin&, int threads, const simd::Isa&);

    // Whether a skin's sites read so few cells that it is faster to step only these cells, on one thread. threads: the
    // number of threads that would step all cells.
    static bool sparse(const model::PreparedSkin&, const model::SiteCells&, int threads);

    // Numbers from pad to pad of a pressure: the cells of a pad that are stepped, and padding.
    size_t pitch() const { return pitch_; }
    // The most pads that one call of press() takes.
    size_t together() const { return together_; }
    // The cells of a frame that are stepped; empty: all of them.
    const std::vector<size_t>& read_cells() const { return read_; }
    // The elements in series of the cells that are stepped, for a pad without elements of its own.
    const std::vector<model::Element>& elements() const { return elements_; }

    struct Press {
        int first, count;                           // the pads
        const float *from, *to;                     // pressures of their cells
        const f32::Coefficients* table;             // of all of them
        std::array<float*, RESPONSE_MAPS> response; // null: not asked for
        bool answers;                               // responses are computed
    };
    // thread: the number of the calling thread, 0 .. threads - 1.
    void press(int thread, const Press&);

    void rest(int pad);
    // Copies the planes of a pad's state (model::StateLayout), without the pressure, to or, where Byte is const, from
    // the caller's memory.
    template <class Byte> void transfer(int pad, Byte* planes) const {
        state_.each_plane([&](float* plane) {
            float* const own = plane + size_t(pad) * pitch_;
            if (held_.empty()) model::copy_state(planes, own, cells_);
            for (const size_t cell : held_) model::copy_state(planes, own + cell, 1);
        });
    }
    // Copies some cells of the first of these planes, then of the pressures of a pad's cells.
    void read(int pad, const std::vector<model::HeldCell>&, size_t planes, const float* pressure, float* to) const;

  private:
    struct Worker {
        std::array<Plane<float>, STEP_SIGNALS> signals;
        Plane<float> strain;                            // of the cells, from number guard_ on
        std::array<Plane<float>, RESPONSE_MAPS> fields; // fields from which sites are read
    };

    void find_neighbours(const model::PreparedSkin&);
    // Notes where neighbour n of a cell is, unless it is `inner` cells away.
    void note_neighbour(size_t cell, int n, int distance, int inner);
    void answer(const Worker&, const float* strain, const std::array<const float*, RESPONSE_MAPS>& signals,
                const Press&, const f32::Constants&) const;

    const model::Variant variant_;
    const simd::Isa& isa_;
    const std::vector<Site> sites_;
    std::vector<size_t> read_, held_; // held_: empty where all cells that are stepped are held
    std::vector<model::Element> elements_;
    size_t cells_ = 0, pitch_ = 0, together_ = 1, guard_ = 0;
    std::vector<int> material_; // index of the first element of each cell of pads together; empty: the same in all
    std::vector<int> line_material_;
    f32::Constants constants_;
    std::vector<float> rest_curvature_, weights_; // of a pad's cells; and the published stencil's weights
    std::vector<int> edge_;                       // see simd::PadResponses
    simd::PadResponses neighbours_{};             // what all presses share
    std::optional<SitesOfFields> of_fields_;
    std::optional<SitesOfCells> of_cells_;
    State<float> state_; // a row for each pad
    std::vector<Worker> workers_;
};

} // namespace dermis::cpu
