// SPDX-License-Identifier: MIT
// Prepare, decide, open, decide again, realise, step: a scene becomes a Result.
#include "dermis/run.hpp"
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/watch.hpp"
#include "host/core/model/site_cells.hpp"
#include "host/core/press/device.hpp"
#include "host/core/press/report.hpp"
#include "host/lab/march/march.hpp"
#include "host/lab/planner/choice.hpp"
#include "host/lab/planner/magnitudes.hpp"
#include "host/lab/reduced/moments.hpp"
#include "host/lab/reduced/sites.hpp"
#include "host/lab/run/collector.hpp"
#include "host/lab/run/witness.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>

namespace dermis {

namespace {

// Says what a run needs at least.
std::string needs_of(const Scene& s) {
    const double cells = double(s.grid.width) * double(s.grid.height),
                 outputs = std::ceil(s.time.duration / s.time.step);
    double fields = 0;
    for (const FieldRequest& f : s.output.fields) fields += double(f.what.size());
    const double of_output = 1 + double(s.sites.size()) + double(s.output.traces.size()) * (s.output.extremes ? 3 : 1) +
                             double(s.output.traces.size() * s.output.probes.size());
    const double maps = 2; // heights and pressures
    return "a run of " + scene::grid_text(s.grid) + " with " + std::to_string((long long)(outputs)) +
           " outputs needs at least " +
           scene::bytes_text(sizeof(double) * (cells * (maps + fields) + outputs * of_output));
}

using Clock = std::chrono::steady_clock;
using SharedMoments = std::shared_ptr<const reduced::Moments>;

int threads_of(const Device& device) { return device.impl().backend->threads(); }

// A validated scene with its skin and schedule.
struct Prepared {
    Scene scene;
    model::PreparedRun run;
    SharedMoments moments; // of the same maps, if they have been made already
};

Prepared prepared(const Scene& scene, const Device& device, bool check) {
    const scene::ValidatedScene validated = scene::validate(scene);
    Prepared p{validated.scene, model::prepare_run(validated, check, threads_of(device)), {}};
    model::Schedule& s = p.run.schedule;
    const auto most = std::ranges::max_element(s.frame_peaks) - s.frame_peaks.begin();
    Map load = s.sequence ? Map(model::FrameFeed(s, p.run.skin.width()).frame(most)) : s.pressure;
    for (const model::Schedule& other : s.others)
        std::ranges::transform(load, other.pressure, load.edit().begin(), std::plus());
    s.fine_load = fine_load_of(p.run.skin.description, load);
    return p;
}

// How a run is computed: all candidates, the one that is taken, and the device for which that was decided.
struct Decision {
    Explanation explanation;
    Device device;
    std::optional<planner::Peaks> peaks; // what errors are relative to; empty if none was bounded

    const Candidate& taken() const { return explanation.candidates[explanation.chosen]; }
    bool marches_in_float() const { return taken().model == Model::march && taken().precision != Precision::f64; }
};

// Changes and opens nothing.
Decision decide(const Prepared& p, const Device& device, const RunOptions& options, bool everything) {
    const planner::Request request{.model = p.scene.model,
                                   .precision = options.precision ? options.precision : p.scene.precision,
                                   .tolerance = p.scene.tolerance,
                                   .baseline = p.scene.method != Method::exact,
                                   .check = options.check,
                                   .on_device = device.impl().asked && device.info().vulkan};
    const model::Capabilities opened = device.impl().backend->capabilities();
    const planner::Backends backends{opened,
                                     device.info().vulkan ? Device::cpu().impl().backend->capabilities() : opened};
    Decision d{.explanation = {}, .device = device, .peaks = {}};
    d.explanation = planner::choose(p.run.skin, p.run.schedule, request, backends, everything, d.peaks);
    return d;
}

// Decides. If the device was put off and a march in float is taken, opens it, and decides again on a Vulkan device.
Decision decided(const Prepared& p, const Device& device, const RunOptions& options, bool everything = false) {
    Decision d = decide(p, device, options, everything);
    if (!device.impl().put_off || !d.marches_in_float()) return d;
    d.device = device.impl().best();
    return d.device.info().vulkan ? decide(p, d.device, options, everything) : d;
}

// A run as it is computed.
struct Realised {
    Scene scene; // validated
    model::PreparedRun run;
    Candidate decision;
    Device device;                    // the one that computes: the CPU path for all but a march in float
    SharedMoments moments;            // null where cells are stepped
    std::unique_ptr<Witness> witness; // null if no tolerance binds, and as witness_of()

