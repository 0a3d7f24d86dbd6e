// SPDX-License-Identifier: MIT
#include "host/planner/reduction.hpp"

#include "host/planner/counted_run.hpp"
#include "host/planner/magnitudes.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::planner {
namespace {

using plan::Element;
using plan::PreparedSkin;
using plan::Schedule;
using Chain = std::vector<Element>;

bool is_viscous(const Element& m) { return m.modulus == 0; }

// The responses of one cell under unit pressure, and what each may be off by in double.
struct Signals {
    Errors value{}, off{};

    double greatest(size_t q) const { return std::abs(value[q]) + off[q]; }
    friend Signals operator-(const Signals& a, const Signals& b) {
        Signals difference;
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            difference.value[q] = a.value[q] - b.value[q];
            difference.off[q] = a.off[q] + b.off[q] + 0x1p-53 * std::abs(difference.value[q]);
        }
        return difference;
    }
};

// Raises a greatest value; what is no number counts as infinite.
void raise(double& greatest, double x) {
    if (!(x <= greatest)) greatest = std::isnan(x) ? INFINITY : x;
}

// The difference of two chains, element by element.
struct Difference {
    Chain added, removed;
};

// Leaves out the elements that both chains have.
Difference difference(const Chain& a, Chain b) {
    Difference d;
    for (const Element& m : a) {
        const auto same = std::find(b.begin(), b.end(), m);
        if (same == b.end()) d.added.push_back(m);
        else b.erase(same);
    }
    d.removed = b;
    return d;
}

// Steps the responses of a difference of chains from output to output.
class DifferenceRun {
  public:
    DifferenceRun(const Schedule& schedule, const Difference& d, const plan::ResponseRule& rule)
        : added_(d.added.size()), materials_(counted(d)), run_(schedule, materials_, rule, Method::exact) {}

    bool next() { return run_.next(); }

    Signals signals() const {
        Signals s;
        const std::vector<CountedCell>& cells = run_.cells();
        for (int q = 0; q < REDUCED_MAPS; ++q) {
            double magnitude = 0;
            double &value = s.value[size_t(q)], &off = s.off[size_t(q)];
            for (size_t i = 0; i < cells.size(); ++i) {
                const double x = cells[i].value(q);
                value += i < added_ ? x : -x;
                off += cells[i].error(q);
                magnitude += std::abs(x);
            }
            off += double(cells.size()) * 0x1p-53 * magnitude;
        }
        return s;
    }

  private:
    static std::vector<CountedMaterial> counted(const Difference& d) {
        const CountedArithmetic in_double{
            .u = 0x1p-53, .peak = 1, .single = false, .bound = false, .carried = 1, .flush = 0};
        std::vector<CountedMaterial> materials;
        for (const Chain& chain : {d.added, d.removed})
            for (const Element& m : chain) materials.push_back({m, in_double, 1});
        return materials;
    }

    const size_t added_;
    const std::vector<CountedMaterial> materials_;
    CountedRun run_;
};

// The greatest |signals| of a cell under unit pressure times the envelope, over all outputs.
Errors greatest_under_envelope(const Schedule& schedule, const Difference& d, const plan::ResponseRule& rule) {
    Errors greatest{};
    DifferenceRun run(schedule, d, rule);
    while (run.next()) {
        const Signals s = run.signals();
        for (size_t q = 0; q < REDUCED_MAPS; ++q) raise(greatest[q], s.greatest(q));
    }
    return greatest;
}

// The same schedule under unit pressure times an envelope, in place of frames.
Schedule under(const Schedule& schedule, const Envelope& envelope) {
    Schedule s;
    s.time = schedule.time;
    s.outputs = schedule.outputs;
    s.load.envelope = envelope;
    return s;
}

double greatest_of(const std::vector<double>& values, size_t first, size_t last) {
    double greatest = 0;
    for (size_t i = first; i < std::min(last, values.size()); ++i) greatest = std::max(greatest, values[i]);
    return greatest;
}

