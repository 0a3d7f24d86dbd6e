// SPDX-License-Identifier: MIT
// A skin's memory, whoever owns it, and presses recorded over it.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/vulkan/sites_kernel.hpp"

#include <optional>

namespace dermis::vulkan {

class Recorder {
  public:
    // Throws Error::bad_input naming the limit that something exceeds.
    Recorder(Pipelines&, plan::Plan&&, uint32_t max_bindings);
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    const plan::Plan& plan() const { return plan_; }
    const plan::ResponseLayout& answers() const { return answers_; }
    const MemoryNeeds& needs() const { return needs_; }
    bool writes_constants() const { return table_.bytes > 0; }
    void bind(size_t binding, const Buffers&); // as needs() says: nothing is checked
    bool in_float(double dt) const noexcept;   // whether such a press can be recorded
    void record(VkCommandBuffer, size_t binding, double dt) const noexcept;

  private:
    struct Part { // of the constants
        VkDeviceSize offset = 0, bytes = 0;
    };
    template <class T> Part append(const std::vector<T>&);
    const std::vector<plan::Medium>& media() const { return sites_ ? sites_->media() : plan_.media; }
    void check_limits() const;

    const DeviceTable& device_;
    plan::Plan plan_;
    const plan::ResponseLayout answers_;
    std::optional<Press> fields_; // either
    std::optional<SitesKernel> sites_;
    MemoryNeeds needs_;
    Part rest_, material_, table_, cells_, looks_;
    std::vector<Piece> tables_; // of each binding
};

} // namespace dermis::vulkan
