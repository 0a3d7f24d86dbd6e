// SPDX-License-Identifier: MIT
#include "host/planner/counted_run.hpp"

#include <algorithm>

namespace dermis::planner {
namespace {

using plan::Element;
using plan::Schedule;

std::vector<Element> elements_of(const std::vector<CountedMaterial>& materials) {
    std::vector<Element> elements;
    for (const CountedMaterial& m : materials) elements.push_back(m.element);
    return elements;
}

// The greatest |pressure| under the envelope, per unit of the map.
double envelope_peak(const scene::Waveform& load, const Envelope& envelope) {
    if (load.sine()) return std::abs(envelope.mean) + std::abs(envelope.amplitude);
    double peak = 0;
    for (const scene::Knot& k : load.knots()) peak = std::max({peak, std::abs(k.left), std::abs(k.right)});
    return peak;
}

// The load of a cell whose greatest |pressure| is `peak`, per unit of it. Pressures that are held are as exact as the
// scene; others come from a few operations on the envelope's values. Between frames only magnitudes are known.
CountedLoad load_of(const Schedule& schedule, const plan::Step& step, double envelope_peak, double peak) {
    constexpr double few = 8 * 0x1p-53;
    if (!schedule.framed) {
        const double off = step.rise != 0 || schedule.method != Method::exact ? few * envelope_peak : 0;
        return {{step.start, off}, {step.rise, 0}, {step.jump, step.jump != 0 ? 2 * off : 0}};
    }
    const auto share = [&](long long k) {
        if (k < 0 || peak == 0) return 0.0;
        return std::min(schedule.frame_peaks[std::min(size_t(k), schedule.frame_peaks.size() - 1)] / peak, 1.0);
    };
    const double before = share(step.frame), after = step.frame < 0 ? 0 : share(step.frame + 1);
    const auto counted = [](double x) { return Counted{x, few * x}; };
    return {counted(std::max(before, after)), counted(step.rise * (before + after)), counted(step.jump * before)};
}

} // namespace

CountedRun::CountedRun(const Schedule& schedule, const std::vector<CountedMaterial>& materials,
                       const plan::ResponseRule& rule, Method method, const plan::Chain& chain)
    : schedule_(schedule), materials_(materials), rule_(rule), chain_(chain), elements_(elements_of(materials)),
      timeline_(schedule, elements_, rule, method), kept_(materials.size()), now_(materials.size()) {
    const Envelope& envelope = schedule.load.envelope;
    const scene::Waveform load(envelope, schedule.time);
    envelope_peak_ = envelope_peak(load, envelope);
    if (!schedule.framed && method == Method::exact && envelope.kind == Envelope::Kind::sine)
        angular_frequency_ = load.angular_frequency();
}

bool CountedRun::next(bool impulses) {
    while (timeline_.next(step_)) {
        for (size_t i = 0; i < materials_.size(); i += chain_.length) press(i, step_);
        if (step_.keep) kept_ = now_;
        if (step_.trace >= 0 || step_.field >= 0 || (impulses && at_impulse())) return true;
    }
    return false;
}

void CountedRun::press(size_t first, const plan::Step& step) {
    std::array<CountedStep, scene::most_in_series> steps;
    std::array<f64::Coefficients, scene::most_in_series> k, cancelled{};
    const CountedLoad load = load_of(schedule_, step, envelope_peak_, materials_[first].peak);
    for (size_t e = 0; e < chain_.length; ++e) {
        const Element& m = materials_[first + e].element;
        k[e] = step.coefficients_of(first + e, m, rule_);
        steps[e].load = load;
        steps[e].z = is_elastic(m) ? 0 : z_of(m, schedule_.time.step);
        steps[e].spring = chain_.spring && e + 1 == chain_.length;
        if (angular_frequency_ && step.rise != 0)
            cancelled[e] = cancelled_under_sine(k[e], m, rule_, *angular_frequency_, schedule_.load.envelope.amplitude);
    }
    plan::join_loads(k.data(), chain_.length, chain_.spring, step.length);
    plan::join_loads(cancelled.data(), chain_.length, false, step.length);
    for (size_t e = 0; e < chain_.length; ++e) {
        steps[e].k = k[e];
        steps[e].load.cancelled = cancelled[e];
    }
    materials_[first].arithmetic.press(steps.data(), chain_.length, &kept_[first], &now_[first]);
    for (size_t e = 0; step.bend > 0 && e < chain_.length; ++e)
        if (const Element& m = materials_[first + e].element; !is_elastic(m)) add_bend(now_[first], m, step);
}

// Adds the error of a step within which the load bends: the rate at its end comes from a pressure and a stress that
// cancel in double.
void CountedRun::add_bend(CountedCell& cell, const Element& m, const plan::Step& step) const {
    const double z = z_of(m, step.after_bend);
    const double rate = strain_rate(m, (4 + 2 * z) * 0x1p-53 * step.bend * std::exp(-z));
    cell.d_rate += rate;
    cell.d_acceleration += rate * (rule_.step_mean ? 1 / schedule_.time.step : z_of(m, 1));
}

} // namespace dermis::planner
