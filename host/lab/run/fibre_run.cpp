// SPDX-License-Identifier: MIT
// The nerve fibres of a run. Their inputs are computed apart from the run's outputs: by the exact method in double, in
// the cells of the fibres alone, at stops so close that lines between them miss little of the load and of what the
// material makes of it. So neither the model of the run nor Time::step changes a spike.
#include "host/lab/run/collector.hpp"

#include "host/core/base/refusal.hpp"
#include "host/core/base/watch.hpp"
#include "host/core/cpu/fibres.hpp"
#include "host/core/model/site_cells.hpp"
#include "host/lab/reduced/moments.hpp"
#include "host/lab/reduced/sites.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dermis {
namespace {

using scene::Instant;

// The most that a line between stops misses, of the amplitude of a sine or of frames, and of a transient after a bend.
constexpr double line_error = 1e-4, transient_error = 1e-5;
constexpr double jump_time = 1e-7; // s: a jump of the load is a line over this time
constexpr double least_tau = 1e-6; // s: transients that are shorter are taken as this long
constexpr size_t most_stops = 20'000'000, most_steps = 1'000'000'000;

// Fibres with the same kind of input.
struct Group {
    std::optional<double> depth;
    DepthKernel kernel = {};
    bool stress = false;
    std::vector<size_t> entries; // of Scene::afferents
};

std::vector<Group> groups_of(const Scene& s, const std::vector<Afferents>& all) {
    std::vector<Group> groups;
    for (size_t i = 0; i < all.size(); ++i) {
        Group g;
        for (const scene::ReceptorClass& c : scene::receptor_classes)
            if (c.type == all[i].type) g.depth = s.receptors.depth.*c.depth, g.kernel = s.receptors.kernel.*c.kernel;
        g.stress = scene::follows_stress(s.receptors, all[i]);
        auto known = std::ranges::find_if(
            groups, [&](const Group& k) { return k.depth == g.depth && k.kernel == g.kernel && k.stress == g.stress; });
        if (known == groups.end()) known = groups.insert(groups.end(), g);
        known->entries.push_back(i);
    }
    return groups;
}

// The scene with an SA1 receptor in place of each fibre, without gain: its response is the fibre's input. The stress
// under a pressure, over the modulus at rest, is the strain of a spring of this modulus.
scene::ValidatedScene felt_by(const Group& group, const std::vector<Afferents>& all, Scene s) {
    const auto presses_crests = [](const Load& l) { return l.contact == Load::Contact::crests; };
    if (!presses_crests(s.load) && std::ranges::none_of(s.more_loads, presses_crests))
        s.surface = {.kind = Surface::Kind::flat, .relief = s.surface.relief}; // it would change nothing
    const Receptors given = std::exchange(s.receptors, {});
    s.receptors.depth.sa1 = group.depth;
    if (group.depth) s.receptors.kernel = group.kernel;
    if (scene::reads_poisson(s.receptors) || scene::is_indenter(s.load)) s.receptors.poisson = given.poisson;
    if (group.stress && s.load.control == Control::depth) s.receptors.follow.sa1 = Signal::stress;
    else if (group.stress) {
        Material spring;
        spring.modulus = scene::modulus_at_rest(scene::chain_of(s.material));
        spring.viscosity = 0;
        scene::take_elements(s.material, spring);
    }
    s.sites.clear();
    s.afferents.clear();
    s.output = {.traces = {}, .probes = {}, .fields = {}, .extremes = false};
    scene::ValidatedScene felt = scene::validate(s);
    felt.scene.material.curvature_length = 0;
    for (size_t i : group.entries)
        for (const Cell c : all[i].cells) felt.scene.sites.push_back({Quantity::sa1, c});
    return felt;
}

// Divides the step of a schedule by a power of two, so that lines follow every sine and last at most a substep of each
// fibre: where two lines meet the rate of the input jumps, and over longer lines FA2's filter would follow the jump.
void divide(model::Schedule& s, const Group& group, const std::vector<Afferents>& all) {
    const double step = s.time.step;
    for (size_t i : group.entries)
        if (f64::FibreConstants k; model::fill_fibre_constants<f64>(model::kind_of(all[i]).model, s.time.step, k))
            s.time.step /= k.substeps;
    for (size_t i = 0; i < s.products(); ++i) {
        const Envelope& e = s.product(i).load.envelope;
        if (s.framed || e.kind != Envelope::Kind::sine) continue;
        const double w = 2 * std::numbers::pi * e.frequency, longest = std::sqrt(8 * line_error) / w;
        scene::need(s.time.duration / longest <= double(most_steps), "load.frequency", e.frequency,
                    "with afferents, which follow it in steps of 0.0045 periods, at most 1e9 steps in time.duration");
        while (s.time.step > longest) s.time.step /= 2;
    }
    s.outputs = static_cast<long long>(std::ceil(s.time.duration / s.time.step - 1e-9));
    scene::need(s.outputs <= static_cast<long long>(most_steps), "time.step", step,
                "with afferents at most 1e9 steps in time.duration, after it is halved to follow sines and afferents");
}

// The times at which the load may jump or bend, ascending, from 0 on; of frames, those of the frames.
std::vector<Instant> bends_of(const model::Schedule& s) {
    std::vector<Instant> bends = {Instant()};
    for (long long k = 1; s.framed && k < s.sequence->maps() && model::frame_time(s, k) < Instant(s.time.duration); ++k)
        bends.push_back(model::frame_time(s, k));
    for (size_t i = 0; !s.framed && i < s.products(); ++i) {
        const scene::Waveform load(s.product(i).load.envelope, s.time);
        for (const scene::Knot& k : load.knots())
            if (k.time < Instant(s.time.duration)) bends.push_back(k.time);
    }
    std::ranges::sort(bends, [](auto& a, auto& b) { return a < b; });
    bends.erase(std::unique(bends.begin(), bends.end()), bends.end());
    return bends;
}

// The time to the next stop, `past` seconds after the load has bent, for transients e^(-t/tau) with any tau of a range,
// the worst of which is half of `past`. interval: between frames, whose transients are at most 2 tau/interval of the
// load; 0: not between frames.
double to_next_stop(double past, const scene::TauRange& range, double interval) {
    const double tau = std::clamp(past / 2, range.min, range.max),
                 error = interval > 0 ? line_error * std::max(1.0, interval / (2 * tau)) : transient_error;
    return std::sqrt(8 * error) * tau * std::exp(past / (2 * tau));
}

// The stops between outputs, as fields: after each bend until the output steps are short enough, and the end.
std::vector<Instant> stops_of(const model::Schedule& s, const std::vector<model::Element>& elements) {
    std::vector<model::Element> slow;
    std::ranges::copy_if(elements, std::back_inserter(slow), [](auto& e) { return !scene::is_elastic(e); });
    scene::TauRange range = scene::tau_range(slow);
    range.min = std::max(range.min, least_tau), range.max = std::max(range.max, range.min);
    const double interval = s.framed ? *s.load.interval : 0;
    const std::vector<Instant> bends = bends_of(s);
    std::vector<Instant> stops = {Instant(s.time.duration)};
    for (size_t i = 0; i < bends.size(); ++i) {
        const double length = (i + 1 < bends.size() ? bends[i + 1] : Instant(s.time.duration)) - bends[i];
        const bool between_frames = s.framed && i + 1 < bends.size(),
                   jumps = !s.framed || i == 0; // frame 0 meets a skin at rest
        if (jumps) stops.insert(stops.end(), {bends[i], bends[i] + jump_time});
        for (double past = 0;;) {
            double next = slow.empty() ? INFINITY : to_next_stop(past, range, jumps ? 0 : interval);
            if (between_frames && s.parabolic()) next = std::min(next, interval / 64);
            if (next > s.time.step || (past += next) >= length) break;
            stops.push_back(bends[i] + past);
        }
        scene::need(stops.size() <= most_stops, "load", double(bends.size()),
                    "with afferents, fewer bends of the load: after each the skin is followed at up to some hundred "
                    "times, at most 2e7 in all");
    }
    std::erase_if(stops, [&](auto& t) { return t <= Instant() || Instant(s.time.duration) < t; });
    for (Instant& t : stops) t = scene::snapped(t, s.time.step);
    std::ranges::sort(stops, [](auto& a, auto& b) { return a < b; });
    stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
    return stops;
}

// Steps the fibres of a group from stop to stop.
class FibreSteps {
  public:
    FibreSteps(const Group& group, const std::vector<Afferents>& all, double regular, int threads,
               std::vector<FiredSpike>& spikes)
        : regular_(regular), spikes_(spikes), fibres_(kinds_of(group, all), 1, std::max(threads, 1), simd::best()) {
        int first = 0;
        for (size_t i = 0; i < all.size(); ++i) {
            const int count = int(all[i].cells.size()) / all[i].endings;
            const bool of_group = std::ranges::count(group.entries, i) > 0;
            for (int k = 0; k < count && of_group; ++k) numbers_.push_back(first + k);
            if (of_group)
                for (const double s : scene::drawn_factors(all[i]))
                    factors_.insert(factors_.end(), size_t(all[i].endings), s);
            first += count;
        }
        inputs_.resize(factors_.size());
    }

