// SPDX-License-Identifier: MIT
#include "host/planner/bound.hpp"

#include "host/reduced/sites.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::planner {
namespace {

constexpr size_t some = 64; // materials and cells looked at, at most

// Of the sum over a stencil's weights, by which it multiplies what its cells are off by.
double weight_of(const plan::Plan& p) {
    if (p.stencil == STENCIL_FIVE_POINT) return 8;
    return p.stencil == STENCIL_FOURTH_ORDER ? 32.0 / 3 : 4;
}

double largest_of(const std::vector<double>& map) {
    double largest = 0;
    for (double v : map) largest = std::max(largest, std::abs(v));
    return largest;
}

double rest_peak(const plan::Plan& p) {
    double largest = largest_of(p.maps.rest_curvature);
    if (p.maps.rest_curvature.empty())
        for (const Cell& c : p.places)
            largest =
                std::max(largest, std::abs(plan::laplacian_at(p.maps.surface, c, p.scene.grid, p.stencil, p.edges)));
    return largest;
}

// What a stencil can make of a strain of 1 at most: of any strain; of a uniform skin's, which has the load's shape.
struct Roughness {
    double laplacian, differences;
};

Roughness roughness_of(const plan::Plan& p, double peak) {
    const double weight = p.constants.bend * weight_of(p);
    Roughness r{weight, 2 * weight};
    if (p.media.size() > 1 || p.framed || peak == 0) return r;
    Grid unit = p.scene.grid;
    unit.spacing.reset();
    r.laplacian = p.constants.bend * largest_of(plan::laplacian(p.maps.pressure, unit, p.stencil, p.edges)) / peak;
    double step = 0; // between neighbours
    const size_t width = size_t(unit.width);
    const std::vector<double>& map = p.maps.pressure;
    for (size_t i = 0; i < map.size(); ++i) {
        if (i % width) step = std::max(step, std::abs(map[i] - map[i - 1]));
        if (i >= width) step = std::max(step, std::abs(map[i] - map[i - width]));
    }
    if (p.edges != EDGES_PERIODIC) r.differences = weight * std::min(2 * step / peak, 2.0); // two cells apart at most
    return r;
}

// A few of very many materials, from the fastest to the slowest.
std::vector<plan::Medium> media_of(const plan::Plan& p) {
    if (p.media.size() <= some) return p.media;
    std::vector<plan::Medium> sorted = p.media, few;
    std::sort(sorted.begin(), sorted.end(), [](const plan::Medium& a, const plan::Medium& b) {
        return a.viscosity * b.modulus < b.viscosity * a.modulus;
    });
    for (size_t i = 0; i < some; ++i) few.push_back(sorted[i * (sorted.size() - 1) / (some - 1)]);
    return few;
}

// One cell under unit pressure, or between frames an upper bound of all, and what arithmetic of unit u is off by.
struct Running {
    double eps = 0, sum = 0, rate = 0, acceleration = 0; // exact
    double d_eps = 0, d_sum = 0, d_rate = 0, d_acceleration = 0;

    double value(int q) const {
        const double of[] = {eps, eps, sum, rate, acceleration};
        return std::abs(of[q]);
    }
    double error(int q) const {
        const double of[] = {d_eps, d_eps, d_sum, d_rate, d_acceleration};
        return of[q];
    }
};

// Arithmetic that keeps count: a value, and what it may be off by.
struct Counted {
    double value, off;
};

struct Arithmetic {
    double u, peak;        // of a rounding; greatest pressure: values are per unit of it
    bool single, bound;    // between frames values are bounds and never cancel
    double carried, flush; // what of a sum's own rounding stays in it; what is stored as 0

