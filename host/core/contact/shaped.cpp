// SPDX-License-Identifier: MIT
// Pads that are pressed by the shapes of bodies.
#include "host/core/contact/touch.hpp"

namespace dermis::contact {
namespace {

bool is_below(double depth) { return depth > 0.5 * not_below; }

// Whether a patch may end where the body does. Round bodies press patches that end before that.
bool has_outline(const Body& b) {
    return b.kind == Body::Kind::box || b.kind == Body::Kind::cylinder || b.kind == Body::Kind::hull;
}

// Whether no ball of this radius, m, is in a body with an outline. In a hull one is looked for: from the middle of its
// frame the ball leaves the face that it pierces most, again and again.
bool is_thin(const Body& b, double radius) {
    if (b.kind != Body::Kind::hull)
        return std::ranges::any_of(b.size, [&](double size) { return size > 0 && size < radius; });
    Vector middle{};
    for (int step = 0; step < 100; ++step) {
        const double* worst = nullptr;
        double most = 0;
        for (const double* f = b.faces; f < b.faces + 4 * b.face_count; f += 4)
            if (const double out = dot({f[0], f[1], f[2]}, middle) + radius - f[3]; out > most) worst = f, most = out;
        if (!worst) return false;
        for (size_t k = 0; k < 3; ++k) middle[k] -= 1.5 * most * worst[k]; // by more, so that it ends inside
    }
    return true;
}

// Whether a body with an outline is below all places of cells of a flat pad: its shadow is convex, so that the corners
// tell it.
bool covers(Laid& l, const Region& r) {
    const double left = r.columns.first - 0.5, right = r.columns.last + 0.5, top = r.rows.first - 0.5,
                 below = r.rows.last + 0.5, x[] = {left, right, left, right}, y[] = {top, top, below, below};
    double depth[] = {not_below, not_below, not_below, not_below};
    l.lines.deepen(l.shape, x, y, 4, depth);
    return std::ranges::all_of(depth, is_below);
}

} // namespace

// Lays the shapes of a body below the cells of a pad, and around it if that is asked for. asked: m, the sum of excesses
// of the press, from which it is known which outlines may be pressed. Returns whether the shapes are below any cell.
bool Touch::Impl::lay(std::span<const Shaped* const> own, const Pose& pose, bool goes_on, double asked) {
    const std::array<int, 4> more = goes_on ? around : std::array<int, 4>{};
    bed.resize(shape.width + more[0] + more[1], shape.height + more[2] + more[3], more[0], more[2]);
    // Cells whose centres are on the finger.
    const auto& a = source.around;
    const Region all{within(-a[0] / shape.spacing - 0.5, shape.width + a[1] / shape.spacing - 0.5,
                            {-more[0], shape.width + more[1] - 1}),
                     within(-a[2] / shape.spacing - 0.5, shape.height + a[3] / shape.spacing - 0.5,
                            {-more[2], shape.height + more[3] - 1})};
    laid.clear();
    bool outlines = false, thin = false;
    for (const Shaped* s : own) {
        laid.emplace_back(s->shape, shape, pose);
        const Body& added = laid.back().shape;
        outlines = outlines || has_outline(added);
        thin = thin || (has_outline(added) && is_thin(added, shape.spacing));
        if (!all.empty())
            laid.back().lines.deepen(added, all.block(bed.pitch),
                                     &bed.deep[bed.number(all.columns.first, all.rows.first)]);
    }
    const bool lies = bed.settle(true);
    if (!outlines) return lies;
    // Where cells may be pressed, and a cell more. A body less than a cell thick may be between the cells' centres.
    if (lies) bed.level = level_of(bed, asked);
    const Region near = lies && !thin ? pressed_beyond(all, bed.deepest - 4 * bed.level) : all;
    const bool flat = shape.radius_x == 0 && shape.radius_y == 0;
    if (near.empty() || (flat && laid.size() == 1 && covers(laid[0], near))) return lies;
    lay_outlines(near, thin);
    return bed.settle(false);
}

// The cells that are deeper than `least`, m, and those beside them.
Region Touch::Impl::pressed_beyond(const Region& all, double least) const {
    Region found{{all.columns.last, all.columns.first}, {all.rows.last, all.rows.first}};
    for (int y = all.rows.first; y <= all.rows.last; ++y)
        for (int x = all.columns.first; x <= all.columns.last; ++x)
            if (bed.deep[bed.number(x, y)] > least) found.add(x, y);
    return {common({found.columns.first - 1, found.columns.last + 1}, all.columns),
            common({found.rows.first - 1, found.rows.last + 1}, all.rows)};
}

// Gives cells through which an outline runs the share of 16 places in them that the body is below, and the mean depth
// there. all: whether it may run through any cell, or only through those of which some corners are below the body.
void Touch::Impl::lay_outlines(const Region& r, bool all) {
    const int columns = r.columns.last - r.columns.first + 2, rows = r.rows.last - r.rows.first + 2;
    corners.assign(size_t(columns) * size_t(rows), not_below);
    for (Laid& l : laid)
        l.lines.deepen(l.shape, {r.columns.first - 0.5, r.rows.first - 0.5, columns, rows, size_t(columns)},
                       corners.data());
    for (int y = 0; y + 1 < rows; ++y)
        for (int x = 0; x + 1 < columns; ++x) {
            const double* corner = &corners[size_t(y) * size_t(columns) + size_t(x)];
            const int below =
                is_below(corner[0]) + is_below(corner[1]) + is_below(corner[columns]) + is_below(corner[columns + 1]);
            if (all || (below > 0 && below < 4)) share_out(r.columns.first + x, r.rows.first + y);
        }
}

// No two of the places have the same x or y, so that an outline along the cells does not move in steps of a quarter.
void Touch::Impl::share_out(int x, int y) {
    constexpr int count = 16;
    double at_x[count], at_y[count], depth[count], sum = 0;
    for (int a = 0; a < count; ++a) {
        const int b = (a & 1) << 3 | (a & 2) << 1 | (a & 4) >> 1 | a >> 3; // a with its bits reversed
        at_x[a] = x + (a + 0.5) / count - 0.5, at_y[a] = y + (b + 0.5) / count - 0.5, depth[a] = not_below;
    }
    for (Laid& l : laid) l.lines.deepen(l.shape, at_x, at_y, count, depth);
    int below = 0;
    for (const double d : depth)
        if (is_below(d)) sum += d, ++below;
    bed.share[bed.number(x, y)] = float(below) / count;
    bed.deep[bed.number(x, y)] = below > 0 ? sum / below : not_below;
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
    // One cell carries no torsion: its spread is rounding.
    const double twist = round > 0.01 * area ? drag_of(torsion / (w.force * round)) : 0;
    const double corner_x = w.along_x / w.force + twist * y, corner_y = w.along_y / w.force - twist * x; // at x = y = 0
    ContactReport report{.asked = w.whole, .sideways = w.whole - w.force, .by_body = 1, .tilted = rest.bound};
    const double drag_x = drag_of(corner_x - twist * 0.5 * spacing), // of cell (0, 0)
        drag_y = drag_of(corner_y + twist * 0.5 * spacing);
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
    const std::span all = shapes.of(size_t(number)); // two searches: Clang 14 does not compile equal_range()
    const auto first = std::ranges::lower_bound(all, own.front()->body, {}, &Shaped::body),
               last = std::ranges::upper_bound(all, own.front()->body, {}, &Shaped::body);
    if (first == last) return false;
    const std::span shapes_of_body(first, last);
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
        const Foot& foot = landing->foot;
        const Vector turn = turned(pose, c->torque);
        if (is_on(landing->patch))
            w.add(shape, *landing, {dot(turn, foot.along_x), dot(turn, foot.along_y), dot(turn, foot.normal)});
        else landed.beside += 1, landed.asked += landing->whole, landed.outside += landing->whole;
    }
    if (!(w.force > 0)) return sum_up(report, landed), true;
    const double area = spacing * spacing, asked = asked_of(w.force, area, source.stiffness);
    const double x = w.moment_x / (w.force * spacing), y = w.moment_y / (w.force * spacing); // cells from the middle
    const auto pressed = [&] {
        return press(bed, {w.force, area, asked, true, x + bed.off_x(shape), y + bed.off_y(shape)});
    };
    const bool goes_on = std::ranges::any_of(around, [](int cells) { return cells > 0; });
    Rest rest;
    const bool lies = lay(shapes_of_body, pose, false, asked);
    if (lies) rest = pressed();
    if (goes_on && (!lies || w.off_pad || bed.presses_border())) {
        if (!lay(shapes_of_body, pose, true, asked)) return false;
        rest = pressed();
    } else if (!lies) return false;
    sum_up(report, landed);
    ContactReport made = add_bed(number, rest, w);
    made.centre_off = spacing * std::hypot(rest.x - bed.off_x(shape) - x, rest.y - bed.off_y(shape) - y);
    sum_up(report, made);
    return true;
}

