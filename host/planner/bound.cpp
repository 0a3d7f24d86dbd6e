// SPDX-License-Identifier: MIT
#include "host/planner/bound.hpp"

#include "host/plan/laplacian.hpp"
#include "host/plan/site_cells.hpp"
#include "host/planner/arithmetic.hpp"
#include "host/reduced/sites.hpp"

#include <algorithm>

namespace dermis::planner {
namespace {

using plan::Element;
using plan::PreparedSkin;
using plan::Schedule;

constexpr size_t sample_limit = 64; // most materials and cells that are analysed

// The sum of a stencil's absolute weights, the factor from errors of the cells to the error of the Laplacian.
double weight_of(int stencil) {
    if (stencil == STENCIL_FIVE_POINT) return 8;
    return stencil == STENCIL_FOURTH_ORDER ? 32.0 / 3 : 4;
}

double largest_of(const std::vector<double>& map) {
    double largest = 0;
    for (double v : map) largest = std::max(largest, std::abs(v));
    return largest;
}

// The greatest |L(S)| over all cells, or over the points if a run without traces and fields reads no others.
double rest_peak(const PreparedSkin& skin, const Schedule& schedule, bool points_only) {
    if (!points_only) return greatest_rest_curvature(skin);
    double largest = 0;
    for (const Cell& c : schedule.points) largest = std::max(largest, std::abs(rest_curvature_at(skin, c)));
    return largest;
}

// Greatest Laplacian of a strain with maximum 1, and greatest sum of its differences. A uniform skin's strain has the
// load's shape, which gives a tighter bound.
struct Roughness {
    double laplacian, differences;
};

Roughness roughness_of(const PreparedSkin& skin, const Schedule& schedule, double peak) {
    const double weight = skin.constants.bend * weight_of(skin.stencil);
    Roughness r{weight, 2 * weight};
    if (skin.materials.size() > 1 || schedule.framed || peak == 0) return r;
    const Grid unit = plan::without_spacing(skin.description.grid);
    const std::vector<double>& map = schedule.pressure;
    r.laplacian = skin.constants.bend * largest_of(plan::laplacian(map, unit, skin.stencil, skin.edges)) / peak;
    double step = 0; // greatest difference of neighbours
    const size_t width = size_t(unit.width);
    for (size_t i = 0; i < map.size(); ++i) {
        if (i % width) step = std::max(step, std::abs(map[i] - map[i - 1]));
        if (i >= width) step = std::max(step, std::abs(map[i] - map[i - width]));
    }
    // A stencil reaches two cells.
    if (skin.edges != EDGES_PERIODIC) r.differences = weight * std::min(2 * step / peak, 2.0);
    return r;
}

// All materials, or of very many some from the fastest to the slowest.
std::vector<Element> sampled_materials(const std::vector<Element>& materials) {
    if (materials.size() <= sample_limit) return materials;
    std::vector<Element> sorted = materials, few;
    std::sort(sorted.begin(), sorted.end(),
              [](const Element& a, const Element& b) { return a.viscosity * b.modulus < b.viscosity * a.modulus; });
    for (size_t i = 0; i < sample_limit; ++i) few.push_back(sorted[i * (sorted.size() - 1) / (sample_limit - 1)]);
    return few;
}

// The most pressed cell of each material, and evenly spaced cells.
std::vector<Cell> sampled_cells(const PreparedSkin& skin, const Schedule& schedule) {
    const std::vector<double>& p = schedule.pressure;
    const size_t width = size_t(skin.width()), pitch = size_t(skin.pitch);
    std::vector<size_t> best(std::min(sample_limit, skin.materials.size()), 0);
    for (size_t i = 0; i < p.size(); ++i) {
        const size_t kind = skin.uniform() ? 0 : size_t(skin.material_of[i / width * pitch + i % width]);
        size_t& cell = best[kind % best.size()];
        if (std::abs(p[i]) > std::abs(p[cell])) cell = i;
    }
    const size_t more = std::min(sample_limit, p.size() / 4);
    for (size_t i = 0; i < more; ++i) best.push_back((2 * i + 1) * p.size() / (2 * more));
    std::vector<Cell> cells;
    for (size_t i : best) cells.push_back({int(i % width), int(i / width)});
    return cells;
}

// The pressures of a step per unit of the map, or between frames the greatest magnitudes over all cells.
struct StepLoad {
    double s0, ds, sj;
};

StepLoad load_of(const Schedule& schedule, const plan::Step& step) {
    if (!schedule.framed) return {step.start, step.rise, step.jump};
    const auto peak = [&](long long k) {
        return k < 0 ? 0 : schedule.frame_peaks[std::min(size_t(k), schedule.frame_peaks.size() - 1)];
    };
    const double before = peak(step.frame), after = step.frame < 0 ? 0 : peak(step.frame + 1);
    return {std::max(before, after), step.rise * (before + after), step.jump * before};
}

// The running analysis of one cell of each material, step by step.
class Analysis {
  public:
    Analysis(const PreparedSkin& skin, const Schedule& schedule, Precision precision, bool flushed, bool points_only)
        : skin_(skin), schedule_(schedule), in_double_(precision == Precision::f64), u_(in_double_ ? 0x1p-53 : 0x1p-24),
          flush_(flushed ? 0x1p-64 : 0), last_(precision == Precision::f32_compensated ? u_ : 0),
          l_(std::abs(skin.constants.curvature_length)), weight_(skin.constants.bend * weight_of(skin.stencil)),
          rest_(rest_peak(skin, schedule, points_only)), peak_(schedule.framed ? 1 : largest_of(schedule.pressure)),
          rough_(roughness_of(skin, schedule, peak_)), arithmetic_{.u = u_,
                                                                   .peak = peak_,
                                                                   .single = !in_double_,
                                                                   .bound = schedule.framed,
                                                                   .carried = precision == Precision::f32_compensated
                                                                                  ? 2 * u_
                                                                                  : 1,
                                                                   .flush = peak_ > 0 ? 2 * flush_ / peak_ : 0},
          materials_(sampled_materials(skin.materials)) {}

