// SPDX-License-Identifier: MIT
// The values a = p*(1 + l*L(S)) and b = p*l*h*L(p) of the cells of a row (see moments.hpp).
#pragma once

#include "host/core/model/laplacian.hpp"
#include "host/core/simd/isa.hpp"
#include "host/lab/schedule/schedule.hpp"

namespace dermis::reduced {

// Computes columns first .. last - 1 of one row after another.
class MomentRow {
  public:
    // map: Moments::Layer::map.
    MomentRow(const model::PreparedSkin& skin, const model::Schedule& schedule, const Map& map, int first, int last)
        : skin_(skin), schedule_(schedule), map_(map), unit_(model::without_spacing(skin.description.grid)),
          first_(first), last_(last), rest_(size_t(last - first)), L_(rest_) {}

    void compute(int y, double* a, double* b, const simd::ColumnSums& sums) {
        laplacians(y);
        simd::best().moments(at(y), rest_.data(), L_.data(), last_ - first_, skin_.constants.curvature_length,
                             skin_.constants.bend, a, b, sums);
    }
    // Adds only to the sums of p, a and b.
    void add_means(int y, const simd::ColumnSums& sums) {
        laplacians(y);
        simd::best().means(at(y), rest_.data(), L_.data(), last_ - first_, skin_.constants.curvature_length,
                           skin_.constants.bend, sums);
    }

  private:
    const double* at(int y) const { return map_.data() + size_t(y) * size_t(unit_.width) + size_t(first_); }
    void laplacians(int y) {
        model::rest_curvature_row(skin_, y, first_, last_, rest_.data());
        model::laplacian_row(schedule_.pressure, y, first_, last_, unit_, skin_.stencil, skin_.edges, L_.data());
    }

    const model::PreparedSkin& skin_;
    const model::Schedule& schedule_;
    const Map& map_;
    const Grid unit_;
    const int first_, last_;
    std::vector<double> rest_, L_;
};

} // namespace dermis::reduced
