// SPDX-License-Identifier: MIT
#include "host/lab/planner/reduction.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::planner {
namespace {

using plan::Element;
using plan::PreparedSkin;
using plan::Schedule;

// A change to a chain with one strain less: one or two elements become `result`.
struct Change {
    Element first;
    std::optional<Element> second;
    Element result;
    double estimate; // of the relative error, by which changes are tried in order
};

Elements changed(Elements chain, const Change& c) {
    chain.erase(std::find(chain.begin(), chain.end(), c.first));
    if (c.second) chain.erase(std::find(chain.begin(), chain.end(), *c.second));
    chain.push_back(c.result);
    return chain;
}

// The changes of a chain within a scene that lasts T seconds in steps of dt.
class Changes {
  public:
    Changes(const Elements& chain, double T, double dt, bool springs) : T_(T), dt_(dt) {
        for (const Element& m : chain) {
            total_ += strain_after(m, 1, T);
            (is_elastic(m) ? elastic_ : is_viscous(m) ? viscous_ : between_).push_back(m);
        }
        std::ranges::sort(between_, [](const Element& a, const Element& b) { return z_of(a, 1) > z_of(b, 1); });
        for (size_t i = 0; i < between_.size(); ++i) {
            if (springs) to_spring(between_[i]);
            to_dashpot(between_[i]);
            if (i > 0) to_one(between_[i - 1], between_[i]);
        }
        if (between_.size() > 1 && viscous_.empty()) {
            const Element &a = between_.end()[-2], &b = between_.end()[-1];
            add({a, b, sum_of_dashpots(a, b), neglected(a) + neglected(b)});
        }
        for (size_t i = 1; i < viscous_.size(); ++i)
            add({viscous_[0], viscous_[i], sum_of_dashpots(viscous_[0], viscous_[i]), 0});
        std::ranges::stable_sort(list_, [](const Change& a, const Change& b) { return a.estimate < b.estimate; });
    }

    const std::vector<Change>& list() const { return list_; }

  private:
    void add(const Change& c) {
        if (is_finite(c.result) && std::isfinite(c.estimate)) list_.push_back(c);
    }

    // The part of a dashpot's strain after T that a modulus takes away.
    double neglected(const Element& m) const { return T_ * strain_rate(m, z_of(m, T_)) / (2 * total_); }

    void to_spring(const Element& m) {
        const double lag = std::min(std::exp(-z_of(m, dt_)), 1 / z_of(m, T_)); // after a jump; behind a steady change
        const double estimate = final_strain(m, lag) / total_;
        if (elastic_.empty()) add({m, {}, spring_of(m), estimate});
        else add({m, elastic_[0], sum_of_springs(m, elastic_[0]), estimate});
    }

    void to_dashpot(const Element& m) {
        if (!viscous_.empty()) add({m, viscous_[0], sum_of_dashpots(m, viscous_[0]), neglected(m)});
    }

    void to_one(const Element& a, const Element& b) {
        const Element one = merged(a, b);
        const double z = z_of(one, T_), apart = (z_of(a, T_) - z_of(b, T_)) / z;
        const double strain =
            final_strain(a, stiffness(one) / stiffness(b)); // the product of both final strains over their sum
        add({a, b, one, strain * apart * apart * std::min(z, 1 / z) / total_});
    }

    const double T_, dt_;
    double total_ = 0;                     // strain after T under a unit step
    Elements elastic_, viscous_, between_; // between_: by retardation time, fastest first
    std::vector<Change> list_;
};

// The first jump of an envelope; 0 if there is none, and nothing if the load was not 0 until then.
std::optional<double> first_jump(const Schedule& s) {
    const scene::Waveform load(s.load.envelope, s.time);
    bool rests = true;
    for (const scene::Knot& k : load.knots()) {
        rests = rests && k.left == 0;
        if (k.left != k.right) return rests ? std::optional(k.right - k.left) : std::nullopt;
        rests = rests && k.right == 0;
    }
    return 0;
}

// Whether every frame and field is at an output, so that steps from output to output reach all of them.
bool falls_on_outputs(const Schedule& s) {
    if (!s.framed) return true;
    if (!scene::steps_per_frame(*s.load.interval, s.time.step)) return false;
    return std::ranges::all_of(s.field_times, [&](const scene::Instant& t) {
        return t == scene::Instant::multiple(std::round(t.t / s.time.step), s.time.step) &&
               t < scene::Instant(double(s.outputs) * s.time.step);
    });
}

// The search for the shortest chain. It doubles the error that it allows again and again, and at each level takes the
// most promising change that the proof allows. A greater allowance therefore never ends with a longer chain.
class Search {
  public:
    // springs: elements may become springs.
    Search(const PreparedSkin& skin, const Schedule& schedule, const Allowance& allowance, bool springs)
        : schedule_(schedule), allowance_(allowance), springs_(springs), best_{.chain = skin.materials} {}

