// SPDX-License-Identifier: MIT
#include "host/lab/planner/bound.hpp"

#include "host/core/model/laplacian.hpp"
#include "host/lab/planner/counted_run.hpp"
#include "host/lab/planner/magnitudes.hpp"
#include "host/lab/reduced/moments.hpp"
#include "host/lab/reduced/sites.hpp"

#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

namespace dermis::planner {
namespace {

using plan::Element;
using plan::PreparedSkin;
using plan::Schedule;

constexpr size_t some = 64; // cells looked at for the greatest values, at most

// The least |v| that is not 0.
double least_of(const std::vector<double>& map) {
    double least = INFINITY;
    for (double v : map)
        if (v != 0) least = std::min(least, std::abs(v));
    return std::isfinite(least) ? least : 0;
}

// Reduces the materials to a number that the analysis has time and memory for. At a given retardation time errors scale
// with peak/modulus and peak/viscosity, so the materials with the greatest of either represent all materials in a
// narrow range of retardation times.
constexpr size_t ranges = 512;

bool too_many(size_t materials, double steps) {
    constexpr double most_cell_steps = 4e6;
    constexpr size_t most_materials = 65536;
    return materials > 2 * ranges && (materials > most_materials || double(materials) * steps > most_cell_steps);
}

std::vector<PressedMaterial> representatives(std::vector<PressedMaterial> all) {
    const auto rate = [](const PressedMaterial& m) { return std::log(z_of(m.element, 1)); };
    double low = INFINITY, high = -INFINITY; // of rates that are finite
    for (const PressedMaterial& m : all)
        if (std::isfinite(rate(m))) low = std::min(low, rate(m)), high = std::max(high, rate(m));
    const auto by_modulus = [](const PressedMaterial& m) { return final_strain(m.element, m.around); };
    const auto by_viscosity = [](const PressedMaterial& m) { return strain_rate(m.element, m.around); };
    std::vector<const PressedMaterial*> soft(ranges + 2, nullptr), fluid(ranges + 2, nullptr);
    for (const PressedMaterial& m : all) {
        const double r = rate(m); // elastic materials come last, viscous ones first
        const size_t range = !std::isfinite(r) ? (r > 0 ? ranges + 1 : 0)
                             : high > low      ? 1 + std::min(size_t((r - low) / (high - low) * ranges), ranges - 1)
                                               : 1;
        if (!soft[range] || by_modulus(m) > by_modulus(*soft[range])) soft[range] = &m;
        if (!fluid[range] || by_viscosity(m) > by_viscosity(*fluid[range])) fluid[range] = &m;
    }
    std::vector<PressedMaterial> few;
    for (const auto& chosen : {soft, fluid})
        for (const PressedMaterial* m : chosen)
            if (m) few.push_back({m->element, m->around, m->around}); // the others may be read where this one is not
    return few;
}

// Adds up to `some` sites of each class: half of them the most pressed, half spread over all sites.
void add_telling_sites(const PreparedSkin& skin, const Schedule& schedule, std::vector<Cell>& cells,
                       std::vector<int>& classes) {
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
        std::vector<std::pair<double, const Site*>> all;
        for (const Site& site : skin.description.sites)
            if (int(site.type) == q)
                all.push_back({std::abs(schedule.map_of(size_t(q))[skin.number_of(site.cell)]), &site});
        std::ranges::stable_sort(all, [](auto& a, auto& b) { return a.first > b.first; });
        for (size_t i = 0; i < std::min(some, all.size()); ++i) {
            const auto& [pressure, site] = all[i < some / 2 ? i : i * (all.size() - 1) / std::max<size_t>(some - 1, 1)];
            cells.push_back(site->cell);
            classes.push_back(q);
        }
    }
}

// The unit of the roundings that are counted: the reference's, where the run's own roundings are measured.
double counted_unit(const Arithmetic& kind) { return kind.separable ? unit_of_reference : kind.unit(); }

// The materials that an analysis steps, each with the arithmetic of its cell.
struct AnalysedMaterials {
    std::vector<PressedMaterial> pressed;
    std::vector<CountedMaterial> counted; // the same, each with the pressure around what is read as its peak
    std::vector<size_t> ends;             // the end of all of them, or of the materials at each place of a series
    plan::Chain chain;
    std::vector<CountedMaterial> extremes; // of each part, its least and its greatest retardation time
};

// Where elements in series are too many, some elements of each place in the series represent all elements of that
// place, as if they were cells of their own.
void represent(AnalysedMaterials& m) {
    const std::vector<PressedMaterial> all = std::exchange(m.pressed, {});
    for (size_t e = 0; e < m.chain.length; ++e) {
        std::vector<PressedMaterial> of_place;
        for (size_t i = e; i < all.size(); i += m.chain.length) of_place.push_back(all[i]);
        const std::vector<PressedMaterial> few = representatives(of_place);
        m.pressed.insert(m.pressed.end(), few.begin(), few.end());
        m.ends.push_back(m.pressed.size());
    }
    m.chain = {};
}

AnalysedMaterials analysed(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind,
                           const Read& read) {
    AnalysedMaterials m{
        .pressed = pressed_materials(skin, schedule, read), .counted = {}, .ends = {}, .chain = skin.chain};
    take_gains(skin, schedule, read, kind.separable, m.pressed);
    if (too_many(m.pressed.size(), double(schedule.outputs))) represent(m);
    if (m.ends.empty()) m.ends = {m.pressed.size()};
    const double least = schedule.framed ? 0 : least_of(schedule.pressure);
    const double u = counted_unit(kind);
    for (const PressedMaterial& material : m.pressed) {
        const double peak = material.around, read = material.peak > 0 ? material.peak : peak;
        m.counted.push_back(
            {.element = material.element,
             .arithmetic = {.u = u,
                            .peak = kind.separable ? 1 : peak,
                            .single = kind.single,
                            .bound = schedule.framed,
                            .carried = kind.compensated ? 2 * u : 1,
                            .flush = peak > 0 && !kind.separable ? 2 * kind.stored / read : 0,
                            .denormal = kind.single && material.peak > 0 ? 0x1p-150 * peak / material.peak : 0,
                            .least = peak > 0 ? least / read : 0},
             .peak = peak});
    }
    for (size_t i = 0; kind.separable && i < skin.parts.size(); ++i)
        for (const Element& element : {skin.parts[i].low, skin.parts[i].high})
            m.extremes.push_back(
                {.element = element, .arithmetic = m.counted[i].arithmetic, .peak = m.counted[i].peak});
    return m;
}

// The roundings of a mean over all cells, in units of the greatest value: one for each level of a tile's tree that
// joins columns, by the mean of the values' magnitudes. In models of products: the roundings of a sum and of its
// division.
double units_of_mean(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind) {
    if (kind.separable) return 2;
    const int columns = std::min(skin.width(), TILE_CELLS);
    const double levels = double(std::bit_width(unsigned(columns - 1)));
    if (schedule.framed || !skin.uniform()) return levels;
    double sum = 0;
    for (double p : schedule.pressure) sum += std::abs(p);
    const double mean = (1 + 1e-6) * sum / double(skin.cells());
    return sum > 0 ? levels * std::min(1.0, mean / largest_of(schedule.pressure)) : levels;
}

// The error of the curvature at rest: of the Laplacian of the heights, four roundings in double, and two to float.
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

