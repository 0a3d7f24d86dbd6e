// SPDX-License-Identifier: MIT
#include "host/core/cpu/pad_cells.hpp"

#include "host/core/model/laplacian.hpp"

#include <cstring>

namespace dermis::cpu {

namespace {

size_t padded(size_t cells) { return (cells + PITCH_CELLS - 1) / PITCH_CELLS * PITCH_CELLS; }

} // namespace

// Measured on 240 x 320 and 20 x 25 cells: a listed cell costs as much as a cell of a field, and a receptor that reads
// its stencil as much as two; with this factor both ways take equally long.
bool PadCells::sparse(const plan::PreparedSkin& skin, const plan::SiteCells& cells, int threads) {
    return double(cells.cells.size() + 2 * cells.points.size()) * threads < 0.9 * double(skin.cells());
}

PadCells::PadCells(const plan::StreamedSkin& s, int threads, const simd::Isa& isa)
    : width_(s.skin.width()), height_(s.skin.height()), stencil_(s.skin.stencil), edges_(s.skin.edges),
      variant_(s.variant()), loops_(isa.of<f32>()), sites_(s.skin.description.sites), elements_(s.skin.materials),
      cells_(s.skin.cells()), constants_(plan::frame_constants(s.skin, {})) {
    const plan::SiteCells read(s.skin, {s.skin.whole()}, plan::cells_of(sites_));
    if (!sites_.empty() && sparse(s.skin, read, 1)) {
        read_ = read.cells;
        cells_ = read_.size();
        elements_ = read.materials;
        of_cells_.emplace(s.skin, read);
        if (!s.skin.uniform()) material_ = read.material_of;
    } else {
        if (!sites_.empty()) of_fields_.emplace(sites_, size_t(width_));
        if (!sites_.empty()) held_ = read.cells;
        for (size_t i = 0; !s.skin.uniform() && i < cells_; ++i) material_.push_back(int(s.skin.material_at(i)));
        find_row_groups();
    }
    pitch_ = padded(cells_);
    if (!material_.empty()) material_.resize(pitch_, 0);
    if (!of_cells_) {
        rest_curvature_ = Plane<float>(pitch_, 0);
        for (int y = 0; y < height_; ++y) {
            std::vector<double> row(static_cast<size_t>(width_));
            plan::rest_curvature_row(s.skin, y, 0, width_, row.data());
            std::ranges::transform(row, rest_curvature_.data() + size_t(y) * size_t(width_),
                                   [](double x) { return float(x); });
        }
    }
    state_ = {pitch_ * size_t(s.pads), variant_.state()};
    workers_.resize(size_t(threads));
    for (Worker& w : workers_) {
        int place = 0;
        for (Plane<float>& signal : w.signals) signal = Plane<float>(pitch_ + PITCH_CELLS, ++place);
        for (Plane<float>* plane : {&w.strain, &w.along}) *plane = Plane<float>(pitch_ + PITCH_CELLS, ++place);
        for (size_t r = 0; of_fields_ && r < RESPONSE_MAPS; ++r) w.fields[r] = Plane<float>(pitch_, ++place);
    }
}

void PadCells::find_row_groups() {
    const int far = f64::reach(stencil_);
    for (int y = 0; y < height_;) {
        const int rows = y >= far && y < height_ - far ? height_ - far - y : 1;
        row_groups_.push_back({y, rows});
        y += rows;
    }
}

void PadCells::press(int thread, int pad, const Press& p) {
    const Worker& worker = workers_[size_t(thread)];
    f32::Constants c = constants_;
    c.coefficients = p.table[0];
    simd::StateRow<float> row = state_.row(pad, int(pitch_));
    if (variant_.chain.length > 1) row.strain = worker.strain.data();
    simd::AdvanceArguments<f32> a{.count = int(cells_),
                                  .elements = int(variant_.chain.elements()),
                                  .spring = variant_.chain.spring,
                                  .pressure = p.from,
                                  .pressure_to = p.to,
                                  .material = material_.empty() ? nullptr : material_.data(),
                                  .table = p.table,
                                  .from = row,
                                  .to = row,
                                  .signal = {}};
    for (size_t s = 0; s < STEP_SIGNALS; ++s) a.signal[s] = worker.signals[s].data();
    loops_.advance(a, c);
    if (!of_cells_) return answer(worker, row, p, c);
    float* strain = worker.strain.data(); // the strain of a chain is here already
    if (variant_.chain.length == 1) std::copy_n(row.strain, cells_, strain);
    strain[cells_] = 0;
    of_cells_->read(strain, signals_of(worker, row, strain, 0), c, p.response);
}

std::array<const float*, RESPONSE_MAPS> PadCells::signals_of(const Worker& worker, const simd::StateRow<float>& row,
                                                             const float* strain, size_t cell) {
    std::array<const float*, RESPONSE_MAPS> of = {strain + cell, row.value[simd::sum_integral] + cell};
    for (size_t s = 0; s < STEP_SIGNALS; ++s) of[QUANTITY_FA1 - QUANTITY_SA1 + s] = worker.signals[s].data() + cell;
    return of;
}

void PadCells::answer(const Worker& worker, const simd::StateRow<float>& row, const Press& p,
                      const f32::Constants& c) const {
    loops_.differences(row.strain, height_, width_, stencil_, edges_, worker.along.data());
    Press fields = p;
    for (size_t r = 0; of_fields_ && r < RESPONSE_MAPS; ++r)
        fields.response[r] = variant_.wanted[QUANTITY_SA1 + r] ? worker.fields[r].data() : nullptr;
    for (const RowGroup& run : row_groups_) loops_.respond(respond_arguments(worker, row, fields, run), c);
    if (of_fields_) of_fields_->read(fields.response, p.response);
}

simd::RespondArguments<f32> PadCells::respond_arguments(const Worker& worker, const simd::StateRow<float>& row,
                                                        const Press& p, const RowGroup& run) const {
    const size_t at = size_t(run.first) * size_t(width_);
    simd::RespondArguments<f32> r{
        .first = 0,
        .last = run.rows * width_,
        .strain = simd::neighbours<float>(run.first, width_, height_, stencil_, edges_,
                                          [&](int y) { return row.strain + size_t(y) * size_t(width_); }),
        .signal = {},
        .rest_curvature = rest_curvature_.data() + at,
        .response = {},
        .streams = false,
        .tiles = {}};
    std::ranges::copy(signals_of(worker, row, row.strain, at), r.signal);
    r.strain.along = worker.along.data() + at;
    for (size_t i = 0; i < RESPONSE_MAPS; ++i) r.response[i] = p.response[i] ? p.response[i] + at : nullptr;
    return r;
}

template <class F> void PadCells::each_run(int pad, F f) const {
    size_t at = 0;
    state_.each_plane([&](float* plane) {
        float* const own = plane + size_t(pad) * pitch_;
        if (held_.empty()) f(own, at, cells_ * sizeof(float));
        for (size_t i = 0; i < held_.size(); ++i) f(own + held_[i], at + i * sizeof(float), sizeof(float));
        at += held() * sizeof(float);
    });
}

void PadCells::rest(int pad) { state_.rest_row(pad, int(pitch_)); }

void PadCells::save(int pad, char* planes) const {
    each_run(pad, [&](const float* run, size_t at, size_t bytes) { std::memcpy(planes + at, run, bytes); });
}

void PadCells::load(int pad, const char* planes) {
    each_run(pad, [&](float* run, size_t at, size_t bytes) { std::memcpy(run, planes + at, bytes); });
}

} // namespace dermis::cpu
