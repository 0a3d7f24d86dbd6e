// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

#include "host/lab/scenes/scene_names.hpp"

#include <fmt/format.h>

namespace dermis::cli {

using output::Json;
using output::text_or_null;

static Json json_of(const Candidate& c) {
    return {{"model", name(c.model)},
            {"precision", name(c.precision)},
            {"device", c.device},
            {"steps", c.steps},
            {"dispatches", c.dispatches},
            {"flops", c.flops},
            {"bytes_moved", c.traffic},
            {"bytes", c.bytes},
            {"seconds", c.seconds},
            {"error", c.error},
            {"refused", text_or_null(c.refused)},
            {"elements", c.reduced}};
}

Json json_of(const Scene& scene, const std::vector<std::string>& overrides, const Explanation& e) {
    Json candidates;
    for (const Candidate& c : e.candidates) candidates.push_back(json_of(c));
    return {{"set", overrides},
            {"width", scene.grid.width},
            {"height", scene.grid.height},
            {"method", name(scene.method)},
            {"tolerance", e.tolerance},
            {"binding", e.binding},
            {"stencil_estimate", e.stencil_estimate},
            {"greatest_curvature", e.greatest_curvature},
            {"retardation_times", e.retardation_times},
            {"strain_between_frames", e.strain_between_frames},
            {"fa1_between_frames", e.fa1_between_frames},
            {"chosen", e.chosen},
            {"candidates", candidates}};
}

Json json_of(const DeviceInfo& d) {
    return {{"name", d.name},
            {"kind", d.kind},
            {"driver", text_or_null(d.driver)},
            {"uuid", text_or_null(d.uuid)},
            {"vulkan", d.vulkan},
            {"refused", text_or_null(d.refused)}};
}

Json json_of(const DeviceInfo& d, const std::vector<SelfTest::Kernel>& kernels) {
    Json json = {{"name", d.name}, {"driver", text_or_null(d.driver)}, {"uuid", text_or_null(d.uuid)}, {"exact", true}};
    for (const SelfTest::Kernel& k : kernels) {
        json["kernels"].push_back({{"name", k.name},
                                   {"hash", fmt::format("{:016x}", k.hash)},
                                   {"values", k.values},
                                   {"different", k.different}});
        if (k.different) json["exact"] = false;
    }
    return json;
}

} // namespace dermis::cli
