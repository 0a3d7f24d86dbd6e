// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

#include <dermis/run.hpp>

namespace dermis::cli {

// Receptors of a fingertip, in every class, over whose crests a texture slides, its pressure along parabolas.
static Scene touched() {
    Scene s = fingertip();
    s.grid = {.width = 61, .height = 37, .spacing = 5e-5};
    s.load.intensity = 1e4;
    s.load.contact = Load::Contact::crests;
    s.load.hold = Hold::parabolic;
    s.load.texture = {.width = 7, .height = 5, .velocity = {0.04, 0.01}};
    for (int i = 0; i < 35; ++i) s.load.texture->map.edit().push_back(1 + i * 11 % 13 / 16.0);
    s.time = {.step = 0x1p-9, .duration = 0x1p-5};
    for (int i = 0; i < 240; ++i) s.sites.push_back({Quantity(QUANTITY_SA1 + i % 4), {i * 31 % 61, i * i * 7 % 37}});
    s.output.traces.clear();
    s.precision = Precision::f32; // every cell is stepped, on the device
    return s;
}

SelfTest::Kernel touch(const Device& device) {
    const Scene surface = touched();
    Scene below = surface;
    below.precision.reset();
    below.model = Model::sites; // in double on the CPU, whatever the device
    below.receptors.depth = {.sa1 = 3e-4, .sa2 = 1e-3, .fa1 = 3e-4, .fa2 = 2e-3};
    SelfTest::Kernel kernel{"touch"};
    for (const Scene& s : {surface, below}) {
        const Result one = run(s, device), two = run(s, Device::cpu(1));
        for (size_t i = 0; i < two.responses.size(); ++i) // in float: last bits in double are the C library's
            kernel.compare(double(float(one.responses[i])), double(float(two.responses[i])));
    }
    return kernel;
}

} // namespace dermis::cli
