// SPDX-License-Identifier: MIT
#pragma once

#include "host/reduced/sites.hpp"
#include "host/plan/frames.hpp"
#include "host/vulkan/press_kernel.hpp"

namespace dermis::vulkan {

// The kernel `sites`, and the memory of its bindings.
class SitesKernel {
  public:
    struct Maps {
        Piece pressure_from, pressure_to, cells, sites, state_from, state_to, response;
        Piece rows, invalid; // any in place of rows under a uniform material
    };
    SitesKernel(Pipelines&, const plan::Plan&, uint32_t max_bindings);
    void bind(size_t binding, const Maps&);
    void record(VkCommandBuffer, size_t binding, const f32::Constants&) const noexcept;

    const std::vector<plan::Medium>& media() const { return looked_at_.media; }
    std::vector<f32::SiteCell> cells() const;
    const std::vector<f32::SiteStencil>& sites() const { return sites_; }

  private:
    struct Part { // of cells and sites: those of a band
        int first_cell, cells, first_site, sites;
    };
    const plan::Plan& plan_;
    plan::SiteCells looked_at_;
    std::vector<f32::SiteStencil> sites_; // by cell
    std::vector<Band> bands_;
    std::vector<Part> parts_;
    Kernel kernel_;
};

} // namespace dermis::vulkan
