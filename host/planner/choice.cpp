// SPDX-License-Identifier: MIT
#include "host/planner/choice.hpp"

#include "host/planner/bound.hpp"
#include "host/reduced/sites.hpp"
#include "host/scene/text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

namespace dermis::planner {
namespace {

constexpr double default_tolerance = 1e-4;

[[noreturn]] void refuse(const char* parameter, const std::string& value, const std::string& why) {
    throw Error(Error::Code::bad_input, parameter,
                std::string(parameter) + " = " + value + "; not allowed here: " + why);
}

int threads_of(const Device& device) {
    const int asked = device.impl().threads;
    return std::max(asked ? asked : int(std::thread::hardware_concurrency()), 1);
}

// Seconds per cell and step. Measured on two cores of a server, and for a GPU by its memory: to choose by, no promise.
double march_rate(const Device& device, Precision precision) {
    const double factor = precision == Precision::f32 ? 1 : precision == Precision::f32_compensated ? 1.2 : 1.7;
    if (device.info().vulkan) return factor * (device.info().kind == "software" ? 28e-9 : 3e-10);
    return factor * 4.5e-9 / threads_of(device);
}

Candidate costed(const plan::Plan& plan, Model model, Precision precision, const Device& device) {
    const double cells = double(plan.maps.pressure.size()), maps = plan.material.empty() ? 0 : 4;
    const double fields = double(plan.scene.output.fields.size()), places = double(plan.places.size());
    const plan::Pressed& box = plan.pressed;
    const double pressed =
        double(box.last_row - box.first_row) * std::min((box.last_tile - box.first_tile) * TILE_CELLS, plan.pitch);
    Candidate c;
    c.model = model;
    c.precision = precision;
    c.device = device.info().name;
    c.steps = plan.outputs + (plan.frames ? std::max(0LL, plan.frames->maps() - plan.outputs) : 0) +
              static_cast<long long>(plan.field_times.size());
    const double steps = double(c.steps), whole = 24 + maps; // surface, L(S), pressure in double
    if (model == Model::moments || model == Model::maps) {
        c.traffic = cells * (32 + 40 * fields);
        c.flops = cells * (40 + 6 * fields) + steps * (250 + 10 * places);
        c.bytes = cells * (16 + 8 * fields);
        c.seconds = cells * (1.5e-8 + 4e-9 * fields) + steps * (2e-7 + 2e-9 * places);
    } else if (model == Model::sites) {
        const double needed = double(plan::SiteCells(plan, plan.places).cells.size());
        c.traffic = needed * steps * 48;
        c.flops = needed * steps * 20 + places * steps * 40;
        c.bytes = cells * 16 + needed * 64 + places * 300;
        c.seconds = plan::why_not_separable(plan).empty()
                        ? places * (3e-7 + steps * 1e-8)
                        : steps * (needed * 4e-9 + places * 10e-9) / threads_of(device);
    } else {
        const bool vulkan = device.info().vulkan;
        const double real = precision == Precision::f64 ? 8 : 4;
        const bool integral = plan.wanted[int(Quantity::sa2)] || !vulkan; // a device keeps it where it is asked for
        const double state = (precision == Precision::f32_compensated ? 2 : 1) * (integral ? 2 : 1); // maps
        const double responses = double(std::count(plan.wanted.begin() + 1, plan.wanted.end(), true));
        const double pressure = plan.framed ? 2 : 1;
        const bool looks =
            !plan.field_times.empty() || plan.framed || plan.scene.load.envelope.kind != Envelope::Kind::sine;
        const double held = vulkan ? pressure + 1 + 2 * state + responses + (plan.derives ? 3 : 0) // S, C, D
                                   : pressure + 1 + (looks ? 2 : 1) * state + (plan.keeps_maps ? responses : 0);
        const double tiles = double(plan.tiles) * plan.constants.height * (responses + 1) * 3;
        c.traffic = pressed * steps * real * (pressure + 1 + 2 * state + (vulkan || plan.keeps_maps ? responses : 0));
        c.flops = pressed * steps * (precision == Precision::f32_compensated ? 66 : 52);
        c.bytes = cells * (whole + 8) +
                  real * (double(plan.pitch) * plan.constants.height * held + tiles) + // 8: strain at the end
                  (maps > 0 ? double(plan.media.size()) * 12 * real : 0);
        c.seconds = steps * (2e-6 + pressed * march_rate(device, precision));
        if (vulkan)
            c.dispatches = c.steps * (2 + static_cast<long long>(responses)), c.seconds += double(c.dispatches) * 5e-6;
    }
    return c;
}

} // namespace

Explanation choose(plan::Plan& plan, const Device& device, const RunOptions& options, bool everything) {
    const Scene& s = plan.scene;
    const bool asked = device.impl().asked, vulkan = device.info().vulkan;
    const std::optional<Precision> precision = options.precision ? options.precision : s.precision;
    if (s.model) {
        const std::string name_of = std::string("\"") + name(*s.model) + "\"";
        if (options.check && *s.model != Model::march) refuse("model", name_of, "a check compares marches");
        const std::string why = plan::why_not(plan, *s.model);
        if (!why.empty()) refuse("model", name_of, why);
        if (*s.model != Model::march && precision && *precision != Precision::f64)
            refuse("precision", name(*precision), "model " + name_of + " works in f64");
    }
    if (precision == Precision::f64 && asked && vulkan && (!s.model || *s.model == Model::march))
        refuse("precision", "f64", "\"" + device.info().name + "\" marches in f32; f64 on the CPU path alone");
    if (precision == Precision::f64 && options.check) refuse("precision", "f64", "a check of backends compares f32");

    Explanation e;
    e.binding = s.tolerance.has_value();
    e.tolerance = s.tolerance.value_or(default_tolerance);
    const Device cpu = vulkan ? Device::cpu() : device;
    for (Model m : {Model::moments, Model::maps, Model::sites}) {
        const std::string why = plan::why_not(plan, m);
        if (why.empty()) e.candidates.push_back(costed(plan, m, Precision::f64, cpu));
        else if (everything) {
            e.candidates.push_back({m, Precision::f64, cpu.info().name});
            e.candidates.back().refused = why;
        }
    }
    for (Precision p : {Precision::f32, Precision::f32_compensated})
        e.candidates.push_back(costed(plan, Model::march, p, device));
    e.candidates.push_back(costed(plan, Model::march, Precision::f64, cpu));
    std::stable_sort(e.candidates.begin(), e.candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.seconds < b.seconds; });

