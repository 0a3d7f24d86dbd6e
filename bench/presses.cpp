// SPDX-License-Identifier: MIT
// Presses of skins: by their number of cells, options, kinds, numbers of pads and sites, and on a device.
#include "bench/skins.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <random>
#include <span>
#include <stdexcept>
#include <thread>

namespace bench {

using namespace dermis;

namespace {

bool software(const Device& device) { return device.info().kind == "software"; }

// Receptors of all classes in turn, in cells drawn at random.
SkinDescription with_sites(SkinDescription d, int count) {
    std::mt19937 random(7);
    constexpr Quantity types[] = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    for (int i = 0; i < count; ++i)
        d.sites.push_back(
            {types[i % 4], {int(random() % unsigned(d.grid.width)), int(random() % unsigned(d.grid.height))}});
    return d;
}

} // namespace

void by_cells(Bench& bench) {
    std::vector<Device> places;
    for (int threads = 1; threads < bench.cores; threads *= 2) places.push_back(Device::cpu(threads));
    places.push_back(Device::cpu(bench.cores));
    for (const Device& device : bench.devices()) places.push_back(device);
    for (int n = 4; n <= (bench.quick ? 512 : 4096); n *= 2) {
        const Press p{.model = "skin", .skin = rectangle(n, n), .method = "exact", .reads_each = true};
        const Frames frames = frames_of(p, 2);
        std::vector<Contender> all;
        for (const Device& place : places) {
            const int most = software(place) ? 20 : 2000, steps = int((software(place) ? 5e5 : 4e6) / n / n);
            all.push_back(pressed(bench, place, "cells", p, std::clamp(steps, 1, most), frames, 2));
        }
        bench.measure(std::move(all), bench.runs);
    }
}

namespace {

constexpr Quantity all_four[] = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
constexpr Quantity three[] = {Quantity::sa1, Quantity::fa1, Quantity::fa2}, two[] = {Quantity::sa1, Quantity::fa1};

struct Option {
    const char* name;
    std::span<const Quantity> responses = all_four;
    Precision precision = Precision::f32;
    bool receptors = false, cells = false; // receptors in place of fields, and the pressures of their cells alone
    size_t frames = 1;                     // of a press
};

const Option all_options[] = {{.name = "all"},
                              {.name = "compensated", .precision = Precision::f32_compensated},
                              {.name = "three", .responses = three},
                              {.name = "two", .responses = two},
                              {.name = "one", .responses = std::span(all_four).first(1)},
                              {.name = "receptors", .receptors = true},
                              {.name = "receptors-cells", .receptors = true, .cells = true},
                              {.name = "frames-4", .frames = 4},
                              {.name = "frames-8", .frames = 8}};

void add_options(Bench& bench, const Device& device, const SkinDescription& d, int pads, int receptors) {
    constexpr size_t ring = 8;
    const Frames frames = frames_of({.skin = d, .options = in_f32(pads)}, ring);
    const double cells = (software(device) ? 2e5 : 2e6) / double(frames->size());
    std::vector<Contender> all;
    for (const Option& o : all_options) {
        Press p{.model = o.name, .skin = o.receptors ? with_sites(d, receptors) : d, .options = in_f32(pads)};
        p.options.precision = o.precision;
        p.options.responses = {o.responses.begin(), o.responses.end()};
        p.frames = o.frames;
        p.cells = o.cells;
        int rings = std::clamp(int(cells), 1, 200);
        if (o.cells && !device.info().vulkan) rings = std::max(rings, 100); // takes microseconds
        all.push_back(pressed(bench, device, "options", p, rings * static_cast<long long>(ring), frames, ring));
    }
    bench.measure(std::move(all), bench.runs);
}

} // namespace

void options(Bench& bench) {
    const int n = bench.quick ? 512 : 2048;
    for (const Device& device : bench.cpus()) {
        add_options(bench, device, rectangle(20, 25), 512, 10);
        add_options(bench, device, rectangle(n, n), 1, 100);
    }
    if (bench.vulkan) add_options(bench, *bench.vulkan, rectangle(20, 25), bench.quick ? 64 : 512, 10);
}

namespace {

struct Kind {
    const char* name;
    int width, height;
    Spread spread = Spread::uniform;
    Stencil stencil = Stencil::five_point;
    int elements = 1;
};

// The first skin of each group is a plain one.
const std::vector<Kind> groups[] = {{{"uniform", 2048, 2048},
                                     {"patches-4", 2048, 2048, Spread::patches},
                                     {"random-4", 2048, 2048, Spread::random},
                                     {"random-1000", 2048, 2048, Spread::thousand}},
                                    {{"width", 1024, 1024},
                                     {"width", 1000, 1024},
                                     {"width", 1023, 1024},
                                     {"fourth-order", 1024, 1024, Spread::uniform, Stencil::fourth_order},
                                     {"published", 1024, 1024, Spread::uniform, published_stencil}},
                                    {{"elements-1", 512, 512},
                                     {"elements-2", 512, 512, Spread::uniform, Stencil::five_point, 2},
                                     {"elements-3", 512, 512, Spread::uniform, Stencil::five_point, 3}}};

Press press_of(const Kind& k) {
    Press p{.model = k.name, .skin = rectangle(k.width, k.height), .method = "exact"};
    p.skin.stencil = k.stencil;
    if (k.stencil != Stencil::five_point) p.stencil = k.name;
    if (k.elements > 1) {
        p.skin.material.modulus.reset();
        p.skin.material.viscosity.reset();
        p.skin.material.elements = chain_of(k.elements, false).elements;
    }
    std::vector<double> moduli;
    for (size_t m : materials_of(k.spread, size_t(k.width))) moduli.push_back(20e3 * (1 + 1e-3 * double(m)));
    p.skin.material.modulus_map = moduli;
    return p;
}

} // namespace

void kinds(Bench& bench) {
    for (const Device& device : bench.cpus())
        for (const std::vector<Kind>& group : groups) {
            std::vector<Contender> all;
            const long long presses = (8LL << 20) / group[0].width / group[0].height;
            for (const Kind& k : group) {
                const Press p = press_of(k);
                all.push_back(pressed(bench, device, "kinds", p, presses, frames_of(p, 2), 2));
            }
            bench.measure(std::move(all), 3 * bench.runs);
        }
}

void streamed_population(Bench& bench) {
    const int n = bench.quick ? 512 : 2048;
    for (bool vulkan : {false, true}) {
        if (vulkan && !bench.vulkan) continue;
        std::vector<Contender> all;
        for (const char* model : {"sites", "march"}) {
            Press p{.model = model, .skin = rectangle(n, n, 50e-6), .method = "exact"};
            if (p.model == "sites") p.skin.sites = dermis::population(p.skin.grid);
            all.push_back(pressed(bench, vulkan ? *bench.vulkan : Device::cpu(bench.cores), "population-frames", p, 5,
                                  frames_of(p, 1, 1e4f), 1));
        }
        bench.measure(std::move(all), bench.runs);
    }
}

namespace {

// Batches of 512 pads and what they are compared with, or sites beside fields.
void add_batches(Bench& bench, const Device& device, std::vector<Press> presses) {
    std::vector<Contender> all;
    for (const Press& p : presses) {
        const double work = device.info().vulkan ? 5e5 : 2e6, cells = double(p.cells_of_frame() * p.skins);
        const Frames frames = frames_of(p, 2, p.model == "at-rest" ? 0 : 1e4f);
        all.push_back(pressed(bench, device, "pads-batch", p, std::clamp(int(work / cells), 2, 2000), frames, 2));
    }
    bench.measure(std::move(all), bench.runs);
}

// The time of a press by shape, number of pads, threads and precision. Above `most_at_once` cells one thread and all of
// them are timed apart, because all skins together would take too much memory, and a software device is left out.
void add_presses(Bench& bench, const SkinDescription& d, int pads) {
    constexpr long long most_at_once = 1 << 22;
    const Press shape{.model = "batch", .skin = d, .options = in_f32(pads)};
    const long long cells = shape.cells_of_frame();
    const int presses = std::clamp(int((bench.quick ? 5e5 : 2e6) / double(cells)), 2, 2000);
    std::vector<std::vector<Device>> rounds = {bench.cpus()};
    if (bench.vulkan) rounds[0].push_back(*bench.vulkan);
    if (cells > most_at_once) rounds.assign({{Device::cpu(1)}, {Device::cpu(bench.cores)}});
    const Frames frames = frames_of(shape, 4);
    for (const std::vector<Device>& together : rounds) {
        std::vector<Contender> all;
        for (const Device& device : together) {
            const bool vulkan = device.info().vulkan;
            const int steps = software(device) ? std::clamp(int(3e5 / double(cells)), 1, 20) : presses;
            const bool beside = !vulkan && d.grid.width <= 64;
            if (beside) all.push_back(native_pads(bench, device, d, pads, presses, frames, 4));
            for (Precision precision : {Precision::f32, Precision::f32_compensated}) {
                Press p = shape;
                p.options.precision = precision;
                Contender c = pressed(bench, device, "pads", p, steps, frames, 4);
                if (beside && precision == Precision::f32) c.ratio_to = "native-bits", c.reference = all.size() - 1;
                all.push_back(std::move(c));
            }
        }
        bench.measure(std::move(all), bench.runs);
    }
}

Measurement cells_row(Measurement r, const char* model, int width, long long height) {
    r = row_of(r, model, r.precision, 1);
    r.width = width;
    r.height = height;
    return r;
}

// Saving and loading the state of 2000 pads, beside a copy of the same number of bytes.
void add_state(Bench& bench) {
    SkinOptions options;
    options.count = 2000;
    Skin skin(Device::cpu(), rectangle(20, 25), options);
    skin.press(std::vector<float>(size_t(options.count) * 500, 1e4f), press_dt);
    std::vector<char> state(skin.state_bytes()), copy(state.size());
    skin.save(state.data(), state.size());
    const auto row = [&](const char* model) {
        return cells_row(bench.cpu("state", 0, bench.cores), model, 20, 25LL * options.count);
    };
    const auto timed = [](auto call) { return [call] { return seconds_of(call); }; };
    bench.measure({{row("memcpy"), timed([&] { std::memcpy(copy.data(), state.data(), state.size()); })},
                   {row("save"), timed([&] { skin.save(state.data(), state.size()); })},
                   {row("load"), timed([&] { skin.load(state.data(), state.size()); })}},
                  3 * bench.runs);
}

// Making 4096 pads, and the second skin of a kind on a device.
void add_made(Bench& bench, const Device& device) {
    for (int count : {4096, 1}) {
        SkinOptions options;
        options.count = count;
        bench.measure(
            cells_row(bench.on(device, "pads-made", 0), count == 1 ? "second-skin" : "batch", 20, 25LL * count),
            [&] { return seconds_of([&] { Skin(device, rectangle(20, 25), options); }); }, bench.runs);
    }
}

// Presses at 1 kHz, and the same number of waits with nothing to do, which show how late the machine itself is.
void add_paced(Bench& bench, const char* model, const SkinDescription& d) {
    using Clock = std::chrono::steady_clock;
    std::optional<Skin> skin;
    if (model != std::string("empty")) skin.emplace(Device::cpu(1), d, in_f32());
    const std::vector<float> frame(size_t(d.grid.width) * size_t(d.grid.height), 1e4f);
    const int steps = bench.quick ? 500 : 5000;
    std::vector<double> seconds;
    int in_time = 0;
    Clock::time_point due = Clock::now();
    for (int i = 0; i < steps; ++i) {
        due += std::chrono::milliseconds(1);
        std::this_thread::sleep_until(due);
        const auto begin = Clock::now();
        if (skin) skin->press(frame, press_dt);
        seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
        in_time += seconds.back() < 1e-3;
    }
    Measurement r = cells_row(bench.cpu("paced", 0, 1), model, d.grid.width, d.grid.height);
    r.precision = "f32";
    r.receptors = static_cast<long long>(d.sites.size());
    r.wall = timing_of(std::move(seconds));
    r.limit = "1 ms";
    r.of_limit = double(in_time) / steps;
    bench.add(r);
}

} // namespace

void pads(Bench& bench) {
    const SkinDescription small = rectangle(20, 25), hand = rectangle(240, 320);
    const Press batch{.model = "batch", .skin = small, .options = in_f32(512)},
        one{.model = "one-skin", .skin = rectangle(512, 500)}, skins{.model = "skins", .skin = small, .skins = 512},
        rests{.model = "at-rest", .skin = small, .options = in_f32(512)},
        sites{.model = "batch-sites", .skin = with_sites(small, 80), .options = in_f32(512)};
    add_batches(bench, Device::cpu(1), {batch, one, skins, rests, sites});
    if (bench.vulkan) add_batches(bench, *bench.vulkan, {batch, one, rests, sites});
    for (int count : {12000, 3000, 300})
        add_batches(bench, Device::cpu(1),
                    {{.model = "sites", .skin = with_sites(hand, count)}, {.model = "fields", .skin = hand}});
    const long long most = bench.quick ? 70000 : 1 << 24; // cells
    for (const auto& [width, height] : {std::pair{4, 4}, {4, 6}, {8, 8}, {16, 16}, {20, 25}, {64, 64}})
        for (int count : {1, 64, 512, 4096})
            if (static_cast<long long>(count) * width * height <= most)
                add_presses(bench, rectangle(width, height), count);
    add_presses(bench, hand, 1);
    if (!bench.quick) add_presses(bench, rectangle(1024, 1024), 1);
    add_state(bench);
    add_made(bench, Device::cpu());
    if (bench.vulkan) add_made(bench, *bench.vulkan);
    add_paced(bench, "empty", hand);
    add_paced(bench, "sites", with_sites(hand, 12000));
    add_paced(bench, "fields", hand);
}

void construction(Bench& bench) {
    for (int n : bench.quick ? std::vector{512, 1024} : std::vector{512, 1024, 2048, 4096}) {
        std::vector<Contender> all;
        for (bool noise : {false, true}) {
            SkinDescription d;
            d.grid = {n, n, {}};
            d.surface.kind = Surface::Kind::wave;
            if (!noise) d.surface.noise = 0;
            Contender& c = all.emplace_back();
            c.row = row_of(bench.cpu(noise ? "construction-noise" : "construction", n, bench.cores), "skin", "", 0);
            c.row.method = "";
            c.work = [d] {
                std::optional<Skin> skin;
                return seconds_of([&] { skin.emplace(Device::cpu(), d); });
            };
        }
        bench.measure(std::move(all), n > 2048 ? 1 : 3);
    }
}

} // namespace bench
