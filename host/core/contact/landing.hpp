// SPDX-License-Identifier: MIT
// Finds where contacts land on a pad, and presses the pad there.
#pragma once

#include "host/core/base/refusal.hpp"
#include "host/core/contact/tiles.hpp"

#include <functional>
#include <optional>

namespace dermis::contact {

using Vector = std::array<double, 3>;
constexpr double greatest_length = 1e6; // m

// The name of a member in a list, or of a thing that is in no list: number -1.
std::string member_of(const char* list, const char* member, int number);
// Throw Error::bad_input.
void check(const Pad&);
void check(const Pose&, const char* list = "pose", int number = -1); // number: in the list; -1: it is none
void check_reach(const Pad&, double reach);
// Refuses a force which would, all on one cell, be more than a float can hold.
void need_float_pressure(const Pad&, double force);
void need_memory(const char* name, bool given);
void need_pitch(const char* name, size_t pitch, int width);
// Refuses numbers that stand in the pad's memory, because they are read while that is written.
void need_apart(const char* name, const Pad&, const void* first, const void* end);
inline void need_within(const char* name, double value, double low, double high, const char* allowed) {
    scene::need(value >= low && value <= high, name, value, allowed);
}

inline double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Returns the components of a vector of the world in the pad's frame.
inline Vector turned(const Pose& pose, const Vector& v) {
    const std::array<double, 9>& r = pose.rotation;
    return {dot({r[0], r[3], r[6]}, v), dot({r[1], r[4], r[7]}, v), dot({r[2], r[5], r[8]}, v)};
}

// The place of a pad's surface that is nearest to a point, as x and y of a Contact; how far the point is above it; and
// the surface's axes there: along x and y of the pad, and outwards.
struct Foot {
    double x, y, above;
    Vector along_x, along_y, normal;
};
Foot foot_of(const Pad&, const Vector& place); // in the pad's frame

// Where a contact meets a pad: its patch, whose force is the component into the pad; its whole force, N; the force's
// components along x and y of the pad, N; and the place on the surface, of a contact in the world.
struct Landing {
    Contact patch;
    double whole, along_x = 0, along_y = 0;
    Foot foot = {};
};
Disc disc_of(const Pad&, const Contact& patch); // in units of cells

// Nothing where a contact in the world has no force, is too far from the pad or pushes away from it; the force then
// counts as outside. facing: the cosine between force and normal up to which it pushes away.
std::optional<Landing> landing_of(const Pad&, const Pose&, double reach, const WorldContact&, ContactReport&,
                                  double facing = 0);

// A traction for each Pa of pressure. Beyond what floats hold, as of a force that is almost along the surface, it is 0.
inline double drag_of(double traction) { return std::abs(traction) <= 1e30 ? traction : 0; }

void add(const Pad&, const Landing&, const Tile&, const CellPress&, ContactReport&);

// Presses a checked pad by its contacts. land(i, report): the landing of contact i, or nothing.
template <class Land> ContactReport press_each(const Pad& pad, size_t count, const Land& land) {
    return press_cells(pad, double(count), [&](const Tile& tile, const CellPress& press, ContactReport& report) {
        for (size_t i = 0; i < count; ++i)
            if (const std::optional<Landing> landing = land(i, report)) add(pad, *landing, tile, press, report);
    });
}

// add_contacts() of contacts that a caller has in a form of its own.
ContactReport add_each(const Pad&, size_t count, const std::function<Contact(size_t)>&);
ContactReport add_each(const Pad&, const Pose&, double reach, size_t count, const std::function<WorldContact(size_t)>&);

} // namespace dermis::contact
