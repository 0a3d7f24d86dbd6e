// SPDX-License-Identifier: MIT
#include "host/lab/planner/magnitudes.hpp"

#include "host/core/model/laplacian.hpp"
#include "host/core/model/site_cells.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::planner {

using plan::PreparedSkin;
using plan::Schedule;

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
    Roughness r{weight, 6 * weight};
    if (!skin.uniform() || schedule.framed || peak == 0) return r;
    const Grid unit = plan::without_spacing(skin.description.grid);
    const std::vector<double>& map = schedule.pressure;
    const double bent = skin.constants.bend * largest_of(plan::laplacian(map, unit, skin.stencil, skin.edges));
    r.laplacian = std::min(bent / peak, weight);
    r.roundings = std::min(skin.constants.bend * roundings_of(skin, map) / peak, r.roundings);
    return r;
}

std::vector<PressedMaterial> pressed_materials(const PreparedSkin& skin, const Schedule& schedule, const Read& read) {
    std::vector<PressedMaterial> all;
    for (size_t i = 0; i < skin.materials.size(); ++i) {
        const double peak = schedule.framed ? schedule.material_peaks[i - i % skin.chain.length] : 0;
        all.push_back({skin.materials[i], peak, peak});
    }
    if (schedule.framed) return all;
    const std::vector<double>& p = schedule.pressure;
    const size_t length = skin.chain.length;
    const auto take = [&](size_t i, double PressedMaterial::*peak) {
        double& greatest = all[skin.material_at(i)].*peak;
        greatest = std::max(greatest, std::abs(p[i]));
    };
    std::vector<Cell> points;
    for (const Site& site : skin.description.sites)
        if (int(site.type) == read.quantity) points.push_back(site.cell);
    if (read.everything)
        for (size_t i = 0; i < p.size(); ++i) take(i, &PressedMaterial::peak);
    else
        for (size_t i : plan::SiteCells(skin, pressed_cells(schedule), points).cells) take(i, &PressedMaterial::around);
    for (const Cell& c : points) take(skin.number_of(c), &PressedMaterial::peak);
    for (size_t i = 0; i < all.size(); ++i) { // elements in series bear the same pressure
        const PressedMaterial& first = all[i - i % length];
        all[i].peak = first.peak;
        all[i].around = std::max(first.peak, first.around);
    }
    return all;
}

void take_gains(const PreparedSkin& skin, const Schedule& schedule, const Read& read, bool separable,
                std::vector<PressedMaterial>& materials) {
    const size_t width = size_t(skin.width());
    for (PressedMaterial& m : materials) m.gain = m.value_gain = 0;
    const auto take = [&](size_t i, double rest) {
        PressedMaterial& m = materials[skin.material_at(i)];
        const double pressure = schedule.framed ? m.peak : std::abs(schedule.pressure[i]);
        if (pressure == 0) return;
        const double share = pressure / m.peak, gain = std::abs(1 + skin.constants.curvature_length * rest);
        const bool even = separable || m.around > m.peak; // otherwise rounded by units of binades
        const double of_units = even ? share : std::ldexp(1, std::ilogb(share * (1 + 1e-5)) + 1);
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

} // namespace dermis::planner