ContactReport Touch::Impl::press_by_image(int number, bool gaps) {
    const auto& [x, y, z] = image_forces[size_t(number)];
    const double whole = std::sqrt(x * x + y * y + z * z);
    bed.resize(shape.width, shape.height, 0, 0);
    const float* image = &images[size_t(number) * cells];
    for (int j = 0; j < shape.height; ++j)
        for (int i = 0; i < shape.width; ++i, ++image)
            if (gaps || *image > 0) bed.deep[bed.number(i, j)] = double(*image);
    if (z >= 0 || !bed.settle(true)) {
        ContactReport lost{.asked = whole, .outside = whole};
        lost.turned_away = z >= 0;
        return lost;
    }
    Wrench w{.force = -z, .whole = whole, .along_x = x, .along_y = y};
    const double area = shape.spacing * shape.spacing, asked = asked_of(w.force, area, source.stiffness);
    bed.level = level_of(bed, asked);
    const Rest rest = press(bed, {w.force, area, asked});
    w.torsion = shape.spacing * (rest.x * y - rest.y * x); // about the pad's middle: none about the pressure's
    ContactReport report = add_bed(number, rest, w);
    report.by_body = 0;
    report.level = bed.deepest - rest.level;
    report.clipped = !gaps && bed.level > bed.deepest;
    return report;
}

} // namespace dermis::contact
