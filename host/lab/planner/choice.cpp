// SPDX-License-Identifier: MIT
#include "host/lab/planner/choice.hpp"

#include "host/core/base/text.hpp"
#include "host/lab/march/stepper.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::planner {
namespace {

using model::PreparedSkin;
using model::Schedule;

constexpr double default_tolerance = 1e-4;

[[noreturn]] void refuse(const char* parameter, const std::string& value, const std::string& why) {
    throw Error(Error::Code::bad_input, parameter,
                std::string(parameter) + " = " + value + "; not allowed here: " + why);
}

// Refuses receptors at a depth, or that follow the stress, where no model that serves the request knows them.
void check_receptors(const PreparedSkin& skin, const Schedule& schedule, const Request& r) {
    if (!schedule.spreads() && schedule.modes.empty()) return;
    const bool marches = r.check || (r.on_device && !r.model) || (r.precision && r.precision != Precision::f64);
    std::string reasons = marches ? "a Vulkan device, f32 and checks march" : "";
    for (Model m : {Model::maps, Model::sites, Model::march}) {
        if (marches && m != Model::march) continue;
        const std::string why = why_not(skin, schedule, m);
        if (why.empty()) return;
        reasons += (reasons.empty() ? "" : "; ") + ("model \"" + std::string(name(m)) + "\": ") + why;
    }
    refuse(schedule.modes.empty() ? "receptors.depth" : "receptors.follow", "(given)", reasons);
}

// Refuses requests that contradict each other, or that no candidate can meet.
void check_request(const PreparedSkin& skin, const Schedule& schedule, const Request& r, const Backends& backends) {
    if (r.model) {
        const std::string name_of = std::string("\"") + name(*r.model) + "\"";
        if (r.check && *r.model != Model::march) refuse("model", name_of, "a check compares marches");
        const std::string why = why_not(skin, schedule, *r.model);
        if (!why.empty()) refuse("model", name_of, why);
        if (*r.model != Model::march && r.precision && *r.precision != Precision::f64)
            refuse("precision", name(*r.precision), "model " + name_of + " works in f64");
    }
    check_receptors(skin, schedule, r);
    if (r.precision != Precision::f64) return;
    if (r.on_device && !backends.opened.f64 && (!r.model || *r.model == Model::march))
        refuse("precision", "f64", "\"" + backends.opened.name + "\" marches in f32; f64 on the CPU path alone");
    if (r.check) refuse("precision", "f64", "a check of backends compares f32");
}

// The models in the order in which they are tried, a march in compensated float before double. Plain float is only
// asked for.
constexpr std::pair<Model, Precision> order_of_trial[] = {
    {Model::sites, Precision::f64}, {Model::moments, Precision::f64},
    {Model::maps, Precision::f64},  {Model::march, Precision::f32_compensated},
    {Model::march, Precision::f64}, {Model::march, Precision::f32}};
constexpr double least_in_float = 1e-6; // the least tolerance for which float is tried

// The reason why the request rules a candidate out; empty where it does not.
std::string ruled_out(const Candidate& c, const Request& r, double tolerance, const Backends& backends) {
    const bool march = c.model == Model::march;
    if (r.model && c.model != *r.model) return std::string("model = ") + name(*r.model) + " is asked for";
    if (r.precision && c.precision != *r.precision)
        return std::string("precision = ") + name(*r.precision) + " is asked for";
    if (r.check && (!march || c.precision == Precision::f64)) return "a check compares marches in f32";
    if (r.on_device && !r.model && !march) return "a Vulkan device is asked for, which marches";
    if (r.on_device && march && c.precision == Precision::f64 && !backends.opened.f64)
        return "f64 on the CPU path alone";
    if (!r.precision && c.precision == Precision::f32) return "precision = f32 is not asked for";
    const bool only = r.check || (r.on_device && !backends.opened.f64); // no other precision can serve
    if (!r.precision && c.precision == Precision::f32_compensated && tolerance < least_in_float && !only)
        return "the tolerance is below " + shortest(least_in_float) + ", so that double is taken";
    return "";
}

class ErrorBounds {
  public:
    ErrorBounds(const PreparedSkin& skin, const Schedule& schedule, std::optional<Peaks>& peaks)
        : skin_(skin), schedule_(schedule), peaks_(peaks), separable_(why_not_separable(skin, schedule).empty()) {}

    const Worst& of(const Candidate& c) {
        const bool march = c.model == Model::march, separable = !march && separable_,
                   spread = march && schedule_.spreads();
        std::optional<Worst>& known = known_[separable ? 0 : 1 + size_t(c.precision) + (spread ? 3 : 0)];
        if (known) return *known;
        if (!peaks_) peaks_ = measured_peaks(skin_, schedule_);
        const Arithmetic kind = arithmetic_of(c.precision, separable, spread);
        if (!separable || skin_.uniform()) return known.emplace(worst(skin_, schedule_, kind));
        const model::PreparedRun parts = model::in_parts({skin_, schedule_}); // of the same strain
        return known.emplace(worst(parts.skin, parts.schedule, kind));
    }

