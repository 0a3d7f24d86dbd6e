// SPDX-License-Identifier: MIT
// Contacts of a simulator on a fingertip: forces at points in the world become pressure on the pad, and the pressure
// the responses of the skin. Here a ball rolls over the pad.
#include <dermis/contact.hpp>
#include <dermis/skin.hpp>

#include <algorithm>
#include <cstdio>

namespace contact = dermis::contact;

int main() {
    constexpr int width = 80, height = 64;
    constexpr double spacing = 2.5e-4, modulus = 5e4; // m, Pa
    dermis::SkinDescription description;
    description.grid.width = width;
    description.grid.height = height;
    description.grid.spacing = spacing;
    description.surface.kind = dermis::Surface::Kind::wave;
    description.surface.relief = 5e-5;
    description.material.modulus = modulus;
    description.material.viscosity = 5e3;
    description.material.thickness = 1e-3;
    description.material.curvature_length = 1e-5;
    description.receptors.depth = dermis::fingertip_depths(); // where receptors feel what presses beside them too
    dermis::Skin skin(dermis::Device::cpu(1), description);

    std::vector<float> pressure(size_t(width) * height);
    contact::Pad pad;
    pad.width = width, pad.height = height, pad.spacing = spacing, pad.pressure = pressure.data();

    // The simulator has the frame of the pad's middle in the world; here the pad faces up, half a metre above the
    // floor.
    contact::Pose middle;
    middle.position = {0, 0, 0.5};
    const contact::Pose pose = middle.from_middle(pad);

    for (int step = 1; step <= 100; ++step) {
        // A solver knows a point, a force and where it pushes. The patch's radius follows from the ball's radius.
        contact::WorldContact ball;
        ball.position = {1e-4 * (step - 50), 0, 0.5};
        ball.direction = {0, 0, -1};
        ball.force = 0.5;
        ball.radius = contact::hertz_radius(ball.force, 8e-3, modulus * 4 / 3);

        std::fill(pressure.begin(), pressure.end(), 0.0f);
        const contact::ContactReport report = contact::add_contacts(pad, pose, 1e-3, {ball});
        if (!report.plausible()) std::printf("%s\n", report.doubts().c_str());
        skin.press(pressure, 0.002);

        if (step % 50 != 0) continue;
        const auto fa1 = skin.response(dermis::Quantity::fa1);
        std::printf("%3d ms: %.3g N on %d cells, at most %.3g Pa; greatest FA1 %.3g\n", step * 2, report.placed,
                    report.cells, report.greatest, *std::max_element(fa1.begin(), fa1.end()));
    }
}
