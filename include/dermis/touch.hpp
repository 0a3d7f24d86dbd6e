// SPDX-License-Identifier: MIT
// Contacts on all pads of a batch in one call, from a simulator's own arrays.
//
//     dermis::contact::Touch touch({.width = 80, .height = 80, .spacing = 2.5e-4, .radius_x = 8e-3, .radius_y = 8e-3},
//                                  5, 1e-3);      // five round fingertips; contacts at most 1 mm off their surface
//     const dermis::contact::ContactReport& report = touch.add(
//         {.position = middles, .rotation = axes},                  // where the pads are
//         {.count = n, .pad = pad, .position = place, .force = force, .radius = &radius, .radius_step = 0});
//     skin.press(touch, dt);
#pragma once

#include <dermis/contact.hpp>

#include <cstdint>
#include <memory>

namespace dermis::contact {

// Where pads are in the world. The numbers of pad i begin i*step numbers behind the first ones. Null is allowed where
// there is no contact.
struct Poses {
    Reals position; // m, -1e6..1e6: three numbers, the middle of the pad
    Reals rotation; // nine numbers, row-major, right to 1e-3; columns are the pad's axes in the world
    std::size_t position_step = 3, rotation_step = 9;
};

// Forces on pads. The numbers of contact i begin i*step behind the first ones, so that a table is read in place; with a
// step of 0 one number holds for all contacts.
struct Contacts {
    std::size_t count = 0;             // at most 2147483647; the other members are ignored where it is 0
    const std::int32_t* pad = nullptr; // which pad the force presses, 0 .. Touch::count() - 1, in any order
    Reals position;                    // m, in the world, -1e6..1e6: three numbers
    Reals force;        // N, in the world, -1e12..1e12: three numbers, the force on the pad. A force of 0 is no contact
    Reals radius;       // m, of the patch, 0..1e6. Null: Hertz's, by `ball` and `modulus` and the component into the
                        // pad, but at least a radius of two cells; these where there is no `ball` beside `body`
    Reals ball;         // m, > 0: 1/(1/R1 + 1/R2) of radii R1 and R2. Null beside `radius`
    double modulus = 0; // Pa, > 0, as hertz_radius() takes it. 0 beside `radius`
    // Which body presses, any number from 0 on; -1: none that is known. Null: all -1. A body with shapes presses by
    // them, and not by patches. Bodies of different pads do not depend on each other, whatever their numbers.
    const std::int32_t* body = nullptr;
    // N m, in the world, -1e12..1e12: three numbers, the moment on the pad about the contact's place, as solvers give
    // it of contacts with torsion and rolling friction. Null: none. Shapes press with it; patches do not.
    Reals torque;
    std::size_t pad_step = 1, position_step = 3, force_step = 3, radius_step = 1, ball_step = 1, body_step = 1,
                torque_step = 3;
};

// What bodies look like, in the world: many shapes of one number are one rigid body. The numbers of shape i begin
// i*step behind the first ones. A shape presses where contacts name its pad, which is not tiled, and its body.
struct Shapes {
    std::size_t count = 0;                              // at most 2147483647
    const std::int32_t *pad = nullptr, *body = nullptr; // the pad below which it is, and its body, 0 or more
    const std::int32_t* kind = nullptr;                 // of Body::Kind
    Reals size; // three numbers, as in Body; of a hull how many faces it has, its first one among `faces`, and 0
    Reals position, rotation;      // three and nine numbers, as in Pose: the shape's frame
    const double* faces = nullptr; // of all hulls, four numbers for each as in Body; null where there is no hull
    std::size_t face_count = 0;    // 0..16777216
    std::size_t pad_step = 1, body_step = 1, kind_step = 1, size_step = 3, position_step = 3, rotation_step = 9;
};

// How deep something sinks into the cells of each pad, as tactile sensors of simulators have it, and the force with
// which it does. The numbers of pad i begin i*step behind the first ones.
struct DepthImages {
    Reals depth; // m, -1e6..1e6: height*width numbers, row 0 first; deeper is greater
    Reals force; // N, -1e12..1e12: three numbers, the force on the pad in the pad's own frame, of which -z presses
    // Whether a depth below 0 is a gap that may close. false: where nothing penetrates the image stops at 0 or below,
    // and nothing is known of what is there.
    bool gaps = false;
    std::size_t depth_step = 0, force_step = 3; // depth_step 0: width*height
};

// How bodies press: as on an elastic foundation, a layer of springs side by side. The contacts of a body give the
// force, its centre, and the force and the torsion along the surface; its shapes give the profile. The pressure of a
// cell is stiffness*(depth + level), where that is above 0; by the level the pressures sum to the force, and the depth
// to which the solver lets bodies sink in does not matter. Tilts bring the centre of pressure to that of the contacts,
// unless it is so near a border that the patch would shrink to a line. Contacts count whose force is within 60 degrees
// of the pad's normal. A lower stiffness widens a patch whose radius would be less than about two cells.
struct Source {
    double stiffness = 0; // Pa/m, 1e-6..1e30: of the skin's own, contact::skin_stiffness(). 0 where there are no shapes
    // m of the finger's surface beyond the pad's borders x = 0, x = width*spacing, y = 0 and y = height*spacing: it
    // carries its part of the force, which is then outside. Below 0: so much of the pad is beyond the finger's border.
    std::array<double, 4> around = {0, 0, 0, 0};
};

// The pressures of a batch of pads that have one shape. Only one thread at a time may use it.
class DERMIS_API Touch {
  public:
    // shape: of each pad; its pressure, shear_x and shear_y are null and its pitch 0, because a Touch has memory of its
    // own. count: of pads, 1..1048576; count*width*height at most 2147483647. reach: as in add_contacts(). shear:
    // whether it keeps tractions too, which a Skin with SkinOptions::shear takes. Throws Error::bad_input;
    // Error::no_memory.
    Touch(const Pad& shape, int count, double reach, bool shear = false, const Source& = {});
    ~Touch();
    Touch(Touch&&) noexcept;
    Touch& operator=(Touch&&) noexcept;

    int count() const;        // number of pads
    const Pad& shape() const; // without memory
    // Pa: width*height pressures of each pad, row 0 first; always the same memory.
    const float* pressure() const;
    // Pa: the tractions along x of all pads, laid out as the pressures, then the tractions along y; null without shear.
    const float* traction() const;

    // Takes away what the last call added, and adds contacts as add_contacts() does, those of a pad in their order.
    // Returns the report of all pads: sums, and the greatest pressure of all. Allocates only where there are more
    // contacts than ever before. Throws Error::bad_input, which names the argument, before anything is changed.
    const ContactReport& add(const Poses&, const Contacts&, const Shapes& = {});
    // The same of depths: each pad is an elastic foundation of the source's stiffness. A pad whose force pulls is not
    // pressed.
    const ContactReport& add(const DepthImages&);
    const ContactReport& report(int pad) const; // of the last add(). Throws Error::bad_input

    // The pads that the last add() had contacts for, ascending.
    const std::vector<int>& touched() const;
    // Cells (x, y) .. (x + width - 1, y + height - 1) of a pad, outside of which its pressures are 0. Throws
    // Error::bad_input.
    struct Block {
        int x = 0, y = 0, width = 0, height = 0;
    };
    Block block(int pad) const;

    struct DERMIS_HIDDEN Impl;
    const Impl& impl() const { return *impl_; }

  private:
    std::unique_ptr<Impl> impl_;
};

} // namespace dermis::contact
