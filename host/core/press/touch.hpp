// SPDX-License-Identifier: MIT
// What a Touch has for a Skin that is pressed by it.
#pragma once

#include "dermis/touch.hpp"

namespace dermis::contact {

// A contact that was copied: its number of a pad, the next contact of the pad, -1: none, and the radius of its ball, m,
// 0 where it has a radius.
struct Listed {
    int pad, next;
    double ball;
    WorldContact contact;
};

struct Touch::Impl {
    Impl(const Pad& shape, int count, double reach, bool shear);

    size_t number_of(int pad) const; // throws Error::bad_input
    void take(const Poses&, const Contacts&);
    void clear();
    void list();
    Report pressed_by(int number, double modulus);
    Pad pad(int number);

    const Pad shape;
    const int count;
    const double reach;
    const size_t cells;                    // of a pad
    std::vector<float> pressure, traction; // traction: empty without shear
    std::vector<Report> reports;           // of each pad
    Report all;
    std::vector<Block> pressed;         // of each pad, the cells that may hold a pressure
    std::vector<int> touched;           // pads with contacts, ascending
    std::vector<unsigned char> touches; // whether a pad is one of them
    std::vector<Pose> poses;            // of each pad with contacts
    std::vector<Listed> contacts;       // of the last call
    std::vector<int> first, last;       // the first and the last contact of a pad, where it has some
};

} // namespace dermis::contact