    bool at(const plan::Step& step, Quantity q) const {
        return (step.trace >= 0 && rows_[size_t(q)]) || (step.field >= 0 && fields_[size_t(step.field)][size_t(q)]);
    }
    bool mean(const plan::Step& step, Quantity q) const { return step.trace >= 0 && means_[size_t(q)]; }

  private:
    using Quantities = std::array<bool, std::tuple_size_v<Errors>>;
    Quantities rows_{}, means_{};
    std::vector<Quantities> fields_;
};

// The material of a uniform skin, pressed by what acts at the depth of a class, and how far that is off, relative to
// its greatest value.
struct DeepMaterial {
    PressedMaterial pressed;
    double off = 0;
};

// Of each class that has a half-space and is read.
std::array<std::optional<DeepMaterial>, REDUCED_MAPS> deep_materials(const PreparedSkin& skin, const Schedule& schedule,
                                                                     const Arithmetic& kind, const Read& read) {
    std::array<std::optional<DeepMaterial>, REDUCED_MAPS> deep;
    for (size_t q = 0; q < deep.size(); ++q) {
        if (!schedule.half_space[q] || !(read.everything || read.quantity == int(q))) continue;
        const plan::HalfSpace& space = *schedule.half_space[q];
        Schedule as = schedule;
        as.pressure = schedule.map_of(q);
        for (double& peak : as.material_peaks) peak *= space.norm();
        std::vector<PressedMaterial> materials = pressed_materials(skin, as, read);
        take_gains(skin, as, read, kind.separable, materials);
        DeepMaterial m{.pressed = materials.front()};
        const double peak = m.pressed.peak;
        m.pressed.around = 2 * peak; // its roundings are not those of the cell that is counted
        m.off = unit_of_double;
        if (schedule.framed) m.off += space.roundings<double>();
        else if (peak > 0) m.off += error_of_stresses(schedule.pressure, skin.description.grid, space) / peak;
        deep[q] = m;
    }
    return deep;
}