    // Whether some change may be within the allowed error, and one element less saves more time than the search takes.
    bool worth_while() const {
        constexpr double counted = 2e-7, measured = 1.1e-6; // s: an element's step in a bound, in measured_peaks()
        constexpr double unnoticed = 4e-3;                  // s
        const double elements = double(best_.chain.size()), proofs = (schedule_.framed ? 10 : 5) * elements;
        const double seconds = double(schedule_.outputs) * (measured * elements + counted * proofs);
        return seconds <= unnoticed + allowance_.seconds / elements && !changes(allowance_.error).empty();
    }

    Replacement found(const ReplacementBound& bound) {
        for (double level = 0x1p-40; level <= allowance_.error; level *= 2)
            while (shorten(bound, level)) {
            }
        return best_;
    }

  private:
    // The changes with an estimate near an error or below.
    std::vector<Change> changes(double error) const {
        constexpr double optimism = 16;
        const double dt = schedule_.time.step;
        const Changes all(best_.chain, dt * double(schedule_.outputs - 1), dt, springs_);
        std::vector<Change> hopeful;
        for (const Change& c : all.list())
            if (c.estimate <= optimism * error) hopeful.push_back(c);
        return hopeful;
    }

    const Replacement& tried(const ReplacementBound& bound, const Elements& chain) {
        const auto before = std::ranges::find_if(tried_, [&](auto& r) { return r.chain == chain; });
        return before != tried_.end() ? *before : tried_.emplace_back(bound.of(chain));
    }

    bool shorten(const ReplacementBound& bound, double level) {
        for (const Change& c : changes(level)) {
            const Replacement& shorter = tried(bound, changed(best_.chain, c));
            if (!(shorter.error <= level)) continue;
            best_ = shorter;
            return true;
        }
        return false;
    }

    const Schedule& schedule_;
    const Allowance& allowance_;
    const bool springs_;
    Replacement best_; // the shortest so far; at first the skin's own chain
    std::vector<Replacement> tried_;
};

} // namespace

bool may_reduce(const PreparedSkin& skin, const Schedule& schedule, Model model) {
    if (skin.chain.length < 2 || !skin.uniform() || schedule.method != Method::exact || schedule.outputs < 2 ||
        schedule.spreads())
        return false;
    if (model == Model::march) return true;
    return model == Model::sites && !why_not_separable(skin, schedule).empty();
}

Replacement reduced(const PreparedSkin& skin, const Schedule& schedule, const Allowance& allowance,
                    const std::function<const Peaks&()>& peaks) {
    const Replacement none{.chain = skin.materials};
    const bool fa1 = schedule.wanted[QUANTITY_FA1], fa2 = schedule.wanted[QUANTITY_FA2];
    const bool elastic = std::ranges::any_of(skin.materials, scene::is_elastic);
    std::optional<double> jump = 0;
    if (allowance.impulses && (fa1 || fa2))
        jump = schedule.framed ? schedule.frame_peaks.front() : first_jump(schedule);
    const bool unbounded = schedule.framed && *jump != 0 && (fa2 || elastic); // impulses of frames
    if (schedule.bent() || !falls_on_outputs(schedule) || !jump || unbounded) return none;
    const bool appears = *jump != 0 && fa1 && !elastic;                      // an impulse of FA1, with a spring
    const bool undefined = fa2 && (schedule.framed || !skin.rule.step_mean); // FA2 of a spring
    Search search(skin, schedule, allowance, !appears && !undefined);
    if (!search.worth_while()) return none;
    if (schedule.framed || *jump == 0) jump.reset();
    return search.found(ReplacementBound(skin, schedule, peaks(), jump));
}

} // namespace dermis::planner
