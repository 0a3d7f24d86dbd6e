// SPDX-License-Identifier: MIT
// labels: device threads
// Presses of many substeps of nerve fibres, or of many frames: how they are cut, and how progress ends them.
#include "dermis/touch.hpp"
#include "host/core/model/fibres.hpp"
#include "tests/shim.hpp"
#include "tests/support.hpp"

#include <cstring>

using namespace test;

namespace {

// Fibres of a class on the first cells of a pad, so sensitive that they fire in slow presses too.
Afferents fibres(Quantity type, int side, int cells, int endings = 1) {
    Afferents a{.type = type, .model = afferent_model(type), .cells = {}, .endings = endings};
    for (auto& pair : a.model->gains)
        for (double& gain : pair) gain *= 300;
    for (int i = 0; i < cells; ++i) a.cells.push_back({i % side, i / side});
    return a;
}

std::vector<float> pressure(int side, int frame, size_t pads = 1) {
    std::vector<float> all(size_t(side * side) * pads);
    for (size_t i = 0; i < all.size(); ++i) all[i] = float((frame % 3) * 3e4 * (1 + 0.01 * double(i % 97)));
    return all;
}

struct Stop {};
// What ends a press when it is called for the `last`-th time; it notes the fractions that it hears.
std::function<void(double)> stop_at(size_t last, std::vector<double>& heard) {
    return [last, &heard](double done) {
        heard.push_back(done);
        if (heard.size() == last) throw Stop();
    };
}

} // namespace

TEST_CASE("a device gives the CPU path's spikes in steps of many substeps and of many endings") {
    const Validated vulkan;
    constexpr int side = 8;
    for (const Quantity type : {Quantity::sa1, Quantity::fa1, Quantity::fa2})
        for (const auto& [cells, endings, dt] :
             {std::tuple{64, 64, 0.1}, {60, 20, 0.05}, {64, 1, 1.0}, {7, 1, 8.0}, {6, 3, 0.4}}) {
            CAPTURE(int(type));
            CAPTURE(endings);
            SkinOptions options{.responses = {Quantity::sa1}};
            options.afferents = {fibres(type, side, cells, endings)};
            Skin on_cpu(Device::cpu(1), finger(side, side), options),
                on_device(vulkan.device(), finger(side, side), options);
            size_t fired = 0;
            for (int n = 1; n <= 3; ++n) {
                on_cpu.press(pressure(side, n), dt);
                on_device.press(pressure(side, n), dt);
                CHECK(same_bits(spikes_of(on_cpu), spikes_of(on_device)));
                CHECK(saved(on_cpu) == saved(on_device));
                fired += on_cpu.spikes().size;
            }
            CHECK(fired > 0);
        }
}

TEST_CASE("spikes come by pad, by fibre and by time, however many blocks of substeps a press takes") {
    constexpr int side = 16;
    SkinOptions options{.responses = {Quantity::sa1}, .count = 3};
    options.afferents = {fibres(Quantity::fa1, side, 200), fibres(Quantity::sa1, side, 250, 5)};
    Skin once(Device::cpu(2), finger(side, side), options);
    size_t called = 0;
    options.progress = [&](double) { ++called; };
    Skin counted(Device::cpu(1), finger(side, side), options);
    for (int n = 1; n < 3; ++n) {
        once.press(pressure(side, n, 3), 1.0);
        counted.press(pressure(side, n, 3), 1.0);
        const Skin::Spikes s = once.spikes();
        REQUIRE(s.size > 100);
        CHECK(same_bits(spikes_of(once), spikes_of(counted)));
        for (size_t i = 1; i < s.size; ++i)
            CHECK(std::tuple(s[i - 1].pad, s[i - 1].afferent, s[i - 1].share) <
                  std::tuple(s[i].pad, s[i].afferent, s[i].share));
    }
    CHECK(called > 2); // so that there were several blocks
}

