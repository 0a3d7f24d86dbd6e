// SPDX-License-Identifier: MIT
#include "host/lab/planner/bound.hpp"

#include "host/core/model/laplacian.hpp"
#include "host/lab/planner/materials.hpp"
#include "host/lab/reduced/moments.hpp"
#include "host/lab/reduced/sites.hpp"

#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

namespace dermis::planner {
namespace {

using model::Element;
using model::PreparedSkin;
using model::Schedule;

// The roundings of a mean over all cells, in units of the greatest value: one for each level of a tile's tree that
// joins columns, by the mean of the values' magnitudes. In models of products: the roundings of a sum and of its
// division.
double units_of_mean(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind) {
    if (kind.separable) return 2;
    const int columns = std::min(skin.width(), TILE_CELLS);
    const double levels = double(std::bit_width(unsigned(columns - 1)));
    if (schedule.framed || kind.spread || !skin.uniform()) return levels;
    double sum = 0;
    for (double p : schedule.pressure) sum += std::abs(p);
    const double mean = (1 + 1e-6) * sum / double(skin.cells());
    return sum > 0 ? levels * std::min(1.0, mean / largest_of(schedule.pressure)) : levels;
}

// The error of the curvature at rest: of the Laplacian of the heights, four roundings in double, and two to float. A
// curvature that is given has fewer.
double error_at_rest(const PreparedSkin& skin, const Arithmetic& kind, double rest) {
    const double spacing = skin.description.grid.spacing.value_or(1), of_heights = roundings_of(skin, skin.heights);
    return (kind.single ? 2 * kind.unit() * rest : 0) +
           unit_of_double * (4 * rest + std::abs(skin.relief) * of_heights / (spacing * spacing));
}

// The roundings of FA2 times its gains, in units: of a gain to float and of the product. A power of two has none.
double units_of_gains(const PreparedSkin& skin, const Arithmetic& kind) {
    for (double gain : skin.description.receptors.fa2_gains)
        if (int exponent = 0; gain != 0 && std::abs(std::frexp(gain, &exponent)) != 0.5) return kind.single ? 2 : 1;
    return 0;
}

double greatest_surface(const PreparedSkin& skin) { return largest_of(skin.heights) * std::abs(skin.relief); }

// Tells which quantities are written at the end of a step.
class Written {
  public:
    Written(const Schedule& schedule, const Read& read) : fields_(schedule.field_times.size()) {
        if (!read.everything) {
            rows_[size_t(read.quantity)] = true;
            return;
        }
        for (Quantity q : schedule.output.traces) rows_[size_t(q)] = means_[size_t(q)] = true;
        for (const FieldRequest& f : schedule.output.fields)
            for (size_t i = 0; i < fields_.size(); ++i)
                if (schedule.field_times[i] == scene::snapped(f.at, schedule.time.step))
                    for (Quantity q : f.what) fields_[i][size_t(q)] = true;
    }

    bool at(const model::Step& step, Quantity q) const {
        return (step.trace >= 0 && rows_[size_t(q)]) || (step.field >= 0 && fields_[size_t(step.field)][size_t(q)]);
    }
    // Whether a quantity is written at any time.
    bool ever(Quantity q) const {
        return rows_[size_t(q)] || std::ranges::any_of(fields_, [q](const Quantities& of) { return of[size_t(q)]; });
    }
    bool mean(const model::Step& step, Quantity q) const { return step.trace >= 0 && means_[size_t(q)]; }

  private:
    using Quantities = std::array<bool, std::tuple_size_v<Errors>>;
    Quantities rows_{}, means_{};
    std::vector<Quantities> fields_;
};

// What the bounds of one product are made from.
struct AnalysedProduct {
    AnalysedProduct(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind, const Read& read)
        : quantum(std::max(schedule.quantum, kind.separable ? 0x1p-1074 * model::unit_of(schedule.pressure) : 0)),
          materials(analysed(skin, schedule, kind, read)),
          rough(roughness_of(skin, schedule, std::ranges::max(materials.pressed, {}, &PressedMaterial::around).around)),
          run(schedule, materials.counted, skin.rule, schedule.method, materials.chain, kind.separable) {}

