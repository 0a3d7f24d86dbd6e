// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

#include <fmt/format.h>

namespace dermis {

using output::Json;

// Makes texts that are empty null.
static void empty_as_null(Json& json, std::initializer_list<const char*> keys) {
    for (const char* key : keys)
        if (json[key] == "") json[key] = Json();
}

static void to_json(Json& json, const Candidate& c) {
    DERMIS_KEYS(json, c, model, precision, device, steps, dispatches, bytes, seconds, error, refused);
    empty_as_null(json, {"refused"});
}

Json cli::json_of(const Scene& scene, const std::vector<std::string>& overrides, const Explanation& e) {
    Json json = {{"set", overrides}};
    DERMIS_KEYS(json, scene.grid, width, height);
    DERMIS_KEYS(json, scene, method);
    DERMIS_KEYS(json, e, tolerance, binding, stencil_estimate, greatest_curvature, retardation_times,
                strain_between_frames, fa1_between_frames, chosen, candidates);
    return json;
}

Json cli::json_of(const DeviceInfo& d) {
    Json json;
    DERMIS_KEYS(json, d, name, kind, driver, uuid, vulkan, refused);
    empty_as_null(json, {"driver", "uuid", "refused"});
    return json;
}

Json cli::json_of(const DeviceInfo& d, const std::vector<SelfTest::Kernel>& kernels) {
    Json json;
    DERMIS_KEYS(json, d, name, driver, uuid);
    empty_as_null(json, {"driver", "uuid"});
    json["exact"] = std::ranges::none_of(kernels, &SelfTest::Kernel::different);
    json["kernels"] = Json::array();
    for (const SelfTest::Kernel& k : kernels) {
        Json& kernel = json["kernels"].emplace_back();
        DERMIS_KEYS(kernel, k, name, hash, values, different);
        kernel["hash"] = fmt::format("{:016x}", k.hash);
    }
    return json;
}

} // namespace dermis
