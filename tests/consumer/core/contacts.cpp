// SPDX-License-Identifier: MIT
// Contacts alone, from floats and from doubles: nothing else of the library is linked.
#include <dermis/touch.hpp>

#include <cstdio>

namespace contact = dermis::contact;

// The force that presses 20 x 20 cells of depth 1e-4 m, and a batch with one contact.
template <class Real> double placed() {
    std::vector<float> pressure(400);
    contact::Pad pad;
    pad.width = pad.height = 20;
    pad.spacing = 5e-4;
    pad.pressure = pressure.data();
    const std::vector<Real> depth(400, Real(1e-4));
    contact::DepthMap map;
    map.depth = depth.data();
    map.force = 0.5;
    const double by_depth = contact::add_depths(pad, map).placed;

    pad.pressure = nullptr;
    contact::Touch touch(pad, 1, 1e-3);
    const Real middle[3] = {}, rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, force[3] = {0, 0, Real(-0.5)},
               radius = Real(2e-3);
    const std::int32_t first = 0;
    contact::Poses poses;
    poses.position = middle;
    poses.rotation = rotation;
    contact::Contacts contacts;
    contacts.count = 1;
    contacts.pad = &first;
    contacts.position = middle;
    contacts.force = force;
    contacts.radius = &radius;
    return by_depth + touch.add(poses, contacts).placed;
}

int main() { std::printf("%.6g N, %.6g N\n", placed<float>(), placed<double>()); }