    const double quantum; // of the run's map
    const AnalysedMaterials materials;
    const Roughness rough;
    CountedRun run; // by the method
};

// The running analysis of one cell of each material, step by step; of one cell under each product.
class Analysis {
  public:
    Analysis(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind, const Read& read)
        : skin_(skin), schedule_(schedule), kind_(kind), u_(kind.unit()),
          last_(kind.compensated ? counted_unit(kind) : 0), l_(std::abs(skin.constants.curvature_length)),
          rest_(rest_peak(skin, schedule, !read.everything)), d_rest_(error_at_rest(skin, kind, rest_)),
          surface_(greatest_surface(skin)), units_of_mean_(units_of_mean(skin, schedule, kind)),
          units_of_gains_(units_of_gains(skin, kind)), written_(schedule, read) {
        for (size_t i = 0; i < schedule.products(); ++i)
            products_.push_back(std::make_unique<AnalysedProduct>(skin, schedule.product(i), kind, read));
        const AnalysedMaterials& materials = products_.front()->materials;
        if (schedule.method != Method::exact)
            exact_.emplace(schedule, materials.counted, skin.rule, Method::exact, materials.chain);
        if (!materials.extremes.empty()) extremes_.emplace(schedule, materials.extremes, skin.rule, schedule.method);
    }

    Bounds run() {
        while (std::ranges::all_of(products_, [](auto& product) { return product->run.next(); })) { // the same steps
            if (exact_) exact_->next(); // a baseline has its fields at outputs, so that both read the same times
            if (extremes_) extremes_->next();
            widen();
        }
        return bounds_;
    }

  private:
    // The distance of the method from the exact one, per unit of pressure; 0 for the exact method itself. A part adds
    // the spread of its retardation times and the rounding of pressure over resistance.
    double truncation(const AnalysedProduct& of_product, size_t cell, int q) const {
        const double x = of_product.run.cells()[cell].signal(q).value,
                     method = exact_ ? std::abs(x - exact_->cells()[cell].signal(q).value) : 0;
        if (!extremes_) return method;
        const std::vector<CountedCell>& of = extremes_->cells();
        return method + std::abs(of[2 * cell].signal(q).value - of[2 * cell + 1].signal(q).value) +
               0x1p-53 * std::abs(x);
    }

    // A quantity of one cell under the greatest pressure on it, or around it.
    struct BoundedSum {
        double value = 0, magnitude = 0; // of a strain in series the magnitudes of its elements, added up
        double off = 0;                  // error of the value
        double gain = INFINITY;          // greatest gain at rest of the error, where it is all rounding
        double value_gain = INFINITY;    // greatest gain at rest of the value
    };
    BoundedSum sum_of(const AnalysedProduct& product, size_t cell, int q, bool around) const {
        BoundedSum s;
        const DeepMaterial* deep =
            !around && product.materials.deep[size_t(q)] ? &*product.materials.deep[size_t(q)] : nullptr;
        const PressedMaterial& m =
            deep ? deep->pressed : product.materials.pressed[cell * product.materials.chain.length];
        const double peak = around ? m.around : m.peak, share = peak < m.around ? peak / m.around : 1;
        const CountedCell& counted = product.run.cells()[cell];
        const Counted& of = counted.signal(q);
        s.value = peak * of.size;
        s.magnitude = q <= QUANTITY_SA1 ? std::max(peak * counted.strains, s.value) : s.value;
        if (!counted.flushed && (kind_.separable || !kind_.compensated)) s.gain = m.gain;
        s.value_gain = m.value_gain;
        if (deep) s.off += deep->off * s.magnitude;
        if (q <= QUANTITY_SA2) s.off += last_ * s.magnitude; // compensated, it is off by the last rounding of its value
        // Half a unit in the last place of a smaller value is up to twice as much of it.
        s.off += peak *
                 ((share < 1 && !kind_.separable ? 2 : 1) * of.off + std::abs(of.shift) + truncation(product, cell, q));
        if (!schedule_.framed) s.off += rounding_of(peak, share, product.quantum) * std::abs(s.value);
        if (kind_.separable) s.off += peak * product.run.measured(cell, q);
        if (kind_.spread && q != QUANTITY_STRAIN) spread(s, deep);
        return s;
    }

