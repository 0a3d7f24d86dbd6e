// SPDX-License-Identifier: MIT
// What a Touch has for a Skin that is pressed by it.
#pragma once

#include "dermis/touch.hpp"

namespace dermis::contact {

struct Touch::Impl {
    Impl(const Pad& shape, int count, double reach, bool shear);

    size_t number_of(int pad) const; // throws Error::bad_input
    void need(const Poses&, const Contacts&) const;
    void clear();
    void list(const Contacts&);
    void press(const Poses&, const Contacts&);
    Report pressed_by(int number, const Poses&, const Contacts&);
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
    std::vector<int> first, last, next; // the first and the last contact of a pad, -1: none; the pad's next contact
};

} // namespace dermis::contact
