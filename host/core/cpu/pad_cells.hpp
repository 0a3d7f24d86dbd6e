// SPDX-License-Identifier: MIT
// The states of pads, skins of one description, and the press of pads that stand side by side, in f32. The loops see a
// pad as one long row: all its cells, or only the cells that its sites read, one after another.
#pragma once

#include "host/core/cpu/planes.hpp"
#include "host/core/model/felt.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/model/stream.hpp"

#include <algorithm>

namespace dermis::cpu {

// The two ways to the response of a receptor: from a field of its class, or from the cells that its stencil reads. Both
// give the same bits.

// Reads fields at the sites of each class.
class SitesOfFields {
  public:
    // pitch: cells from row to row of the fields.
    SitesOfFields(const std::vector<Site>& sites, size_t pitch) {
        for (const Site& site : sites)
            cells_[size_t(site.type) - QUANTITY_SA1].push_back(size_t(site.cell.y) * pitch + size_t(site.cell.x));
    }
    void read(const std::array<float*, RESPONSE_MAPS>& fields,
              const std::array<float*, RESPONSE_MAPS>& responses) const {
        for (size_t r = 0; r < RESPONSE_MAPS; ++r)
            std::ranges::transform(cells_[r], responses[r], [field = fields[r]](size_t cell) { return field[cell]; });
    }

  private:
    std::array<std::vector<size_t>, RESPONSE_MAPS> cells_;
};

// Computes the responses of sites from the strain and the signals of the cells in SiteCells, in their order. strain has
// one number more, 0: the strain of cells at rest.
class SitesOfCells {
  public:
    SitesOfCells(const model::PreparedSkin& skin, const model::SiteCells& cells) : stencil_(skin.stencil) {
        for (const Site& site : skin.description.sites)
            sites_[size_t(site.type) - QUANTITY_SA1].emplace_back(skin, cells, site.cell);
    }
    void read(const float* strain, const std::array<const float*, RESPONSE_MAPS>& signals, const f32::Constants& c,
              const std::array<float*, RESPONSE_MAPS>& responses) const {
        for (size_t r = 0; r < RESPONSE_MAPS; ++r)
            std::ranges::transform(sites_[r], responses[r], [&](const model::SitePlace<f32>& site) {
                const float gain = f32::gain_at(site.curvature(strain, stencil_, c.bend), c);
                return f32::answer(int(r) + QUANTITY_SA1, signals[r][site.stencil.here], gain, c);
            });
    }

  private:
    int stencil_;
    std::array<std::vector<model::SitePlace<f32>>, RESPONSE_MAPS> sites_;
};

class PadCells {
  public:
    PadCells(const model::StreamedSkin& s, int threads, const simd::Isa& isa)
        : variant_(s.variant()), isa_(isa), sites_(s.skin.description.sites), elements_(s.skin.materials),
          cells_(s.skin.cells()), constants_(model::frame_constants(s.skin, {})) {
        std::vector<int> material;
        const model::SiteCells read = model::site_cells_of(s.skin);
        if (!sites_.empty() && sparse(s.skin, read, 1)) {
            read_ = read.cells;
            cells_ = read_.size();
            elements_ = read.materials;
            of_cells_.emplace(s.skin, read);
            if (!s.skin.uniform()) material = read.material_of;
        } else {
            if (!sites_.empty()) of_fields_.emplace(sites_, size_t(s.skin.width()));
            if (!sites_.empty()) held_ = read.cells;
            for (size_t i = 0; !s.skin.uniform() && i < cells_; ++i) material.push_back(int(s.skin.material_at(i)));
        }
        pitch_ = padded(cells_);
        if (sites_.empty()) together_ = std::max<size_t>(cells_together / pitch_, 1);
        material.resize(material.empty() ? 0 : pitch_, 0);
        for (size_t i = 0; !material.empty() && i < together_; ++i)
            material_.insert(material_.end(), material.begin(), material.end());
        line_material_ = shared_in_lines(material_);
        if (!of_cells_) find_neighbours(s.skin);
        state_ = {pitch_ * size_t(s.pads), variant_.state()};
        workers_.resize(size_t(threads));
        for (Worker& w : workers_) {
            int place = 0;
            for (Plane<float>& signal : w.signals) signal = Plane<float>(pitch_ * together_ + PITCH_CELLS, ++place);
            w.strain = Plane<float>(pitch_ * together_ + 2 * guard_ + PITCH_CELLS, ++place);
            for (size_t r = 0; of_fields_ && r < RESPONSE_MAPS; ++r) w.fields[r] = Plane<float>(pitch_, ++place);
        }
    }

