// SPDX-License-Identifier: MIT
// The members of a Touch that a Skin reads when the Touch presses it.
#pragma once

#include "dermis/touch.hpp"
#include "host/core/contact/landing.hpp"

namespace dermis::contact {

// A contact that was copied: its number of a pad, and the radius of its ball, m, 0 where it has a radius.
struct Listed {
    int pad;
    double ball = 0;
    WorldContact contact = {};
};

struct Touch::Impl {
    Impl(const Pad& shape, int count, double reach, bool shear);

    size_t number_of(int pad) const; // throws Error::bad_input
    void take(const Poses&, const Contacts&);
    void clear();
    void list();
    ContactReport pressed_by(int number, double modulus);
    Pad pad(int number);

    const Pad shape;
    const int count;
    const double reach;
    const size_t cells;                    // of a pad
    std::vector<float> pressure, traction; // traction: empty without shear
    std::vector<ContactReport> reports;    // of each pad
    ContactReport all;
    std::vector<Block> pressed;       // of each pad, the cells that may hold a pressure
    std::vector<int> touched;         // pads with contacts, ascending
    std::vector<Pose> poses;          // of each pad with contacts
    std::vector<Listed> contacts;     // of the last call
    std::vector<const Listed*> order; // by pads, ascending, those of a pad in their order
    std::vector<size_t> counts, ends; // of each pad, how many contacts it has, and behind which of `order` they end
};

} // namespace dermis::contact
