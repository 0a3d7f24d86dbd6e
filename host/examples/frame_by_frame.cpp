// SPDX-License-Identifier: MIT
// A skin inside a simulation: each frame hands it a pressure map and reads its responses. Here a round indenter goes
// down and slides over ridged skin.
#include <dermis/skin.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace {

constexpr int width = 160, height = 120;
constexpr double dt = 1.0 / 60; // s, one frame of the simulation

// Stands for the contact model of a simulator: pressure in Pa on every cell, row 0 first. The pressure falls off as
// under a ball that is pressed into an elastic ground.
void contact(std::vector<float>& pressure, double center_x, double peak) {
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double r = std::hypot(x - center_x, y - height / 2) / 25;
            pressure[size_t(y) * width + x] = r < 1 ? float(peak * std::sqrt(1 - r * r)) : 0.0f;
        }
}

} // namespace

int main() {
    // A description holds what stays the same from frame to frame: grid, ridges, material, sites.
    dermis::SkinDescription description;
    description.grid.width = width;
    description.grid.height = height;
    description.surface.kind = dermis::Surface::Kind::wave;
    description.material.viscosity = 0.2;

    // Only the responses that are asked for are computed.
    dermis::SkinOptions options;
    options.responses = {dermis::Quantity::sa1, dermis::Quantity::fa1};

    // One thread, the caller's own, suits a loop that has other work for the other cores.
    dermis::Skin skin(dermis::Device::cpu(1), description, options);

    std::vector<float> pressure(size_t(width) * height);
    for (int frame = 1; frame <= 60; ++frame) {
        // For 20 frames the indenter goes down in place, then it slides to the right.
        contact(pressure, 50 + std::max(0, frame - 20), std::min(frame, 20) / 20.0);

        // The pressure at the end of the frame; since the last frame it has run linearly to this one.
        skin.press(pressure, dt);

        // A response refers to memory of the skin, which the next press overwrites.
        const auto sa1 = skin.response(dermis::Quantity::sa1);
        const auto fa1 = skin.response(dermis::Quantity::fa1);
        if (frame % 20 == 0)
            std::printf("frame %d: greatest SA1 %.4f, greatest FA1 %.4f\n", frame,
                        *std::max_element(sa1.begin(), sa1.end()), *std::max_element(fa1.begin(), fa1.end()));
    }
}