TEST_CASE("a press of fibres is cut into submissions by its work, and has the same spikes") {
    constexpr int side = 24;
    SkinOptions options{.responses = {Quantity::sa1}, .count = 2};
    options.afferents = {fibres(Quantity::sa1, side, 500), fibres(Quantity::fa1, side, 60, 20)};
    Skin on_cpu(Device::cpu(1), finger(side, side), options);
    const Validated vulkan(shimmed(), {.validation = {}, .most_work = 3e4});
    Skin on_device(vulkan.device(), finger(side, side), options);
    for (int n = 1; n < 4; ++n) {
        std::vector<uint64_t> submissions;
        shim.submissions = &submissions;
        on_device.press(pressure(side, n, 2), 0.02);
        shim.submissions = nullptr;
        on_cpu.press(pressure(side, n, 2), 0.02);
        CHECK(same_bits(spikes_of(on_cpu), spikes_of(on_device)));
        CHECK(saved(on_cpu) == saved(on_device));
        CHECK(submissions.size() > 100);
        for (const uint64_t groups : submissions) CHECK(groups <= 64); // of 64 fibres, or of the skin's cells
    }
}

TEST_CASE("progress ends a press of fibres between blocks of substeps, which is then undone") {
    const Validated vulkan;
    constexpr int side = 32;
    for (const Device& device : {Device::cpu(1), Device::cpu(2), vulkan.device()})
        for (const Hold hold : {Hold::linear, Hold::parabolic}) {
            SkinOptions options{.responses = {Quantity::sa1, Quantity::fa2}, .hold = hold};
            options.afferents = {fibres(Quantity::sa1, side, side * side, 2)};
            Skin untouched(device, finger(side, side), options);
            std::vector<double> heard;
            options.progress = stop_at(2, heard);
            Skin skin(device, finger(side, side), options);
            for (Skin* s : {&skin, &untouched}) s->press(pressure(side, 1), 0.01);
            CHECK(heard.empty()); // a short press
            const Bytes before = saved(skin);
            CHECK_THROWS_AS(skin.press(pressure(side, 2), 2.0), Stop);
            CHECK(heard == std::vector<double>{0, 0});
            CHECK(saved(skin) == before);
            CHECK(skin.spikes().size == 0);
            CHECK(std::isnan(skin.report().vibration.value) == (hold == Hold::parabolic));
            for (Skin* s : {&skin, &untouched}) s->press(pressure(side, 2), 0.02);
            CHECK(same_bits(spikes_of(skin), spikes_of(untouched)));
            CHECK(saved(skin) == saved(untouched));
            for (const Quantity q : options.responses)
                CHECK(std::memcmp(skin.response(q).data, untouched.response(q).data, side * side * sizeof(float)) == 0);
        }
}

TEST_CASE("progress ends a press of frames after a whole frame, whose state the skin then has") {
    const Validated vulkan;
    constexpr int side = 10, frames = 3000;
    std::vector<float> all;
    for (int n = 0; n < frames; ++n) {
        const std::vector<float> one = pressure(side, n, 2);
        all.insert(all.end(), one.begin(), one.end());
    }
    const size_t of_frame = all.size() / frames;
    for (const Device& device : {Device::cpu(1), vulkan.device()})
        for (const bool fires : {false, true})
            for (const size_t calls : {1, 2}) {
                SkinOptions options{.responses = {Quantity::sa1}, .count = 2};
                if (fires) options.afferents = {fibres(Quantity::fa1, side, 30)};
                Skin expected(device, finger(side, side), options);
                std::vector<double> heard;
                options.progress = stop_at(calls, heard);
                Skin skin(device, finger(side, side), options);
                CHECK_THROWS_AS(skin.press_frames(all.data(), frames, of_frame, 1e-3), Stop);
                REQUIRE(heard.size() == calls);
                const auto whole = size_t(std::lround(heard.back() * frames));
                CHECK(whole == (fires ? 1 : 1024) * calls);
                expected.press_frames(all.data(), whole, of_frame, 1e-3);
                CHECK(saved(skin) == saved(expected));
                CHECK(same_bits(spikes_of(skin), spikes_of(expected)));
            }
}

