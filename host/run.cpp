// SPDX-License-Identifier: MIT
// Scene -> Plan -> backend -> Result.
#include "host/device.hpp"
#include "host/simd/pool.hpp"
#include "host/planner/choice.hpp"
#include "host/reduced/moments.hpp"
#include "host/reduced/sites.hpp"
#include "host/plan/float_environment.hpp"
#include "host/scene/text.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

namespace dermis {
namespace {

using Clock = std::chrono::steady_clock;

std::vector<Quantity> wanted(const plan::Plan& plan) {
    std::vector<Quantity> list;
    for (int q = 0; q < REDUCED_MAPS; ++q)
        if (plan.wanted[q]) list.push_back(Quantity(q));
    return list;
}

// Puts samples where they belong in a Result; tells where a step has left the numbers.
class Collector {
  public:
    Collector(Result& result, const plan::Plan& plan) : result_(result), plan_(plan), wanted_(wanted(plan)) {
        const Output& output = plan.scene.output;
        result.responses.reserve(size_t(plan.outputs) * plan.scene.sites.size());
        simd::prefer_large_pages(result.responses.data(), result.responses.capacity() * sizeof(double));
        for (Quantity q : output.traces) {
            Trace& t = result.traces.emplace_back();
            t.quantity = q;
            t.probes.resize(output.probes.size());
            t.mean.reserve(size_t(plan.outputs));
            if (output.extremes) t.min.reserve(size_t(plan.outputs)), t.max.reserve(size_t(plan.outputs));
            for (auto& column : t.probes) column.reserve(size_t(plan.outputs));
        }
    }

    void operator()(const plan::Step& step, const plan::Sample& sample) {
        const size_t probes = plan_.scene.output.probes.size(), places = plan_.places.size();
        const bool whole = plan_.model != Model::sites; // otherwise no other cells are known
        for (Quantity q : wanted_)
            if (whole) check_finite(sample.totals[int(q)].mean, q, step.time);
        if (step.trace >= 0) {
            result_.time.push_back(step.time);
            for (Trace& t : result_.traces) {
                const plan::Totals& totals = sample.totals[int(t.quantity)];
                t.mean.push_back(totals.mean);
                if (plan_.scene.output.extremes) {
                    t.min.push_back(totals.min);
                    t.max.push_back(totals.max);
                }
                for (size_t i = 0; i < probes; ++i)
                    t.probes[i].push_back(sample.probes[size_t(t.quantity) * places + i]);
            }
        }
        if (step.trace >= 0) {
            const std::vector<Site>& sites = plan_.scene.sites;
            const double* values = sample.probes.data() + probes;
            const size_t first = result_.responses.size();
            bool finite = true;
            for (size_t i = 0; i < sites.size(); ++i) {
                const double v = values[size_t(sites[i].type) * places + i];
                result_.responses.push_back(v);
                finite &= std::isfinite(v);
            }
            for (size_t i = 0; !finite && i < sites.size(); ++i)
                check_finite(result_.responses[first + i], sites[i].type, step.time);
        }
        if (step.impulse < 0 || !whole) return;
        for (auto [quantity, elastic] : {std::pair{Quantity::fa1, true}, {Quantity::fa2, false}}) {
            if (!plan_.wanted[int(quantity)]) continue;
            if (std::none_of(plan_.media.begin(), plan_.media.end(),
                             [elastic = elastic](auto& m) { return (m.viscosity == 0) == elastic; }))
                continue;
            Impulse& i = result_.impulses.emplace_back();
            i.time = step.time;
            i.quantity = quantity;
            const plan::Totals& totals = sample.totals[int(i.quantity)];
            i.mean = totals.mean;
            i.min = plan_.scene.output.extremes ? totals.min : NAN;
            i.max = plan_.scene.output.extremes ? totals.max : NAN;
            const auto first = sample.probes.begin() + int(i.quantity) * int(places);
            i.probes.assign(first, first + int(probes));
        }
    }

    // A mean over all cells is finite where every cell is. With allow_unstable growth without end is what was asked
    // for.
    void check_finite(double value, Quantity q, double time) const {
        if (std::isfinite(value) || plan_.scene.allow_unstable) return;
        throw Error(
            Error::Code::bad_input, "",
            std::string(name(q)) + " overflows at t = " + shortest(time) + " s in " + name(result_.precision) +
                "; allowed: loads, materials and lengths whose results stay below 3.4e38 in f32, 1.8e308 in f64");
    }

