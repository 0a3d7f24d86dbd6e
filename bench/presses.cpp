// SPDX-License-Identifier: MIT
// Presses of skins: by their number of cells, options, kinds, numbers of pads and sites, and on a device.
#include "bench/skins.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <random>
#include <stdexcept>
#include <thread>

namespace bench {

using namespace dermis;

namespace {

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
    for (int n = 4; n <= (bench.quick ? 512 : 4096); n *= 2)
        measure_presses(bench, "cells", places,
                        {{.model = "skin", .skin = rectangle(n, n), .method = "exact", .reads_each = true}},
                        {4e6, 5e5, 1, 2000, 20}, bench.runs);
}

namespace {

void add_options(Bench& bench, const Device& device, const SkinDescription& d, int pads, int receptors) {
    const auto all = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    std::vector<Press> presses(9, {.skin = d, .options = in_f32(pads), .ring = 8});
    for (Press& p : presses) p.options.responses = all;
    for (const size_t i : {5, 6}) presses[i].skin = with_sites(d, receptors);
    const char* names[] = {"all",       "compensated",     "three",    "two",     "one",
                           "receptors", "receptors-cells", "frames-4", "frames-8"};
    for (size_t i = 0; i < 9; ++i) presses[i].model = names[i];
    presses[1].options.precision = Precision::f32_compensated;
    presses[2].options.responses = {Quantity::sa1, Quantity::fa1, Quantity::fa2};
    presses[3].options.responses = {Quantity::sa1, Quantity::fa1};
    presses[4].options.responses = {Quantity::sa1};
    presses[6].cells = true; // the pressures of their cells alone
    presses[7].frames = 4;
    presses[8].frames = 8;
    measure_presses(bench, "options", {device}, presses, {2e6, 2e5, 1, 200, 200, 8}, bench.runs);
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

Press kind(const char* model, int width, int height, Spread spread = Spread::uniform,
           Stencil stencil = Stencil::five_point, int elements = 1) {
    Press p{.model = model, .skin = rectangle(width, height), .method = "exact"};
    p.skin.stencil = stencil;
    if (stencil != Stencil::five_point) p.stencil = model;
    if (elements > 1) {
        p.skin.material.modulus.reset();
        p.skin.material.viscosity.reset();
        p.skin.material.elements = chain_of(elements, false).elements;
    }
    std::vector<double> moduli;
    for (size_t m : materials_of(spread, size_t(width))) moduli.push_back(20e3 * (1 + 1e-3 * double(m)));
    p.skin.material.modulus_map = moduli;
    return p;
}

} // namespace

// The first skin of each round is a plain one.
void kinds(Bench& bench) {
    for (const Device& device : bench.cpus()) {
        const auto measure = [&](int presses, const std::vector<Press>& round) {
            measure_presses(bench, "kinds", {device}, round, fixed(presses), 3 * bench.runs);
        };
        measure(2, {kind("uniform", 2048, 2048), kind("patches-4", 2048, 2048, Spread::patches),
                    kind("random-4", 2048, 2048, Spread::random), kind("random-1000", 2048, 2048, Spread::thousand)});
        measure(8, {kind("width", 1024, 1024), kind("width", 1000, 1024), kind("width", 1023, 1024),
                    kind("fourth-order", 1024, 1024, Spread::uniform, Stencil::fourth_order),
                    kind("published", 1024, 1024, Spread::uniform, published_stencil)});
        measure(32,
                {kind("elements-1", 512, 512), kind("elements-2", 512, 512, Spread::uniform, Stencil::five_point, 2),
                 kind("elements-3", 512, 512, Spread::uniform, Stencil::five_point, 3)});
    }
}

Press hand_of_sites(int n) {
    Press p{.model = "sites", .skin = rectangle(n, n, 50e-6), .method = "exact", .ring = 1, .pressure = 1e4f};
    p.skin.sites = dermis::population(p.skin.grid);
    return p;
}

void streamed_population(Bench& bench) {
    const Press sites = hand_of_sites(bench.quick ? 512 : 2048);
    Press fields = sites;
    fields.model = "march";
    fields.skin.sites.clear();
    std::vector<Device> places = {Device::cpu(bench.cores)};
    if (bench.vulkan) places.push_back(*bench.vulkan);
    for (const Device& place : places)
        measure_presses(bench, "population-frames", {place}, {sites, fields}, fixed(5), bench.runs);
}

namespace {

// Batches of 512 pads and what they are compared with, or sites beside fields.
void add_batches(Bench& bench, const Device& device, const std::vector<Press>& presses) {
    measure_presses(bench, "pads-batch", {device}, presses, {2e6, 5e5, 2}, bench.runs);
}

// The time of a press by shape, number of pads, threads and precision. Above `most_at_once` cells one thread and all of
// them are timed apart, because all skins together would take too much memory, and a software device is left out.
void add_presses(Bench& bench, const SkinDescription& d, int pads) {
    constexpr long long most_at_once = 1 << 22;
    Press native{.model = "native-bits", .skin = d, .options = in_f32(pads), .ring = 4, .native = true}, f32 = native;
    f32.model = "batch";
    f32.native = false;
    f32.ratio_to = native.model;
    Press compensated = f32;
    compensated.options.precision = Precision::f32_compensated;
    compensated.ratio_to = "";
    std::vector<std::vector<Device>> rounds = {bench.cpus()};
    if (bench.vulkan) rounds[0].push_back(*bench.vulkan);
    if (f32.cells_of_frame() > most_at_once) rounds.assign({{Device::cpu(1)}, {Device::cpu(bench.cores)}});
    std::vector<Press> presses = {f32, compensated};
    if (d.grid.width <= 64) presses.insert(presses.begin(), native);
    for (const std::vector<Device>& together : rounds)
        measure_presses(bench, "pads", together, presses, {bench.quick ? 5e5 : 2e6, 3e5, 1, 2000, 20}, bench.runs);
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
    const Press batch{.model = "batch", .skin = small, .options = in_f32(512), .pressure = 1e4f},
        one{.model = "one-skin", .skin = rectangle(512, 500), .pressure = 1e4f},
        skins{.model = "skins", .skin = small, .skins = 512, .pressure = 1e4f},
        rests{.model = "at-rest", .skin = small, .options = in_f32(512), .pressure = 0},
        sites{.model = "batch-sites", .skin = with_sites(small, 80), .options = in_f32(512), .pressure = 1e4f};
    add_batches(bench, Device::cpu(1), {batch, one, skins, rests, sites});
    if (bench.vulkan) add_batches(bench, *bench.vulkan, {batch, one, rests, sites});
    for (int count : {12000, 3000, 300})
        add_batches(bench, Device::cpu(1),
                    {{.model = "sites", .skin = with_sites(hand, count), .pressure = 1e4f},
                     {.model = "fields", .skin = hand, .pressure = 1e4f}});
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
