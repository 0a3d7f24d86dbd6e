// SPDX-License-Identifier: MIT
#include "host/lab/planner/magnitudes.hpp"

#include "host/core/model/laplacian.hpp"
#include "host/core/model/site_cells.hpp"
#include "host/lab/schedule/cell.hpp"
#include "host/lab/schedule/timeline.hpp"

#include <algorithm>
#include <functional>

namespace dermis::planner {

using model::PreparedSkin;
using model::Schedule;

double weight_of(int stencil) {
    if (stencil == STENCIL_FIVE_POINT) return 8;
    return stencil == STENCIL_FOURTH_ORDER ? 32.0 / 3 : 4;
}

double largest_of(const std::vector<double>& map) {
    double largest = 0;
    for (double v : map) largest = std::max(largest, std::abs(v));
    return largest;
}

size_t greatest_cell(const std::vector<double>& map) {
    const auto less = [](double a, double b) { return std::abs(a) < std::abs(b); };
    return size_t(std::ranges::max_element(map, less) - map.begin());
}

double rest_peak(const PreparedSkin& skin, const Schedule& schedule, bool points_only) {
    if (!points_only) return greatest_rest_curvature(skin);
    double largest = 0;
    for (const Cell& c : schedule.points) largest = std::max(largest, std::abs(rest_curvature_at(skin, c)));
    return largest;
}

double roundings_of(const PreparedSkin& skin, const std::vector<double>& map) {
    const size_t width = size_t(skin.width()), height = size_t(skin.height());
    const bool periodic = skin.edges == EDGES_PERIODIC, fourth_order = skin.stencil == STENCIL_FOURTH_ORDER;
    double across = 0, down = 0; // greatest differences of neighbours
    for (size_t y = 0; y < height; ++y) {
        const double *row = map.data() + y * width, *next = y + 1 < height ? row + width : periodic ? map.data() : row;
        for (size_t x = 0; x + 1 < width; ++x) across = std::max(across, std::abs(row[x + 1] - row[x]));
        if (periodic) across = std::max(across, std::abs(row[0] - row[width - 1]));
        for (size_t x = 0; x < width; ++x) down = std::max(down, std::abs(next[x] - row[x]));
    }
    return (fourth_order ? 6 * 3 : 3 * 2) * (across + down);
}

Roughness roughness_of(const PreparedSkin& skin, const Schedule& schedule, double peak) {
    const double weight = skin.constants.bend * weight_of(skin.stencil);
    Roughness r{weight, 6 * weight, weight};
    // If numbers of a map, or retardation times in one part, differ before they are rounded, their errors are unequal.
    const auto equal = [](const Map& m) { return std::ranges::adjacent_find(m, std::not_equal_to()) == m.end(); };
    const bool even = equal(schedule.pressure) && !schedule.load.map.empty() && equal(schedule.load.map);
    if (skin.cells() == 1 || (skin.uniform() && skin.parts.empty() && !schedule.framed && even)) return {};
    if (skin.uniform() && schedule.frame_roughness && peak > 0)
        r.laplacian = std::min(skin.constants.bend * *schedule.frame_roughness * largest_of(schedule.pressure) / peak,
                               r.laplacian);
    if (!skin.uniform() || schedule.framed || peak == 0) return r;
    const Grid unit = model::without_spacing(skin.description.grid);
    const std::vector<double>& map = schedule.pressure;
    const double bent = skin.constants.bend * largest_of(model::laplacian(map, unit, skin.stencil, skin.edges));
    r.laplacian = std::min(bent / peak, weight);
    r.roundings = std::min(skin.constants.bend * roundings_of(skin, map) / peak, r.roundings);
    return r;
}

std::vector<PressedMaterial> pressed_materials(const PreparedSkin& skin, const Schedule& schedule, const Read& read) {
    std::vector<PressedMaterial> all;
    for (const model::Element& element : skin.materials) all.push_back({.element = element});
    const std::vector<double>& p = schedule.pressure;
    const size_t length = skin.chain.length;
    const auto take = [&](size_t i, double PressedMaterial::*peak) {
        double& greatest = all[skin.material_at(i)].*peak;
        greatest = std::max(greatest, std::abs(p[i]));
    };
    std::vector<Cell> points;
    for (const Site& site : skin.description.sites)
        if (int(site.type) == read.quantity) points.push_back(site.cell);
    model::PressedCells around = pressed_cells(schedule);
    around.spread = true; // another product may press a point that this one does not
    if (read.everything)
        for (size_t i = 0; i < p.size(); ++i) take(i, &PressedMaterial::peak);
    else
        for (size_t i : model::SiteCells(skin, around, points).cells) take(i, &PressedMaterial::around);
    for (const Cell& c : points) take(skin.number_of(c), &PressedMaterial::peak);
    for (size_t i = 0; i < all.size(); ++i) { // elements in series bear the same pressure
        const PressedMaterial& first = all[i - i % length];
        all[i].peak = first.peak;
        all[i].around = std::max(first.peak, first.around);
    }
    return all;
}

void take_gains(const PreparedSkin& skin, const Schedule& schedule, const Read& read, const Arithmetic& kind,
                std::vector<PressedMaterial>& materials) {
    const size_t width = size_t(skin.width());
    for (PressedMaterial& m : materials) m.gain = m.value_gain = 0;
    const auto take = [&](size_t i, double rest) {
        PressedMaterial& m = materials[skin.material_at(i)];
        const double pressure = schedule.framed ? m.peak : std::abs(schedule.pressure[i]);
        if (pressure == 0) return;
        const double share = pressure / m.peak, gain = std::abs(1 + skin.constants.curvature_length * rest);
        const bool even = kind.separable || m.around > m.peak;  // otherwise rounded by units of binades
        const bool denormal = kind.single && m.peak < 0x1p-100; // all are rounded to the same unit
        const double of_units = denormal ? 1 : even ? share : std::ldexp(1, std::ilogb(share * (1 + 1e-5)) + 1);
        m.gain = std::max(m.gain, std::min(of_units, 1.0) * gain);
        m.value_gain = std::max(m.value_gain, share * gain);
    };
    if (!read.everything) {
        for (const Site& site : skin.description.sites)
            if (int(site.type) == read.quantity) take(skin.number_of(site.cell), rest_curvature_at(skin, site.cell));
        return;
    }
    std::vector<double> rest(width);
    for (size_t y = 0; y < size_t(skin.height()); ++y) {
        const double* row = schedule.framed ? nullptr : schedule.pressure.data() + y * width;
        if (row && std::all_of(row, row + width, [](double p) { return p == 0; })) continue;
        rest_curvature_row(skin, int(y), 0, int(width), rest.data());
        for (size_t x = 0; x < width; ++x) take(y * width + x, rest[x]);
    }
}

namespace {

using Numbers = std::vector<size_t>;

// The numbers below `count` with the greatest measures above 0, up to `most`, the greatest first.
template <class Measure> Numbers greatest(size_t most, size_t count, Measure measure) {
    std::vector<std::pair<double, size_t>> best; // the least of them first
    const auto later = std::greater<std::pair<double, size_t>>();
    for (size_t i = 0; i < count; ++i) {
        const double m = measure(i);
        if (!(m > 0) || (best.size() == most && m <= best.front().first)) continue;
        if (best.size() == most) std::pop_heap(best.begin(), best.end(), later), best.pop_back();
        best.push_back({m, i});
        std::push_heap(best.begin(), best.end(), later);
    }
    std::sort_heap(best.begin(), best.end(), later);
    Numbers numbers;
    for (const auto& [m, i] : best) numbers.push_back(i);
    return numbers;
}

// Above 0, up to 1. The cells where it is greatest lie evenly over any part of a skin: its factors are two powers of
// the plastic number, so that no width makes columns of these cells.
double turn(size_t cell, size_t width) {
    const double way = 0.7548776662466927 * double(cell % width) + 0.5698402909980532 * double(cell / width);
    return 1 - (way - std::floor(way));
}

// The first of each list, then the second of each, and so on; each number once.
Numbers in_turn(const std::vector<Numbers>& lists) {
    Numbers all;
    for (size_t i = 0, longest = std::ranges::max(lists, {}, [](auto&list) { return list.size(); }).size(); i < longest;
         ++i)
        for (const Numbers& list : lists)
            if (i < list.size() && std::ranges::find(all, list[i]) == all.end()) all.push_back(list[i]);
    return all;
}

} // namespace

std::vector<Cell> telling_cells(const PreparedSkin& skin, const Schedule& schedule) {
    const size_t width = size_t(skin.width()), count = skin.cells(), few = skin.uniform() ? 4 : 32;
    const auto element = [&](size_t i) -> const model::Element& { return skin.materials[skin.material_at(i)]; };
    std::vector<Numbers> lists;
    for (size_t k = 0; k < schedule.products(); ++k) {
        const std::vector<double>& p = schedule.product(k).pressure;
        const std::vector<double> bent =
            model::laplacian(p, model::without_spacing(skin.description.grid), skin.stencil, skin.edges);
        lists.push_back(greatest(few, count, [&](size_t i) { return final_strain(element(i), std::abs(p[i])); }));
        lists.push_back(greatest(few, count, [&](size_t i) { return strain_rate(element(i), std::abs(p[i])); }));
        lists.push_back(greatest(4, count, [&](size_t i) { return std::abs(bent[i]); }));
        lists.push_back(greatest(48, count, [&](size_t i) { return p[i] != 0 ? turn(i, width) : 0; }));
    }
    if (schedule.framed) lists.push_back({schedule.changed_most});
    lists.push_back(greatest(16, count, [&](size_t i) { return turn(i, width); }));
    std::vector<Cell> cells;
    for (size_t i : in_turn(lists)) cells.push_back({int(i % width), int(i / width)});
    return cells;
}

std::vector<size_t> telling_sites(const PreparedSkin& skin, const Schedule& schedule) {
    const std::vector<Site>& sites = skin.description.sites;
    const auto turn_of = [&](size_t i) { return turn(skin.number_of(sites[i].cell), size_t(skin.width())); };
    std::vector<Numbers> lists;
    for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
        const auto is_of = [&](size_t i) { return size_t(sites[i].type) == q; };
        const auto pressure = [&](size_t i) {
            double sum = 0;
            for (size_t k = 0; is_of(i) && k < schedule.products(); ++k)
                sum += std::abs(schedule.product(k).map_of(q)[skin.number_of(sites[i].cell)]);
            return sum;
        };
        lists.push_back(greatest(32, sites.size(), pressure));
        lists.push_back(greatest(24, sites.size(), [&](size_t i) { return pressure(i) > 0 ? turn_of(i) : 0; }));
        lists.push_back(greatest(8, sites.size(), [&](size_t i) { return is_of(i) ? turn_of(i) : 0; }));
    }
    return in_turn(lists);
}

