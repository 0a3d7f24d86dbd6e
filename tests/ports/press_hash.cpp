// SPDX-License-Identifier: MIT
// Presses skins of many kinds on the CPU by the core alone, and prints a hash of the bits of responses, spikes and
// state for each. What it prints is the same on every system.
#include "dermis/skin.hpp"

#include <cstdio>
#include <cstring>
#include <exception>

using namespace dermis;

namespace {

// FNV-1a of bytes.
class Hash {
  public:
    void add(const void* bytes, size_t count) {
        for (size_t i = 0; i < count; ++i)
            value_ = (value_ ^ static_cast<const unsigned char*>(bytes)[i]) * 1099511628211u;
    }
    unsigned long long value() const { return value_; }

  private:
    unsigned long long value_ = 14695981039346656037u;
};

SkinDescription ridged(int width, int height) {
    SkinDescription d;
    d.grid = {width, height, 50e-6};
    d.surface.kind = Surface::Kind::spiral;
    d.surface.relief = 5e-5;
    d.material.modulus = 20e3, d.material.viscosity = 1e3;
    d.material.thickness = 1e-3, d.material.curvature_length = 1e-5;
    return d;
}

// Presses six frames, each step four times as long as the one before.
void press(const char* name, const SkinDescription& d, const SkinOptions& options) {
    Skin skin(Device::cpu(2), d, options);
    const size_t cells = size_t(options.count) * size_t(d.grid.width) * size_t(d.grid.height);
    std::vector<float> given(options.shear ? 3 * cells : cells); // pressures, then tractions along x and y
    Hash hash;
    const float most = options.control == Control::depth ? 1e-4f : 1e4f; // m or Pa
    unsigned number = 1;
    double dt = 0x1p-10;
    for (int frame = 0; frame < 6; ++frame, dt *= 4) {
        for (float& p : given) number = number * 1664525u + 1013904223u, p = most * float(number >> 8) / (1 << 24);
        if (options.shear) skin.press(given.data(), given.data() + cells, cells, dt);
        else skin.press(given, dt);
        for (const Quantity q : {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2}) {
            const Skin::Response r = skin.response(q);
            hash.add(r.data, r.size * sizeof(float));
        }
        hash.add(skin.spikes().data, skin.spikes().size * sizeof(Spike));
    }
    std::vector<char> state(skin.state_bytes());
    skin.save(state.data(), state.size());
    hash.add(state.data(), state.size());
    std::printf("%-12s %3d x %-3d %016llx\n", name, d.grid.width, d.grid.height, hash.value());
    std::fflush(stdout);
}

void press_all(int width, int height) {
    const SkinDescription plain = ridged(width, height);
    press("plain", plain, {});
    press("parabolic", plain, {.hold = Hold::parabolic});
    press("compensated", plain, {.precision = Precision::f32_compensated});
    press("batch", plain, {.count = 5});
    press("depth", plain, {.control = Control::depth});
    press("shear", plain, {.shear = true});
    SkinDescription d = plain;
    d.stencil = Stencil::fourth_order, d.edges = Edges::periodic;
    press("periodic", d, {});
    d = plain;
    d.material.modulus = Material().modulus, d.material.viscosity = Material().viscosity;
    d.material.elements = {{.modulus = 2e4, .viscosity = 1e2}, {.modulus = 5e4, .viscosity = 1e4}};
    d.material.spring = 1e5;
    press("chain", d, {});
    d = plain;
    for (int i = 0; i < 40; ++i) d.sites.push_back({Quantity(1 + i % 4), {i * 7 % width, i * 5 % height}});
    press("sites", d, {});
    d = plain;
    d.receptors.depth.sa1 = 3e-4, d.receptors.depth.fa1 = 5e-4, d.receptors.depth.fa2 = 2e-3;
    press("at depths", d, {});
    SkinOptions options;
    for (const Quantity type : {Quantity::sa1, Quantity::fa1, Quantity::fa2}) {
        Afferents a;
        a.type = type;
        a.cells = {{0, 0}, {width / 2, height / 2}, {width - 1, height - 1}};
        options.afferents.push_back(a);
    }
    press("fibres", plain, options);
}

} // namespace

int main() try {
    for (const auto& [width, height] : {std::pair{16, 16}, {41, 31}, {101, 97}}) press_all(width, height);
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