  private:
    Worst worst(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind) const {
        const bool whole = !schedule.output.traces.empty() || !schedule.output.fields.empty();
        const auto of_cells = [&](const Arithmetic& as) {
            return whole ? bounds_of_cells(skin, schedule, as) : Bounds{};
        };
        const auto of_sites = [&](const Arithmetic& as) { return bounds_of_sites(skin, schedule, as); };
        Bounds cells = of_cells(kind), sites = of_sites(kind);
        Peaks sure = *peaks_;
        const bool other = kind.separable || kind.spread; // peaks are of a march in double, by sums over all cells
        if ((other || !kind.single) && schedule.method == Method::exact) {
            const Arithmetic march = arithmetic_of(Precision::f64, false);
            const Bounds of = other ? of_cells(march) : cells, at = other ? of_sites(march) : sites;
            for (size_t q = 0; q < sure.all.size(); ++q) {
                sure.all[q] = std::max(sure.all[q] - 2 * of.throughout[q], 0.0);
                sure.sites[q] = std::max(sure.sites[q] - 2 * at.throughout[q], 0.0);
            }
            if (kind.spread) cells.throughout = of.throughout, sites.throughout = at.throughout;
        }
        return worst_asked(skin, schedule, cells, sites, sure, kind.stored);
    }

    const PreparedSkin& skin_;
    const Schedule& schedule_;
    std::optional<Peaks>& peaks_; // empty until they are needed
    const bool separable_;
    // Of products; of marches and sites in each precision; of marches that spread.
    std::array<std::optional<Worst>, 7> known_;
};

bool is_unforced(const Candidate& c, const Request& r) { return !r.precision && (c.model == Model::march || !r.model); }

// Refuses a tolerance that not even the best of the candidates keeps. rounds: all of its error is rounding.
[[noreturn]] void refuse_tolerance(double tolerance, const Candidate& best, const Worst& worst, bool rounds) {
    std::string attainable =
        std::isfinite(best.error)
            ? shortest(best.error) + " with model " + name(best.model) + " in " + name(best.precision) + " on " +
                  best.device
            : "none, because results may grow beyond " +
                  (best.precision == Precision::f64 ? "1.8e308" : "3.4e38 in " + std::string(name(best.precision)));
    if (rounds && std::isfinite(best.error) && best.error >= 1)
        attainable += std::string("; ") + name(worst.of) + " is 0 to rounding where it is written: at most about " +
                      shortest(worst.peak);
    throw Error(Error::Code::bad_input, "tolerance",
                "tolerance = " + shortest(tolerance) + "; attainable here: " + attainable);
}

// Adds what is known of the skin without a run.
void describe(Explanation& e, const PreparedSkin& skin, const Schedule& schedule) {
    const model::StencilEstimate at_rest = stencil_estimate(skin, schedule.pressure, 0);
    e.stencil_estimate = at_rest.greatest;
    e.greatest_curvature = at_rest.curvature;
    if (!why_not_separable(skin, schedule).empty()) return;
    for (const model::TimeGroup& part : skin.parts) e.retardation_times.push_back(scene::tau_range({part.element}).max);
}

} // namespace

Explanation choose(const PreparedSkin& skin, const Schedule& schedule, const Request& r, const Backends& backends,
                   bool everything, std::optional<Peaks>& peaks) {
    check_request(skin, schedule, r, backends);
    Explanation e;
    e.binding = r.tolerance.has_value();
    e.tolerance = r.tolerance.value_or(default_tolerance);
    ErrorBounds bounds(skin, schedule, peaks);
    std::optional<size_t> taken, nearest;
    for (const auto& [model, precision] : order_of_trial) {
        if (taken && !everything) break;
        const bool march = model == Model::march, in_float = march && precision != Precision::f64;
        const model::Capabilities& backend = in_float ? backends.opened : backends.cpu;
        const size_t i = e.candidates.size();
        Candidate& c = e.candidates.emplace_back(Candidate{model, precision, backend.name});
        c.refused = why_not(skin, schedule, model);
        // Of a run whose tolerance binds a part of the cost goes to witnesses.
        if ((everything || e.binding) && c.refused.empty()) estimate_cost(c, skin, schedule, backend);
        if (!c.refused.empty()) continue;
        c.refused = ruled_out(c, r, e.tolerance, backends);
        const bool possible = c.refused.empty();
        const bool rough = march || std::ranges::any_of(skin.parts, std::mem_fn(&model::TimeGroup::rough));
        const bool spreads = march && schedule.spreads(); // no better in double than in float
        const bool binds = e.binding || (rough && is_unforced(c, r) && !spreads);
        // No bound is needed for a candidate that is the only one, or whose only error is rounding in double.
        const bool forced = r.model || r.precision || r.baseline;
        if (everything || (possible && (binds || forced || spreads))) c.error = bounds.of(c).error;
        if (!possible || taken) {
            if (possible) c.refused = "another one that keeps the tolerance comes first";
        } else if (!binds || c.error <= e.tolerance) {
            taken = i;
        } else {
            if (!nearest || c.error < e.candidates[*nearest].error) nearest = i;
            c.refused = "its error may reach " + shortest(c.error) + ", above the tolerance";
        }
    }
    if (!taken && nearest && e.binding) {
        const Candidate& best = e.candidates[*nearest];
        const bool spreads = best.model == Model::march && schedule.spreads();
        refuse_tolerance(e.tolerance, best, bounds.of(best), !r.baseline && !spreads);
    }
    if (!taken && nearest) e.candidates[*nearest].refused.clear(), taken = nearest; // the default binds where it can
    if (!taken) refuse("precision", r.precision ? name(*r.precision) : "(free)", "no model of this scene works in it");
    e.chosen = *taken;
    if (everything) describe(e, skin, schedule);
    return e;
}

} // namespace dermis::planner