    // Half a unit in the last place of the greatest cell's value; of no other cell is it more.
    double rounding(double x) const {
        int exponent = 0;
        std::frexp(peak * std::abs(x) * (1 + 1e-5), &exponent);
        return x == 0 || peak == 0 ? 0 : std::ldexp(u, exponent - 1) / peak;
    }
    Counted of(double coefficient) const { // as it comes to the kernel
        const double off =
            single ? std::abs(double(float(coefficient)) - coefficient) : 0x1p-50 * std::abs(coefficient);
        return {coefficient, off};
    }
    Counted times(Counted a, Counted b) const {
        const double x = a.value * b.value, off = std::abs(a.value) * b.off + std::abs(b.value) * a.off;
        return {x, off + (std::abs(a.value) == 1 ? 0 : rounding(x))};
    }
    Counted plus(Counted a, Counted b) const {
        const double x = bound ? std::abs(a.value) + std::abs(b.value) : a.value + b.value;
        return {x, a.off + b.off + (a.value == 0 || b.value == 0 ? 0 : rounding(x))};
    }
};

// press.h, counted. What eps and sum were off by before is carried on linearly, where the kernel's terms cancel.
Running pressed(const Running& c, const f64::Coefficients& k, double s0_, double ds_, double sj_, const Arithmetic& a) {
    const double u = a.u;
    const Counted p{1, (a.bound ? 4 : 1) * (a.single ? u : 0)}; // rounded to float; frames are joined in it
    const Counted s0 = a.times(a.of(s0_), p), ds = a.times(a.of(ds_), p), sj = a.times(a.of(sj_), p);
    const Counted eps{c.eps, 0}, sum{c.sum, 0};
    const Counted r = a.plus(s0, a.times(a.of(-k.E), eps));
    const Counted step = a.plus(a.times(a.of(k.b), r), a.times(a.of(k.f), ds));
    const Counted gained = a.plus(a.plus(a.times(a.of(k.i0), eps), a.times(a.of(k.i1), s0)), a.times(a.of(k.i2), ds));
    const Counted leaked = a.plus(gained, a.times(a.of(-k.leak), sum));
    const Counted rate = a.plus(a.times(a.of(k.v0), r), a.times(a.of(k.v1), ds));
    const Counted acceleration =
        a.plus(a.plus(a.times(a.of(k.a0), r), a.times(a.of(k.a1), ds)), a.times(a.of(k.a2), sj));
    const double keep = std::abs(1 - k.b * k.E), keep_sum = std::abs(1 - k.leak);
    Running n;
    n.eps = a.bound ? keep * c.eps + std::abs(k.b * s0_) + std::abs(k.f * ds_) : c.eps + step.value;
    n.sum = a.bound ? keep_sum * c.sum + gained.value : c.sum + leaked.value;
    n.rate = rate.value;
    n.acceleration = acceleration.value;
    n.d_eps = keep * c.d_eps + step.off + a.carried * a.rounding(n.eps) + a.flush;
    n.d_sum = keep_sum * c.d_sum + std::abs(k.i0) * c.d_eps + leaked.off + a.carried * a.rounding(n.sum) + a.flush;
    n.d_rate = rate.off + std::abs(k.v0 * k.E) * c.d_eps;
    n.d_acceleration = acceleration.off + std::abs(k.a0 * k.E) * c.d_eps;
    return n;
}

} // namespace

Errors measured_peaks(const plan::Plan& plan) {
    const std::vector<double>& p = plan.maps.pressure;
    const size_t width = size_t(plan.constants.width);
    std::vector<Cell> cells;
    if (plan.model == Model::sites) {
        const size_t n = std::min(some, plan.places.size());
        for (size_t i = 0; i < n; ++i) cells.push_back(plan.places[i * plan.places.size() / n]);
    } else { // the cell of the greatest pressure of each material, and some more
        std::vector<size_t> best(std::min(some, plan.media.size()), 0);
        for (size_t i = 0; i < p.size(); ++i) {
            const size_t kind = plan.material.empty() ? 0 : size_t(plan.material[i / width * plan.pitch + i % width]);
            size_t& cell = best[kind % best.size()];
            if (std::abs(p[i]) > std::abs(p[cell])) cell = i;
        }
        const size_t more = std::min(some, p.size() / 4);
        for (size_t i = 0; i < more; ++i) best.push_back((2 * i + 1) * p.size() / (2 * more));
        for (size_t i : best) cells.push_back({int(i % width), int(i / width)});
    }
    Errors largest{};
    const plan::SiteCells needed(plan, cells);
    const auto stepper = reduced::sites(plan, needed, 1, [&](const plan::Step&, const plan::Sample& sample) {
        for (size_t i = 0; i < sample.probes.size(); ++i) {
            double& peak = largest[i / cells.size()];
            peak = std::max(peak, std::abs(sample.probes[i]));
        }
    });
    const plan::Plan exact = plan::timing(plan, needed.media, Method::exact);
    plan::FrameFeed feed(plan);
    plan::Timeline timeline(exact);
    for (plan::Step step; timeline.next(step);) {
        feed.before(step, [&](const std::vector<double>& frame) { stepper->frame(frame); });
        stepper->press(step);
    }
    return largest;
}