// The running analysis of one cell of each material, step by step.
class Analysis {
  public:
    Analysis(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind, const Read& read)
        : skin_(skin), schedule_(schedule), kind_(kind), u_(kind.unit()),
          last_(kind.compensated ? counted_unit(kind) : 0), l_(std::abs(skin.constants.curvature_length)),
          weight_(skin.constants.bend * weight_of(skin.stencil)), rest_(rest_peak(skin, schedule, !read.everything)),
          d_rest_(error_at_rest(skin, kind, rest_)), surface_(greatest_surface(skin)),
          unit_(kind.separable ? plan::unit_of(schedule.pressure) : 1),
          units_of_mean_(units_of_mean(skin, schedule, kind)), units_of_gains_(units_of_gains(skin, kind)),
          written_(schedule, read), materials_(analysed(skin, schedule, kind, read)),
          deep_(deep_materials(skin, schedule, kind, read)),
          rough_(roughness_of(
              skin, schedule,
              schedule.framed ? 1 : std::ranges::max(materials_.pressed, {}, &PressedMaterial::around).around)),
          run_(schedule, materials_.counted, skin.rule, schedule.method, materials_.chain, kind.separable) {
        if (schedule.method != Method::exact)
            exact_.emplace(schedule, materials_.counted, skin.rule, Method::exact, materials_.chain);
        if (!materials_.extremes.empty()) extremes_.emplace(schedule, materials_.extremes, skin.rule, schedule.method);
    }

    Bounds run() {
        while (run_.next()) {
            if (exact_) exact_->next(); // a baseline has its fields at outputs, so that both read the same times
            if (extremes_) extremes_->next();
            widen();
        }
        return bounds_;
    }

  private:
    // The distance of the method from the exact one, per unit of pressure; 0 for the exact method itself. A part adds
    // the spread of its retardation times and the rounding of pressure over resistance.
    double truncation(size_t i, int q) const {
        const double x = run_.cells()[i].value(q), method = exact_ ? std::abs(x - exact_->cells()[i].value(q)) : 0;
        if (!extremes_) return method;
        const std::vector<CountedCell>& of = extremes_->cells();
        return method + std::abs(of[2 * i].value(q) - of[2 * i + 1].value(q)) + 0x1p-53 * std::abs(x);
    }