    bool sites_alone() const { return decision.model == Model::sites; }
};

// The only place where a skin changes after it is prepared: parts and units.
Realised realised(Prepared&& p, const Decision& d) {
    const Candidate& taken = d.taken();
    Realised r{.scene = std::move(p.scene),
               .run = std::move(p.run),
               .decision = taken,
               .device = d.marches_in_float()     ? d.device
                         : d.device.info().vulkan ? Device::cpu()
                                                  : d.device,
               .moments = {},
               .witness = {}};
    if (d.explanation.binding && d.peaks) r.witness = witness_of(r.run, taken, *d.peaks);
    if (taken.model == Model::march || !why_not_separable(r.run.skin, r.run.schedule).empty()) return r;
    r.run = in_units(in_parts(std::move(r.run)));
    const bool same_cells = p.moments && p.moments->cells == r.run.schedule.points;
    r.moments =
        same_cells ? p.moments : reduced::moments_of(r.run.skin, r.run.schedule, r.sites_alone(), threads_of(r.device));
    return r;
}

// Whether the load is a map in Pa, or a sum of such maps.
bool is_in_pascal(const model::Schedule& s) {
    return !s.sequence && s.unit == 1 && std::ranges::all_of(s.others, [](const auto& one) { return one.unit == 1; });
}

// The last run with another material's elements over the same maps; it is decided, bounded and refused on its own.
Prepared prepared(Realised&& last, const Material& material) {
    scene::check_material(last.scene, material);
    scene::take_elements(last.scene.material, material);
    last.run.schedule.points.resize(last.scene.output.probes.size() + last.scene.sites.size()); // without a witness's
    last.run.schedule.modes.clear();
    last.run.schedule.shares.clear();
    take_follow(last.run.schedule, last.scene);
    if (last.scene.load.control == Load::Control::depth) // the strain is the load's in every material
        return {std::move(last.scene), std::move(last.run), last.moments};
    last.run.skin = with_material(std::move(last.run.skin), material);
    return {std::move(last.scene), std::move(last.run), last.moments};
}

// Takes the steps of one run and fills its Result.
class Run {
  public:
    Run(const Realised& d, const RunOptions& options)
        : d_(d), skin_(d.run.skin), schedule_(d.run.schedule), collect_(result_, skin_, schedule_, !d.sites_alone()) {
        result_.model = d.decision.model;
        result_.precision = d.decision.model == Model::march ? d.decision.precision : Precision::f64;
        result_.predicted_error = d.decision.error;
        const Material& material = d.scene.material;
        const scene::TauRange tau =
            scene::tau_range(scene::is_uniform(material) ? scene::chain_of(material) : skin_.materials);
        result_.tau_min = tau.min;
        result_.tau_max = tau.max;
        result_.cells_per_ridge = scene::cells_per_ridge(skin_.description);
        result_.fine_load = schedule_.fine_load;
        make_stepper();
        result_.device = d.device.info(); // after make_stepper(), which may have tested the device
        if (!options.check) return;
        const Device other = d.device.info().vulkan ? Device::cpu() : Device::open("vulkan");
        check_ = std::make_unique<CrossCheck>(
            [&](model::Stepper::Sink sink) {
                return march(other, skin_, schedule_, d.decision.precision, std::move(sink));
            },
            result_, skin_, schedule_);
    }

