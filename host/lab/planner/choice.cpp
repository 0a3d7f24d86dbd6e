// SPDX-License-Identifier: MIT
#include "host/lab/planner/choice.hpp"

#include "host/core/base/text.hpp"
#include "host/lab/march/stepper.hpp"
#include "host/lab/planner/bound.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::planner {
namespace {

using plan::PreparedSkin;
using plan::Schedule;

constexpr double default_tolerance = 1e-4;

[[noreturn]] void refuse(const char* parameter, const std::string& value, const std::string& why) {
    throw Error(Error::Code::bad_input, parameter,
                std::string(parameter) + " = " + value + "; not allowed here: " + why);
}

// Refuses receptors at a depth, or that follow the stress, where no model that serves the request knows them.
void refuse_depth(const PreparedSkin& skin, const Schedule& schedule, const Request& r) {
    if (!schedule.spreads() && schedule.modes.empty()) return;
    const char* key = schedule.spreads() ? "receptors.depth" : "receptors.follow";
    const bool marches = r.check || (r.on_device && !r.model) || (r.precision && r.precision != Precision::f64);
    if (marches) refuse(key, "(given)", "a Vulkan device, f32 and checks march, cell by cell");
    std::string reasons;
    for (Model m : {Model::maps, Model::sites}) {
        const std::string why = why_not(skin, schedule, m);
        if (why.empty()) return;
        reasons += (reasons.empty() ? "" : "; ") + ("model \"" + std::string(name(m)) + "\": ") + why;
    }
    refuse(key, "(given)", reasons);
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
    refuse_depth(skin, schedule, r);
    if (r.precision != Precision::f64) return;
    if (r.on_device && !backends.opened.f64 && (!r.model || *r.model == Model::march))
        refuse("precision", "f64", "\"" + backends.opened.name + "\" marches in f32; f64 on the CPU path alone");
    if (r.check) refuse("precision", "f64", "a check of backends compares f32");
}

// The candidates in the order of their seconds. everything: also candidates that cannot serve, with the reason.
std::vector<Candidate> candidates(const PreparedSkin& skin, const Schedule& schedule, const Backends& backends,
                                  bool everything) {
    std::vector<Candidate> all;
    for (Model m : {Model::moments, Model::maps, Model::sites}) {
        const std::string why = why_not(skin, schedule, m);
        if (why.empty()) all.push_back(costed(skin, schedule, m, Precision::f64, backends.cpu));
        else if (everything) {
            all.push_back({m, Precision::f64, backends.cpu.name});
            all.back().refused = why;
        }
    }
    const std::string why = why_not(skin, schedule, Model::march);
    for (Precision p : {Precision::f32, Precision::f32_compensated, Precision::f64}) {
        const plan::Capabilities& backend = p == Precision::f64 ? backends.cpu : backends.opened;
        if (!why.empty() && !everything) continue;
        all.push_back(costed(skin, schedule, Model::march, p, backend));
        all.back().refused = why;
    }
    std::ranges::stable_sort(all, [](const Candidate& a, const Candidate& b) { return a.seconds < b.seconds; });
    return all;
}

// The reason why the request rules a candidate out; empty where it does not.
std::string ruled_out(const Candidate& c, const Request& r, const Backends& backends) {
    const bool march = c.model == Model::march;
    if (r.model && c.model != *r.model) return std::string("model = ") + name(*r.model) + " is asked for";
    if (r.precision && c.precision != *r.precision)
        return std::string("precision = ") + name(*r.precision) + " is asked for";
    if (r.check && (!march || c.precision == Precision::f64)) return "a check compares marches in f32";
    if (r.on_device && !r.model && !march) return "a Vulkan device is asked for, which marches";
    if (r.on_device && march && c.precision == Precision::f64 && !backends.opened.f64)
        return "f64 on the CPU path alone";
    return "";
}

class ErrorBounds {
  public:
    ErrorBounds(const PreparedSkin& skin, const Schedule& schedule, std::optional<Peaks>& peaks)
        : skin_(skin), schedule_(schedule), peaks_(peaks) {}

    Worst of(const Candidate& c) {
        const bool separable = c.model != Model::march && why_not_separable(skin_, schedule_).empty();
        const Arithmetic kind = arithmetic_of(c.precision, separable);
        if (!separable || skin_.uniform()) return worst(skin_, schedule_, kind);
        if (!parts_) parts_ = plan::in_parts({skin_, schedule_});
        return worst(parts_->skin, parts_->schedule, kind);
    }

