// SPDX-License-Identifier: MIT
// The bytes of a saved state, after one byte that says of which skin. A state that is taken is saved as it was, or, if
// it is of version 2, in the present version and from then on the same; the skin goes on from it.
#include "tests/fuzz/fuzz.hpp"

#include <memory>

using namespace dermis;

namespace {

// Skins of 3 x 2 cells: of one element, of two and a spring, with receptors; compensated or not.
std::unique_ptr<Skin> skin_of(int variant) {
    Scene s;
    s.grid = {3, 2, {}};
    if (variant & 1) {
        s.material.elements = {{3, 0.05}, {2, 0.9}};
        s.material.spring = 5;
    }
    if (variant & 2) s.sites = {{Quantity::sa1, {1, 0}}, {Quantity::fa2, {2, 1}}};
    SkinOptions options{.precision = variant & 4 ? Precision::f32 : Precision::f32_compensated};
    return std::make_unique<Skin>(Device::cpu(1), s, options);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static std::unique_ptr<Skin> skins[8];
    if (!size) return 0;
    std::unique_ptr<Skin>& skin = skins[data[0] % 8];
    if (!skin) skin = skin_of(data[0] % 8);
    if (!fuzz::taken([&] { skin->load(data + 1, size - 1); })) return 0;
    std::vector<unsigned char> taken(data + 1, data + size), again(skin->state_bytes());
    if (data[9] == 2) {
        taken.resize(again.size());
        skin->save(taken.data(), taken.size());
        skin->load(taken.data(), taken.size());
    }
    skin->save(again.data(), again.size());
    fuzz::need(again == taken, "another state");
    const std::vector<float> pressure(6, 1);
    fuzz::taken([&] { skin->press(pressure, 0.01); });
    fuzz::taken([&] { skin->report(); });
    skin->reset();
    return 0;
}
