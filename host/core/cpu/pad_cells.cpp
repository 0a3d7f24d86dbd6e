// SPDX-License-Identifier: MIT
#include "host/core/cpu/pad_cells.hpp"

#include "host/core/model/laplacian.hpp"

#include <cstring>

namespace dermis::cpu {

namespace {

// The most cells of pads that are pressed together: their strain and signals fit into the first-level cache.
constexpr size_t cells_together = 1024;

size_t padded(size_t cells) { return (cells + PITCH_CELLS - 1) / PITCH_CELLS * PITCH_CELLS; }

} // namespace

// Measured on 240 x 320 and 20 x 25 cells: a receptor that reads its stencil costs as much as two listed cells; with
// this factor, which is 0.62 to 0.7 on two processors, both ways take equally long.
bool PadCells::sparse(const model::PreparedSkin& skin, const model::SiteCells& cells, int threads) {
    return double(cells.cells.size() + 2 * cells.points.size()) * threads < 0.65 * double(skin.cells());
}

PadCells::PadCells(const model::StreamedSkin& s, int threads, const simd::Isa& isa)
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

void PadCells::find_neighbours(const model::PreparedSkin& skin) {
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

void PadCells::note_neighbour(size_t cell, int n, int distance, int inner) {
    if (distance == inner) return;
    int(&known)[2] = neighbours_.edge_distance[n];
    const int i = known[0] == inner || known[0] == distance ? 0 : 1;
    known[i] = distance;
    edge_[cell] |= 1 << (2 * n + i);
    if (n % 4 == 1 || n % 4 == 2) neighbours_.mirrored = neighbours_.mirrored && distance == 0;
}

void PadCells::press(int thread, const Press& p) {
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

void PadCells::answer(const Worker& worker, const float* strain, const std::array<const float*, RESPONSE_MAPS>& signals,
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

void PadCells::rest(int pad) { state_.rest_row(pad, int(pitch_)); }

void PadCells::read(int pad, const std::vector<model::HeldCell>& cells, size_t planes, const float* pressure,
                    float* to) const {
    const auto copy = [&](const float* own) {
        for (const model::HeldCell& c : cells) *to++ = own[held_.empty() ? c.held : held_[c.held]];
    };
    state_.each_plane([&](const float* plane) {
        if (planes > 0) copy(plane + size_t(pad) * pitch_), --planes;
    });
    copy(pressure);
}

} // namespace dermis::cpu