    void operator()(const model::Step& step, const model::Sample& sample) {
        if (step.impulse >= 0 || !(step.time > time_)) return; // nothing lasts
        const double* felt = sample.points.data() + size_t(QUANTITY_SA1) * inputs_.size();
        for (size_t i = 0; i < inputs_.size(); ++i) inputs_[i] = factors_[i] * felt[i];
        if (!std::ranges::all_of(inputs_, [](double q) { return std::isfinite(q); }))
            throw Error(Error::Code::bad_input, "",
                        "the input of an afferent overflows at t = " + shortest(step.time) +
                            " s; allowed: loads and materials whose strains stay below 1.8e308");
        double dt = step.time - time_;
        if (std::abs(dt - regular_) <= 1e-9 * regular_) dt = regular_; // the constants stay
        time_ = step.time;
        if (!fibres_.prepare(dt))
            scene::refuse("time.step", shortest(dt),
                          "at most 65536 refractory times or quarters of the shortest time constant of the "
                          "afferents, and models whose coefficients fit a double");
        fibres_.set_input(0, inputs_.data());
        fibres_.forget_spikes();
        fibres_.press(0, 1);
        for (const auto& s : fibres_.spikes())
            spikes_.push_back({.time = time_ - (1 - s.share) * dt, .afferent = numbers_[size_t(s.fibre)]});
    }