// The greatest |signals| of a cell under frames, of which only magnitudes are known. Its pressure is p_0 times a step,
// and a change p_(k+1) - p_k times a ramp from each frame k to the next; or each p_k times a hat, which is the ramp up
// to it less the ramp away from it. Signals are the sums of those of steps and ramps, and both ways bound them.
class UnderFrames {
  public:
    UnderFrames(const Schedule& schedule, const Difference& d, const plan::ResponseRule& rule)
        : interval_(*schedule.load.interval), whole_(size_t(scene::steps_per_frame(interval_, schedule.time.step))),
          frames_(schedule.frame_peaks.size()), of_step_(under(schedule, {})), of_ramp_(under(schedule, ramp())),
          step_(of_step_, d, rule), ramp_(of_ramp_, d, rule), before_(std::min(whole_, size_t(schedule.outputs))),
          hats_(before_.size()), ramps_(before_.size()) {
        const std::vector<double>& peaks = schedule.frame_peaks;
        first_ = peaks.front();
        last_ = frames_ > 1 ? peaks.back() : 0;
        middle_ = greatest_of(peaks, 1, frames_ - 1);
        change_ = greatest_of(schedule.frame_changes, 0, frames_);
    }

    Errors greatest() {
        Errors all{};
        for (size_t n = 0; step_.next() && ramp_.next(); ++n) {
            const Signals step = step_.signals(), ramp = ramp_.signals(), hat = ramp - before_[n % whole_],
                          first = step - ramp;
            before_[n % whole_] = ramp;
            const bool last = frames_ > 1 && n > (frames_ - 2) * whole_;
            for (size_t q = 0; q < REDUCED_MAPS; ++q) {
                double &hats = hats_[n % whole_][q], &ramps = ramps_[n % whole_][q];
                ramps += ramp.greatest(q);
                raise(longest_[q], ramp.greatest(q));
                const double by_change = first_ * step.greatest(q) + change_ * ramps;
                double by_peak = first_ * (frames_ > 1 ? first : step).greatest(q);
                hats += hat.greatest(q);
                by_peak += middle_ * hats + (last ? last_ * longest_[q] : 0);
                raise(all[q], (1 + 0x1p-40) * std::min(by_change, by_peak)); // sums are rounded
            }
        }
        return all;
    }

  private:
    Envelope ramp() const {
        Envelope e;
        e.kind = Envelope::Kind::ramp;
        e.rise = interval_;
        return e;
    }

    const double interval_;
    const size_t whole_, frames_; // steps from frame to frame; frames
    const Schedule of_step_, of_ramp_;
    DifferenceRun step_, ramp_;
    std::vector<Signals> before_;      // the ramp's in the last `whole_` steps
    std::vector<Errors> hats_, ramps_; // sums of greatest signals at the steps before, a whole number of frames apart
    Errors longest_{};                 // the greatest of a ramp so far
    double first_, middle_, last_;     // greatest |pressure| of the first frame, of those between and of the last one
    double change_;                    // greatest of a cell from frame to frame
};

// The greatest magnitudes of what is read: of the pressure and of the resting skin's curvature, and the greatest
// curvature of the strain per unit of the signal of strain.
struct Magnitudes {
    double peak, rest, curved;
};

// The bound of the error of every output that is asked for, by other chains in place of a skin's own.
class Proof {
  public:
    Proof(const PreparedSkin& skin, const Schedule& schedule, const Peaks& peaks)
        : skin_(skin), schedule_(schedule), peaks_(peaks), l_(std::abs(skin.constants.curvature_length)),
          exact_(greatest({skin.materials, {}})) {
        const Output& o = schedule.output;
        if (!o.traces.empty() || !o.fields.empty()) everywhere_ = magnitudes_of({.everything = true, .quantity = 0});
        for (const Site& site : skin.description.sites) {
            std::optional<Magnitudes>& of = at_sites_[size_t(site.type)];
            if (!of) of = magnitudes_of({.everything = false, .quantity = int(site.type)});
        }
    }

