// SPDX-License-Identifier: MIT
// Contacts of a whole batch beside the presses that they lead to: few of many pads, all pads of 64 hands, and shear.
#include "dermis/touch.hpp"
#include "bench/skins.hpp"

#include <algorithm>
#include <stdexcept>

namespace bench {

using namespace dermis;

namespace {

constexpr int side = 48, flat_side = 16;
constexpr double flat_spacing = 1.5e-3; // m

// Contacts of a batch, as patches or by the shapes of bodies.
struct Laid {
    contact::Touch touch;
    std::vector<double> position{}, force{}, size{}, place{}, rotation{};
    std::vector<int32_t> pad{}, shape_pad{}, kind{};
    double radius = 0; // m, of a patch; 0: shapes press
    std::vector<double> middles = std::vector<double>(size_t(3 * touch.count()));
    std::vector<int32_t> body = {};
    void add() {
        constexpr double axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        body.resize(pad.size());
        touch.add({.position = middles.data(), .rotation = axes, .rotation_step = 0},
                  {.count = pad.size(),
                   .pad = pad.data(),
                   .position = position.data(),
                   .force = force.data(),
                   .radius = radius > 0 ? &radius : nullptr,
                   .body = radius > 0 ? nullptr : body.data(),
                   .radius_step = 0},
                  {.count = shape_pad.size(),
                   .pad = shape_pad.data(),
                   .body = body.data(),
                   .kind = kind.data(),
                   .size = size.data(),
                   .position = place.data(),
                   .rotation = rotation.data()});
    }
};

// A contact in the middle of every nth round pad, of a patch with a radius of 2.4 cells.
Laid patches(int pads, int every) {
    const contact::Pad pad{.width = side, .height = side, .spacing = 2.5e-4, .radius_x = 8e-3, .radius_y = 8e-3};
    Laid all{.touch = {pad, pads, 1e-3, true}, .radius = 6e-4};
    for (int i = 0; i < pads; i += every) {
        all.pad.push_back(i);
        all.position.insert(all.position.end(), {1e-4, -2e-4, 0});
        all.force.insert(all.force.end(), {0.02, 0.01, -0.1});
    }
    return all;
}

// Times some ways to press in turn. The others are compared with the first way.
void add_ways(Bench& bench, const char* kind, int side, int pads, int threads,
              const std::vector<std::pair<const char*, std::function<void()>>>& ways) {
    const int presses = bench.quick ? 5 : 40;
    std::vector<Contender> all;
    for (const auto& [model, way] : ways) {
        Contender& c = all.emplace_back(Contender{row_of(bench.cpu(kind, side, threads), model, "f32", presses), {}});
        c.row.method = fmt::format("exact-{}x{}x{}", side, side, pads);
        c.row.height = static_cast<long long>(side) * pads;
        c.row.bytes_per_cell = 48;
        if (all.size() > 1) c.ratio_to = ways[0].first;
        c.work = [&way = way, presses] {
            return seconds_of([&] {
                for (int i = 0; i < presses; ++i) way();
            });
        };
    }
    bench.measure(std::move(all), bench.runs);
}

// every: one pad of so many is touched.
void add_touched(Bench& bench, int pads, int every, const Device& device) {
    Laid contacts = patches(pads, every);
    contacts.add();
    SkinOptions options = in_f32(pads);
    Skin listed(device, rectangle(side, side), options), all(device, rectangle(side, side), options);
    options.shear = true;
    Skin sheared(device, rectangle(side, side), options);
    const size_t cells = size_t(side) * side;
    const float* const pressure = contacts.touch.pressure();
    std::vector<float> of_listed;
    for (const int pad : contacts.pad)
        of_listed.insert(of_listed.end(), pressure + size_t(pad) * cells, pressure + size_t(pad + 1) * cells);
    const auto press_listed = [&] { listed.press(of_listed.data(), of_listed.size(), press_dt, contacts.pad); };
    const auto press_all = [&] { all.press(pressure, size_t(pads) * cells, press_dt); };
    const auto shear = [&] { sheared.press(contacts.touch, press_dt); };
    for (int i = 0; i < 3; ++i) press_listed(), press_all(), shear();
    for (Quantity q : {Quantity::sa1, Quantity::fa1})
        if (!std::ranges::equal(all.response(q), sheared.response(q)))
            throw std::runtime_error("a touch has other bits");
    add_ways(bench, "touch", side, pads, device.impl().backend->threads(),
             {{"press-listed", press_listed},
              {"touch-add", [&] { contacts.add(); }},
              {"press-all", press_all},
              {"touch-shear", shear}});
}

// Bodies below every nth of so many flat pads, in two contacts each, turned and off the middle.
Laid bodies(contact::Body::Kind kind, const std::array<double, 3>& size, int pads, int every) {
    Laid all{
        .touch = {
            {.width = flat_side, .height = flat_side, .spacing = flat_spacing}, pads, 1e-3, false, {.stiffness = 5e7}}};
    for (int i = 0; i < pads; i += every) {
        const double turn = 0.3 * std::sin(i), tilt = 0.02 * std::sin(3.0 * i), x = 6e-3 * std::sin(7.0 * i);
        const bool lies = kind == contact::Body::Kind::cylinder; // its axis is along the pad's y
        const double c = std::cos(turn), s = std::sin(turn), ct = std::cos(tilt), st = std::sin(tilt);
        const double across[3] = {c, s, 0}, along[3] = {-s * ct, c * ct, st}, up[3] = {s * st, -c * st, ct};
        for (int k = 0; k < 3; ++k)
            all.rotation.insert(all.rotation.end(), {across[k], lies ? up[k] : along[k], lies ? -along[k] : up[k]});
        all.shape_pad.push_back(i), all.kind.push_back(int32_t(kind));
        all.size.insert(all.size.end(), size.begin(), size.end());
        all.place.insert(all.place.end(), {x, 0, 15e-3});
        for (const double y : {-4e-3, 4e-3}) {
            all.pad.push_back(i);
            all.position.insert(all.position.end(), {x + 5e-4, y, 0});
            all.force.insert(all.force.end(), {0, 0, -0.75});
        }
    }
    return all;
}

// A ball, a bottle and a box with two edges on the pad press every nth pad, beside the press of these of four
// responses.
void add_bodies(Bench& bench, int pads, int every) {
    using Kind = contact::Body::Kind;
    Laid ball = bodies(Kind::sphere, {15e-3}, pads, every), bottle = bodies(Kind::cylinder, {15e-3, 0.04}, pads, every),
         box = bodies(Kind::box, {8e-3, 0.02, 15e-3}, pads, every);
    SkinOptions options = in_f32(pads);
    options.responses = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    Skin skin(Device::cpu(1), rectangle(flat_side, flat_side, flat_spacing), options);
    for (Laid* each : {&ball, &bottle, &box}) each->add(), skin.press(each->touch, press_dt);
    add_ways(bench, every == 1 ? "bodies" : "few-bodies", flat_side, pads, 1,
             {{"touch-press", [&] { skin.press(ball.touch, press_dt); }},
              {"shape-ball", [&] { ball.add(); }},
              {"shape-bottle", [&] { bottle.add(); }},
              {"shape-box", [&] { box.add(); }}});
}

} // namespace

void touch(Bench& bench) {
    add_bodies(bench, bench.quick ? 400 : 4096, 1);
    add_bodies(bench, bench.quick ? 400 : 4096, bench.quick ? 10 : 102);
    for (const Device& device : bench.cpus()) {
        add_touched(bench, bench.quick ? 400 : 4096, bench.quick ? 10 : 102, device);
        add_touched(bench, bench.quick ? 32 : 320, 1, device);
    }
}

} // namespace bench
