// SPDX-License-Identifier: MIT
// Pads that are pressed by the shapes of bodies.
#include "host/core/contact/touch.hpp"

namespace dermis::contact {
namespace {

bool has_body(const Shaped* s, int body) { return s->body < body; }

bool is_below(double depth) { return depth > 0.5 * not_below; }

// Whether a patch may end where the body does. Round bodies press patches that end before that.
bool has_outline(const Body& b) { return b.kind == Body::Kind::box || b.kind == Body::Kind::cylinder; }

// A body with an outline whose faces are moved outwards; a round one as it is.
Body resized(Body b, double by) {
    for (double& size : b.size)
        if (has_outline(b) && size != 0) size += by;
    return b;
}
bool exists(const Body& b) { return std::ranges::all_of(b.size, [](double size) { return size >= 0; }); }

// Whether a body is below all cells of a flat pad, with half a cell to spare: its shadow is convex.
bool covers(Laid& l, const Pad& pad, const CellSpan& columns, const CellSpan& rows) {
    const Body less = resized(l.shape, -0.71 * pad.spacing);
    if (pad.radius_x != 0 || pad.radius_y != 0 || !exists(less)) return false;
    Places corners;
    for (const int x : {columns.first, columns.last})
        for (const int y : {rows.first, rows.last}) corners.add(x, y);
    double depth[4];
    std::fill_n(depth, 4, not_below);
    l.lines.deepen(less, corners, depth);
    return std::ranges::all_of(depth, is_below);
}

// The share of 16 places in a cell that a body is below, and the mean depth there. No two places have the same x or y,
// so that an outline along the cells does not move in steps of a quarter.
void share_out(int x, int y, std::vector<Laid>& all, float& share, double& deep) {
    Places places;
    for (int a = 0; a < 16; ++a) {
        const int b = (a & 1) << 3 | (a & 2) << 1 | (a & 4) >> 1 | a >> 3; // a with its bits reversed
        places.add(x + (a + 0.5) / 16 - 0.5, y + (b + 0.5) / 16 - 0.5);
    }
    double depth[16], sum = 0;
    std::fill_n(depth, 16, not_below);
    for (Laid& l : all) l.lines.deepen(l.shape, places, depth);
    int below = 0;
    for (const double d : depth)
        if (is_below(d)) sum += d, ++below;
    share = float(below) / 16;
    deep = below > 0 ? sum / below : not_below;
}

// Adds the pressures of a bed to a pad whose cell (0, 0) is the bed's cell (left, top), and tractions: the force along
// the surface in proportion to the pressure, and its torsion in proportion to the distance from the pressure's centre
// as well. Their sums are exact, because the pressure has no first moment about its centre.
ContactReport add_bed(const Pad& pad, const Bed& bed, const Rest& rest, const Wrench& w, int left, int top) {
    const double x = (rest.x + 0.5 * bed.width - left) * pad.spacing, // of the centre, m from the pad's corner
        y = (rest.y + 0.5 * bed.height - top) * pad.spacing;
    const double middle_x = x - 0.5 * pad.width * pad.spacing, middle_y = y - 0.5 * pad.height * pad.spacing;
    const double torsion = w.torsion - (middle_x * w.along_y - middle_y * w.along_x);
    const double round = rest.round * pad.spacing * pad.spacing;
    const double twist = round > 0 ? torsion / (w.force * round) : 0, drag_x = w.along_x / w.force,
                 drag_y = w.along_y / w.force;
    double first_x = 0, first_y = 0, sum = 0; // of the cells of the pad
    ContactReport report = press_cells(pad, 1, [&](const Tile&, const CellPress& press, ContactReport&) {
        for (int j = std::max(rest.cells[2] - top, 0); j <= std::min(rest.cells[3] - top, pad.height - 1); ++j)
            for (int i = std::max(rest.cells[0] - left, 0); i <= std::min(rest.cells[1] - left, pad.width - 1); ++i) {
                const double p = double(bed.pressure[size_t(j + top) * size_t(bed.width) + size_t(i + left)]);
                if (p == 0) continue;
                const double dx = (i + 0.5) * pad.spacing - x, dy = (j + 0.5) * pad.spacing - y;
                press.dragging(drag_x - twist * dy, drag_y + twist * dx)(i, j, p);
                sum += p, first_x += p * dx, first_y += p * dy;
            }
    });
    const double area = pad.spacing * pad.spacing, on_pad = std::min(sum * area / w.force, 1.0);
    report.asked = w.whole;
    report.sideways = w.whole - w.force;
    report.outside = on_pad > 1 - 1e-6 ? 0 : (1 - on_pad) * w.force;
    report.shear = {(drag_x * sum - twist * first_y) * area, (drag_y * sum + twist * first_x) * area};
    report.by_body = 1, report.tilted = rest.bound;
    return report;
}

} // namespace

// Lays the shapes of a body below the cells of a pad, and around it if that is asked for. Returns whether they are below
// any.
bool Touch::Impl::lay(int number, int body, bool goes_on) {
    const std::array<int, 4> more = goes_on ? around : std::array<int, 4>{};
    bed.resize(shape.width + more[0] + more[1], shape.height + more[2] + more[3]);
    // Cells whose centres are on the finger.
    const auto& a = source.around;
    const CellSpan columns = within(-a[0] / shape.spacing - 0.5, shape.width + a[1] / shape.spacing - 0.5,
                                    {-more[0], shape.width + more[1] - 1});
    const CellSpan rows = within(-a[2] / shape.spacing - 0.5, shape.height + a[3] / shape.spacing - 0.5,
                                 {-more[2], shape.height + more[3] - 1});
    std::vector<Laid>& all = laid;
    all.clear();
    const auto own = shapes.of(size_t(number));
    const Pose pose = poses[size_t(number)].from_middle(shape);
    bool outlined = false;
    for (auto s = std::lower_bound(own.begin(), own.end(), body, has_body); s != own.end() && (*s)->body == body; ++s) {
        all.push_back({(*s)->shape, Lines(shape, pose, (*s)->shape.pose)});
        outlined = outlined || (has_outline((*s)->shape) && !covers(all.back(), shape, columns, rows));
    }
    const auto number_at = [&](int x, int y) {
        return size_t(y + more[2]) * size_t(bed.width) + size_t(x + more[0]);
    };
    const int count = columns.last - columns.first + 1;
    for (int y = rows.first; y <= rows.last; ++y)
        each_piece(columns.first, y, count, [&](const Places& places, int first) {
            const size_t at = number_at(columns.first + first, y);
            for (Laid& l : all) {
                l.lines.deepen(l.shape, places, &bed.deep[at]);
                if (!outlined) continue;
                l.lines.deepen(resized(l.shape, 0.71 * shape.spacing), places, &bed.outer[at]);
                if (const Body less = resized(l.shape, -0.71 * shape.spacing); exists(less))
                    l.lines.deepen(less, places, &bed.inner[at]);
            }
        });
    for (size_t i = 0; i < bed.deep.size(); ++i) bed.share[i] = is_below(bed.deep[i]) ? 1 : 0;
    for (int y = rows.first; outlined && y <= rows.last; ++y)
        for (int x = columns.first; x <= columns.last; ++x)
            if (const size_t at = number_at(x, y); is_below(bed.outer[at]) && !is_below(bed.inner[at]))
                share_out(x, y, all, bed.share[at], bed.deep[at]);
    return bed.settle();
}

// Presses a pad by the shapes of a body, of which these are the contacts. Returns false, and has done nothing, if no
// shape is below a cell.
bool Touch::Impl::press_by_shape(int number, std::span<const Listed* const> own, ContactReport& report) {
    const int body = own.front()->body;
    const Pad on = pad(number);
    const Pose pose = poses[size_t(number)].from_middle(shape);
    const auto is_on = [&](const Contact& c) { // on the finger, or half a cell beside it
        const auto& a = source.around;
        const double half = 0.5 * shape.spacing;
        return c.x >= -a[0] - half && c.x <= shape.width * shape.spacing + a[1] + half && c.y >= -a[2] - half &&
               c.y <= shape.height * shape.spacing + a[3] + half;
    };
    ContactReport landed;
    Wrench w;
    for (const Listed* c : own) {
        const std::optional<Landing> landing = landing_of(on, pose, reach, c->contact, landed, 0.5);
        if (!landing) continue;
        if (is_on(landing->patch)) w.add(on, *landing);
        else landed.beside += 1, landed.asked += landing->whole, landed.outside += landing->whole;
    }
    if (!(w.force > 0)) return sum_up(report, landed), true;
    const bool goes_on = std::ranges::any_of(around, [](int cells) { return cells > 0; });
    const auto pressed_at = [&](int left, int top) {
        const double middle_x = left + 0.5 * (shape.width - bed.width), middle_y = top + 0.5 * (shape.height - bed.height);
        return press(bed, {w.force, source.stiffness, shape.spacing * shape.spacing, true,
                           w.moment_x / (w.force * shape.spacing) + middle_x,
                           w.moment_y / (w.force * shape.spacing) + middle_y});
    };
    int left = 0, top = 0;
    bool lies = lay(number, body, false);
    if (!lies && !goes_on) return false;
    Rest rest;
    if (lies) rest = pressed_at(0, 0);
    const bool at_border = !lies || w.off_pad || rest.cells[0] == 0 || rest.cells[1] == shape.width - 1 ||
                           rest.cells[2] == 0 || rest.cells[3] == shape.height - 1;
    if (goes_on && at_border) {
        if (!lay(number, body, true)) return false;
        left = around[0], top = around[2];
        rest = pressed_at(left, top);
    }
    const double middle_x = left + 0.5 * (shape.width - bed.width), middle_y = top + 0.5 * (shape.height - bed.height);
    ContactReport pressed = add_bed(on, bed, rest, w, left, top);
    pressed.centre_off =
        shape.spacing * std::hypot(rest.x - middle_x - w.moment_x / (w.force * shape.spacing),
                                   rest.y - middle_y - w.moment_y / (w.force * shape.spacing));
    sum_up(report, landed);
    sum_up(report, pressed);
    grow(number, {std::max(rest.cells[0] - left, 0), std::min(rest.cells[1] - left, shape.width - 1)},
         {std::max(rest.cells[2] - top, 0), std::min(rest.cells[3] - top, shape.height - 1)});
    return true;
}

} // namespace dermis::contact