    Reduction of(const Chain& chain) const {
        Reduction r;
        for (const Element& m : chain) r.elements.push_back({.modulus = m.modulus, .viscosity = m.viscosity});
        const Errors off = greatest(difference(skin_.materials, chain));
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            if (everywhere_) r.cells[q] = error(q, off, *everywhere_);
            if (at_sites_[q]) r.sites[q] = error(q, off, *at_sites_[q]);
        }
        return r;
    }

    // The worst error of what is asked for, relative to the greatest exact values; infinite where it is not known.
    double worst(const Reduction& r) const {
        for (size_t q = 0; q < REDUCED_MAPS; ++q)
            if (!std::isfinite(r.cells[q]) || !std::isfinite(r.sites[q])) return INFINITY;
        Bounds cells{r.cells, {}}, sites{r.sites, {}};
        cells.greatest.fill(INFINITY); // no output counts as exact
        sites.greatest.fill(INFINITY);
        return worst_asked(skin_, schedule_, cells, sites, peaks_, arithmetic_of(Precision::f64, false).stored);
    }

  private:
    Errors greatest(const Difference& d) const {
        if (schedule_.framed) return UnderFrames(schedule_, d, skin_.rule).greatest();
        return greatest_under_envelope(schedule_, d, skin_.rule);
    }

    Magnitudes magnitudes_of(const Read& read) const {
        const double weight = skin_.constants.bend * weight_of(skin_.stencil);
        Magnitudes m{.peak = 1, .rest = rest_peak(skin_, schedule_, !read.everything), .curved = weight};
        if (schedule_.framed) return m; // signals are those under the frames' pressures
        const PressedMaterial pressed = pressed_materials(skin_, schedule_, read).front();
        const double peak = largest_of(schedule_.pressure);
        m.peak = pressed.peak;
        m.curved = std::min(weight * pressed.around, roughness_of(skin_, schedule_, peak).laplacian * peak);
        return m;
    }

    // The greatest error of X = x*(1 + l*C), where signals x are off by `off` and C by what the strain is.
    double error(size_t q, const Errors& off, const Magnitudes& m) const {
        if (q == QUANTITY_STRAIN) return m.peak * off[q];
        const double gain = 1 + l_ * (m.rest + m.curved * exact_[QUANTITY_STRAIN]);
        return m.peak * (off[q] * gain + (exact_[q] + off[q]) * l_ * m.curved * off[QUANTITY_STRAIN]);
    }

    const PreparedSkin& skin_;
    const Schedule& schedule_;
    const Peaks& peaks_;
    const double l_;
    const Errors exact_; // greatest signals of the skin's own chain
    std::optional<Magnitudes> everywhere_;
    std::array<std::optional<Magnitudes>, REDUCED_MAPS> at_sites_;
};

// A change that keeps one strain less: two elements, or one alone, become `result`.
struct Change {
    Element first;
    std::optional<Element> second;
    Element result;
    double estimate; // of the relative error, by which changes are tried in order
};

Chain changed(Chain chain, const Change& c) {
    chain.erase(std::find(chain.begin(), chain.end(), c.first));
    if (c.second) chain.erase(std::find(chain.begin(), chain.end(), *c.second));
    chain.push_back(c.result);
    return chain;
}

double in_series(double a, double b) { return 1 / (1 / a + 1 / b); }
Element spring_of(const Element& a, const Element& b) {
    return {.modulus = in_series(a.modulus, b.modulus), .viscosity = 0};
}
Element dashpot_of(const Element& a, const Element& b) {
    return {.modulus = 0, .viscosity = in_series(a.viscosity, b.viscosity)};
}

// One element of the same strain at last, whose retardation time is the mean by strain.
Element merged(const Element& a, const Element& b) {
    const double modulus = in_series(a.modulus, b.modulus);
    const double tau = modulus * (a.viscosity / a.modulus / a.modulus + b.viscosity / b.modulus / b.modulus);
    return {.modulus = modulus, .viscosity = modulus * tau};
}