    // Signals are stored, and spread if their receptors lie at a depth.
    void spread(BoundedSum& s, const DeepMaterial* deep) const {
        if (s.value != 0) s.off += kind_.stored;
        s.gain = INFINITY;
        if (!deep) return;
        const double most = std::abs(s.value) + s.off;
        s.off = deep->norm * s.off + (model::spread_error * std::max(deep->norm, 1.0) + deep->rounded) * most;
        s.value *= deep->share;
        s.magnitude *= deep->share;
    }

    // The sums of every cell; where some elements represent all, one sum that no cell exceeds.
    std::vector<BoundedSum> sums_of(const AnalysedProduct& product, int q, bool around) const {
        std::vector<BoundedSum> all;
        const std::vector<size_t>& ends = product.materials.ends;
        for (size_t i = 0; i < ends.front() / product.materials.chain.length; ++i)
            all.push_back(sum_of(product, i, q, around));
        if (ends.size() == 1) return all;
        BoundedSum together;
        for (size_t place = 0, i = 0; place < ends.size(); ++place) {
            BoundedSum most;
            for (; i < ends[place]; ++i) {
                const BoundedSum s = sum_of(product, i, q, around);
                raise(most.magnitude, s.magnitude);
                raise(most.off, s.off);
            }
            together.magnitude += most.magnitude;
            together.off += most.off;
        }
        // The kernel rounds its one sum as often as there are elements. Each of these roundings is at most twice the
        // rounding of the elements alone.
        together.value = together.magnitude;
        together.off *= 2 * double(ends.size());
        return {together};
    }

    // The sums of every cell; under several products one sum that no cell exceeds.
    std::vector<BoundedSum> sums_of(int q, bool around) const {
        if (products_.size() == 1) return sums_of(*products_.front(), q, around);
        BoundedSum together{.gain = 0, .value_gain = 0};
        for (const auto& product : products_)
            for (const BoundedSum& of : sums_of(*product, q, around)) {
                together.magnitude += of.magnitude;
                together.off += of.off;
                raise(together.gain, of.gain);
                raise(together.value_gain, of.value_gain);
            }
        together.value = together.magnitude;
        return {together};
    }

    // The greatest strain under a product, and its error.
    std::pair<double, double> strain_under(const AnalysedProduct& product) const {
        double strain = 0, off = 0;
        for (const BoundedSum& eps : sums_of(product, QUANTITY_STRAIN, true)) {
            raise(strain, eps.magnitude);
            raise(off, eps.off);
        }
        return {strain, off};
    }

    // Takes the errors at the end of a step that is read.
    void widen() {
        double strain = 0, d_strain = 0, curved = 0, d_C = d_rest_;
        for (const auto& product : products_) {
            const auto [eps, off] = strain_under(*product);
            strain += eps;
            d_strain += off;
            curved += product->rough.laplacian * eps;
            d_C += product->rough.of_error * off + u_ * (product->rough.laplacian + product->rough.roundings) * eps;
        }
        const double bent = l_ * curved, gain = 1 + l_ * rest_ + bent;
        for (int q = 0; q < REDUCED_MAPS; ++q)
            for (const BoundedSum& of : written_.ever(Quantity(q)) ? sums_of(q, false) : std::vector<BoundedSum>()) {
                const double x = std::abs(of.value), greatest = q == QUANTITY_STRAIN ? x : x * gain;
                const double stored = x == 0 || kind_.separable ? 0 : kind_.stored;
                const double run = x + of.off, value = run * std::min(of.value_gain + bent, gain); // of the response
                const double of_gains = q == QUANTITY_FA2 ? units_of_gains_ * u_ * value : 0;
                const double rounded =
                    of_gains + (kind_.separable ? rounding_of_products(run, run * of.value_gain, bent, value)
                                                : rounding(run, gain, value));
                const double error = q == QUANTITY_STRAIN ? of.off + stored + (kind_.separable ? u_ * run : 0)
                                                          : of.off * std::min(of.gain + bent, gain) + run * l_ * d_C +
                                                                rounded + 2 * stored;
                const double sum = x * gain * (written_.mean(step(), Quantity(q)) ? double(skin_.cells()) : 1);
                take(Quantity(q), greatest, sum < (kind_.single ? 3e38 : 1e308) ? error : INFINITY);
            }
        take_shape(strain, d_strain, curved, d_C);
    }

