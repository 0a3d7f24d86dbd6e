// SPDX-License-Identifier: MIT
#include "host/core/vulkan/sites_kernel.hpp"

#include "host/core/model/laplacian.hpp"

#include <algorithm>

namespace dermis::vulkan {
namespace {

constexpr uint32_t most_groups = 65535; // workgroups along an axis that every device allows

static_assert(sizeof(f32::SiteConstants) <= 128, "push constants: every device has 128 bytes");

f32::SiteStencil stencil_of(const model::PreparedSkin& skin, const model::SiteCells& needed, const Site& site,
                            size_t response) {
    const model::StencilCells n = stencil_cells_of(skin, needed, site.cell);
    f32::SiteStencil s{};
    s.here = int(n.here);
    s.x_far_low = int(n.x[0]);
    s.x_low = int(n.x[1]);
    s.x_high = int(n.x[2]);
    s.x_far_high = int(n.x[3]);
    s.y_far_low = int(n.y[0]);
    s.y_low = int(n.y[1]);
    s.y_high = int(n.y[2]);
    s.y_far_high = int(n.y[3]);
    s.quantity = int(site.type);
    s.response = int(response);
    s.rest_curvature = float(rest_curvature_at(skin, site.cell));
    return s;
}

} // namespace

SitesKernel::SitesKernel(Pipelines& pipelines, const model::StreamedSkin& streamed, const model::ResponseLayout& layout,
                         uint32_t max_bindings)
    : width_(streamed.skin.width()), pitch_(streamed.skin.pitch), planes_(streamed.variant().state().planes()),
      pads_(streamed.pads > 1),
      needed_(streamed.skin, {streamed.skin.whole()}, model::cells_of(streamed.skin.description.sites)),
      windows_(row_windows(
          pipelines.device(), streamed.skin,
          {.first = 0,
           .last = streamed.skin.height(),
           .planes = 1,
           .work = pads_ ? 0.0 : double(planes_ + 1)})), // a pad has one window: its cells are all cells of a dispatch
      kernel_(pipelines, sites_module(),
              {.bindings = SITES_BINDINGS,
               .constants_bytes = sizeof(f32::SiteConstants),
               .specialization = specialization(streamed.variant()),
               .max_sets = max_bindings * uint32_t(windows_.size())}) {
    const std::vector<Site>& sites = streamed.skin.description.sites;
    for (size_t i = 0; i < sites.size(); ++i)
        sites_.push_back(stencil_of(streamed.skin, needed_, sites[i], layout.site[i]));
    for (f32::SiteStencil& site : sites_)
        site.of_class = int(layout.of[size_t(site.quantity)].count / size_t(streamed.pads));
    std::sort(sites_.begin(), sites_.end(), [](auto& a, auto& b) { return a.here < b.here; });
    divide_cells();
}

void SitesKernel::divide_cells() {
    const auto cells_before = [&](int row) {
        const auto at = std::lower_bound(needed_.cells.begin(), needed_.cells.end(), size_t(row) * size_t(width_));
        return int(at - needed_.cells.begin());
    };
    const auto sites_before = [&](int cell) {
        const auto at = std::lower_bound(sites_.begin(), sites_.end(), cell, [](auto& s, int c) { return s.here < c; });
        return int(at - sites_.begin());
    };
    for (const RowWindow& window : windows_) {
        const int first = cells_before(window.first), last = cells_before(window.last);
        window_cells_.push_back({.first_cell = first,
                                 .cells = last - first,
                                 .first_site = sites_before(first),
                                 .sites = sites_before(last) - sites_before(first)});
    }
}

std::vector<f32::SiteCell> SitesKernel::cells() const {
    const size_t width = size_t(width_);
    std::vector<f32::SiteCell> cells;
    for (size_t i = 0; i < needed_.cells.size(); ++i) {
        const size_t cell = needed_.cells[i];
        cells.push_back({int(cell / width * size_t(pitch_) + cell % width), needed_.material_of[i]});
    }
    return cells;
}

void SitesKernel::bind(size_t binding, const Maps& m) {
    size_t set = binding * windows_.size();
    for (const RowWindow& window : windows_)
        kernel_.bind(set++, {
                                {SITES_PRESSURE_FROM, pads_ ? m.pressure_from : window.of(m.pressure_from, pitch_)},
                                {SITES_PRESSURE_TO, pads_ ? m.pressure_to : window.of(m.pressure_to, pitch_)},
                                {SITES_CELLS, m.cells},
                                {SITES_SITES, m.sites},
                                {SITES_STATE_FROM, m.state_from},
                                {SITES_STATE_TO, m.state_to},
                                {SITES_RESPONSE, m.response},
                                {SITES_COEFFICIENTS, m.coefficients},
                                {SITES_INVALID, m.invalid},
                            });
}

void SitesKernel::record(VkCommandBuffer commands, size_t binding, const f32::Constants& constants, uint32_t pads,
                         Recording* own) const {
    f32::SiteConstants s{};
    s.c = constants;
    for (size_t i = 0; i < windows_.size(); ++i) {
        const WindowCells& window = window_cells_[i];
        s.c.base_row = windows_[i].base;
        s.first_cell = window.first_cell;
        s.cells = window.cells;
        s.first_site = window.first_site;
        s.sites = constants.respond ? window.sites : 0;
        const uint32_t all = groups(window.cells + s.sites, SITES_X), x = std::min(all, most_groups);
        if (all == 0) continue;
        if (own) own->add(work_of(window) * pads);
        kernel_.record(commands, binding * windows_.size() + i, &s, x, (all + x - 1) / x, pads);
    }
}

} // namespace dermis::vulkan
