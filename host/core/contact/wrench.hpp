// SPDX-License-Identifier: MIT
// Contacts of one body on one pad as one force.
#pragma once

#include "host/core/contact/landing.hpp"

namespace dermis::contact {

// Sums over contacts. Places are along the pad's surface, m from its middle.
struct Wrench {
    double force = 0, whole = 0;       // N: the components into the pad, and the whole forces
    double along_x = 0, along_y = 0;   // N
    double moment_x = 0, moment_y = 0; // N m: force times place; their quotient is the centre of pressure
    double torsion = 0;                // N m, about the normal in the middle
    bool off_pad = false;              // whether a contact is beyond the pad's border

    void add(const Pad& pad, const Landing& l) {
        const double x = l.patch.x - 0.5 * pad.width * pad.spacing, y = l.patch.y - 0.5 * pad.height * pad.spacing;
        // A force along a flat pad above or below its plane has a moment, which the centre of pressure takes.
        const double lever = pad.radius_x == 0 && pad.radius_y == 0 ? l.above : 0;
        force += l.patch.force, whole += l.whole;
        along_x += l.along_x, along_y += l.along_y;
        moment_x += l.patch.force * x + lever * l.along_x;
        moment_y += l.patch.force * y + lever * l.along_y;
        torsion += x * l.along_y - y * l.along_x;
        off_pad = off_pad || l.patch.x < 0 || l.patch.x > pad.width * pad.spacing || l.patch.y < 0 ||
                  l.patch.y > pad.height * pad.spacing;
    }
};

} // namespace dermis::contact