    void run() {
        plan::Timeline timeline(schedule_, materials_, skin_.rule, schedule_.method),
            exact_timeline(schedule_, materials_, skin_.rule, Method::exact);
        const bool baseline = schedule_.method != Method::exact;
        std::vector<CountedCell> kept(materials_.size()), exact(materials_.size());
        now_ = exact_ = kept;
        for (plan::Step step, true_step; timeline.next(step);) {
            // Only the timeline of the exact method has impulses and fields between outputs: they are skipped.
            while (baseline && exact_timeline.next(true_step) && true_step.trace < 0) {
            }
            const StepLoad load = load_of(schedule_, step);
            for (size_t i = 0; i < materials_.size(); ++i) {
                now_[i] = arithmetic_.pressed(kept[i], (*step.coefficients)[i], load.s0, load.ds, load.sj);
                exact_[i] = now_[i];
                if (baseline)
                    exact_[i] = exact[i] = arithmetic_.pressed(exact[i], (*true_step.coefficients)[i], true_step.start,
                                                               true_step.rise, true_step.jump);
            }
            if (step.trace >= 0 || step.field >= 0) widen();
            if (step.keep) kept = now_;
        }
    }

    // The greatest errors relative to the largest values.
    Errors relative(const Errors& largest) const {
        const auto& gains = skin_.description.receptors.fa2_gains;
        const double gain = std::max(std::abs(gains[0]), std::abs(gains[1]));
        Errors errors = worst_;
        errors[QUANTITY_FA2] *= gain;
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            const double stored = 2.1 * flush_ * (q == QUANTITY_FA2 ? gain : 1);
            errors[q] = values_[q] == 0 && errors[q] <= stored ? 0 : errors[q] / largest[q]; // only zeros: exact
            if (std::isnan(errors[q])) errors[q] = INFINITY;
        }
        return errors;
    }

  private:
    // Distance of the method from the exact one, per unit of pressure; 0 for the exact method itself.
    double truncation(size_t i, int q) const { return std::abs(now_[i].value(q) - exact_[i].value(q)); }