  private:
    Result& result_;
    const plan::Plan& plan_;
    std::vector<Quantity> wanted_;
};

bool same_bits(double a, double b) { return std::bit_cast<uint64_t>(a) == std::bit_cast<uint64_t>(b); }

long long different(const std::vector<double>& a, const std::vector<double>& b) {
    long long n = 0;
    for (size_t i = 0; i < a.size(); ++i) n += !same_bits(a[i], b[i]);
    return n;
}

// A second backend that takes the same steps; every cell of every output is compared, and every sample.
class Check {
  public:
    Check(const Device& device, const plan::Plan& plan, Result& result)
        : result_(result), wanted_(wanted(plan)), collected_(other_result_, plan),
          stepper_(march(device, plan, [this](auto& s, auto& x) { collected_(s, x); })) {}

    void frame(const std::vector<double>& pressure) { stepper_->frame(pressure); }

    void press(const plan::Step& step, plan::Stepper& first) {
        stepper_->press(step);
        if (!step.respond()) return;
        std::vector<Quantity> what = wanted_;
        if (what.empty() || what[0] != Quantity::strain) what.insert(what.begin(), Quantity::strain); // always there
        if (step.field >= 0) what.insert(what.end(), {Quantity::curvature, Quantity::deformation});
        first.read(what, ours_);
        stepper_->read(what, theirs_);
        for (size_t q = 0; q < what.size(); ++q) {
            result_.cells_compared += static_cast<long long>(ours_[q].size());
            result_.cells_different += different(ours_[q], theirs_[q]);
        }
    }

    void finish() {
        stepper_->finish();
        for (size_t i = 0; i < result_.traces.size(); ++i) {
            const Trace &a = result_.traces[i], &b = other_result_.traces[i];
            result_.cells_different += different(a.mean, b.mean) + different(a.min, b.min) + different(a.max, b.max);
            for (size_t p = 0; p < a.probes.size(); ++p) result_.cells_different += different(a.probes[p], b.probes[p]);
        }
    }

