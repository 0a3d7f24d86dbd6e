// SPDX-License-Identifier: MIT
// Computes strain, indentation and curvature of a pad from its saved state, in float, with the bits of a march's
// fields. No state holds the strain of a spring: it is the strain under the pressure of the last press.
#pragma once

#include "host/core/model/site_cells.hpp"
#include "host/core/model/streamed_skin.hpp"
#include "host/core/simd/isa.hpp"

namespace dermis::model {

class Felt {
  public:
    explicit Felt(const StreamedSkin& s)
        : width_(s.skin.width()), height_(s.skin.height()), stencil_(s.skin.stencil), edges_(s.skin.edges),
          cells_(s.skin.cells()), count_(s.sites().empty() ? cells_ : s.sites().size()), chain_(s.skin.chain),
          compensated_(s.variant().compensated), layout_(state_layout_of(s)), bend_(float(s.skin.constants.bend)),
          thickness_(float(s.skin.constants.thickness)), cells_differ_(chain_.spring && !s.skin.uniform()) {
        const PreparedSkin& skin = s.skin;
        if (!skin.description.sites.empty()) {
            const SiteCells cells = site_cells_of(skin);
            read_ = cells.cells;
            for (const Site& site : skin.description.sites) sites_.emplace_back(skin, cells, site.cell);
        }
        for (const Site& site : s.picked) picked_.push_back(skin.number_of(site.cell));
        for (int pad = 0; !cells_differ_ && pad < s.pads; ++pad) springs_.push_back(spring_behind(elements_of(s, pad)));
        for (size_t i = 0; cells_differ_ && i < layout_.cells; ++i)
            springs_.push_back(
                skin.materials[skin.material_at(read_.empty() ? i : read_[i]) + chain_.elements()].modulus);
    }

    // The numbers that a pad gives: its cells, or its sites in the order given.
    size_t count() const { return count_; }
    // Writes the strain of each cell that a state holds. planes, pressure: of a pad's state (StateLayout).
    void strain(int pad, const float* planes, const float* pressure, float* out) const {
        for (size_t i = 0; i < layout_.cells; ++i)
            out[i] = strain_at(pad, i, planes + i, layout_.cells, pressure[read_.empty() ? i : read_[i]]);
    }

    // The strain of cell i of the state. first: its number in the first plane, and `plane` numbers behind it in the
    // next.
    float strain_at(int pad, size_t i, const float* first, size_t plane, float pressure) const {
        float strain = *first;
        for (size_t e = 1; e < chain_.elements(); ++e)
            strain = f32::in_series(strain, first[size_t(STATE_SUM(int(e), int(compensated_), 0)) * plane]);
        if (!chain_.spring) return strain;
        const float modulus = float(springs_[cells_differ_ ? i : size_t(pad)]);
        return f32::in_series(strain, f32::flush(pressure / modulus));
    }

    // Gives pads other elements in series, all of them the same.
    void set_elements(const PadList& pads, const std::vector<Element>& elements) {
        for (size_t i = 0; !cells_differ_ && i < pads.count; ++i) springs_[size_t(pads[i])] = spring_behind(elements);
    }

    // Writes strain, indentation or curvature. rest_curvature: width*height of fields.
    void read(Quantity q, std::span<const float> strain, const float* rest_curvature, float* out) const {
        if (!picked_.empty()) {
            std::vector<float> field(cells_);
            read_field(q, strain, rest_curvature, field.data());
            std::ranges::transform(picked_, out, [&](size_t cell) { return field[cell]; });
            return;
        }
        if (sites_.empty()) return read_field(q, strain, rest_curvature, out);
        std::vector<float> held(strain.begin(), strain.end());
        held.push_back(0); // the cell at rest
        for (size_t i = 0; i < count_; ++i) {
            const float eps = held[sites_[i].stencil.here];
            if (q == Quantity::strain) out[i] = eps;
            else if (q == Quantity::indentation) out[i] = f32::flush(thickness_ * eps);
            else out[i] = f32::flush(sites_[i].curvature(held.data(), stencil_, bend_));
        }
    }

  private:
    void read_field(Quantity q, std::span<const float> strain, const float* rest_curvature, float* out) const {
        if (q == Quantity::strain) std::ranges::copy(strain, out);
        else if (q == Quantity::indentation)
            std::ranges::transform(strain, out, [&](float eps) { return f32::flush(thickness_ * eps); });
        else
            for (int y = 0; y < height_; ++y, out += width_, rest_curvature += width_) {
                const auto rows = simd::neighbours<float>(y, width_, height_, stencil_, edges_, [&](int row) {
                    return strain.data() + size_t(row) * size_t(width_);
                });
                simd::best().in_f32.laplacian(rows, 0, width_, out);
                for (int x = 0; x < width_; ++x)
                    out[x] = f32::flush(f32::curvature_of(rest_curvature[x], out[x], bend_));
            }
    }

    static double spring_behind(std::span<const Element> chain) {
        return chain.size() > 1 && scene::is_elastic(chain.back()) ? chain.back().modulus : 0;
    }

    const int width_, height_, stencil_, edges_;
    const size_t cells_, count_;
    const Chain chain_;
    const bool compensated_;
    const StateLayout layout_;
    const float bend_, thickness_;
    std::vector<size_t> read_;          // cells that sites read; empty: all
    std::vector<SitePlace<f32>> sites_; // in the order given, where the state holds the cells alone that they read
    std::vector<size_t> picked_;        // cells of the sites in the order given, where the state holds all cells
    std::vector<double> springs_;       // in series, Pa: of pads, 0 if there is none; or of the cells of a state
    bool cells_differ_;                 // the latter
};

// The shear strains of a pad's cells along both axes.
struct ShearMaps {
    const float *along_x, *along_y;
    int width, height, edges;
    float slope; // thickness over twice the spacing: of the displacement, which is thickness*shear
};
// The weights of du_x/dx, of du_y/dy and of (du_x/dy + du_y/dx)/2 of the displacement u.
struct StretchWeights {
    float x, y, xy;
};
// Writes the stretch of each cell with these weights, by central differences.
inline void stretch_of(const StretchWeights& w, const ShearMaps& m, float* out) {
    const auto row = [&](const float* map, int y) {
        return map + size_t(f32::wrapped(y, m.height, m.edges)) * size_t(m.width);
    };
    const auto across = [&](const float* here, int x) { // the difference of the two neighbours in a row
        return here[f32::wrapped(x + 1, m.width, m.edges)] - here[f32::wrapped(x - 1, m.width, m.edges)];
    };
    for (int y = 0; y < m.height; ++y)
        for (int x = 0; x < m.width; ++x) {
            const float x_by_x = across(row(m.along_x, y), x), y_by_x = across(row(m.along_y, y), x);
            const float x_by_y = row(m.along_x, y + 1)[x] - row(m.along_x, y - 1)[x],
                        y_by_y = row(m.along_y, y + 1)[x] - row(m.along_y, y - 1)[x];
            const float difference = (w.x * x_by_x + w.y * y_by_y) + w.xy * (0.5f * (x_by_y + y_by_x));
            *out++ = f32::flush(m.slope * difference);
        }
}

} // namespace dermis::model
