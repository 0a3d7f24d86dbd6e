// SPDX-License-Identifier: MIT
#include "host/core/contact/touch.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"

#include <numbers>

namespace dermis::contact {
namespace {

// The group of numbers of pad or contact i.
template <size_t n> std::array<double, n> group_of(Reals numbers, size_t step, size_t i) {
    return numbers.visit([&](const auto* first) {
        std::array<double, n> group;
        std::copy_n(first + i * step, n, group.begin());
        return group;
    });
}

// Copies the numbers of contact i.
Listed copied(const Contacts& c, size_t i) {
    Listed made{.pad = c.pad[i * c.pad_step]};
    if (c.body) made.body = c.body[i * c.body_step];
    made.contact.position = group_of<3>(c.position, c.position_step, i);
    made.contact.direction = group_of<3>(c.force, c.force_step, i);
    made.contact.force = std::sqrt(dot(made.contact.direction, made.contact.direction));
    if (c.torque) made.torque = group_of<3>(c.torque, c.torque_step, i);
    if (c.radius) made.contact.radius = c.radius[i * c.radius_step];
    else if (c.ball) made.ball = c.ball[i * c.ball_step];
    return made;
}

Shaped copied(const Shapes& s, size_t i) {
    Shaped made{.pad = s.pad[i * s.pad_step], .body = s.body[i * s.body_step]};
    made.shape.kind = Body::Kind(s.kind[i * s.kind_step]);
    made.shape.size = group_of<3>(s.size, s.size_step, i);
    made.shape.pose.position = group_of<3>(s.position, s.position_step, i);
    made.shape.pose.rotation = group_of<9>(s.rotation, s.rotation_step, i);
    return made;
}

bool is_within(const Vector& numbers, double limit) {
    return std::ranges::all_of(numbers, [limit](double n) { return n >= -limit && n <= limit; });
}

// Refuses a member of item i of a list. The message has the first `count` numbers of the member.
[[noreturn]] void refuse_item(size_t i, const char* member, const Vector& numbers, size_t count,
                              const std::string& allowed) {
    std::string value;
    for (size_t k = 0; k < count; ++k) value += (k ? ", " : "") + shortest(numbers[k]);
    scene::refuse(std::string(member) + "[" + std::to_string(i) + "]", value, allowed);
}

Pad checked(Pad shape) {
    scene::need(shape.pressure == nullptr && !shape.shear_x && !shape.shear_y, "shape.pressure", 1,
                "null: a Touch has memory of its own");
    scene::need(shape.pitch == 0, "shape.pitch", double(shape.pitch), "0");
    float none = 0;
    shape.pressure = &none;
    check(shape);
    shape.pressure = nullptr;
    return shape;
}

// Throws Error::bad_input where add() cannot take an array.
void need_arrays(const Poses& poses, const Contacts& c) {
    scene::need(c.count <= 2147483647, "contacts.count", double(c.count), "at most 2147483647");
    need_memory("contacts.pad", c.pad);
    need_memory("contacts.position", bool(c.position));
    need_memory("contacts.force", bool(c.force));
    need_memory("poses.position", bool(poses.position));
    need_memory("poses.rotation", bool(poses.rotation));
    if (c.radius && c.ball) scene::refuse("contacts.ball", "(given)", "null beside contacts.radius");
    if (c.radius) return scene::need(c.modulus == 0, "contacts.modulus", c.modulus, "0 beside contacts.radius");
    if (!c.ball && c.body) return scene::need(c.modulus == 0, "contacts.modulus", c.modulus, "0 without contacts.ball");
    need_memory("contacts.ball", bool(c.ball));
    scene::need_positive("contacts.modulus", c.modulus);
}

void need_arrays(const Shapes& s) {
    scene::need(s.count <= 2147483647, "shapes.count", double(s.count), "at most 2147483647");
    need_memory("shapes.pad", s.pad);
    need_memory("shapes.body", s.body);
    need_memory("shapes.kind", s.kind);
    need_memory("shapes.size", bool(s.size));
    need_memory("shapes.position", bool(s.position));
    need_memory("shapes.rotation", bool(s.rotation));
    need_memory("shapes.faces", s.faces || s.face_count == 0);
    scene::need(s.face_count <= 16777216, "shapes.face_count", double(s.face_count), "0..16777216");
}

// Throws Error::bad_input where a number of contact i is not allowed.
void need_contact(const Listed& c, size_t i, int pads, bool has_radius, bool has_ball) {
    if (c.pad < 0 || c.pad >= pads)
        refuse_item(i, "contacts.pad", {double(c.pad)}, 1, "0.." + std::to_string(pads - 1));
    if (c.body < -1) refuse_item(i, "contacts.body", {double(c.body)}, 1, "-1..2147483647");
    const auto &place = c.contact.position, &force = c.contact.direction;
    if (!is_within(place, greatest_length)) refuse_item(i, "contacts.position", place, 3, "-1e6..1e6");
    if (!is_within(force, 1e12)) refuse_item(i, "contacts.force", force, 3, "-1e12..1e12");
    if (!is_within(c.torque, 1e12)) refuse_item(i, "contacts.torque", c.torque, 3, "-1e12..1e12");
    if (has_radius && !(c.contact.radius >= 0 && c.contact.radius <= greatest_length))
        refuse_item(i, "contacts.radius", {c.contact.radius}, 1, "0..1e6");
    if (has_ball && !(c.ball > 0 && c.ball <= greatest_length))
        refuse_item(i, "contacts.ball", {c.ball}, 1, "above 0, at most 1e6");
}

// Of each border how many cells of the finger are beyond it: those whose centres are on the finger.
std::array<int, 4> cells_around(const Pad& shape, const Source& source) {
    std::array<int, 4> cells{};
    for (size_t k = 0; k < 4; ++k) {
        const int side = k < 2 ? shape.width : shape.height;
        const double radius = k < 2 ? shape.radius_x : shape.radius_y, across = side * shape.spacing,
                     most = radius != 0 ? 0.5 * (std::numbers::pi * radius - across)
                                        : std::max(side, 1024) * shape.spacing;
        const std::string name = "source.around[" + std::to_string(k) + "]";
        if (!(source.around[k] >= -across && source.around[k] <= std::max(most, 0.0)))
            scene::refuse(name, shortest(source.around[k]),
                          shortest(-across) + ".." + shortest(std::max(most, 0.0)) + " m: less the pad, " +
                              (radius != 0 ? "a quarter turn" : "1024 cells or the pad once more"));
        cells[k] = std::max(int(std::floor(source.around[k] / shape.spacing + 0.5)), 0);
    }
    return cells;
}

} // namespace

void sum_up(ContactReport& all, const ContactReport& r) {
    all.asked += r.asked, all.placed += r.placed, all.outside += r.outside, all.sideways += r.sideways;
    for (size_t k = 0; k < 2; ++k) all.shear[k] += r.shear[k];
    all.greatest = std::max(all.greatest, r.greatest);
    all.cells += r.cells, all.below_cell += r.below_cell;
    all.beside += r.beside, all.too_far += r.too_far, all.turned_away += r.turned_away;
    all.by_body += r.by_body, all.by_patch += r.by_patch, all.tilted += r.tilted;
    all.centre_off = std::max(all.centre_off, r.centre_off);
    all.clipped += r.clipped;
}

Touch::Impl::Impl(const Pad& given, int n, double r, bool shear, const Source& by)
    : shape(checked(given)), count(n), reach(r), source(by), around(cells_around(shape, by)),
      cells(size_t(shape.width) * size_t(shape.height)), pressure(size_t(n) * cells),
      traction(shear ? 2 * size_t(n) * cells : 0), reports(size_t(n)), pressed(size_t(n)), poses(size_t(n)),
      contacts(n), shapes(n) {
    if (by.stiffness != 0) need_within("source.stiffness", by.stiffness, 1e-6, 1e30, "1e-6..1e30");
    touched.reserve(size_t(n));
}

size_t Touch::Impl::number_of(int pad) const {
    scene::need(pad >= 0 && pad < count, "pad", pad, "0.." + std::to_string(count - 1));
    return size_t(pad);
}

// Copies the contacts that have a force, the poses of their pads and the shapes of bodies, and checks the copies,
// because the caller's memory may change. Throws Error::bad_input where add() cannot take something; no pressure has
// changed then.
void Touch::Impl::take(const Poses& given, const Contacts& c, const Shapes& s) {
    contacts.items.clear();
    shapes.items.clear();
    if (c.count != 0) need_arrays(given, c);
    contacts.items.reserve(c.count);
    double asked = 0;
    int posed = -1; // the pad with the pose that was checked last; -1: no pose has been checked
    for (size_t i = 0; i < c.count; ++i) {
        Listed own = copied(c, i);
        if (!c.radius && !c.ball) own.contact.radius = 2 * shape.spacing;
        need_contact(own, i, count, bool(c.radius), bool(c.ball));
        if (own.contact.direction == Vector{}) continue;
        contacts.items.push_back(own);
        asked += own.contact.force;
        if (own.pad == posed) continue;
        posed = own.pad;
        Pose& pose = poses[size_t(posed)];
        pose.position = group_of<3>(given.position, given.position_step, size_t(posed));
        pose.rotation = group_of<9>(given.rotation, given.rotation_step, size_t(posed));
        check(pose, "poses", posed);
    }
    need_float_pressure(shape, asked);
    contacts.order.reserve(contacts.items.size());
    patches.reserve(contacts.items.size());
    if (s.count == 0) return;
    need_arrays(s);
    scene::need(!shape.tiled, "shapes.count", double(s.count), "0 on tiled pads, which share no bodies");
    scene::need(source.stiffness > 0, "source.stiffness", source.stiffness, "1e-6..1e30 Pa/m, where there are shapes");
    faces.assign(s.faces, s.faces + 4 * s.face_count);
    shapes.items.reserve(s.count);
    for (size_t i = 0; i < s.count; ++i) {
        Shaped own = copied(s, i);
        if (own.pad < 0 || own.pad >= count)
            refuse_item(i, "shapes.pad", {double(own.pad)}, 1, "0.." + std::to_string(count - 1));
        if (own.body < 0) refuse_item(i, "shapes.body", {double(own.body)}, 1, "0..2147483647");
        if (own.shape.kind == Body::Kind::hull) take_faces(own.shape, i);
        check(own.shape, "shapes", int(i));
        shapes.items.push_back(own);
    }
    shapes.order.reserve(s.count);
    laid.reserve(s.count);
    const int columns = shape.width + around[0] + around[1], rows = shape.height + around[2] + around[3];
    bed.reserve(columns, rows);
    corners.reserve(size_t(columns + 1) * size_t(rows + 1));
}

// Gives a hull its faces, which its sizes name. number: of the shape.
void Touch::Impl::take_faces(Body& hull, size_t number) const {
    const double all = double(faces.size() / 4), count = hull.size[0], first = hull.size[1];
    for (const double n : {count, first})
        if (!(n >= 0 && n <= all && n == std::floor(n) && first + count <= all && count >= 4 && count <= 65536))
            refuse_item(number, "shapes.size", hull.size, 3,
                        "of a hull the number of its faces, 4..65536, its first one and 0");
    hull.faces = faces.data() + 4 * size_t(first), hull.face_count = size_t(count), hull.size = {0, 0, hull.size[2]};
}

// Copies the images and checks the copies. Throws Error::bad_input; no pressure has changed then.
void Touch::Impl::take(const DepthImages& d) {
    need_memory("images.depth", bool(d.depth));
    need_memory("images.force", bool(d.force));
    scene::need(source.stiffness > 0, "source.stiffness", source.stiffness, "1e-6..1e30 Pa/m, where there are images");
    const size_t step = d.depth_step ? d.depth_step : cells;
    if (step < cells) scene::refuse("images.depth_step", std::to_string(step), "0, or a pad's cells and more");
    images.resize(pressure.size());
    image_forces.resize(size_t(count));
    double greatest = 0;
    for (size_t pad = 0; pad < size_t(count); ++pad) {
        image_forces[pad] = group_of<3>(d.force, d.force_step, pad);
        if (!is_within(image_forces[pad], 1e12)) refuse_item(pad, "images.force", image_forces[pad], 3, "-1e12..1e12");
        greatest = std::max(greatest, -image_forces[pad][2]);
        d.depth.visit([&](const auto* first) { std::copy_n(first + pad * step, cells, &images[pad * cells]); });
    }
    for (size_t i = 0; i < images.size(); ++i)
        if (!(std::abs(images[i]) <= float(greatest_length)))
            scene::refuse("images.depth[" + std::to_string(i / cells * step + i % cells) + "]",
                          shortest(double(images[i])), "-1e6..1e6");
    need_float_pressure(shape, greatest);
    bed.reserve(shape.width, shape.height);
}

// Takes the pressures and reports of the last call away.
void Touch::Impl::clear() {
    for (const int number : touched) {
        Block& b = pressed[size_t(number)];
        const Pad own = pad(number);
        for (float* map : {own.pressure, own.shear_x, own.shear_y})
            for (int y = b.y; map && y < b.y + b.height; ++y) std::fill_n(map + row_at(own, y) + b.x, b.width, 0.0f);
        b = {};
        reports[size_t(number)] = {};
        contacts.counts[size_t(number)] = shapes.counts[size_t(number)] = 0;
    }
    touched.clear();
    all = {};
}

void Touch::Impl::list() {
    for (const Listed& c : contacts.items)
        if (contacts.counts[size_t(c.pad)]++ == 0) touched.push_back(c.pad);
    if (!std::ranges::is_sorted(touched)) std::ranges::sort(touched);
    for (const Shaped& s : shapes.items) shapes.counts[size_t(s.pad)] += contacts.counts[size_t(s.pad)] != 0;
    contacts.list(touched);
    shapes.list(touched);
}

Pad Touch::Impl::pad(int number) {
    Pad own = shape;
    own.pressure = pressure.data() + size_t(number) * cells;
    if (!traction.empty()) {
        own.shear_x = traction.data() + size_t(number) * cells;
        own.shear_y = own.shear_x + size_t(count) * cells;
    }
    return own;
}

// Presses one pad by its contacts: those of bodies that have shapes by these, the others by patches.
ContactReport Touch::Impl::pressed_by(int number, double modulus) {
    const auto all = contacts.of(size_t(number));
    ContactReport report;
    patches.clear();
    for (size_t first = 0, last; first < all.size(); first = last) {
        last = first + 1;
        while (last < all.size() && all[last]->body == all[first]->body) ++last;
        const auto own = all.subspan(first, last - first);
        if (own[0]->body >= 0) {
            if (press_by_shape(number, own, report)) continue;
            report.by_patch += int(own.size());
        }
        patches.insert(patches.end(), own.begin(), own.end());
    }
    sum_up(report, press_by_patches(number, modulus));
    return report;
}

// modulus: Pa, for contacts that have a ball; 0: each contact has a radius, or is two cells wide.
ContactReport Touch::Impl::press_by_patches(int number, double modulus) {
    const Pad own = pad(number);
    const Pose pose = poses[size_t(number)].from_middle(own);
    return press_each(own, patches.size(), [&](size_t i, ContactReport& report) {
        std::optional<Landing> landing = landing_of(own, pose, reach, patches[i]->contact, report);
        if (!landing) return landing;
        Contact& patch = landing->patch;
        if (modulus > 0) patch.radius = std::max(hertz_radius(patch.force, patches[i]->ball, modulus), 2 * own.spacing);
        const Disc disc = disc_of(own, patch);
        const double half = std::max(disc.reach, 1.0); // a patch below a cell presses the nearest one
        grow(number, within(disc.x - half, disc.x + half, {0, own.width - 1}),
             within(disc.y - half, disc.y + half, {0, own.height - 1}));
        return landing;
    });
}

// Makes the block of a pad hold these cells too.
void Touch::Impl::grow(int number, const CellSpan& columns, const CellSpan& rows) {
    if (columns.empty() || rows.empty()) return;
    Block& b = pressed[size_t(number)];
    const int x = b.height == 0 ? columns.first : std::min(b.x, columns.first),
              y = b.height == 0 ? rows.first : std::min(b.y, rows.first);
    const int right = std::max(b.x + b.width, columns.last + 1), below = std::max(b.y + b.height, rows.last + 1);
    b = {x, y, right - x, below - y};
}

Touch::Touch(const Pad& shape, int count, double reach, bool shear, const Source& source) {
    const auto words = [&] {
        return "the pressures of " + std::to_string(count) + " pads of " + std::to_string(shape.width) + " x " +
               std::to_string(shape.height) + " cells";
    };
    scene::guarded(words, [&] {
        scene::need(count >= 1 && count <= 1048576, "count", count, "1..1048576");
        scene::need(double(count) * shape.width * shape.height <= 2147483647, "count*width*height",
                    double(count) * shape.width * shape.height, "at most 2147483647");
        check_reach(shape, reach);
        impl_ = std::make_unique<Impl>(shape, count, reach, shear, source);
    });
}

Touch::~Touch() = default;
Touch::Touch(Touch&&) noexcept = default;
Touch& Touch::operator=(Touch&&) noexcept = default;

int Touch::count() const { return impl_->count; }
const Pad& Touch::shape() const { return impl_->shape; }
const float* Touch::traction() const { return impl_->traction.empty() ? nullptr : impl_->traction.data(); }
const float* Touch::pressure() const { return impl_->pressure.data(); }

const ContactReport& Touch::add(const Poses& poses, const Contacts& contacts, const Shapes& shapes) {
    const auto words = [&] { return "the list of " + std::to_string(contacts.count) + " contacts"; };
    return scene::guarded(words, [&]() -> const ContactReport& {
        const DefaultFloats guard;
        Impl& s = *impl_;
        s.take(poses, contacts, shapes);
        s.clear();
        s.list();
        for (const int number : s.touched) {
            s.reports[size_t(number)] = s.pressed_by(number, contacts.modulus);
            sum_up(s.all, s.reports[size_t(number)]);
        }
        return s.all;
    });
}

const ContactReport& Touch::add(const DepthImages& given) {
    const auto words = [&] { return std::string("a copy of the depth images"); };
    return scene::guarded(words, [&]() -> const ContactReport& {
        const DefaultFloats guard;
        Impl& s = *impl_;
        s.take(given);
        s.clear();
        for (int number = 0; number < s.count; ++number)
            if (s.image_forces[size_t(number)] != Vector{}) {
                s.touched.push_back(number);
                s.reports[size_t(number)] = s.press_by_image(number, given.gaps);
                sum_up(s.all, s.reports[size_t(number)]);
            }
        return s.all;
    });
}

const ContactReport& Touch::report(int pad) const { return impl_->reports[impl_->number_of(pad)]; }
const std::vector<int>& Touch::touched() const { return impl_->touched; }
Touch::Block Touch::block(int pad) const { return impl_->pressed[impl_->number_of(pad)]; }

} // namespace dermis::contact
