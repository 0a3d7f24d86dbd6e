// SPDX-License-Identifier: MIT
// The steps of a run, split at its outputs and at the breakpoints of its load.
#pragma once

#include "host/core/model/streamed_skin.hpp"
#include "host/lab/scenes/waveform.hpp"
#include "host/lab/schedule/forcing.hpp"
#include "host/lab/schedule/schedule.hpp"

#include <functional>

namespace dermis::model {

using CoefficientTable = std::vector<f64::Coefficients>; // one entry for each material, or one for all
using SharedCoefficients = std::shared_ptr<const CoefficientTable>;
using SharedGains = std::shared_ptr<const std::vector<SineGains<double>>>; // one entry for each material

// A pressure of a sequence: a frame, or between it and the next one after this share of the time between them.
using FramePlace = std::pair<long long, double>;

// One press of every cell, from the last kept state to `time`. keep: the new state replaces the old one. Otherwise the
// step is a peek (a field between outputs, an impulse). trace, impulse, field: index of the output at its end, or -1.
struct Step {
    SharedCoefficients coefficients; // under a load that is held; null: made from `length` when asked for
    SharedGains gains;               // of a sine over a whole step; null: to be made from the forcing
    std::shared_ptr<const Forcing<double>> forcing; // null: none; equal pointers mean equal numbers
    double start = 0, rise = 0, jump = 0;           // see Constants in kernels/layout.h
    long long frame = -1;                           // in a sequence the step is between this frame and the next
    FramePlace from{-1, 0}, to{-1, 0};              // the pressures that the feed gives for it
    // Under parabolic hold the feed gives the pressures at both ends of the step. The one that the state holds from
    // earlier, and that bends it, is of `led`, `before` seconds before its start; 0: nothing bends it.
    bool parabolic = false;
    double before = 0;
    scene::Instant led;
    double time = 0, length = 0; // s: the step's end, and how long it takes
    scene::Instant begin, end;
    bool exact = false; // by the exact method
    double after_bend =
        0; // s: from the last breakpoint of the load within the step to the step's end; 0: there is none
    bool keep = true;
    long long trace = -1;
    int impulse = -1, field = -1;
    bool respond() const { return trace >= 0 || impulse >= 0 || field >= 0; }
    bool same_coefficients(const Step& other) const {
        return coefficients && coefficients == other.coefficients && forcing == other.forcing && before == other.before;
    }
    size_t entries() const { return parabolic ? 2 : 1; } // coefficients of an element
    // A step of no length under parabolic hold, after which the state holds the frame before `frame`.
    bool leads() const { return from.first < frame; }
    // The members of Constants: of the way between the pressures that the feed gives.
    double constant_start() const { return parabolic ? 0 : start; }
    double constant_rise() const { return parabolic && rise != 0 ? 1 : rise; }
    // The coefficients of a material, by its index and its element.
    f64::Coefficients coefficients_of(size_t material, const Element& element, const ResponseRule& rule) const {
        f64::Coefficients k = coefficients ? (*coefficients)[coefficients->size() == 1 ? 0 : material]
                                           : exact_coefficients(element, rule, length);
        if (forcing)
            force<f64>(k, element, rule, *forcing, gains ? &(*gains)[material] : nullptr,
                       forcing->begun ? (*forcing->begun)[material] : Begun());
        return k;
    }
};

// Writes the coefficients of a step, in K = f32 or f64, for the elements in series from index `first` on.
template <class K>
void fill_chain(const Step& step, const std::vector<Element>& materials, const Chain& chain, const ResponseRule& rule,
                size_t first, typename K::Coefficients* to) {
    SeriesCoefficients k, past;
    const auto of = [&](size_t e) { return step.coefficients_of(first + e, materials[first + e], rule); };
    join_series(&materials[first], chain, rule,
                {step.length, step.parabolic ? std::optional(step.before) : std::nullopt}, of, k, past);
    if (chain.spring && step.forcing && step.forcing->impulse) { // the strain just before the jump
        f64::Coefficients& spring = k[chain.length - 1];
        spring.b = 0;
        spring.f = step.forcing->before / spring.E;
    }
    for (size_t e = 0; e < chain.length; ++e) {
        *to++ = rounded<K>(k[e]);
        if (step.parabolic) *to++ = rounded<K>(past[e]);
    }
}

// Writes the coefficients of a step for each material.
template <class K>
void fill_table(const Step& step, const std::vector<Element>& materials, const Chain& chain, const ResponseRule& rule,
                std::vector<typename K::Coefficients>& table) {
    table.resize(materials.size() * step.entries());
    for (size_t i = 0; i < materials.size(); i += chain.length)
        fill_chain<K>(step, materials, chain, rule, i, table.data() + i * step.entries());
}

// Writes a step's coefficients for each cell of a row, by its index into the materials; for skins with too many
// materials for a table.
template <class K>
void fill_row(const Step& step, const std::vector<Element>& materials, const Chain& chain, const ResponseRule& rule,
              const int* material, int cells, typename K::Coefficients* row) {
    if (chain.length == 1 && step.gains && step.forcing->is_sine_alone())
        return fill_row_of_sine<K>(*step.coefficients, *step.gains, material, cells, *step.forcing, row);
    if (chain.length > 1 || step.parabolic || !step.coefficients || (step.forcing && !step.forcing->scales())) {
        for (int i = 0; i < cells; ++i)
            fill_chain<K>(step, materials, chain, rule, size_t(material[i]),
                          row + size_t(i) * chain.length * step.entries());
        return;
    }
    f64::Coefficients factor{};
#define SET_ONE(name) factor.name = 1;
    COEFFICIENTS(SET_ONE)
#undef SET_ONE
    if (step.forcing) scale_change<f64>(factor, step.forcing->segments.front().du);
    const f64::Coefficients* table = step.coefficients->data();
    const bool shared = step.coefficients->size() == 1;
    for (int i = 0; i < cells; ++i) {
        const f64::Coefficients& k = table[shared ? 0 : material[i]];
#define SCALE(name) row[i].name = static_cast<typename K::real>(k.name * factor.name);
        COEFFICIENTS(SCALE)
#undef SCALE
    }
}

// Reads the frames of a sequence and gives them on as steps need them.
class FrameFeed {
  public:
    FrameFeed(const Schedule& schedule, int width) : schedule_(schedule), width_(width) {}
    void before(const Step&, const std::function<void(const std::vector<double>&)>& give);
    const std::vector<double>& frame(long long k); // Pa; after the last frame the last one; until the next call