    // Whether a skin's sites read so few cells that it is faster to step only these cells, on one thread. threads: the
    // number of threads that would step all cells.
    // Measured on 240 x 320 and 20 x 25 cells: a receptor that reads its stencil costs as much as two listed cells;
    // with this factor, which is 0.62 to 0.7 on two processors, both ways take equally long.
    static bool sparse(const model::PreparedSkin& skin, const model::SiteCells& cells, int threads) {
        return double(cells.cells.size() + 2 * cells.points.size()) * threads < 0.65 * double(skin.cells());
    }

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
    void press(int thread, const Press& p) {
        const Worker& worker = workers_[size_t(thread)];
        f32::Constants c = constants_;
        c.coefficients = p.table[0];
        simd::StateRow<float> row = state_.row(p.first, int(pitch_));
        row.strain = worker.strain.data() + guard_;
        simd::AdvanceArguments<f32> a{.count = p.count * int(pitch_),
                                      .elements = int(variant_.chain.elements()),
                                      .spring = variant_.chain.spring,
                                      .pressure = p.from,
                                      .pressure_to = p.to,
                                      .material = material_.empty() ? nullptr : material_.data(),
                                      .line_material = material_.empty() ? nullptr : line_material_.data(),
                                      .table = p.table,
                                      .from = row,
                                      .to = row,
                                      .signal = {}};
        for (size_t s = 0; s < STEP_SIGNALS; ++s)
            if (p.answers && variant_.wanted[QUANTITY_FA1 + s]) a.signal[s] = worker.signals[s].data();
        isa_.in_f32.advance(a, c);
        if (!p.answers) return;
        std::array<const float*, RESPONSE_MAPS> signals = {row.strain, row.value[simd::sum_integral]};
        for (size_t s = 0; s < STEP_SIGNALS; ++s) signals[QUANTITY_FA1 - QUANTITY_SA1 + s] = worker.signals[s].data();
        if (!of_cells_) return answer(worker, row.strain, signals, p, c);
        row.strain[cells_] = 0;
        of_cells_->read(row.strain, signals, c, p.response);
    }

    void rest(int pad) { state_.rest_row(pad, int(pitch_)); }
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
    void read(int pad, const std::vector<model::HeldCell>& cells, size_t planes, const float* pressure,
              float* to) const {
        const auto copy = [&](const float* own) {
            for (const model::HeldCell& c : cells) *to++ = own[held_.empty() ? c.held : held_[c.held]];
        };
        state_.each_plane([&](const float* plane) {
            if (planes > 0) copy(plane + size_t(pad) * pitch_), --planes;
        });
        copy(pressure);
    }

  private:
    // The most cells of pads that are pressed together: their strain and signals fit into the first-level cache.
    static constexpr size_t cells_together = 1024;

    static size_t padded(size_t cells) { return (cells + PITCH_CELLS - 1) / PITCH_CELLS * PITCH_CELLS; }

    struct Worker {
        std::array<Plane<float>, STEP_SIGNALS> signals;
        Plane<float> strain;                            // of the cells, from number guard_ on
        std::array<Plane<float>, RESPONSE_MAPS> fields; // fields from which sites are read
    };

    void find_neighbours(const model::PreparedSkin& skin) {
        const int width = skin.width(), height = skin.height();
        guard_ = padded(cells_ + 2 * size_t(width) + PITCH_CELLS);
        edge_.assign(pitch_, 0);
        rest_curvature_.assign(pitch_, 0);
        const size_t weights = skin.stencil == STENCIL_PUBLISHED ? std::size(neighbours_.weight) : 0;
        weights_.assign(weights * pitch_, 0);
        neighbours_ = {.pads = 1, .cells = int(cells_), .width = width, .stencil = skin.stencil, .mirrored = true};
        const int near = skin.stencil == STENCIL_PUBLISHED ? 0 : 1, inner[] = {-2, -near, near, 2};
        for (int n = 0; n < 8; ++n)
            std::ranges::fill(neighbours_.edge_distance[n], inner[n % 4] * (n < 4 ? 1 : width)); // not used yet
        std::vector<double> rest(static_cast<size_t>(width));
        for (size_t cell = 0; cell < cells_; ++cell) {
            const int x = int(cell) % width, y = int(cell) / width;
            if (x == 0) model::rest_curvature_row(skin, y, 0, width, rest.data());
            rest_curvature_[cell] = float(rest[size_t(x)]);
            for (int axis = 0; axis < 2; ++axis) {
                const int i = axis ? y : x, step = axis ? width : 1;
                const f32::Axis a = f32::axis(i, axis ? height : width, skin.stencil, skin.edges);
                const int at[] = {a.far_low, a.low, a.high, a.far_high};
                for (int n = 0; n < 4; ++n) note_neighbour(cell, 4 * axis + n, (at[n] - i) * step, inner[n] * step);
                const float w[] = {a.w_low, a.w_high, a.w};
                for (size_t k = 0; k < weights / 2; ++k) weights_[(size_t(3 * axis) + k) * pitch_ + cell] = w[k];
            }
        }
        neighbours_.edge = edge_.data();
        neighbours_.rest_curvature = rest_curvature_.data();
        for (size_t k = 0; k < weights; ++k) neighbours_.weight[k] = weights_.data() + k * pitch_;
    }
    // Notes where neighbour n of a cell is, unless it is `inner` cells away.
    void note_neighbour(size_t cell, int n, int distance, int inner) {
        if (distance == inner) return;
        int(&known)[2] = neighbours_.edge_distance[n];
        const int i = known[0] == inner || known[0] == distance ? 0 : 1;
        known[i] = distance;
        edge_[cell] |= 1 << (2 * n + i);
        if (n % 4 == 1 || n % 4 == 2) neighbours_.mirrored = neighbours_.mirrored && distance == 0;
    }
    void answer(const Worker& worker, const float* strain, const std::array<const float*, RESPONSE_MAPS>& signals,
                const Press& p, const f32::Constants& c) const {
        std::array<float*, RESPONSE_MAPS> fields = p.response;
        for (size_t r = 0; of_fields_ && r < RESPONSE_MAPS; ++r)
            fields[r] = variant_.wanted[QUANTITY_SA1 + r] ? worker.fields[r].data() : nullptr;
        simd::PadResponses r = neighbours_;
        r.pads = p.count;
        r.pitch = pitch_;
        r.strain = strain;
        std::ranges::copy(signals, r.signal);
        std::ranges::copy(fields, r.response);
        isa_.respond_pads(r, c);
        if (of_fields_) of_fields_->read(fields, p.response);
    }

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
