// SPDX-License-Identifier: MIT
// Measures how long a press takes for each kind of skin: several materials, rows that end within a cache line, other
// stencils, elements in series. The first skin of each group is a plain one. The skins of a group are pressed in
// the same rounds, in f32 on the CPU path.
#include "bench/skins.hpp"

namespace bench {

using namespace dermis;

namespace {

struct Kind {
    const char* name;
    int width, height;
    Spread spread = Spread::uniform;
    Stencil stencil = Stencil::five_point;
    int elements = 1;
};

const std::vector<Kind> groups[] = {
    {{.name = "uniform", .width = 2048, .height = 2048},
     {.name = "patches-4", .width = 2048, .height = 2048, .spread = Spread::patches},
     {.name = "random-4", .width = 2048, .height = 2048, .spread = Spread::random},
     {.name = "random-1000", .width = 2048, .height = 2048, .spread = Spread::thousand}},
    {{.name = "width", .width = 1024, .height = 1024},
     {.name = "width", .width = 1000, .height = 1024},
     {.name = "width", .width = 1023, .height = 1024},
     {.name = "fourth-order", .width = 1024, .height = 1024, .stencil = Stencil::fourth_order},
     {.name = "published", .width = 1024, .height = 1024, .stencil = published_stencil}},
    {{.name = "elements-1", .width = 512, .height = 512},
     {.name = "elements-2", .width = 512, .height = 512, .elements = 2},
     {.name = "elements-3", .width = 512, .height = 512, .elements = 3}}};

SkinDescription description_of(const Kind& k) {
    SkinDescription d = rectangle(k.width, k.height);
    d.stencil = k.stencil;
    if (k.elements > 1) {
        d.material.modulus.reset();
        d.material.viscosity.reset();
        d.material.elements = chain_of(k.elements, false).elements;
    }
    std::vector<double> moduli;
    for (size_t m : materials_of(k.spread, size_t(k.width))) moduli.push_back(20e3 * (1 + 1e-3 * double(m)));
    d.material.modulus_map = moduli;
    return d;
}

} // namespace

void kinds(Bench& bench) {
    SkinOptions options;
    options.precision = Precision::f32;
    for (int threads : bench.cores > 1 ? std::vector{1, bench.cores} : std::vector{1})
        for (const std::vector<Kind>& group : groups) {
            std::vector<Skin> skins;
            std::vector<std::function<double()>> work;
            skins.reserve(group.size());
            const size_t most = size_t(group[0].width) * size_t(group[0].height), presses = (size_t(8) << 20) / most;
            const std::vector<float> frames = random_frames(most, 2);
            for (const Kind& k : group) {
                Skin& skin = skins.emplace_back(Device::cpu(threads), description_of(k), options);
                const auto press = [&skin, &frames, most, cells = size_t(k.width) * size_t(k.height)](size_t count) {
                    for (size_t i = 0; i < count; ++i) skin.press(frames.data() + most * (i % 2), cells, press_dt);
                };
                press(2);
                work.push_back([press, presses] { return seconds_of([&] { press(presses); }); });
            }
            const std::vector<Timing> timings = bench.paired(work, 3 * bench.runs);
            for (size_t i = 0; i < group.size(); ++i) {
                Measurement r = bench.cpu("kinds", group[i].width, threads);
                r.model = group[i].name;
                if (group[i].stencil != Stencil::five_point) r.stencil = group[i].name;
                r.precision = "f32";
                r.height = group[i].height;
                r.steps = static_cast<long long>(presses);
                r.wall = timings[i];
                bench.add(r);
            }
        }
}

} // namespace bench