    // Takes a value of a quantity at the end of the step, and its error.
    void take(Quantity q, double value, double error) {
        const size_t i = size_t(q);
        raise(bounds_.greatest[i], value);
        raise(bounds_.throughout[i], error);
        if (!written_.at(step(), q)) return;
        raise(bounds_.error[i], error);
        if (written_.mean(step(), q)) raise(bounds_.error[i], error + units_of_mean_ * u_ * (value + error));
    }

    // Takes curvature and deformation under a strain.
    void take_shape(double strain, double d_strain, double bent, double d_C) {
        const double indented = skin_.constants.thickness * strain;
        const double most = kind_.single ? 3e38 : 1e308; // near which a sum overflows
        take(Quantity::curvature, rest_ + bent,
             rest_ + bent < most ? d_C + terms() * u_ * (rest_ + bent) + kind_.stored : INFINITY);
        take(Quantity::deformation, surface_ + indented,
             surface_ + indented < most ? skin_.constants.thickness * d_strain +
                                              double(1 + products_.size()) * u_ * (surface_ + indented) + kind_.stored
                                        : INFINITY);
    }

    const model::Step& step() const { return products_.front()->run.step(); }
    // How many strains the curvature is a sum of.
    double terms() const { return double(std::max({skin_.parts.size(), products_.size()})); }

    double half_unit(double x) const { return x > 0 ? std::ldexp(u_, std::ilogb(x * (1 + 1e-5))) : 0; }

    // Returns how far pressures are off, relative to the greatest one: the map is rounded in double, and to float.
    double rounding_of(double peak, double share, double quantum) const {
        const double units = kind_.separable || share < 1 || peak == 0 ? u_ : half_unit(peak) / peak;
        const double stored = (kind_.single ? 0x1p-149 : quantum) / peak;
        return units + (kind_.single ? 0x1p-53 : 0) + (peak > 0 ? stored : 0);
    }

    // The roundings of a response, which is the product of a signal x and its gain: of the curvature times a length, of
    // the gain and of the product.
    double rounding(double x, double gain, double response) const {
        return (kind_.single ? 2 : 1) * u_ * x * (gain - 1) + std::min(x * half_unit(gain), u_ * response) +
               half_unit(response);
    }

    // The roundings of a response by products, x*(a - sum of g*b) per unit of pressure: two of a, the response at rest,
    // and one of its length; four of each g*b, which the strain adds; one of each difference; one of the product. The
    // sum over products rounds once more for each, and its extremes are found by another order of the same operations.
    double rounding_of_products(double x, double at_rest, double bent, double response) const {
        const double differences = terms() > 1 ? terms() * (at_rest + x * bent) : response;
        const double lengths = products_.size() > 1 ? 2 : 1;
        return u_ * (2 * at_rest + lengths * x * l_ * rest_ + 4 * x * bent + differences +
                     double(products_.size()) * response);
    }

