// SPDX-License-Identifier: MIT
// The two ways to the response of a receptor: from a field of its class, or from the cells that its stencil reads. Both
// give the same bits.
#pragma once

#include "host/core/model/felt.hpp"

#include <algorithm>

namespace dermis::cpu {

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

} // namespace dermis::cpu
