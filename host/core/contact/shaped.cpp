// SPDX-License-Identifier: MIT
// Pads that are pressed by the shapes of bodies.
#include "host/core/contact/touch.hpp"

namespace dermis::contact {
namespace {

bool is_before(const Shaped* s, int body) { return s->body < body; }
bool is_below(double depth) { return depth > 0.5 * not_below; }

// Whether a patch may end where the body does. Round bodies press patches that end before that.
bool has_outline(const Body& b) { return b.kind == Body::Kind::box || b.kind == Body::Kind::cylinder; }

// A body whose faces are moved outwards (sign 1) or inwards (-1) by half the extent of a cell; nothing if none is left.
std::optional<Body> resized(const Laid& l, int sign) {
    const Vector half = l.lines.half_cell();
    Body made = l.shape;
    if (made.kind == Body::Kind::cylinder)
        made.size[0] += sign * std::max(half[0], half[1]), made.size[1] += sign * half[2];
    else
        for (size_t k = 0; k < 3; ++k) made.size[k] += sign * half[k];
    if (std::ranges::any_of(made.size, [](double size) { return size < 0; })) return {};
    return made;
}

// Whether a body with an outline is below all cells of a flat pad, with half a cell to spare: its shadow is convex.
bool covers(Laid& l, const Pad& pad, const Region& r) {
    const std::optional<Body> less = resized(l, -1);
    if (pad.radius_x != 0 || pad.radius_y != 0 || !less) return false;
    Places corners;
    for (const int x : {r.columns.first, r.columns.last})
        for (const int y : {r.rows.first, r.rows.last}) corners.add(x, y);
    double depth[4];
    std::fill_n(depth, 4, not_below);
    l.lines.deepen(*less, corners, depth);
    return std::ranges::all_of(depth, is_below);
}

} // namespace

// Lays the shapes of a body below the cells of a pad, and around it if that is asked for. asked: m, the sum of excesses
// of the press, from which it is known which outlines may be pressed. Returns whether the shapes are below any cell.
bool Touch::Impl::lay(int number, int body, bool goes_on, double asked) {
    const std::array<int, 4> more = goes_on ? around : std::array<int, 4>{};
    bed.resize(shape.width + more[0] + more[1], shape.height + more[2] + more[3], more[0], more[2]);
    // Cells whose centres are on the finger.
    const auto& a = source.around;
    const Region all{within(-a[0] / shape.spacing - 0.5, shape.width + a[1] / shape.spacing - 0.5,
                            {-more[0], shape.width + more[1] - 1}),
                     within(-a[2] / shape.spacing - 0.5, shape.height + a[3] / shape.spacing - 0.5,
                            {-more[2], shape.height + more[3] - 1})};
    laid.clear();
    const auto own = shapes.of(size_t(number));
    const Pose pose = poses[size_t(number)].from_middle(shape);
    bool outlines = false;
    for (auto s = std::lower_bound(own.begin(), own.end(), body, is_before); s != own.end() && (*s)->body == body;
         ++s) {
        laid.push_back({(*s)->shape, Lines(shape, pose, (*s)->shape.pose)});
        outlines = outlines || has_outline((*s)->shape);
        if (!all.empty())
            laid.back().lines.deepen(laid.back().shape, all.block(bed.pitch),
                                     &bed.deep[bed.number(all.columns.first, all.rows.first)]);
    }
    const bool lies = bed.settle(true);
    if (!outlines) return lies;
    const double level = lies ? level_of(bed, asked) : 0;
    return lay_outlines(all, lies ? bed.deepest - 4 * level : not_below) || lies;
}

// Gives cells through which an outline runs, which is deeper than `least`, their shares and their mean depths. Returns
// whether there are any.
bool Touch::Impl::lay_outlines(const Region& all, double least) {
    // Where cells may be pressed, and a cell more. A body less than about a cell thick may be between the cells'
    // centres.
    Region near{{all.columns.last, all.columns.first}, {all.rows.last, all.rows.first}};
    for (int y = all.rows.first; y <= all.rows.last; ++y) {
        const double* row = &bed.deep[bed.number(0, y)];
        int first = all.columns.first, last = all.columns.last;
        while (first <= last && !(row[first] > least)) ++first;
        while (last > first && !(row[last] > least)) --last;
        if (first <= last) near.add(first, y), near.add(last, y);
    }
    near = near.grown(all);
    std::vector<std::array<int, 2>>& cells = edges;
    cells.clear();
    for (Laid& l : laid) {
        if (!has_outline(l.shape)) continue;
        const std::optional<Body> more = resized(l, 1), less = resized(l, -1);
        const Region& where = less ? near : all;
        if (where.empty() || covers(l, shape, where)) continue;
        const CellBlock block = where.block(size_t(where.columns.last - where.columns.first + 1));
        for (auto* depths : {&outer, &inner}) depths->assign(block.pitch * size_t(block.rows), not_below);
        l.lines.deepen(*more, block, outer.data());
        if (less) l.lines.deepen(*less, block, inner.data());
        for (size_t i = 0; i < outer.size(); ++i)
            if (is_below(outer[i]) && outer[i] > least && !is_below(inner[i]))
                cells.push_back({block.x + int(i % block.pitch), block.y + int(i / block.pitch)});
    }
    constexpr size_t at_once = Places::most / 16;
    for (size_t i = 0; i < cells.size(); i += at_once)
        share_out(std::span(cells).subspan(i, std::min(at_once, cells.size() - i)));
    return !cells.empty() && bed.settle(false);
}

// Gives cells the share of 16 places in each that the body is below, and the mean depth there. No two places of a cell
// have the same x or y, so that an outline along the cells does not move in steps of a quarter.
void Touch::Impl::share_out(std::span<const std::array<int, 2>> cells) {
    Places places;
    for (const auto& [x, y] : cells)
        for (int a = 0; a < 16; ++a) {
            const int b = (a & 1) << 3 | (a & 2) << 1 | (a & 4) >> 1 | a >> 3; // a with its bits reversed
            places.add(x + (a + 0.5) / 16 - 0.5, y + (b + 0.5) / 16 - 0.5);
        }
    double depth[Places::most];
    std::fill_n(depth, places.count, not_below);
    for (Laid& l : laid) l.lines.deepen(l.shape, places, depth);
    for (size_t i = 0; i < cells.size(); ++i) {
        double sum = 0;
        int below = 0;
        for (size_t a = 16 * i; a < 16 * (i + 1); ++a)
            if (is_below(depth[a])) sum += depth[a], ++below;
        const size_t at = bed.number(cells[i][0], cells[i][1]);
        bed.share[at] = float(below) / 16;
        bed.deep[at] = below > 0 ? sum / below : not_below;
    }
}

// Adds the pressures of the bed to a pad, and tractions: the force along the surface in proportion to the pressure, and
// its torsion in proportion to the distance from the pressure's centre as well. Their sums are exact, because the
// pressure has no first moment about its centre.
ContactReport Touch::Impl::add_bed(int number, const Rest& rest, const Wrench& w) {
    const Pad on = pad(number);
    const double spacing = shape.spacing, area = spacing * spacing, round = rest.round * area;
    const double x = (rest.x + 0.5 * bed.width - bed.left) * spacing, // of the centre, m from the pad's corner
        y = (rest.y + 0.5 * bed.height - bed.top) * spacing;
    const double off_x = x - 0.5 * shape.width * spacing, off_y = y - 0.5 * shape.height * spacing;
    const double torsion = w.torsion - (off_x * w.along_y - off_y * w.along_x);
    const double twist = round > 0 ? torsion / (w.force * round) : 0;
    const double corner_x = w.along_x / w.force + twist * y, corner_y = w.along_y / w.force - twist * x; // at x = y = 0
    ContactReport report{.asked = w.whole, .sideways = w.whole - w.force, .by_body = 1, .tilted = rest.bound};
    const double drag_x = corner_x - twist * 0.5 * spacing, drag_y = corner_y + twist * 0.5 * spacing; // of cell (0, 0)
    const Gained own = loops().add({shape.width, shape.height, size_t(shape.width), bed.pitch,
                                    bed.pressure.data() + bed.number(0, 0), float(rest.scale), on.pressure, on.shear_x,
                                    on.shear_y, float(drag_x), float(drag_y), float(twist * spacing)});
    report.placed = own.placed * area, report.greatest = double(own.greatest), report.cells = own.cells;
    report.shear = {(drag_x * own.pressed - twist * spacing * own.y) * area,
                    (drag_y * own.pressed + twist * spacing * own.x) * area};
    grow(number, {own.left, own.right}, {own.top, own.bottom});
    const double outside = w.force - own.pressed * area;
    report.outside = outside > 1e-6 * w.force ? outside : 0;
    return report;
}

// Presses a pad by the shapes of a body, of which these are the contacts. Returns false, and has done nothing, if no
// shape is below a cell.
bool Touch::Impl::press_by_shape(int number, std::span<const Listed* const> own, ContactReport& report) {
    const Pose pose = poses[size_t(number)].from_middle(shape);
    const double spacing = shape.spacing;
    const auto is_on = [&](const Contact& c) { // on the finger, or half a cell beside it
        const auto& a = source.around;
        return c.x >= -a[0] - 0.5 * spacing && c.x <= (shape.width + 0.5) * spacing + a[1] &&
               c.y >= -a[2] - 0.5 * spacing && c.y <= (shape.height + 0.5) * spacing + a[3];
    };
    ContactReport landed;
    Wrench w;
    for (const Listed* c : own) {
        const std::optional<Landing> landing = landing_of(shape, pose, reach, c->contact, landed, 0.5);
        if (!landing) continue;
        if (is_on(landing->patch)) w.add(shape, *landing);
        else landed.beside += 1, landed.asked += landing->whole, landed.outside += landing->whole;
    }
    if (!(w.force > 0)) return sum_up(report, landed), true;
    const double asked = w.force / (source.stiffness * spacing * spacing);
    const double x = w.moment_x / (w.force * spacing), y = w.moment_y / (w.force * spacing); // cells from the middle
    const auto pressed = [&] {
        return press(bed,
                     {w.force, source.stiffness, spacing * spacing, true, x + bed.off_x(shape), y + bed.off_y(shape)});
    };
    const bool goes_on = std::ranges::any_of(around, [](int cells) { return cells > 0; });
    Rest rest;
    const bool lies = lay(number, own.front()->body, false, asked);
    if (lies) rest = pressed();
    if (goes_on && (!lies || w.off_pad || bed.presses_border())) {
        if (!lay(number, own.front()->body, true, asked)) return false;
        rest = pressed();
    } else if (!lies) return false;
    sum_up(report, landed);
    ContactReport made = add_bed(number, rest, w);
    made.centre_off = spacing * std::hypot(rest.x - bed.off_x(shape) - x, rest.y - bed.off_y(shape) - y);
    sum_up(report, made);
    return true;
}

} // namespace dermis::contact
