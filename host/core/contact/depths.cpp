// SPDX-License-Identifier: MIT
// Depths become pressure: an elastic foundation.
#include "host/core/base/float_environment.hpp"
#include "host/core/contact/landing.hpp"

#include <limits>

namespace dermis::contact {
namespace {

// The caller's depths.
template <class T> struct DepthRows {
    const T* first;
    size_t pitch;
    int width, height;
    const T* row(int y) const { return first + size_t(y) * pitch; }
};

// The depths above a level. Depths are relative to a reference.
struct Excess {
    double sum = 0;    // m: of these depths
    int64_t cells = 0; // number of these depths
};

template <class T> Excess above(const DepthRows<T>& depths, double reference, double level) {
    double sums[4] = {0, 0, 0, 0};
    int64_t cells[4] = {0, 0, 0, 0};
    for (int y = 0; y < depths.height; ++y) {
        const T* row = depths.row(y);
        each_in_lanes(depths.width, [&](int x, int lane) {
            const double depth = double(row[x]) - reference;
            const bool counts = depth > level;
            sums[lane] += counts ? depth : 0.0;
            cells[lane] += counts;
        });
    }
    return {(sums[0] + sums[1]) + (sums[2] + sums[3]), cells[0] + cells[1] + cells[2] + cells[3]};
}

// Returns the greatest depth. Refuses a depth that is no length. The first loop has no early exit, so that it is fast.
template <class T> double checked_depths(const DepthRows<T>& depths) {
    const auto is_length = [](T depth) { return std::abs(depth) <= T(greatest_length); };
    T greatest[4];
    std::fill_n(greatest, 4, std::numeric_limits<T>::lowest());
    for (int y = 0; y < depths.height; ++y) {
        const T* row = depths.row(y);
        bool bad = false;
        each_in_lanes(depths.width, [&](int x, int lane) {
            bad |= !is_length(row[x]);
            greatest[lane] = row[x] > greatest[lane] ? row[x] : greatest[lane];
        });
        for (int x = 0; x < depths.width && bad; ++x)
            if (!is_length(row[x]))
                scene::refuse("depths.depth[" + std::to_string(x) + ", " + std::to_string(y) + "]",
                              shortest(double(row[x])), "-1e6..1e6");
    }
    return double(*std::max_element(greatest, greatest + 4));
}

// Returns the level, relative to a reference, above which the depths sum up to `target`, by Newton's method. This sum
// is a convex and piecewise linear function of the level. Each step assumes that all cells above the last level count,
// and so never goes too high, whichever level it starts from; from the second step on cells only drop out, until none
// does, or rounding brings one back.
template <class T> double level_of(const DepthRows<T>& depths, double reference, double target) {
    Excess active = above(depths, reference,
                          reference > 0 ? -reference : std::numeric_limits<double>::lowest()); // what the depths say
    for (bool first = true;; first = false) {
        const double level = (active.sum - target) / double(active.cells);
        const Excess next = above(depths, reference, level);
        if (next.cells == active.cells || (!first && next.cells > active.cells)) return level;
        active = next;
    }
}

template <class T> ContactReport add_rows(const Pad& pad, const DepthMap& d, const DepthRows<T>& depths) {
    need_apart("depths.depth", pad, depths.first, depths.row(pad.height - 1) + pad.width);
    const double greatest = checked_depths(depths);
    ContactReport report;
    report.asked = d.force;
    if (d.force == 0) return report;
    // Where a level is looked for, depths are relative to the greatest one, so that little is lost to rounding.
    double reference = 0, level = 0;
    const double area = pad.spacing * pad.spacing;
    if (d.stiffness != 0) {
        reference = greatest;
        level = level_of(depths, reference, std::max(d.force / (d.stiffness * area), 1e-290));
        report.level = reference + level;
    }
    const Excess excess = above(depths, reference, level);
    if (excess.cells == 0) {
        report.outside = d.force;
        return report;
    }
    const double scale = d.force / ((excess.sum - double(excess.cells) * level) * area);
    if (!finite(scale)) scene::refuse("depths.depth", shortest(greatest), "depths that add up to more than 1e-290 m");
    const auto pass = [&](const Tile&, const CellPress& press, ContactReport&) {
        for (int y = 0; y < pad.height; ++y)
            for (int x = 0; x < pad.width; ++x) {
                const double sunk = double(depths.row(y)[x]) - reference - level;
                if (sunk > 0) press(x, y, scale * sunk);
            }
    };
    return press_cells(pad, 1, pass, report);
}

} // namespace

ContactReport add_depths(const Pad& pad, const DepthMap& d) {
    const DefaultFloats guard;
    check(pad);
    need_memory("depths.depth", bool(d.depth));
    need_pitch("depths.pitch", d.pitch, pad.width);
    scene::need_not_negative("depths.force", d.force);
    if (d.stiffness != 0) need_within("depths.stiffness", d.stiffness, 1e-6, 1e30, "1e-6..1e30");
    need_float_pressure(pad, d.force);
    return d.depth.visit([&]<class T>(const T* first) {
        return add_rows<T>(pad, d, {first, d.pitch ? d.pitch : size_t(pad.width), pad.width, pad.height});
    });
}

} // namespace dermis::contact
