// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

#include "host/lab/output/json.hpp"
#include "host/lab/scenes/scene_names.hpp"

#include <fmt/ranges.h>

namespace dermis::cli {
namespace {

using output::json_number;
using output::json_text;

std::string text_or_null(const std::string& text) { return text.empty() ? "null" : json_text(text); }

std::string json_of_candidate(const Candidate& c) {
    std::vector<std::string> reduced;
    for (const KelvinVoigt& e : c.reduced)
        reduced.push_back(
            fmt::format("{{\"modulus\": {}, \"viscosity\": {}}}", json_number(e.modulus), json_number(e.viscosity)));
    return fmt::format("{{\"model\": \"{}\", \"precision\": \"{}\", \"device\": {}, \"steps\": {}, \"dispatches\": {}, "
                       "\"flops\": {}, \"bytes_moved\": {}, \"bytes\": {}, \"seconds\": {}, \"error\": {}, "
                       "\"refused\": {}, \"elements\": [{}]}}",
                       name(c.model), name(c.precision), json_text(c.device), c.steps, c.dispatches,
                       json_number(c.flops), json_number(c.traffic), json_number(c.bytes), json_number(c.seconds),
                       json_number(c.error), text_or_null(c.refused), fmt::join(reduced, ", "));
}

} // namespace

std::string json_list(const std::vector<std::string>& items) {
    return items.empty() ? "[]" : fmt::format("[\n{}\n]", fmt::join(items, ",\n"));
}

std::string json_of(const Scene& scene, const std::vector<std::string>& overrides, const Explanation& e) {
    std::vector<std::string> set, times, candidates;
    for (const std::string& text : overrides) set.push_back(json_text(text));
    for (double t : e.retardation_times) times.push_back(json_number(t));
    for (const Candidate& c : e.candidates) candidates.push_back(json_of_candidate(c));
    return fmt::format("{{\"set\": [{}], \"width\": {}, \"height\": {}, \"method\": \"{}\", \"tolerance\": {}, "
                       "\"binding\": {}, \"stencil_estimate\": {}, \"greatest_curvature\": {}, "
                       "\"retardation_times\": [{}], \"strain_between_frames\": {}, \"fa1_between_frames\": {},\n"
                       "  \"chosen\": {}, \"candidates\": [\n    {}]}}",
                       fmt::join(set, ", "), scene.grid.width, scene.grid.height, name(scene.method),
                       json_number(e.tolerance), e.binding, json_number(e.stencil_estimate),
                       json_number(e.greatest_curvature), fmt::join(times, ", "), json_number(e.strain_between_frames),
                       json_number(e.fa1_between_frames), e.chosen, fmt::join(candidates, ",\n    "));
}

std::string json_of(const DeviceInfo& d) {
    return fmt::format("{{\"name\": {}, \"kind\": {}, \"driver\": {}, \"uuid\": {}, \"vulkan\": {}, \"refused\": {}}}",
                       json_text(d.name), json_text(d.kind), text_or_null(d.driver), text_or_null(d.uuid), d.vulkan,
                       text_or_null(d.refused));
}

std::string json_of(const DeviceInfo& d, const std::vector<SelfTest::Kernel>& kernels) {
    std::vector<std::string> all;
    bool exact = true;
    for (const SelfTest::Kernel& k : kernels) {
        all.push_back(fmt::format("{{\"name\": \"{}\", \"hash\": \"{:016x}\", \"values\": {}, \"different\": {}}}",
                                  k.name, k.hash, k.values, k.different));
        exact &= k.different == 0;
    }
    return fmt::format("{{\"name\": {}, \"driver\": {}, \"uuid\": {}, \"exact\": {}, \"kernels\": [\n    {}]}}",
                       json_text(d.name), text_or_null(d.driver), text_or_null(d.uuid), exact,
                       fmt::join(all, ",\n    "));
}

} // namespace dermis::cli