    const PreparedSkin& skin_;
    const Schedule& schedule_;
    const Arithmetic kind_;
    const double u_;
    const double last_;                        // of a value: the last rounding, where earlier ones are compensated
    const double l_, rest_, d_rest_, surface_; // d_rest_: what L(S) is off by; surface_: greatest |S|
    const double units_of_mean_, units_of_gains_;
    const Written written_;
    std::vector<std::unique_ptr<AnalysedProduct>> products_; // of Schedule::product
    std::optional<CountedRun> exact_;                        // beside a baseline
    std::optional<CountedRun> extremes_;
    Bounds bounds_{};
};

// The exact solution in some points: of sites at outputs, of cells at outputs and fields; take(quantity, point, |X|).
template <class Take>
void solve(const PreparedSkin& skin, const Schedule& schedule, const std::vector<Cell>& points,
           const std::vector<int>& classes, Take take) {
    const model::SiteCells needed(skin, pressed_cells(schedule), points);
    // Products have FA2 with its gain.
    const bool products = (!schedule.modes.empty() && !schedule.framed) || !schedule.others.empty();
    const bool gained = products && skin.constants.gain_plus != 0;
    const double gain = gained ? std::abs(skin.constants.gain_plus) : 1;
    const Written written(schedule, {.everything = true, .quantity = 0});
    model::Step now; // as the timeline gave it
    // Values at outputs and fields count, written or not; but a field's time has no mean over a step of an output.
    const auto counts = [&](Quantity q) {
        return now.trace >= 0 || written.at(now, q) || q != Quantity::fa2 || !skin.rule.step_mean;
    };
    const auto sink = [&](const model::Step& step, const model::Sample& sample) {
        if (step.trace < 0) return; // an impulse
        for (size_t i = 0; i < sample.points.size(); ++i) {
            const size_t q = i / points.size(), point = i % points.size();
            if (classes[point] == reduced::every_quantity ? counts(Quantity(q))
                                                          : now.trace >= 0 && classes[point] == int(q)) // of a site
                take(q, point, std::abs(sample.points[i]) / (q == QUANTITY_FA2 ? gain : 1));
        }
    };
    Schedule asked = schedule;
    asked.points = points;
    asked.output.extremes = false;
    asked.output.traces.clear();
    const auto stepper = products
                             ? reduced::separable(skin, asked, reduced::moments_of(skin, asked, true, 1), false, sink)
                             : reduced::sites(skin, schedule, needed, classes, 1, sink, false);
    const std::vector<Element> elements = schedule.modes.empty() ? needed.materials : elements_of(skin, schedule);
    model::FrameFeed feed(schedule, skin.width());
    model::Timeline timeline(schedule, elements, skin.rule, Method::exact);
    const long long telling = products && schedule.derives ? telling_outputs(skin, schedule)[QUANTITY_STRAIN] : -1;
    std::vector<std::vector<double>> maps;
    for (model::Step step; timeline.next(step);) {
        feed.before(step, [&](const std::vector<double>& frame) { stepper->frame(frame); });
        const bool reads = step.field >= 0 || step.trace == telling || step.trace + 1 == schedule.outputs;
        now = step;
        if (step.field >= 0) step.trace = std::max(step.trace, 0LL); // a sample too
        stepper->press(step);
        if (telling < 0 || !reads || !counts(Quantity::curvature)) continue;
        stepper->read({Quantity::curvature}, maps); // products have it in no point
        take(size_t(Quantity::curvature), 0, largest_of(maps[0]));
    }
}

} // namespace

Arithmetic arithmetic_of(Precision precision, bool separable, bool spread) {
    const double least = precision == Precision::f64 ? f64::least_stored() : double(f32::least_stored());
    return {.single = precision != Precision::f64,
            .compensated = separable || precision != Precision::f32,
            .separable = separable,
            .spread = spread,
            .stored = least};
}

Peaks measured_peaks(const PreparedSkin& skin, const Schedule& schedule) {
    const bool whole = !schedule.output.traces.empty() || !schedule.output.fields.empty();
    // Between frames the sums for one cell at a depth take as long as many of its steps.
    const size_t most = whole && schedule.framed && schedule.spreads() ? 8 : SIZE_MAX;
    std::vector<Cell> points;
    if (whole) points = telling_cells(skin, schedule);
    points.resize(std::min(points.size(), most));
    const size_t cells = points.size();
    std::vector<int> classes(cells, reduced::every_quantity);
    std::vector<size_t> sites = telling_sites(skin, schedule);
    sites.resize(std::min(sites.size(), most));
    for (size_t i : sites) {
        points.push_back(skin.description.sites[i].cell);
        classes.push_back(int(skin.description.sites[i].type));
    }
    Peaks peaks{};
    if (points.empty()) return peaks;
    solve(skin, schedule, points, classes, [&](size_t q, size_t point, double x) {
        double& peak = (point < cells ? peaks.all : peaks.sites)[q];
        peak = std::max(peak, x);
    });
    double &curvature = peaks.all[size_t(Quantity::curvature)], &deformed = peaks.all[size_t(Quantity::deformation)];
    curvature = std::max(curvature, greatest_rest_curvature(skin)); // of the skin at rest, as at the first output
    const double surface = greatest_surface(skin);
    deformed = std::max(surface, skin.constants.thickness * peaks.all[QUANTITY_STRAIN] - surface);
    return peaks;
}

// The bounds of one analysis. A stress that classes follow has its own, of its elements in series, and the roundings of
// their shares.
static Bounds bounds_of(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind, const Read& read) {
    Bounds all = Analysis(skin, schedule, kind, read).run();
    if (schedule.modes.empty()) return all;
    const Bounds of =
        Analysis(stress_in_series(skin, schedule), schedule, arithmetic_of(Precision::f64, false), read).run();
    for (size_t q = 0; q < schedule.follows.size(); ++q) {
        if (!schedule.follows[q]) continue;
        const double shared = double(schedule.modes.size() + 4) * unit_of_double * of.greatest[q];
        all.error[q] = of.error[q] + shared;
        all.throughout[q] = of.throughout[q] + shared;
        all.greatest[q] = of.greatest[q];
    }
    return all;
}

Bounds bounds_of_cells(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind) {
    return bounds_of(skin, schedule, kind, {.everything = true, .quantity = 0});
}

Bounds bounds_of_sites(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind) {
    Bounds all{};
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
        const std::vector<Site>& sites = skin.description.sites;
        if (std::ranges::none_of(sites, [q](const Site& site) { return int(site.type) == q; })) continue;
        const Bounds of = bounds_of(skin, schedule, kind, {.everything = false, .quantity = q});
        for (Errors Bounds::*bound : {&Bounds::error, &Bounds::throughout, &Bounds::greatest})
            (all.*bound)[size_t(q)] = (of.*bound)[size_t(q)];
    }
    return all;
}

