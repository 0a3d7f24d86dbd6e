// SPDX-License-Identifier: MIT
// Computes strain, indentation and curvature of a pad from its saved state, in float, with the bits of a march's
// fields. No state holds the strain of a spring: it is the strain under the pressure of the last press.
#pragma once

#include "host/core/model/site_cells.hpp"
#include "host/core/model/streamed_skin.hpp"

namespace dermis::model {

class Felt {
  public:
    explicit Felt(const StreamedSkin&);

    // The numbers that a pad gives: its cells, or its sites in the order given.
    size_t count() const { return count_; }
    // Writes the strain of each cell that a state holds. planes, pressure: of a pad's state (StateLayout).
    void strain(int pad, const float* planes, const float* pressure, float* out) const;
    // The strain of cell i of the state. first: its number in the first plane, and `plane` numbers behind it in the
    // next.
    float strain_at(int pad, size_t i, const float* first, size_t plane, float pressure) const;
    // Gives pads other elements in series, all of them the same.
    void set_elements(const PadList&, const std::vector<Element>&);
    // Writes strain, indentation or curvature. rest_curvature: width*height of fields.
    void read(Quantity, std::span<const float> strain, const float* rest_curvature, float* out) const;

  private:
    void read_field(Quantity, std::span<const float> strain, const float* rest_curvature, float* out) const;

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
void stretch_of(const StretchWeights&, const ShearMaps&, float* out);

} // namespace dermis::model
