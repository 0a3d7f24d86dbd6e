// SPDX-License-Identifier: MIT
#include "host/vulkan/sites_kernel.hpp"

#include <algorithm>

namespace dermis::vulkan {
namespace {

constexpr uint32_t most_groups = 65535; // along one axis, everywhere

static_assert(sizeof(f32::SiteConstants) <= 128, "push constants: 128 bytes are what every device has");

std::vector<Cell> cells_of(const plan::Plan& plan) {
    std::vector<Cell> cells;
    for (const Site& site : plan.scene.sites) cells.push_back(site.cell);
    return cells;
}

} // namespace

SitesKernel::SitesKernel(Pipelines& pipelines, const plan::Plan& plan, uint32_t max_bindings)
    : plan_(plan), looked_at_(plan, cells_of(plan)),
      bands_(vulkan::bands(plan, 0, plan.constants.height, 1, pipelines.gpu().limits.maxStorageBufferRange)),
      kernel_(pipelines, sites_module(pipelines.gpu().rounds), SITES_BINDINGS, sizeof(f32::SiteConstants),
              variant_of(plan), max_bindings * uint32_t(bands_.size())) {
    const plan::ResponseLayout answers = plan::response_layout_of(plan);
    for (size_t i = 0; i < plan.scene.sites.size(); ++i) {
        const Site& site = plan.scene.sites[i];
        const plan::StencilCells n = plan::stencil_cells_of(plan, looked_at_, site.cell);
        const auto r = [](size_t rank) { return int(rank); };
        sites_.push_back(
            {r(n.here), r(n.x[0]), r(n.x[1]), r(n.x[2]), r(n.x[3]), r(n.y[0]), r(n.y[1]), r(n.y[2]), r(n.y[3]),
             int(site.type), int(answers.site[i]),
             float(plan::laplacian_at(plan.maps.surface, site.cell, plan.scene.grid, plan.stencil, plan.edges))});
    }
    std::sort(sites_.begin(), sites_.end(), [](auto& a, auto& b) { return a.here < b.here; });
    const size_t width = size_t(plan.constants.width);
    const auto cell_before = [&](int row) { // how many cells are in rows before this
        const auto at = std::lower_bound(looked_at_.cells.begin(), looked_at_.cells.end(), size_t(row) * width);
        return int(at - looked_at_.cells.begin());
    };
    const auto site_before = [&](int cell) {
        const auto at = std::lower_bound(sites_.begin(), sites_.end(), cell, [](auto& s, int c) { return s.here < c; });
        return int(at - sites_.begin());
    };
    for (const Band& band : bands_) {
        const int first = cell_before(band.first), last = cell_before(band.last);
        parts_.push_back({first, last - first, site_before(first), site_before(last) - site_before(first)});
    }
}

std::vector<f32::SiteCell> SitesKernel::cells() const {
    const size_t width = size_t(plan_.constants.width);
    std::vector<f32::SiteCell> cells;
    for (size_t i = 0; i < looked_at_.cells.size(); ++i) {
        const size_t cell = looked_at_.cells[i];
        cells.push_back({int(cell / width * size_t(plan_.pitch) + cell % width), looked_at_.material[i]});
    }
    return cells;
}

void SitesKernel::bind(size_t binding, const Maps& m) {
    size_t set = binding * bands_.size();
    for (const Band& band : bands_)
        kernel_.bind(set++, {band.of(m.pressure_from, plan_.pitch), band.of(m.pressure_to, plan_.pitch), m.cells,
                             m.sites, m.state_from, m.state_to, m.response, m.rows, m.invalid});
}

void SitesKernel::record(VkCommandBuffer commands, size_t binding, const f32::Constants& constants) const noexcept {
    f32::SiteConstants s{constants, 0, 0, 0, 0};
    for (size_t i = 0; i < bands_.size(); ++i) {
        const Part& part = parts_[i];
        s.c.base_row = bands_[i].base;
        s.first_cell = part.first_cell;
        s.cells = part.cells;
        s.first_site = part.first_site;
        s.sites = part.sites;
        const uint32_t all = groups(part.cells + part.sites, SITES_X), x = std::min(all, most_groups);
        if (all > 0) kernel_.record(commands, binding * bands_.size() + i, &s, x, (all + x - 1) / x);
    }
}

} // namespace dermis::vulkan