    // like: null, or a result of the same maps; the figures that describe the skin at the end are copied from it.
    Result take(const Result* like) {
        const auto start = Clock::now();
        const std::vector<model::Element> modal =
            schedule_.modes.empty() ? std::vector<model::Element>() : elements_of(skin_, schedule_);
        model::Timeline timeline(schedule_,
                                 !modal.empty() ? modal
                                 : cells_       ? cells_->materials
                                                : skin_.materials,
                                 skin_.rule, schedule_.method, threads_of(d_.device));
        model::FrameFeed feed(schedule_, skin_.width());
        for (model::Step step; timeline.next(step);) {
            feed.before(step, [&](const std::vector<double>& frame) {
                stepper_->frame(frame);
                if (check_) check_->frame(frame);
                if (d_.witness) d_.witness->frame(frame);
            });
            if (d_.witness && step.impulse < 0)
                d_.witness->advance(step.end); // impulses come before fields at earlier times
            stepper_->press(step);
            ++result_.steps;
            if (check_) check_->press(step, *stepper_);
            if (step.field >= 0) read_fields(step);
            if (d_.witness) d_.witness->read(step, *stepper_);
            if (step.trace >= 0 && step.trace == most_strained_ && step.trace + 1 < schedule_.outputs)
                most_curved_ = stepper_->estimate(skin_).curvature;
            if (step.trace >= 0)
                scene::reach(std::lerp(d_.scene.afferents.empty() ? 0 : share_of_fibres, 1.0,
                                       double(step.trace + 1) / double(schedule_.outputs)),
                             step.trace % 16 == 0);
        }
        stepper_->finish();
        if (check_) check_->finish();
        if (d_.witness) d_.witness->tell(result_);
        result_.seconds = std::chrono::duration<double>(Clock::now() - start).count();
        if (!d_.sites_alone()) describe_end(like);
        result_.dispatches = stepper_->dispatches();
        result_.left_out = stepper_->left_out();
        scene::reach(1, true);
        return std::move(result_);
    }

  private:
    void make_stepper() {
        const auto sink = [this](const model::Step& step, const model::Sample& sample) {
            collect_(step, sample);
            if (d_.witness) d_.witness->compare(step, sample);
        };
        if (d_.decision.model == Model::march) {
            most_strained_ = planner::telling_outputs(skin_, schedule_)[QUANTITY_STRAIN];
            stepper_ = march(d_.device, skin_, schedule_, d_.decision.precision, sink);
        } else if (d_.moments) {
            stepper_ = reduced::separable(skin_, schedule_, d_.moments, d_.sites_alone(), sink);
        } else {
            cells_.emplace(skin_, pressed_cells(schedule_), schedule_.points);
            stepper_ = reduced::sites(skin_, schedule_, *cells_, reduced::classes_of(skin_, schedule_),
                                      threads_of(d_.device), sink);
        }
    }

    void read_fields(const model::Step& step) {
        for (const FieldRequest& f : schedule_.output.fields) {
            if (!(scene::snapped(f.at, schedule_.time.step) == schedule_.field_times[size_t(step.field)])) continue;
            std::vector<std::vector<double>> maps;
            stepper_->read(f.what, maps);
            for (size_t i = 0; i < maps.size(); ++i) {
                for (double v : maps[i]) collect_.check_finite(v, f.what[i], f.at);
                if (d_.witness) d_.witness->compare(f.what[i], maps[i]);
                result_.fields.push_back({f.at, f.what[i], std::move(maps[i])});
            }
        }
    }

    // Fills in the figures that describe the skin after the last step.
    void describe_end(const Result* like) {
        if (like) {
            result_.stencil_estimate = like->stencil_estimate;
            result_.greatest_curvature = like->greatest_curvature;
            result_.pressed_cells = like->pressed_cells;
            result_.kinks = like->kinks;
            result_.greatest_gain = like->greatest_gain;
            return;
        }
        const model::StencilEstimate estimate = stepper_->estimate(skin_);
        result_.stencil_estimate = estimate.greatest;
        result_.kinks = estimate.kinks;
        result_.greatest_curvature = std::max(estimate.curvature, most_curved_);
        result_.greatest_gain = std::abs(skin_.constants.curvature_length) * result_.greatest_curvature;
        std::vector<const double*> maps;
        for (size_t k = 0; k < schedule_.products(); ++k) maps.push_back(schedule_.product(k).pressure.data());
        long long count = 0;
        for (size_t i = 0; i < skin_.cells(); ++i)
            count += std::ranges::any_of(maps, [i](const double* map) { return map[i] != 0; });
        result_.pressed_cells = count;
    }