    std::optional<Errors> peaks[2]; // of all cells, of sites
    std::optional<size_t> taken, nearest;
    for (size_t i = 0; i < e.candidates.size(); ++i) {
        Candidate& c = e.candidates[i];
        const bool march = c.model == Model::march;
        if (!c.refused.empty()) continue;
        if (s.model && c.model != *s.model) c.refused = std::string("model = ") + name(*s.model) + " is asked for";
        else if (precision && c.precision != *precision)
            c.refused = std::string("precision = ") + name(*precision) + " is asked for";
        else if (options.check && (!march || c.precision == Precision::f64))
            c.refused = "a check compares marches in f32";
        else if (asked && vulkan && !s.model && !march) c.refused = "a Vulkan device is asked for, which marches";
        else if (asked && vulkan && march && c.precision == Precision::f64) c.refused = "f64 on the CPU path alone";
        const bool possible = c.refused.empty();
        // what is the only one anyway, or exact but for rounding in double, needs no bound to be taken
        const bool free = march && !precision, forced = s.model || precision || s.method != Method::exact;
        if (everything || (possible && !taken && (e.binding || free || forced))) {
            plan.model = c.model;
            if (c.model != Model::sites && plan.maps.rest_curvature.empty()) plan::complete(plan);
            auto& peak = peaks[c.model == Model::sites];
            if (!peak) peak = measured_peaks(plan);
            c.error = worst_asked(plan, predicted_errors(plan, c.precision, march || c.model == Model::sites, *peak));
        }
        if (!possible || taken) continue;
        const bool binds = e.binding || free;
        if (binds && !(c.error <= e.tolerance)) {
            if (!nearest || c.error < e.candidates[*nearest].error) nearest = i;
            c.refused = "its error may reach " + shortest(c.error) + ", above the tolerance";
        } else {
            taken = i;
            if (!everything) break;
        }
    }
    if (!taken && nearest && e.binding) {
        const Candidate& best = e.candidates[*nearest];
        throw Error(Error::Code::bad_input, "tolerance",
                    "tolerance = " + shortest(e.tolerance) + "; attainable here: " + shortest(best.error) +
                        " with model " + name(best.model) + " in " + name(best.precision) + " on " + best.device);
    }
    if (!taken && nearest) e.candidates[*nearest].refused.clear(), taken = nearest; // the default binds where it can
    if (!taken) refuse("precision", precision ? name(*precision) : "(free)", "no model of this scene works in it");
    for (size_t i = 0; i < e.candidates.size(); ++i)
        if (i != *taken && e.candidates[i].refused.empty()) e.candidates[i].refused = "dearer than the one taken";
    e.chosen = *taken;
    if (everything && !plan.maps.rest_curvature.empty())
        e.stencil_estimate = plan::stencil_estimate(plan, plan.maps.pressure, 0).greatest;
    plan.model = e.candidates[*taken].model;
    plan.precision = e.candidates[*taken].precision;
    plan.compensated = plan.precision == Precision::f32_compensated;
    return e;
}

} // namespace dermis::planner