  private:
    const Peaks& peaks() {
        if (!peaks_) peaks_ = measured_peaks(skin_, schedule_);
        return *peaks_;
    }

    Worst worst(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind) {
        const bool whole = !schedule.output.traces.empty() || !schedule.output.fields.empty();
        const auto of_cells = [&](const Arithmetic& as) {
            return whole ? bounds_of_cells(skin, schedule, as) : Bounds{};
        };
        const auto of_sites = [&](const Arithmetic& as) { return bounds_of_sites(skin, schedule, as); };
        const Bounds cells = of_cells(kind), sites = of_sites(kind);
        Peaks sure = peaks();
        if ((kind.separable || !kind.single) && schedule.method == Method::exact) { // peaks are of a march in double
            const Arithmetic march = arithmetic_of(Precision::f64, false);
            const Bounds of = kind.separable ? of_cells(march) : cells, at = kind.separable ? of_sites(march) : sites;
            for (size_t q = 0; q < sure.all.size(); ++q) {
                sure.all[q] = std::max(sure.all[q] - 2 * of.throughout[q], 0.0);
                sure.sites[q] = std::max(sure.sites[q] - 2 * at.throughout[q], 0.0);
            }
        }
        return worst_asked(skin, schedule, cells, sites, sure, kind.stored);
    }

    const PreparedSkin& skin_;
    const Schedule& schedule_;
    std::optional<Peaks>& peaks_;            // empty until they are needed
    std::optional<plan::PreparedRun> parts_; // of the same strain, where materials differ
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

} // namespace

Explanation choose(const PreparedSkin& skin, const Schedule& schedule, const Request& r, const Backends& backends,
                   bool everything, std::optional<Peaks>& peaks) {
    check_request(skin, schedule, r, backends);
    Explanation e;
    e.binding = r.tolerance.has_value();
    e.tolerance = r.tolerance.value_or(default_tolerance);
    e.candidates = candidates(skin, schedule, backends, everything);
    ErrorBounds bounds(skin, schedule, peaks);
    std::optional<size_t> taken, nearest;
    for (size_t i = 0; i < e.candidates.size() && (everything || !taken); ++i) {
        Candidate& c = e.candidates[i];
        if (!c.refused.empty()) continue;
        c.refused = ruled_out(c, r, backends);
        const bool possible = c.refused.empty();
        const bool rough =
            c.model == Model::march || std::ranges::any_of(skin.parts, std::mem_fn(&plan::TimeGroup::rough));
        const bool unforced = is_unforced(c, r), binds = e.binding || (rough && unforced);
        // No bound is needed for a candidate that is the only one, or whose only error is rounding in double.
        const bool forced = r.model || r.precision || r.baseline;
        if (everything || (possible && !taken && (binds || forced))) c.error = bounds.of(c).error;
        if (!possible || taken) continue;
        if (!binds || c.error <= e.tolerance) {
            taken = i;
            continue;
        }
        if (!nearest || c.error < e.candidates[*nearest].error) nearest = i;
        c.refused = "its error may reach " + shortest(c.error) + ", above the tolerance";
    }
    if (!taken && nearest && e.binding) {
        const Candidate& best = e.candidates[*nearest];
        refuse_tolerance(e.tolerance, best, bounds.of(best), !r.baseline);
    }
    if (!taken && nearest) e.candidates[*nearest].refused.clear(), taken = nearest; // the default binds where it can
    if (!taken) refuse("precision", r.precision ? name(*r.precision) : "(free)", "no model of this scene works in it");
    for (size_t i = 0; i < e.candidates.size(); ++i)
        if (i != *taken && e.candidates[i].refused.empty()) e.candidates[i].refused = "dearer than the one taken";
    e.chosen = *taken;
    if (!everything) return e;
    const plan::StencilEstimate at_rest = stencil_estimate(skin, schedule.pressure, 0);
    e.stencil_estimate = at_rest.greatest;
    e.greatest_curvature = at_rest.curvature;
    if (!why_not_separable(skin, schedule).empty()) return e;
    for (const plan::TimeGroup& part : skin.parts) e.retardation_times.push_back(scene::tau_range({part.element}).max);
    return e;
}

} // namespace dermis::planner