    const Realised& d_;
    const model::PreparedSkin& skin_;
    const model::Schedule& schedule_;
    Result result_;
    Collector collect_;
    long long most_strained_ = -1;          // in a march, the output at which the skin is likely to be curved most
    double most_curved_ = 0;                // greatest |C| there, 1/m
    std::optional<model::SiteCells> cells_; // the cells that the model `sites` steps, if it steps any
    std::unique_ptr<model::Stepper> stepper_;
    std::unique_ptr<CrossCheck> check_;
};

// Presses the cell with the greatest pressure along lines and along parabolas between the frames of a sequence.
void compare_holds(const model::PreparedRun& run, Explanation& e) try {
    model::FrameFeed frames(run.schedule, run.skin.width());
    const size_t cell = planner::greatest_cell(run.schedule.pressure);
    const double peak = std::max(run.schedule.pressure[cell], 1e-300); // no quotient by 0
    SkinDescription one;
    one.grid = {1, 1, {}}; // without curvature, so that responses are strain and rate
    const auto first = run.skin.materials.begin() + long(run.skin.material_at(cell));
    for (const model::Element& m : std::span(first, run.skin.chain.length))
        one.material.elements.push_back({m.modulus, m.viscosity});
    SkinOptions options{.responses = {Quantity::sa1, Quantity::fa1}};
    Skin line(Device::cpu(1), one, options);
    options.hold = Hold::parabolic;
    Skin bow(Device::cpu(1), one, options);
    double differ[2] = {}, greatest[2] = {1e-300, 1e-300};
    for (long long k = 0; k < run.schedule.sequence->maps(); ++k) {
        for (Skin* skin : {&line, &bow}) // a jump at the first frame
            skin->press({float(frames.frame(k)[cell] / peak)}, k ? *run.schedule.load.interval : 0);
        for (size_t i = 0; i < 2; ++i) {
            const double x = line.response(options.responses[i])[0], y = bow.response(options.responses[i])[0];
            differ[i] = std::max(differ[i], std::abs(x - y));
            greatest[i] = std::max(greatest[i], std::abs(y));
        }
    }
    e.strain_between_frames = differ[0] / greatest[0];
    e.fa1_between_frames = differ[1] / greatest[1];
} catch (const Error& error) { // a number beyond float: nothing is known
    if (error.code() != Error::Code::bad_input) throw;
}

} // namespace

Explanation plan(const Scene& scene, const Device& device, const RunOptions& options) {
    const auto words = [&] { return needs_of(scene); };
    return scene::guarded(words, [&] {
        const DefaultFloats guard;
        const scene::Watch watch(options.progress);
        const Prepared p = prepared(scene, device, false);
        Explanation e = decided(p, device, options, true).explanation;
        e.fine_load = p.run.schedule.fine_load;
        if (p.run.schedule.sequence) compare_holds(p.run, e);
        return e;
    });
}

std::vector<Result> run(const Scene& scene, const std::vector<Material>& materials, const Device& device,
                        const RunOptions& options) {
    const auto words = [&] {
        return (materials.size() > 1 ? std::to_string(materials.size()) + " times " : "") + needs_of(scene);
    };
    return scene::guarded(words, [&] {
        const DefaultFloats guard;
        const scene::Watch watch(options.progress);
        std::vector<Result> results;
        std::optional<Realised> last; // of the material before; its maps serve as long as no length and no map changes
        for (size_t i = 0; i < materials.size(); ++i) {
            const Material &material = materials[i], &before = i ? materials[i - 1] : scene.material;
            const bool same_maps = last && material.thickness == before.thickness &&
                                   material.curvature_length == before.curvature_length && scene::is_uniform(before) &&
                                   scene::is_uniform(material) && is_in_pascal(last->run.schedule) &&
                                   (scene.receptors.fa2 || scene::has_spring(before) == scene::has_spring(material));
            const bool shared = same_maps && last->moments;
            Scene with = scene;
            with.material = material;
            Prepared p = same_maps ? prepared(std::move(*last), material) : prepared(with, device, options.check);
            const Decision d = decided(p, device, options);
            last.emplace(realised(std::move(p), d));
            // The figures of the skin at the end are the first run's where both come from the same moments.
            const bool like_first = shared && last->moments && !results.empty() && !options.describe_each;
            std::vector<FiredSpike> spikes = spikes_of(with, last->scene.afferents, threads_of(last->device));
            results.push_back(Run(*last, options).take(like_first ? &results.front() : nullptr));
            results.back().spikes = std::move(spikes);
        }
        return results;
    });
}

Result run(const Scene& scene, const Device& device, const RunOptions& options) {
    const auto words = [&] { return needs_of(scene); };
    return scene::guarded(words,
                          [&] { return std::move(run(scene, std::vector{scene.material}, device, options).front()); });
}

} // namespace dermis
