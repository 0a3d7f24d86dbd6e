// SPDX-License-Identifier: MIT
// The kernel `press` over memory of the caller's, one row window after another.
#pragma once

#include "host/core/model/site_cells.hpp"
#include "host/core/model/streamed_skin.hpp"
#include "host/core/vulkan/recording.hpp"
#include "host/core/vulkan/windows.hpp"

namespace dermis::vulkan {

// The kernel `press` as this device runs it.
Module press_module_for(const DeviceTable&, const model::Variant& = {});

// The list of a press at sites, row by row.
std::vector<f32::SiteEntry> site_entries(const model::StreamedSkin&, const model::ResponseLayout&,
                                         const model::SiteCells&);

class PressKernel {
  public:
    // In a batch, pressures, states and responses are the pads' one after another; the other ranges are shared by all
    // pads.
    struct Maps {
        BufferRange pressure_from, pressure_to, rest_curvature, state_from, state_to;
        std::array<BufferRange, RESPONSE_MAPS> response; // any small range for a response that is not asked for
        BufferRange sites, responses;                    // of sites, in place of `response`: sites(), and all responses
        BufferRange coefficients, material, invalid;     // any range for the first two if the material is uniform
    };
    // sites: site_entries() of a variant with sites.
    PressKernel(Pipelines&, const model::PreparedSkin&, const model::Variant&, const model::PressedBox&,
                uint32_t max_bindings, const std::vector<f32::SiteEntry>& sites = {});
    void bind(size_t binding, const Maps&);
    size_t pads_of_group() const { return size_t(group_.z); }
    // pads: the number of pads to press; their list is filled up to whole workgroups with entries of no pad. own: the
    // library's recording of this command buffer, to which the work of each window is added; null where the command
    // buffer is a host's.
    void record(VkCommandBuffer, size_t binding, const f32::Constants&, uint32_t pads, Recording* own) const;
    double work_of_pad() const {
        double work = 0;
        for (size_t i = 0; i < windows_.size(); ++i) work += work_of(i);
        return work;
    }
    const std::vector<RowWindow>& windows() const { return windows_; }
    // The entries of each window, filled up to whole workgroups.
    const std::vector<f32::SiteEntry>& sites() const { return sites_; }

  private:
    struct Group { // size of a workgroup
        int x, y, z;
    };
    struct SiteWindow { // what a window has of sites_
        size_t first, count;
        uint32_t x, y; // workgroups
    };
    static Group group_of(const model::PreparedSkin&, const model::Variant&, const model::PressedBox&);
    void divide(const std::vector<f32::SiteEntry>&);
    double work_of(size_t window) const {
        const double cells = variant_.sites ? double(PRESS_CELLS) * double(site_windows_[window].count)
                                            : double(columns_) * windows_[window].rows();
        return numbers_of_press(variant_) * cells;
    }

    const model::Variant variant_;
    const int pitch_, columns_; // columns_: the number of columns that are pressed
    const Group group_;
    std::vector<RowWindow> windows_;
    std::vector<f32::SiteEntry> sites_;
    std::vector<SiteWindow> site_windows_;
    Kernel kernel_;
};

} // namespace dermis::vulkan