TEST_CASE("progress ends a press of frames while they are copied, and nothing has changed") {
    const Validated vulkan;
    constexpr int side = 64;
    constexpr size_t frames = 600, cells = side * side;
    std::vector<float> all(frames * cells, 1e-4f);
    all.back() = NAN; // which nobody has come to
    for (const Device& device : {Device::cpu(2), vulkan.device()})
        for (const Control control : {Control::pressure, Control::depth}) {
            std::vector<double> heard;
            SkinOptions options{.responses = {Quantity::sa1}, .control = control};
            options.afferents = {fibres(Quantity::sa1, side, 30)};
            options.progress = stop_at(2, heard);
            Skin skin(device, finger(side, side), options);
            skin.press(pressure(side, 1), 0.01);
            const Bytes before = saved(skin);
            const size_t fired = skin.spikes().size;
            CHECK_THROWS_AS(skin.press_frames(all.data(), frames, cells, 1e-3), Stop);
            CHECK(heard == std::vector<double>{0, 0});
            CHECK(saved(skin) == before);
            CHECK(skin.spikes().size == fired);
            const std::string message = refusal(
                Error::Code::bad_input, [&] { skin.press_frames(all.data() + cells, frames - 1, cells, 1e-3); });
            CHECK(message.find(" in cell [63, 63] of frame 598; allowed: finite numbers") != std::string::npos);
            CHECK(saved(skin) == before);
        }
}

TEST_CASE("a press keeps the steps and pads that it was called with, whatever their memory holds later") {
    constexpr int side = 32;
    std::vector<int> list = {2, 0};
    std::vector<double> dt = {2.0, 2.5};
    bool changes = false;
    SkinOptions options{.responses = {Quantity::sa1}, .count = 3, .hold = Hold::parabolic};
    options.afferents = {fibres(Quantity::sa1, side, side * side)};
    options.progress = [&](double) {
        if (changes) list = {1, 1 << 30}, dt = {-1.0, 1e-9};
    };
    const std::vector<float> p = pressure(side, 1, 2), frames = pressure(side, 2, 8);
    Bytes states[2];
    for (const bool change : {false, true}) {
        Skin skin(Device::cpu(1), finger(side, side), options);
        for (const bool each : {true, false}) {
            list = {2, 0}, dt = {2.0, 2.5}, changes = change;
            if (each) skin.press(p.data(), p.size(), dt.data(), dt.size(), Pads(list.data(), list.size()));
            else skin.press_frames(frames.data(), 4, p.size(), 0.01, Pads(list.data(), list.size()));
            CHECK((list[0] == 1) == change);
        }
        states[change] = saved(skin);
    }
    CHECK(states[0] == states[1]);
}

TEST_CASE("in a press its skin cannot be pressed, changed or saved, and others can") {
    constexpr int side = 16;
    SkinOptions options{.responses = {Quantity::sa1}};
    Skin other(Device::cpu(1), finger(side, side), options);
    options.afferents = {fibres(Quantity::sa1, side, side * side)};
    std::vector<std::string> refused;
    Skin* self = nullptr;
    const std::vector<float> p = pressure(side, 1);
    const contact::Touch touch({.width = side, .height = side, .spacing = 5e-4}, 1, 1e-3);
    options.progress = [&](double) {
        other.press(p, 0.01);
        char byte = 0;
        for (const std::function<void()>& call : std::vector<std::function<void()>>{
                 [&] { self->press(p, 0.01); }, [&] { self->press(touch, 0.01); },
                 [&] { self->press_frames(p.data(), 1, p.size(), 0.01); },
                 [&] { self->press_cells(p.data(), p.size(), 0.01); }, [&] { self->reset(); },
                 [&] { self->save(&byte, 1); }, [&] { self->load(&byte, 1); }, [&] { self->set_material({}); }})
            refused.push_back(refusal(Error::Code::bad_input, call));
    };
    Skin skin(Device::cpu(1), finger(side, side), options);
    self = &skin;
    skin.press(p, 4.0);
    REQUIRE(refused.size() >= 8);
    for (const std::string& message : refused)
        CHECK(message == "skin = (in a press, which calls progress); allowed: another skin");
    skin.press(p, 0.01);
}

TEST_CASE("frames of no pad are pressed at once, however many they are") {
    SkinOptions options{.responses = {Quantity::sa1}, .count = 4};
    for (const bool fires : {false, true}) {
        if (fires) options.afferents = {fibres(Quantity::sa1, 8, 8)};
        Skin skin(Device::cpu(1), finger(8, 8), options);
        skin.press(pressure(8, 1, 4), 0.01);
        const Bytes before = saved(skin);
        skin.press_frames(nullptr, size_t(1) << 62, 0, 1e-3, Pads(nullptr, 0));
        CHECK(saved(skin) == before);
    }
}
