// SPDX-License-Identifier: MIT
// The kernel `sites` over memory of the caller's, one row window after another.
#pragma once

#include "host/core/model/site_cells.hpp"
#include "host/core/model/streamed_skin.hpp"
#include "host/core/vulkan/recording.hpp"
#include "host/core/vulkan/windows.hpp"

namespace dermis::vulkan {

class SitesKernel {
  public:
    struct Maps {
        BufferRange pressure_from, pressure_to, cells, sites, state_from, state_to, response;
        BufferRange coefficients, invalid; // any range for the first if the material is uniform
    };
    SitesKernel(Pipelines&, const model::StreamedSkin&, const model::ResponseLayout&, uint32_t max_bindings);
    void bind(size_t binding, const Maps&);
    // pads and own: see PressKernel::record().
    void record(VkCommandBuffer, size_t binding, const f32::Constants&, uint32_t pads, Recording* own) const;
    double work_of_pad() const { return double(planes_) * double(needed_.cells.size()) + double(sites_.size()); }

    const std::vector<model::Element>& materials() const { return needed_.materials; }
    std::vector<f32::SiteCell> cells() const;
    const std::vector<f32::SiteStencil>& sites() const { return sites_; }

  private:
    struct WindowCells { // the cells and sites in the rows of a window
        int first_cell, cells, first_site, sites;
    };
    void divide_cells();
    double work_of(const WindowCells& window) const { return double(planes_) * window.cells + window.sites; }

    const int width_, pitch_, planes_; // planes: of a state
    const bool pads_;
    const model::SiteCells needed_;
    std::vector<f32::SiteStencil> sites_; // sorted by cell
    std::vector<RowWindow> windows_;
    std::vector<WindowCells> window_cells_;
    Kernel kernel_;
};

} // namespace dermis::vulkan
