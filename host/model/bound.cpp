// SPDX-License-Identifier: MIT
#include "host/model/bound.hpp"

#include "host/model/sites.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::model {
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

struct Arithmetic {
    double u, carry, flush; // a rounding; what a sum's own rounding leaves in it; what is stored as 0
};

// Terms of press.h in their order, each rounding u, a coefficient 2^-50 more.
Running pressed(const Running& c, const f64::Row& k, double s0, double ds, double sj, bool bound, const Arithmetic& a) {
    const double u = a.u, v = a.u + 0x1p-50;
    const auto both = [&](double x, double y) { return bound ? std::abs(x) + std::abs(y) : x + y; };
    const double r = bound ? std::abs(s0) + k.E * c.eps : s0 - k.E * c.eps;
    const double d_r = k.E * c.d_eps + v * (3 * std::abs(s0) + 2 * k.E * std::abs(c.eps) + std::abs(r));
    const double step = both(k.b * r, k.f * ds), gained = both(both(k.i0 * c.eps, k.i1 * s0), k.i2 * ds);
    const double keep = std::abs(1 - k.b * k.E);
    Running n;
    n.eps = bound ? keep * c.eps + std::abs(k.b * s0) + std::abs(k.f * ds) : c.eps + step;
    n.sum = bound ? std::abs(1 - k.leak) * c.sum + gained : c.sum + gained - k.leak * c.sum;
    n.rate = both(k.v0 * r, k.v1 * ds);
    n.acceleration = both(both(k.a0 * r, k.a1 * ds), k.a2 * sj);
    n.d_eps = keep * c.d_eps + std::abs(k.b) * (d_r - k.E * c.d_eps) + v * 2 * std::abs(k.b * r) +
              v * 4 * std::abs(k.f * ds) + u * std::abs(step) + a.carry * std::abs(n.eps) + a.flush;
    n.d_sum = std::abs(1 - k.leak) * c.d_sum + std::abs(k.i0) * c.d_eps +
              v * (2 * std::abs(k.i0 * c.eps) + 4 * std::abs(k.i1 * s0) + 5 * std::abs(k.i2 * ds)) +
              v * 3 * (std::abs(gained) + std::abs(k.leak * c.sum)) + a.carry * std::abs(n.sum) + a.flush;
    n.d_rate = std::abs(k.v0) * d_r + v * (3 * std::abs(k.v0 * r) + 5 * std::abs(k.v1 * ds));
    n.d_acceleration =
        std::abs(k.a0) * d_r + v * (4 * std::abs(k.a0 * r) + 6 * std::abs(k.a1 * ds) + 6 * std::abs(k.a2 * sj));
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
        for (size_t i = 0; i < some; ++i) best.push_back((2 * i + 1) * p.size() / (2 * some));
        for (size_t i : best) cells.push_back({int(i % width), int(i / width)});
    }
    Errors largest{};
    const SiteCells needed(plan, cells);
    const auto marcher = sites(plan, needed, [&](const plan::Step&, const plan::Sample& sample) {
        for (size_t i = 0; i < sample.probes.size(); ++i) {
            double& peak = largest[i / cells.size()];
            peak = std::max(peak, std::abs(sample.probes[i]));
        }
    });
    const plan::Plan exact = plan::timing(plan, needed.media, Method::exact);
    plan::FrameFeed feed(plan);
    plan::Timeline timeline(exact);
    for (plan::Step step; timeline.next(step);) {
        feed.before(step, [&](const std::vector<double>& frame) { marcher->frame(frame); });
        marcher->press(step);
    }
    return largest;
}

Errors predicted_errors(const plan::Plan& plan, Precision precision, bool flushed, const Errors& largest) {
    const double u = precision == Precision::f64 ? 0x1p-53 : 0x1p-24, flush = flushed ? 0x1p-64 : 0;
    const double carry = precision == Precision::f32_compensated ? 2 * u * u : u;
    const double last = precision == Precision::f32_compensated ? u : 0; // of the value, once, where sums carry
    const f64::Constants& c = plan.constants;
    const double weight = c.bend * weight_of(plan), rest = rest_peak(plan), l = std::abs(c.curvature_length);
    const double peak = plan.framed ? 1 : largest_of(plan.maps.pressure); // frames come with their own
    const Arithmetic arithmetic{u, carry, peak > 0 ? 2 * flush / peak : 0};
    const std::vector<plan::Medium> media = media_of(plan);
    const plan::Plan timed = plan::timing(plan, media, plan.scene.method),
                     exact_timed = plan::timing(plan, media, Method::exact);
    plan::Timeline timeline(timed), exact_timeline(exact_timed);
    const bool baseline = plan.scene.method != Method::exact;
    std::vector<Running> kept(media.size()), now(media.size()), exact(media.size()), exact_now(media.size());
    Errors worst{};
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
            now[i] = pressed(kept[i], (*step.rows)[i], s0, ds, sj, plan.framed, arithmetic);
            if (baseline) {
                exact_now[i] = pressed(exact[i], (*true_step.rows)[i], true_step.start, true_step.rise, true_step.jump,
                                       false, arithmetic);
                exact[i] = exact_now[i];
            }
            const double gone = baseline ? std::abs(now[i].eps - exact_now[i].eps) : 0;
            strain = std::max(strain, peak * std::abs(now[i].eps));
            d_strain = std::max(d_strain, peak * (now[i].d_eps + last * std::abs(now[i].eps) + gone));
        }
        const double gain = 1 + l * (rest + weight * strain);
        const double d_C = weight * d_strain + u * (2 * rest + 6 * weight * strain);
        if (step.trace >= 0 || step.field >= 0)
            for (size_t i = 0; i < media.size(); ++i)
                for (int q = 0; q < REDUCED_MAPS; ++q) {
                    const double x = peak * now[i].value(q);
                    double gone = 0;
                    if (baseline) {
                        const Running &m = now[i], &e = exact_now[i];
                        const double apart[] = {m.eps - e.eps, m.eps - e.eps, m.sum - e.sum, m.rate - e.rate,
                                                m.acceleration - e.acceleration};
                        gone = peak * std::abs(apart[q]);
                    }
                    const double d_x = peak * (now[i].error(q) + (q < 3 ? last * now[i].value(q) : 0)) + gone;
                    const double error = q == 0 ? d_x + flush : d_x * gain + x * (l * d_C + 4 * u * gain) + 2 * flush;
                    worst[q] = std::max(worst[q], error);
                }
        if (step.keep) kept = now;
    }
    const auto& gains = plan.scene.receptors.fa2_gains;
    worst[4] *= std::max(std::abs(gains[0]), std::abs(gains[1]));
    for (int q = 0; q < REDUCED_MAPS; ++q) {
        if (peak == 0 || worst[q] <= 2.1 * flush * (q == 4 ? std::max(std::abs(gains[0]), std::abs(gains[1])) : 1))
            worst[q] = 0; // nothing but zeros
        else worst[q] = worst[q] / largest[q];
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

} // namespace dermis::model