  private:
    static std::vector<model::FibreKind> kinds_of(const Group& group, const std::vector<Afferents>& all) {
        std::vector<model::FibreKind> kinds;
        for (size_t i : group.entries) kinds.push_back(model::kind_of(all[i]));
        return kinds;
    }

    const double regular_; // s: from output to output
    std::vector<FiredSpike>& spikes_;
    cpu::Fibres<f64> fibres_;
    std::vector<int> numbers_;             // in the list, of each fibre of the group
    std::vector<double> factors_, inputs_; // of each ending of the group
    double time_ = 0;
};

// Appends the spikes of a group. done: of the run before, and after.
void run_group(const Group& group, const std::vector<Afferents>& all, const Scene& asked, int threads,
               std::pair<double, double> done, std::vector<FiredSpike>& spikes) {
    model::PreparedRun run = model::prepare_run(felt_by(group, all, asked), false, threads);
    divide(run.schedule, group, all);
    const bool separable = why_not_separable(run.skin, run.schedule).empty();
    if (separable) run = in_units(in_parts(std::move(run)));
    model::Schedule& schedule = run.schedule;
    schedule.field_times = stops_of(schedule, elements_of(run.skin, schedule));
    for (model::Schedule& other : schedule.others)
        other.time = schedule.time, other.outputs = schedule.outputs, other.field_times = schedule.field_times;
    const auto fire =
        std::make_shared<FibreSteps>(group, all, schedule.between_outputs(), threads, spikes); // outlives no sink
    const auto sink = [fire](const model::Step& step, const model::Sample& sample) { (*fire)(step, sample); };
    std::optional<model::SiteCells> cells;
    std::unique_ptr<model::Stepper> stepper;
    if (separable) {
        const auto moments = reduced::moments_of(run.skin, schedule, true, threads);
        stepper = reduced::separable(run.skin, schedule, moments, true, sink);
    } else {
        cells.emplace(run.skin, pressed_cells(schedule), schedule.points);
        stepper = reduced::sites(run.skin, schedule, *cells, reduced::classes_of(run.skin, schedule), threads, sink);
    }
    const std::vector<model::Element> elements = !schedule.modes.empty() ? elements_of(run.skin, schedule)
                                                 : cells                 ? cells->materials
                                                                         : run.skin.materials;
    model::Timeline timeline(schedule, elements, run.skin.rule, schedule.method, threads);
    model::FrameFeed feed(schedule, run.skin.width());
    for (model::Step step; timeline.next(step);) {
        feed.before(step, [&](const std::vector<double>& frame) { stepper->frame(frame); });
        if (step.impulse < 0) step.trace = std::max(step.trace, 0LL); // every stop gives a sample
        stepper->press(step);
        scene::reach(std::lerp(done.first, done.second, step.begin.t / asked.time.duration), false);
    }
    stepper->finish();
}

} // namespace

std::vector<FiredSpike> spikes_of(const Scene& asked, const std::vector<Afferents>& afferents, int threads) {
    std::vector<FiredSpike> spikes;
    const std::vector<Group> groups = groups_of(asked, afferents);
    const double share = share_of_fibres / double(groups.size());
    for (size_t i = 0; i < groups.size(); ++i)
        run_group(groups[i], afferents, asked, threads, {share * double(i), share * double(i + 1)}, spikes);
    std::ranges::sort(spikes, [](const FiredSpike& a, const FiredSpike& b) {
        return a.time < b.time || (a.time == b.time && a.afferent < b.afferent);
    });
    return spikes;
}

} // namespace dermis
