// SPDX-License-Identifier: MIT
// Sites on 1 cm2 of fingertip, one for each receptor that it has, tapped frame by frame: only the cells that the sites
// need are computed, and each press returns one value for each site.
#include <dermis/skin.hpp>

#include <algorithm>
#include <cstdio>
#include <vector>

int main() {
    using dermis::Quantity;

    dermis::SkinDescription skin_with_units;
    // With a spacing between cells all lengths are in metres, and have to be given.
    skin_with_units.grid.width = 400;
    skin_with_units.grid.height = 400;
    skin_with_units.grid.spacing = 2.5e-5;
    skin_with_units.surface.kind = dermis::Surface::Kind::wave;
    skin_with_units.surface.ridges = 20;
    skin_with_units.surface.relief = 5e-5;
    skin_with_units.material.modulus = 5e4;
    skin_with_units.material.viscosity = 5e3;
    skin_with_units.material.thickness = 1e-3;
    skin_with_units.material.curvature_length = 1e-5;

    // By default densities of the human fingertip; the seed decides where each site lies.
    dermis::Density density;
    density.sa1 = 100;
    skin_with_units.sites = dermis::population(skin_with_units.grid, density, 7);
    std::printf("%zu sites\n", skin_with_units.sites.size());

    dermis::Skin skin(dermis::Device::cpu(1), skin_with_units);
    std::vector<float> pressure(400 * 400);
    for (int step = 1; step <= 100; ++step) {
        // Twenty steps of 2 ms under even pressure, then twenty without.
        std::fill(pressure.begin(), pressure.end(), (step - 1) / 20 % 2 == 0 ? 1e4f : 0.0f);
        skin.press(pressure, 0.002);

        // The responses of a class come in the order in which its sites stand in `sites`.
        if (step % 20 != 0) continue;
        std::printf("%3d ms:", step * 2);
        for (Quantity type : {Quantity::sa1, Quantity::fa1}) {
            const auto response = skin.response(type);
            double sum = 0;
            for (float value : response) sum += value;
            std::printf("  %s of %zu sites, mean %.4g", name(type), response.size, sum / double(response.size));
        }
        std::printf("\n");
    }
}