std::array<long long, REDUCED_MAPS> telling_outputs(const PreparedSkin& skin, const Schedule& schedule) {
    std::array<long long, REDUCED_MAPS> outputs{};
    if (schedule.framed) {
        const auto after = [&](const std::vector<double>& of_frames, long long frames) {
            const double frame = double(std::ranges::max_element(of_frames) - of_frames.begin() + frames);
            const double output = std::ceil(frame * *schedule.load.interval / schedule.time.step);
            return std::min(static_cast<long long>(std::min(output, 1e18)), schedule.outputs - 1);
        };
        outputs.fill(after(schedule.frame_peaks, 0));
        if (!schedule.frame_changes.empty())
            outputs[QUANTITY_FA1] = outputs[QUANTITY_FA2] = after(schedule.frame_changes, 1);
        return outputs;
    }
    const Schedule few = with_fewer_outputs(schedule, 512);
    const size_t most = greatest_cell(schedule.pressure);
    const auto first = skin.materials.begin() + std::ptrdiff_t(skin.material_at(most));
    const std::vector<model::Element> elements(first, first + std::ptrdiff_t(skin.chain.length));
    model::ProductCell<f64> cell(skin.chain, elements.data(), schedule.time.duration);
    std::vector<f64::Coefficients> table;
    model::Timeline timeline(few, elements, skin.rule, few.every == 1 ? schedule.method : Method::exact);
    std::array<double, REDUCED_MAPS> largest{};
    for (model::Step step; timeline.next(step);) {
        if (!step.keep) continue;
        model::fill_table<f64>(step, elements, skin.chain, skin.rule, table);
        cell.press(f64::load(step.start, step.rise, step.jump), table.data());
        cell.keep();
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            const double signal = std::abs(cell.signal(int(q)));
            if (signal > largest[q] && step.trace >= 0) largest[q] = signal, outputs[q] = step.trace * few.every;
        }
    }
    return outputs;
}

} // namespace dermis::planner