Errors predicted_errors(const plan::Plan& plan, Precision precision, bool flushed, const Errors& largest) {
    const double u = precision == Precision::f64 ? 0x1p-53 : 0x1p-24, flush = flushed ? 0x1p-64 : 0;
    const double carried = precision == Precision::f32_compensated ? 2 * u : 1;
    const double last = precision == Precision::f32_compensated ? u : 0; // of the value, once, where sums carry
    const f64::Constants& c = plan.constants;
    const double weight = c.bend * weight_of(plan), rest = rest_peak(plan), l = std::abs(c.curvature_length);
    const double peak = plan.framed ? 1 : largest_of(plan.maps.pressure); // frames come with their own
    const Arithmetic arithmetic{u,           peak,    precision != Precision::f64,
                                plan.framed, carried, peak > 0 ? 2 * flush / peak : 0};
    const Roughness rough = roughness_of(plan, peak);
    const std::vector<plan::Medium> media = media_of(plan);
    const plan::Plan timed = plan::timing(plan, media, plan.scene.method),
                     exact_timed = plan::timing(plan, media, Method::exact);
    plan::Timeline timeline(timed), exact_timeline(exact_timed);
    const bool baseline = plan.scene.method != Method::exact;
    std::vector<Running> kept(media.size()), now(media.size()), exact(media.size()), exact_now(media.size());
    Errors worst{}, values{};
    for (plan::Step step, true_step; timeline.next(step);) {
        const auto frame_peak = [&](long long k) {
            return k < 0 ? 0 : plan.frame_peaks[std::min(size_t(k), plan.frame_peaks.size() - 1)];
        };
        const double before = frame_peak(step.frame), after = step.frame < 0 ? 0 : frame_peak(step.frame + 1);
        const double s0 = plan.framed ? std::max(before, after) : step.start,
                     ds = plan.framed ? step.rise * (before + after) : step.rise,
                     sj = plan.framed ? step.jump * before : step.jump;
        // impulses and fields between outputs come from the exact method's timeline alone
        while (baseline && exact_timeline.next(true_step) && true_step.trace < 0) {
        }
        double strain = 0, d_strain = 0;
        for (size_t i = 0; i < media.size(); ++i) {
            now[i] = pressed(kept[i], (*step.rows)[i], s0, ds, sj, arithmetic);
            if (baseline) {
                exact_now[i] = pressed(exact[i], (*true_step.rows)[i], true_step.start, true_step.rise, true_step.jump,
                                       arithmetic);
                exact[i] = exact_now[i];
            }
            const double gone = baseline ? std::abs(now[i].eps - exact_now[i].eps) : 0;
            strain = std::max(strain, peak * std::abs(now[i].eps));
            d_strain = std::max(d_strain, peak * (now[i].d_eps + last * std::abs(now[i].eps) + gone));
        }
        const double gain = 1 + l * (rest + rough.laplacian * strain);
        const double d_C = weight * d_strain + u * (2 * rest + (rough.laplacian + rough.differences) * strain);
        if (step.trace >= 0 || step.field >= 0)
            for (size_t i = 0; i < media.size(); ++i)
                for (int q = 0; q < REDUCED_MAPS; ++q) {
                    const double x = peak * now[i].value(q);
                    values[q] = std::max(values[q], x);
                    double gone = 0;
                    if (baseline) {
                        const Running &m = now[i], &e = exact_now[i];
                        const double apart[] = {m.eps - e.eps, m.eps - e.eps, m.sum - e.sum, m.rate - e.rate,
                                                m.acceleration - e.acceleration};
                        gone = peak * std::abs(apart[q]);
                    }
                    const double d_x = peak * (now[i].error(q) + (q < 3 ? last * now[i].value(q) : 0)) + gone;
                    if (precision != Precision::f64 && !(x * gain < 3e38)) worst[q] = INFINITY;
                    const double error = q == 0 ? d_x + flush : d_x * gain + x * (l * d_C + 3 * u * gain) + 2 * flush;
                    worst[q] = std::max(worst[q], error);
                }
        if (step.keep) kept = now;
    }
    const auto& gains = plan.scene.receptors.fa2_gains;
    worst[4] *= std::max(std::abs(gains[0]), std::abs(gains[1]));
    for (int q = 0; q < REDUCED_MAPS; ++q) {
        const double stored = 2.1 * flush * (q == 4 ? std::max(std::abs(gains[0]), std::abs(gains[1])) : 1);
        worst[q] = values[q] == 0 && worst[q] <= stored ? 0 : worst[q] / largest[q]; // nothing but zeros is exact
        if (std::isnan(worst[q])) worst[q] = INFINITY;
    }
    return worst;
}

double worst_asked(const plan::Plan& plan, const Errors& errors) {
    const Scene& s = plan.scene;
    double worst = 0;
    const auto count = [&](Quantity q) {
        if (q < Quantity::curvature) worst = std::max(worst, errors[size_t(q)]);
    };
    for (Quantity q : s.output.traces) count(q);
    for (const FieldRequest& f : s.output.fields)
        for (Quantity q : f.what) count(q);
    for (const Site& site : s.sites) count(site.type);
    return worst;
}

} // namespace dermis::planner