// The changes of a chain within a scene that lasts T seconds in steps of dt.
class Changes {
  public:
    Changes(const Chain& chain, double T, double dt, bool springs) : T_(T), dt_(dt) {
        for (const Element& m : chain) {
            total_ += is_elastic(m) ? final_strain(m, 1) : is_viscous(m) ? strain_rate(m, T) : crept(m);
            (is_elastic(m) ? elastic_ : is_viscous(m) ? viscous_ : between_).push_back(m);
        }
        std::sort(between_.begin(), between_.end(),
                  [](const Element& a, const Element& b) { return z_of(a, 1) > z_of(b, 1); });
        for (size_t i = 0; i < between_.size(); ++i) {
            if (springs) to_spring(between_[i]);
            to_dashpot(between_[i]);
            if (i > 0) to_one(between_[i - 1], between_[i]);
        }
        if (between_.size() > 1 && viscous_.empty()) {
            const Element &a = between_.end()[-2], &b = between_.end()[-1];
            add({a, b, dashpot_of(a, b), neglected(a) + neglected(b)});
        }
        for (size_t i = 1; i < viscous_.size(); ++i)
            add({viscous_[0], viscous_[i], dashpot_of(viscous_[0], viscous_[i]), 0});
        std::stable_sort(list_.begin(), list_.end(),
                         [](const Change& a, const Change& b) { return a.estimate < b.estimate; });
    }

    const std::vector<Change>& list() const { return list_; }

  private:
    void add(const Change& c) {
        const double modulus = c.result.modulus, viscosity = c.result.viscosity;
        const bool element = std::isfinite(modulus) && std::isfinite(viscosity) && (modulus > 0 || viscosity > 0);
        if (element) list_.push_back(c);
    }

    // The strain of an element after T under a unit step.
    double crept(const Element& m) const { return final_strain(m, -std::expm1(-z_of(m, T_))); }
    // The part of that which a modulus takes away from a dashpot's strain.
    double neglected(const Element& m) const { return T_ * strain_rate(m, z_of(m, T_)) / (2 * total_); }

    void to_spring(const Element& m) {
        const double lag = std::min(std::exp(-z_of(m, dt_)), 1 / z_of(m, T_)); // after a jump; behind a steady change
        const double estimate = final_strain(m, lag) / total_;
        if (elastic_.empty()) add({m, {}, {.modulus = m.modulus, .viscosity = 0}, estimate});
        else add({m, elastic_[0], spring_of(m, elastic_[0]), estimate});
    }

    void to_dashpot(const Element& m) {
        if (!viscous_.empty()) add({m, viscous_[0], dashpot_of(m, viscous_[0]), neglected(m)});
    }

    void to_one(const Element& a, const Element& b) {
        const Element one = merged(a, b);
        const double z = z_of(one, T_), apart = (z_of(a, T_) - z_of(b, T_)) / z;
        const double strain = 1 / (a.modulus + b.modulus); // J_a*J_b/(J_a + J_b)
        add({a, b, one, strain * apart * apart * std::min(z, 1 / z) / total_});
    }

    const double T_, dt_;
    double total_ = 0;                  // strain after T under a unit step
    Chain elastic_, viscous_, between_; // the last by retardation time, fastest first
    std::vector<Change> list_;
};

// Whether the load jumps, so that a response has impulses.
bool jumps(const Schedule& s) {
    if (s.framed) return s.frame_peaks.front() > 0;
    const scene::Waveform load(s.load.envelope, s.time);
    return std::any_of(load.knots().begin(), load.knots().end(),
                       [](const scene::Knot& k) { return k.left != k.right; });
}

// Whether every frame and field is at an output, so that steps from output to output tell all.
bool falls_on_outputs(const Schedule& s) {
    if (!s.framed) return true;
    if (!scene::steps_per_frame(*s.load.interval, s.time.step)) return false;
    return std::all_of(s.field_times.begin(), s.field_times.end(), [&](const scene::Instant& t) {
        return t == scene::Instant::multiple(std::round(t.t / s.time.step), s.time.step) &&
               t < scene::Instant(double(s.outputs) * s.time.step);
    });
}