  private:
    Result& result_;
    const std::vector<Quantity> wanted_;
    Result other_result_;
    std::vector<std::vector<double>> ours_, theirs_;
    Collector collected_;
    std::unique_ptr<plan::Stepper> stepper_;
};

} // namespace

const Trace& Result::trace(Quantity q) const {
    const auto t = std::find_if(traces.begin(), traces.end(), [q](auto& trace) { return trace.quantity == q; });
    if (t == traces.end())
        throw Error(Error::Code::bad_input, "output.traces",
                    std::string("output.traces has no \"") + name(q) + "\"; allowed: what the scene asked for");
    return *t;
}

namespace {

// What the numbers printed beside a result are taken from: the skin at its last step.
void look_at_end(Result& result, const plan::Plan& plan, plan::Stepper& stepper) {
    const plan::StencilEstimate estimate = stepper.estimate(plan);
    result.stencil_estimate = estimate.greatest;
    result.kinks = estimate.kinks;
    result.greatest_gain = std::abs(*plan.scene.material.curvature_length) * estimate.curvature;
}

using SharedMoments = std::shared_ptr<const reduced::Moments>;

Result run_plan(const plan::Plan& plan, const SharedMoments& moments, const Device& device, const RunOptions& options,
                const Result* like = nullptr) {
    const bool marches = plan.model == Model::march;
    Result result;
    result.model = plan.model;
    result.precision = marches ? plan.precision : Precision::f64;
    result.predicted_error = plan.predicted_error;
    result.tau_min = INFINITY;
    for (const plan::Medium& m : plan.media) {
        result.tau_min = std::min(result.tau_min, m.viscosity / m.modulus);
        result.tau_max = std::max(result.tau_max, m.viscosity / m.modulus);
    }
    Collector collect(result, plan);
    std::optional<plan::SiteCells> cells;
    plan::Plan timed;
    if (!marches && !moments) {
        cells.emplace(plan, plan.places);
        timed = plan::timing(plan, cells->media, plan.scene.method);
    }
    const auto stepper = marches   ? march(device, plan, std::ref(collect))
                         : moments ? reduced::separable(plan, moments, std::ref(collect))
                                   : reduced::sites(plan, *cells, device.impl().threads, std::ref(collect));
    result.device = device.info(); // what making the march has found out
    std::unique_ptr<Check> check;
    if (options.check)
        check = std::make_unique<Check>(device.info().vulkan ? Device::cpu() : Device::open("vulkan"), plan, result);

    const auto start = Clock::now();
    plan::Timeline timeline(cells ? timed : plan);
    plan::FrameFeed feed(plan);
    for (plan::Step step; timeline.next(step);) {
        feed.before(step, [&](const std::vector<double>& frame) {
            stepper->frame(frame);
            if (check) check->frame(frame);
        });
        stepper->press(step);
        ++result.steps;
        if (check) check->press(step, *stepper);
        if (step.field >= 0)
            for (const FieldRequest& f : plan.scene.output.fields)
                if (scene::Waveform::snapped(f.at, plan.scene.time.step) == plan.field_times[size_t(step.field)]) {
                    std::vector<std::vector<double>> maps;
                    stepper->read(f.what, maps);
                    for (size_t i = 0; i < maps.size(); ++i) {
                        for (double v : maps[i]) collect.check_finite(v, f.what[i], f.at);
                        result.fields.push_back({f.at, f.what[i], std::move(maps[i])});
                    }
                }
        if (options.progress && step.trace >= 0 && step.trace % 16 == 0)
            options.progress(double(step.trace + 1) / double(plan.outputs));
    }
    stepper->finish();
    if (check) check->finish();
    else result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (plan.model == Model::sites) {
        // nothing is known of the other cells
    } else if (like) {
        result.stencil_estimate = like->stencil_estimate;
        result.kinks = like->kinks;
        result.greatest_gain = like->greatest_gain;
    } else {
        look_at_end(result, plan, *stepper);
    }
    result.dispatches = stepper->dispatches();
    result.left_out = stepper->left_out();
    if (options.progress) options.progress(1);
    return result;
}

plan::Plan decided(const Scene& scene, const Device& device, const RunOptions& options) {
    plan::Plan plan = plan::prepare(scene);
    const Explanation e = planner::choose(plan, device, options, false);
    plan.predicted_error = e.candidates[e.chosen].error;
    plan.keeps_maps |= options.check;
    plan.derives |= options.check && !scene.output.fields.empty(); // then all of it is compared
    if (plan.model == Model::march && plan.maps.rest_curvature.empty()) plan::complete(plan);
    return plan;
}

// All but a march in float is the CPU path's.
Device working(const plan::Plan& plan, const Device& device) {
    return device.info().vulkan && (plan.model != Model::march || plan.precision == Precision::f64) ? Device::cpu()
                                                                                                    : device;
}

// Null where cells have to march.
SharedMoments moments_for(const plan::Plan& plan, const Device& device) {
    return plan.model == Model::march || !plan::why_not_separable(plan).empty()
               ? nullptr
               : reduced::moments_of(plan, device.impl().threads);
}

} // namespace

Explanation explain(const Scene& scene, const Device& device, const RunOptions& options) {
    const DefaultFloats guard;
    plan::Plan plan = plan::prepare(scene);
    return planner::choose(plan, device, options, true);
}

Result run(const Scene& scene, const Device& device, const RunOptions& options) {
    const DefaultFloats guard;
    const plan::Plan plan = decided(scene, device, options);
    return run_plan(plan, moments_for(plan, device), working(plan, device), options);
}

std::vector<Result> run(const Scene& scene, const std::vector<Material>& materials, const Device& device,
                        const RunOptions& options) {
    const DefaultFloats guard;
    std::vector<Result> results;
    std::optional<plan::Plan> plan; // of the material before, as long as its maps serve
    SharedMoments moments;
    for (const Material& material : materials) {
        const Result* like = nullptr;
        const auto same_lengths = [&](const Material& m) {
            return m.thickness == material.thickness && m.curvature_length == material.curvature_length;
        };
        if (moments && same_lengths(results.empty() ? scene.material : materials[results.size() - 1]) &&
            material.modulus_map.empty() && material.viscosity_map.empty()) {
            plan::set_material(*plan, material);
            plan->predicted_error = std::nan(""); // the first one's
            like = &results.front();
        } else {
            Scene with = scene;
            with.material = material;
            plan = decided(with, device, options);
            moments = moments_for(*plan, device);
        }
        results.push_back(run_plan(*plan, moments, working(*plan, device), options, like));
    }
    return results;
}

} // namespace dermis
