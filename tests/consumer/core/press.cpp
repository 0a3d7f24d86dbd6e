// SPDX-License-Identifier: MIT
// What a simulator embeds: contacts become pressure, a skin is pressed, and a SkinProgram says what it asks of a
// device.
#include <dermis/contact.hpp>
#include <dermis/device.hpp>
#include <dermis/skin.hpp>
#include <dermis/vulkan.hpp>

#include <algorithm>
#include <cstdio>
#include <vector>

int main() {
    dermis::SkinDescription description;
    description.grid.width = description.grid.height = 20;
    description.grid.spacing = 5e-4;
    description.surface.relief = 5e-5;
    description.material.modulus = 1e5;
    description.material.viscosity = 5e3;
    description.material.thickness = 1e-3;
    description.material.curvature_length = 1e-5;
    dermis::Skin skin(dermis::Device::cpu(1), description);

    std::vector<float> pressure(400);
    dermis::contact::Pad pad;
    pad.width = pad.height = 20;
    pad.spacing = 5e-4;
    pad.pressure = pressure.data();
    dermis::contact::Contact finger;
    finger.x = finger.y = 5e-3;
    finger.force = 0.5;
    finger.radius = 2e-3;
    const dermis::contact::ContactReport report = dermis::contact::add_contacts(pad, {finger});
    skin.press(pressure, 0.01);
    const auto sa1 = skin.response(dermis::Quantity::sa1);

    bool refused = false;
    try {
        dermis::vulkan::SkinProgram program({}, description, 1); // no device
    } catch (const dermis::Error& e) {
        refused = e.code() == dermis::Error::Code::bad_input;
    }
    std::printf("%.3g N, greatest SA1 %.3g, no device %s\n", report.placed, *std::max_element(sa1.begin(), sa1.end()),
                refused ? "refused" : "taken");
}