    // A quantity of one cell under the greatest pressure on it, or around it: of its element, or summed over its
    // elements in series.
    struct BoundedSum {
        double value = 0, magnitude = 0; // the sum; the sum of magnitudes
        double off = 0;                  // error of the sum
        double gain = INFINITY;          // greatest gain at rest of the error, where it is all rounding
        double value_gain = INFINITY;    // greatest gain at rest of the value
    };
    BoundedSum sum_of(size_t first, int q, bool around) const {
        BoundedSum s;
        const DeepMaterial* deep = !around && deep_[size_t(q)] ? &*deep_[size_t(q)] : nullptr;
        const PressedMaterial& m = deep ? deep->pressed : materials_.pressed[first];
        const size_t length = materials_.chain.length;
        const double peak = around ? m.around : m.peak, share = peak < m.around ? peak / m.around : 1;
        double error = 0, shift = 0, truncated = 0;
        for (size_t i = first; i < first + length; ++i) {
            const Counted& of = run_.cells()[i].signal(q);
            s.value += peak * of.value;
            s.magnitude += peak * std::abs(of.value);
            error += of.off;
            shift += of.shift;
            truncated += truncation(i, q);
        }
        if (!run_.cells()[first].flushed && (kind_.separable || !kind_.compensated)) s.gain = m.gain;
        s.value_gain = m.value_gain;
        if (deep) s.off += deep->off * s.magnitude;
        if (q <= QUANTITY_SA2) s.off += last_ * s.magnitude; // compensated, it is off by the last rounding of its value
        // Half a unit in the last place of a smaller value is up to twice as much of it.
        s.off += peak * ((share < 1 && !kind_.separable ? 2 : 1) * error + std::abs(shift) + truncated);
        if (!schedule_.framed) s.off += rounding_of(peak, share) * std::abs(s.value);
        // Strains in series are added up here; for other quantities, the counted arithmetic contains the kernel's sums.
        if (kind_.separable) s.off += peak * run_.measured(first / length, q);
        else if (q <= QUANTITY_SA1 && s.magnitude > 0) s.off += double(length - 1) * (u_ * s.magnitude + kind_.stored);
        return s;
    }