// The search for the shortest chain. It allows twice the error again and again, and at each level takes the most
// promising change that the proof allows; so what is allowed more never ends with a longer chain.
class Search {
  public:
    // springs: elements may become one.
    Search(const PreparedSkin& skin, const Schedule& schedule, const Allowance& allowance, bool springs)
        : skin_(skin), schedule_(schedule), allowance_(allowance), springs_(springs), chain_(skin.materials) {}

    // Whether some change may be within the allowed error, and one element less saves more time than the search takes.
    bool worth_while() const {
        constexpr double counted = 2e-7, measured = 1.1e-6,
                         unnoticed = 4e-3; // s, of an element's step but for the last
        const double elements = double(chain_.size()), proofs = (schedule_.framed ? 10 : 5) * elements;
        const double seconds = double(schedule_.outputs) * (measured * elements + counted * proofs);
        return seconds <= unnoticed + allowance_.seconds / elements && !changes(allowance_.error).empty();
    }

    Reduction found(const Peaks& peaks) {
        const Proof proof(skin_, schedule_, peaks);
        for (double level = 0x1p-40; level <= allowance_.error; level *= 2)
            while (shorten(proof, level)) {
            }
        return best_;
    }

  private:
    // A chain that was tried.
    struct Tried {
        Chain chain;
        Reduction reduction;
        double error;
    };

    // The changes that may be within an error, as estimates go.
    std::vector<Change> changes(double error) const {
        constexpr double optimism = 16;
        const double dt = schedule_.time.step;
        const Changes all(chain_, dt * double(schedule_.outputs - 1), dt, springs_);
        std::vector<Change> hopeful;
        for (const Change& c : all.list())
            if (c.estimate <= optimism * error) hopeful.push_back(c);
        return hopeful;
    }

    const Tried& tried(const Proof& proof, const Chain& chain) {
        const auto before = std::find_if(tried_.begin(), tried_.end(), [&](auto& t) { return t.chain == chain; });
        if (before != tried_.end()) return *before;
        const Reduction r = proof.of(chain);
        return tried_.emplace_back(Tried{chain, r, proof.worst(r)});
    }

    bool shorten(const Proof& proof, double level) {
        for (const Change& c : changes(level)) {
            const Tried& shorter = tried(proof, changed(chain_, c));
            if (!(shorter.error <= level)) continue;
            best_ = shorter.reduction;
            chain_ = shorter.chain;
            return true;
        }
        return false;
    }

    const PreparedSkin& skin_;
    const Schedule& schedule_;
    const Allowance& allowance_;
    const bool springs_;
    Chain chain_;    // the shortest so far
    Reduction best_; // that one, unless it is the skin's own
    std::vector<Tried> tried_;
};

} // namespace

bool may_reduce(const PreparedSkin& skin, const Schedule& schedule, Model model) {
    if (skin.chain < 2 || schedule.method != Method::exact || schedule.outputs < 2) return false;
    if (model == Model::march) return true;
    return model == Model::sites && !why_not_separable(skin, schedule).empty();
}

Reduction reduced(const PreparedSkin& skin, const Schedule& schedule, const Allowance& allowance,
                  const std::function<const Peaks&()>& peaks) {
    if (!falls_on_outputs(schedule)) return {};
    const bool impulses = allowance.impulses && jumps(schedule);
    const bool fa1 = schedule.wanted[QUANTITY_FA1], fa2 = schedule.wanted[QUANTITY_FA2];
    const bool elastic = std::any_of(skin.materials.begin(), skin.materials.end(), scene::is_elastic);
    if (impulses && (fa2 || (fa1 && elastic))) return {};
    const bool undefined = fa2 && (schedule.framed || !skin.rule.step_mean); // of a spring
    Search search(skin, schedule, allowance, !undefined && !(impulses && fa1));
    return search.worth_while() ? search.found(peaks()) : Reduction{};
}

} // namespace dermis::planner