Worst worst_asked(const PreparedSkin& skin, const Schedule& schedule, const Bounds& all, const Bounds& sites,
                  const Peaks& peaks, double stored) {
    const auto& gains = skin.description.receptors.fa2_gains;
    const double gain = std::max(std::abs(gains[0]), std::abs(gains[1]));
    Worst worst;
    const auto count = [&](Quantity q, const Bounds& bounds, const Errors& largest) {
        const double scale = q == Quantity::fa2 ? gain : 1;
        const double off = scale * bounds.error[size_t(q)];
        const double error = off + (q == Quantity::fa2 && off > 0 ? stored : 0);         // flushed after the gains
        if (scale * bounds.greatest[size_t(q)] <= stored && error <= 5 * stored) return; // exact
        // In cells that have come to rest what is measured is a rounding too.
        const double measured = largest[size_t(q)],
                     peak = measured > 2 * bounds.throughout[size_t(q)] ? scale * measured : 0;
        const double before = worst.error;
        raise(worst.error, error / std::max(peak, stored));
        if (worst.error > before) worst.of = q, worst.peak = peak;
    };
    for (Quantity q : schedule.output.traces) count(q, all, peaks.all);
    for (const FieldRequest& f : schedule.output.fields)
        for (Quantity q : f.what) count(q, all, peaks.all);
    for (const Site& site : skin.description.sites) count(site.type, sites, peaks.sites);
    return worst;
}

} // namespace dermis::planner