  private:
    const std::vector<double>& pressure(const FramePlace&);

    const Schedule& schedule_;
    const int width_;
    FramePlace given_[2] = {{-1, 0}, {-1, 0}}; // the last two
    std::array<long long, 3> number_{-1, -1, -1};
    std::array<std::vector<double>, 3> frames_; // frame k at k % 3
    std::vector<double> between_;
};

scene::Instant frame_time(const Schedule&, long long k);

// The steps of a schedule in order, for these materials. Materials and schedule must outlive the timeline.
class Timeline {
  public:
    // threads: they make coefficients, as for Device::cpu.
    Timeline(const Schedule&, const std::vector<Element>& materials, const ResponseRule&, Method, int threads = 1);
    Timeline(const Schedule& schedule, const PreparedSkin& skin)
        : Timeline(schedule, skin.materials, skin.rule, schedule.method) {}
    bool next(Step&);
    scene::Instant frame_time(long long k) const { return model::frame_time(schedule_, k); }

  private:
    using Instant = scene::Instant;
    Instant output_time(long long n) const;
    long long frame_at(Instant) const;
    bool regular(Instant from, Instant to) const;
    double length_of(Instant from, Instant to) const;
    template <class Make> auto table_of(Make) const;
    Forcing<double> forcing_of(Instant from, Instant to, double dt);
    Step exact_step(Instant from, Instant to);
    Step framed_step(Instant from, Instant to);
    Step held_step(long long n);
    void lead(Instant from, Instant to);
    void peek_field(Step);
    void peek_impulse(Step, double before, double jump);
    void fill();
    Instant fill_frames(Instant from, Instant to);
    void fill_envelope(Instant from, Instant to);
    Instant next_field() const;

    const Schedule& schedule_;
    const std::vector<Element>& materials_;
    const ResponseRule rule_;
    const Method method_;
    const int threads_;
    // An elastic element's state does not hold its rate: the rate before a step follows from the load's slope.
    const bool rate_from_slope_;
    SharedCoefficients regular_; // of a whole step, from output to output
    Instant led_;                // under parabolic hold: the time of the earlier pressure that the state holds
    scene::Waveform load_;
    // The elements' states after every few knots since the output at `begun_from_`: all steps since begin with them.
    struct BegunUntil {
        Instant end;
        std::shared_ptr<const std::vector<Begun>> states;
    };
    std::vector<BegunUntil> begun_;
    Instant begun_from_;
    SharedGains gains_;              // of a whole step of the exact method
    std::vector<Step> pending_;      // steps up to the next output, last first
    long long output_ = 0;           // index of the next output
    std::vector<scene::Knot> jumps_; // Schedule::jumps, or the envelope's own
    size_t field_ = 0, jump_ = 0;
    int impulses_ = 0;
    double rate_before_ = 0, rate_ = 0, strain_ = 0; // published: d[n-1], d[n], eps[n] under unit pressure
};

} // namespace dermis::model