    // The sums of every cell; where some elements represent all, one sum that no cell exceeds.
    std::vector<BoundedSum> sums_of(int q, bool around) const {
        std::vector<BoundedSum> all;
        for (size_t i = 0; i < materials_.ends.front(); i += materials_.chain.length)
            all.push_back(sum_of(i, q, around));
        const std::vector<size_t>& ends = materials_.ends;
        if (ends.size() == 1) return all;
        BoundedSum together;
        for (size_t place = 0, i = 0; place < ends.size(); ++place) {
            BoundedSum most;
            for (; i < ends[place]; ++i) {
                const BoundedSum s = sum_of(i, q, around);
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

    // Takes the errors at the end of a step that is read.
    void widen() {
        double strain = 0, d_strain = 0;
        for (const BoundedSum& eps : sums_of(QUANTITY_STRAIN, true)) {
            raise(strain, eps.magnitude);
            raise(d_strain, eps.off);
        }
        const double bent = l_ * rough_.laplacian * strain, gain = 1 + l_ * rest_ + bent;
        const double d_C = weight_ * d_strain + d_rest_ + u_ * (rough_.laplacian + rough_.roundings) * strain;
        for (int q = 0; q < REDUCED_MAPS; ++q)
            for (const BoundedSum& of : sums_of(q, false)) {
                const double x = std::abs(of.value), greatest = q == QUANTITY_STRAIN ? x : x * gain;
                const double stored = x == 0 || kind_.separable ? 0 : kind_.stored;
                const double run = x + of.off, value = run * std::min(of.value_gain + bent, gain); // of the response
                const double of_gains = q == QUANTITY_FA2 ? units_of_gains_ * u_ * value : 0;
                const double rounded =
                    of_gains + (kind_.separable ? rounding_of_product(run, run * of.value_gain, bent, value)
                                                : rounding(run, gain, value));
                const double error = q == QUANTITY_STRAIN ? of.off + stored + (kind_.separable ? u_ * run : 0)
                                                          : of.off * std::min(of.gain + bent, gain) + run * l_ * d_C +
                                                                rounded + 2 * stored;
                const double sum = x * gain * (written_.mean(run_.step(), Quantity(q)) ? double(skin_.cells()) : 1);
                take(Quantity(q), greatest, sum < (kind_.single ? 3e38 : 1e308) ? error : INFINITY);
            }
        take_shape(strain, d_strain, d_C);
    }

    // Takes a value of a quantity at the end of the step, and its error.
    void take(Quantity q, double value, double error) {
        const size_t i = size_t(q);
        raise(bounds_.greatest[i], value);
        raise(bounds_.throughout[i], error);
        if (!written_.at(run_.step(), q)) return;
        raise(bounds_.error[i], error);
        if (written_.mean(run_.step(), q)) raise(bounds_.error[i], error + units_of_mean_ * u_ * (value + error));
    }

    // Takes curvature and deformation under a strain.
    void take_shape(double strain, double d_strain, double d_C) {
        const double parts = double(std::max<size_t>(skin_.parts.size(), 1)), bent = rough_.laplacian * strain;
        const double indented = skin_.constants.thickness * strain;
        take(Quantity::curvature, rest_ + bent, d_C + parts * u_ * (rest_ + bent) + kind_.stored);
        take(Quantity::deformation, surface_ + indented,
             skin_.constants.thickness * d_strain + 2 * u_ * (surface_ + indented) + kind_.stored);
    }

    double half_unit(double x) const { return x > 0 ? std::ldexp(u_, std::ilogb(x * (1 + 1e-5))) : 0; }

    // Returns how far pressures are off, relative to the greatest one: the map is rounded in double, and to float.
    double rounding_of(double peak, double share) const {
        const double units = kind_.separable || share < 1 || peak == 0 ? u_ : half_unit(peak) / peak;
        const double stored = (kind_.single ? 0x1p-149 : 0x1p-1074 * unit_) / peak; // a smaller one is a multiple of it
        return units + (kind_.single ? 0x1p-53 : 0) + (peak > 0 ? stored : 0);
    }

    // The roundings of a response, which is the product of a signal x and its gain: of the curvature times a length, of
    // the gain and of the product.
    double rounding(double x, double gain, double response) const {
        return (kind_.single ? 2 : 1) * u_ * x * (gain - 1) + std::min(x * half_unit(gain), u_ * response) +
               half_unit(response);
    }

    // The roundings of a response by products, x*(a - sum of g*b) per unit of pressure: two of a, the response at rest,
    // and one of its length; four of each g*b, which the strain adds; one of each difference; one of the product.
    double rounding_of_product(double x, double at_rest, double bent, double response) const {
        const double parts = double(skin_.parts.size());
        const double differences = parts > 1 ? parts * (at_rest + x * bent) : response;
        return u_ * (2 * at_rest + x * l_ * rest_ + 4 * x * bent + differences + response);
    }

    const PreparedSkin& skin_;
    const Schedule& schedule_;
    const Arithmetic kind_;
    const double u_;
    const double last_; // of a value: the last rounding, where earlier ones are compensated
    const double l_, weight_, rest_, d_rest_, surface_; // d_rest_: what L(S) is off by; surface_: greatest |S|
    const double unit_;                                 // Pa: of the run's map
    const double units_of_mean_, units_of_gains_;
    const Written written_;
    const AnalysedMaterials materials_;
    const std::array<std::optional<DeepMaterial>, REDUCED_MAPS> deep_;
    const Roughness rough_;
    CountedRun run_;                  // by the method
    std::optional<CountedRun> exact_; // beside a baseline
    std::optional<CountedRun> extremes_;
    Bounds bounds_{};
};

// The exact solution in some points, step by step; take(quantity, point, |X|).
template <class Take>
void solve(const PreparedSkin& skin, const Schedule& schedule, const std::vector<Cell>& points,
           const std::vector<int>& classes, Take take) {
    const plan::SiteCells needed(skin, pressed_cells(schedule), points);
    const bool product = !schedule.modes.empty() && !schedule.framed; // it has FA2 with its gain
    const bool gained = product && skin.constants.gain_plus != 0;
    const double gain = gained ? std::abs(skin.constants.gain_plus) : 1;
    const auto sink = [&](auto&, const plan::Sample& sample) {
        for (size_t i = 0; i < sample.points.size(); ++i)
            take(i / points.size(), i % points.size(),
                 std::abs(sample.points[i]) / (i / points.size() == QUANTITY_FA2 ? gain : 1));
    };
    Schedule asked = schedule;
    asked.points = points;
    asked.output.extremes = false;
    const auto stepper = product
                             ? reduced::separable(skin, asked, reduced::moments_of(skin, asked, true, 1), false, sink)
                             : reduced::sites(skin, schedule, needed, classes, 1, sink, false);
    const std::vector<Element> elements = schedule.modes.empty() ? needed.materials : elements_of(skin, schedule);
    plan::FrameFeed feed(schedule, skin.width());
    plan::Timeline timeline(schedule, elements, skin.rule, Method::exact);
    for (plan::Step step; timeline.next(step);) {
        feed.before(step, [&](const std::vector<double>& frame) { stepper->frame(frame); });
        stepper->press(step);
    }
}

} // namespace

Arithmetic arithmetic_of(Precision precision, bool separable) {
    const double least = precision == Precision::f64 ? f64::least_stored() : double(f32::least_stored());
    return {.single = precision != Precision::f64,
            .compensated = separable || precision != Precision::f32,
            .separable = separable,
            .stored = least};
}

std::vector<Cell> telling_cells(const PreparedSkin& skin, const Schedule& schedule) {
    const std::vector<double>& p = schedule.pressure;
    const size_t width = size_t(skin.width());
    const auto element = [&](size_t i) -> const Element& { return skin.materials[skin.material_at(i)]; };
    std::vector<size_t> chosen;
    const auto choose = [&](size_t count, auto measure) {
        std::vector<std::pair<double, size_t>> best; // the greatest ones, the least of them first
        const auto later = std::greater<std::pair<double, size_t>>();
        for (size_t i = 0; i < p.size(); ++i) {
            const double m = measure(i);
            if (!(m > 0) || (best.size() == count && m <= best.front().first)) continue;
            if (best.size() == count) std::pop_heap(best.begin(), best.end(), later), best.pop_back();
            best.push_back({m, i});
            std::push_heap(best.begin(), best.end(), later);
        }
        for (const auto& [m, i] : best) chosen.push_back(i);
    };
    const size_t count = skin.uniform() ? 4 : some / 2;
    choose(count, [&](size_t i) { return final_strain(element(i), std::abs(p[i])); });
    choose(count, [&](size_t i) { return strain_rate(element(i), std::abs(p[i])); });
    const size_t more = std::min(some, p.size());
    for (size_t i = 0; i < more; ++i) chosen.push_back((2 * i + 1) * p.size() / (2 * more));
    std::vector<Cell> cells;
    for (size_t i : chosen) cells.push_back({int(i % width), int(i / width)});
    return cells;
}

Peaks measured_peaks(const PreparedSkin& skin, const Schedule& schedule) {
    const bool whole = !schedule.output.traces.empty() || !schedule.output.fields.empty();
    std::vector<Cell> points;
    if (whole) points = telling_cells(skin, schedule);
    const size_t cells = points.size();
    std::vector<int> classes(cells, reduced::every_quantity);
    add_telling_sites(skin, schedule, points, classes);
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

// The bounds of one analysis. A stress that classes follow is a sum of elements, some of them less than 0: what these
// are off together is bounded by the elements in series, stepped cell by cell, and by the roundings of their shares.
static Bounds bounds_of(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind, const Read& read) {
    Bounds all = Analysis(skin, schedule, kind, read).run();
    if (schedule.modes.empty()) return all;
    std::vector<KelvinVoigt> elements;
    for (size_t i = 0; i < schedule.modes.size(); ++i) {
        const double share = std::abs(schedule.shares[i]);
        elements.push_back({schedule.modes[i].modulus / share, schedule.modes[i].viscosity / share});
    }
    Material material = skin.description.material;
    scene::take_chain(material, elements);
    const Bounds of =
        Analysis(with_material(skin, material), schedule, arithmetic_of(Precision::f64, false), read).run();
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

double worst_asked(const PreparedSkin& skin, const Schedule& schedule, const Bounds& all, const Bounds& sites,
                   const Peaks& peaks, double stored) {
    const auto& gains = skin.description.receptors.fa2_gains;
    const double gain = std::max(std::abs(gains[0]), std::abs(gains[1]));
    double worst = 0;
    const auto count = [&](Quantity q, const Bounds& bounds, const Errors& largest) {
        const double scale = q == Quantity::fa2 ? gain : 1;
        const double flushed = q == Quantity::fa2 ? stored : 0; // after the gains
        const double error = scale * bounds.error[size_t(q)] + flushed;
        if (scale * bounds.greatest[size_t(q)] <= stored && error <= 5 * stored) return; // exact
        raise(worst, error / std::max(scale * largest[size_t(q)], stored));
    };
    for (Quantity q : schedule.output.traces) count(q, all, peaks.all);
    for (const FieldRequest& f : schedule.output.fields)
        for (Quantity q : f.what) count(q, all, peaks.all);
    for (const Site& site : skin.description.sites) count(site.type, sites, peaks.sites);
    return worst;
}

} // namespace dermis::planner