    // Widens the worst errors by those at the end of a step that is read.
    void widen() {
        double strain = 0, d_strain = 0;
        for (size_t i = 0; i < now_.size(); ++i) {
            strain = std::max(strain, peak_ * std::abs(now_[i].eps));
            d_strain = std::max(
                d_strain, peak_ * (now_[i].d_eps + last_ * std::abs(now_[i].eps) + truncation(i, QUANTITY_STRAIN)));
        }
        const double gain = 1 + l_ * (rest_ + rough_.laplacian * strain);
        const double d_C = weight_ * d_strain + u_ * (2 * rest_ + (rough_.laplacian + rough_.differences) * strain);
        for (size_t i = 0; i < now_.size(); ++i)
            for (int q = 0; q < REDUCED_MAPS; ++q) {
                const double value = std::abs(now_[i].value(q)), x = peak_ * value;
                double& worst = worst_[size_t(q)];
                values_[size_t(q)] = std::max(values_[size_t(q)], x);
                const bool sum = q <= QUANTITY_SA2; // if compensated, its error is the last rounding of its value
                const double d_x = peak_ * (now_[i].error(q) + (sum ? last_ * value : 0)) + peak_ * truncation(i, q);
                if (!in_double_ && !(x * gain < 3e38)) worst = INFINITY;
                const double error =
                    q == QUANTITY_STRAIN ? d_x + flush_ : d_x * gain + x * (l_ * d_C + 3 * u_ * gain) + 2 * flush_;
                worst = std::max(worst, error);
            }
    }

    const PreparedSkin& skin_;
    const Schedule& schedule_;
    const bool in_double_;
    const double u_, flush_;
    const double last_; // relative error of the last rounding of a sum whose earlier ones are compensated; otherwise 0
    const double l_, weight_, rest_, peak_;
    const Roughness rough_;
    const CountedArithmetic arithmetic_;
    const std::vector<Element> materials_;
    std::vector<CountedCell> now_, exact_; // by the scene's method; by the exact one
    Errors worst_{}, values_{};
};

} // namespace

Errors measured_peaks(const PreparedSkin& skin, const Schedule& schedule, bool points_only) {
    std::vector<Cell> cells;
    const std::vector<Cell>& points = schedule.points;
    if (points_only) {
        const size_t n = std::min(sample_limit, points.size());
        for (size_t i = 0; i < n; ++i) cells.push_back(points[i * points.size() / n]);
    } else {
        cells = sampled_cells(skin, schedule);
    }
    Errors largest{};
    const plan::SiteCells needed(skin, pressed_cells(schedule), cells);
    const bool own_class = points_only && cells.size() == points.size();
    const auto stepper = reduced::sites(skin, schedule, needed, own_class, 1, [&](auto&, const plan::Sample& sample) {
        for (size_t i = 0; i < sample.points.size(); ++i) {
            double& peak = largest[i / cells.size()];
            peak = std::max(peak, std::abs(sample.points[i]));
        }
    });
    plan::FrameFeed feed(schedule);
    plan::Timeline timeline(schedule, needed.materials, skin.rule, Method::exact);
    for (plan::Step step; timeline.next(step);) {
        feed.before(step, [&](const std::vector<double>& frame) { stepper->frame(frame); });
        stepper->press(step);
    }
    return largest;
}

Errors predicted_errors(const PreparedSkin& skin, const Schedule& schedule, Precision precision, bool flushed,
                        const Errors& largest, bool points_only) {
    Analysis analysis(skin, schedule, precision, flushed, points_only);
    analysis.run();
    return analysis.relative(largest);
}

double worst_asked(const PreparedSkin& skin, const Schedule& schedule, const Errors& errors) {
    double worst = 0;
    const auto count = [&](Quantity q) {
        if (q < Quantity::curvature) worst = std::max(worst, errors[size_t(q)]);
    };
    for (Quantity q : schedule.output.traces) count(q);
    for (const FieldRequest& f : schedule.output.fields)
        for (Quantity q : f.what) count(q);
    for (const Site& site : skin.description.sites) count(site.type);
    return worst;
}

} // namespace dermis::planner
