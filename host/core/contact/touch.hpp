// SPDX-License-Identifier: MIT
// The members of a Touch that a Skin reads when the Touch presses it.
#pragma once

#include "dermis/touch.hpp"
#include "host/core/contact/bodies.hpp"
#include "host/core/contact/foundation.hpp"
#include "host/core/contact/landing.hpp"

#include <span>

namespace dermis::contact {

// Contacts of one body on one pad as one force: sums over them. Places are along the pad's surface, m from its middle.
struct Wrench {
    double force = 0, whole = 0;       // N: the components into the pad, and the whole forces
    double along_x = 0, along_y = 0;   // N
    double moment_x = 0, moment_y = 0; // N m: force times place; their quotient is the centre of pressure
    double torsion = 0;                // N m, about the normal in the middle
    bool off_pad = false;              // whether a contact is beyond the pad's border

    // torque: N m, about the contact's place, along the surface's axes there and outwards.
    void add(const Pad& pad, const Landing& l, const Vector& torque) {
        const double x = l.patch.x - 0.5 * pad.width * pad.spacing, y = l.patch.y - 0.5 * pad.height * pad.spacing;
        // A force along a flat pad above or below its plane has a moment, which the centre of pressure takes.
        const double lever = pad.radius_x == 0 && pad.radius_y == 0 ? l.foot.above : 0;
        force += l.patch.force, whole += l.whole;
        along_x += l.along_x, along_y += l.along_y;
        moment_x += l.patch.force * x + lever * l.along_x + torque[1];
        moment_y += l.patch.force * y + lever * l.along_y - torque[0];
        torsion += x * l.along_y - y * l.along_x + torque[2];
        off_pad = off_pad || l.patch.x < 0 || l.patch.x > pad.width * pad.spacing || l.patch.y < 0 ||
                  l.patch.y > pad.height * pad.spacing;
    }
};

// A contact that was copied: the number of its pad, that of its body or -1, and the radius of its ball, m, 0 where it
// has a radius.
struct Listed {
    int pad, body = -1;
    double ball = 0;
    WorldContact contact = {};
    Vector torque = {};
};

// A shape that was copied.
struct Shaped {
    int pad, body;
    Body shape = {};
};

// A shape below a pad.
struct Laid {
    Laid(const Body& body, const Pad& pad, const Pose& pose) : shape(body), lines(pad, pose, body.pose) {}
    Body shape;
    Lines lines;
};

// Cells of a pad, or around it.
struct Region {
    CellSpan columns, rows;

    bool empty() const { return columns.empty() || rows.empty(); }
    void add(int x, int y) {
        columns = {std::min(columns.first, x), std::max(columns.last, x)};
        rows = {std::min(rows.first, y), std::max(rows.last, y)};
    }
    contact::Block block(size_t pitch) const {
        return {double(columns.first), double(rows.first), columns.last - columns.first + 1, rows.last - rows.first + 1,
                pitch};
    }
};

// Items of the last call, by the pads that they belong to; those of a pad by their bodies, then in the caller's order.
template <class Item> struct ByPad {
    std::vector<Item> items;
    std::vector<const Item*> order;
    std::vector<size_t> counts, ends; // of each pad, how many it has, and behind which of `order` they end

    explicit ByPad(int pads) : counts(size_t(pads)), ends(size_t(pads)) {}
    std::span<const Item* const> of(size_t pad) const { return {order.data() + ends[pad] - counts[pad], counts[pad]}; }
    // touched: the pads, in whose ascending order they are listed.
    void list(const std::vector<int>& touched) {
        size_t begin = 0;
        for (const int pad : touched) {
            ends[size_t(pad)] = begin;
            begin += counts[size_t(pad)];
        }
        order.resize(begin);
        for (const Item& item : items)
            if (counts[size_t(item.pad)] != 0) order[ends[size_t(item.pad)]++] = &item;
        for (const int pad : touched) {
            const auto last = order.begin() + std::ptrdiff_t(ends[size_t(pad)]);
            std::sort(last - std::ptrdiff_t(counts[size_t(pad)]), last,
                      [](const Item* a, const Item* b) { return a->body != b->body ? a->body < b->body : a < b; });
        }
    }
};

struct Touch::Impl {
    Impl(const Pad& shape, int count, double reach, bool shear, const Source&);

    size_t number_of(int pad) const; // throws Error::bad_input
    void take(const Poses&, const Contacts&, const Shapes&);
    void take_faces(Body& hull, size_t number) const;
    void clear();
    void list();
    void take(const DepthImages&);
    ContactReport press_by_image(int number, bool gaps);
    ContactReport pressed_by(int number, double modulus);
    ContactReport press_by_patches(int number, double modulus);
    bool press_by_shape(int number, std::span<const Listed* const>, ContactReport&);
    bool lay(std::span<const Shaped* const>, const Pose&, bool goes_on, double asked);
    Region pressed_beyond(const Region&, double least) const;
    void lay_outlines(const Region&, bool all);
    void share_out(int x, int y);
    ContactReport add_bed(int number, const Rest&, const Wrench&);
    Pad pad(int number);
    void grow(int number, const CellSpan& columns, const CellSpan& rows);

    const Pad shape;
    const int count;
    const double reach;
    const Source source;
    const std::array<int, 4> around;       // cells of the finger beyond the pad's borders
    const size_t cells;                    // of a pad
    std::vector<float> pressure, traction; // traction: empty without shear
    std::vector<ContactReport> reports;    // of each pad
    ContactReport all;
    std::vector<Block> pressed; // of each pad, the cells that may hold a pressure
    std::vector<int> touched;   // pads with contacts, ascending
    std::vector<Pose> poses;    // of each pad with contacts
    ByPad<Listed> contacts;
    ByPad<Shaped> shapes;
    std::vector<double> faces;          // of hulls
    std::vector<float> images;          // of pads that depths press, one behind the other
    std::vector<Vector> image_forces;   // N, of each pad in its frame
    std::vector<const Listed*> patches; // contacts of a pad that press by patches
    std::vector<Laid> laid;             // the shapes of the body that is being laid below a pad
    std::vector<double> corners;        // depths at the corners of cells, m
    Bed bed;                            // room for the cells of a pad and around it, where there are shapes
};

void sum_up(ContactReport&, const ContactReport&);

} // namespace dermis::contact
