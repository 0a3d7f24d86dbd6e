// SPDX-License-Identifier: MIT
// labels: device threads
// Materials that differ from cell to cell: each cell is what a uniform skin of its material would be.
#include "host/core/embedding/backend.hpp"
#include "host/core/press/device.hpp"
#include "tests/embedding_host.hpp"
#include "tests/shim.hpp"

#include <random>

using namespace test;

namespace {

// A level skin without thickness: no cell looks at another, so responses are the bare strain and its like.
Scene level(int width, int height) {
    Scene s = small_scene(width, height);
    s.model = Model::march;
    s.surface.kind = Surface::Kind::flat;
    s.grid.spacing = s.surface.relief = s.material.curvature_length = 1;
    s.material.modulus = 1.54;
    s.material.viscosity = 1;
    s.material.thickness = 0;
    return s;
}

const std::vector<Quantity> all = {Quantity::strain, Quantity::sa1,       Quantity::sa2,        Quantity::fa1,
                                   Quantity::fa2,    Quantity::curvature, Quantity::deformation};

struct Backend {
    Device device;
    Precision precision;
};
std::vector<Backend> backends(const Validated& vulkan) {
    return {{Device::cpu(), Precision::f64},
            {Device::cpu(), Precision::f32},
            {Device::cpu(), Precision::f32_compensated},
            {vulkan.device(), Precision::f32},
            {vulkan.device(), Precision::f32_compensated}};
}

Result run_on(const Scene& s, const Backend& b) {
    RunOptions options{.precision = b.precision};
    return run(s, b.device, options);
}

} // namespace

TEST_CASE("a map of one number has the bits of the number") {
    const Validated vulkan;
    Scene one = small_scene(21, 10);
    one.model = Model::march;
    Scene map = one;
    one.output.fields = map.output.fields = {{0.21, all}};
    map.material.modulus_map.edit().assign(210, one.material.modulus.value_or(1.54));
    map.material.viscosity_map.edit().assign(210, one.material.viscosity.value_or(1));
    for (const Backend& b : backends(vulkan)) {
        const Result r = run_on(one, b), m = run_on(map, b);
        for (const Trace& t : r.traces) CHECK(m.trace(t.quantity).mean == t.mean);
        for (size_t i = 0; i < all.size(); ++i) CHECK(m.fields[i].values == r.fields[i].values);
    }
}

TEST_CASE("every cell has the bits of a uniform skin of its material, under every envelope") {
    const int width = 11, height = 6;
    const std::pair<double, double> kinds[] = {{1.5, 1}, {4, 0.02}, {0, 3}, {2.5, 100}};
    for (Envelope::Kind envelope : {Envelope::Kind::step, Envelope::Kind::ramp, Envelope::Kind::sine,
                                    Envelope::Kind::pulse, Envelope::Kind::table})
        for (Fa2 fa2 : {Fa2::point, Fa2::step_mean}) {
            Scene s = level(width, height);
            s.receptors = {0.3, fa2, {1, -0.5}};
            Envelope& e = s.load.envelope;
            e.kind = envelope;
            if (envelope != Envelope::Kind::table && envelope != Envelope::Kind::sine) e.start = 0.07;
            e.rise = 0.11;
            e.length = 0.03;
            e.period = 0.13;
            if (envelope == Envelope::Kind::table) e.times = {0.02, 0.15, 0.15, 0.3}, e.values = {1, 0.5, -1, 2};
            s.output.fields = {{0.05, all}, {0.23, all}, {0.35, all}};
            Scene mixed = s;
            for (int i = 0; i < width * height; ++i) {
                mixed.material.modulus_map.edit().push_back(kinds[i % 4].first);
                mixed.material.viscosity_map.edit().push_back(kinds[i % 4].second);
            }
            for (Precision precision : {Precision::f64, Precision::f32}) {
                const Backend b{Device::cpu(), precision};
                const Result r = run_on(mixed, b);
                for (int kind = 0; kind < 4; ++kind) {
                    Scene uniform = s;
                    uniform.material.modulus = kinds[kind].first;
                    uniform.material.viscosity = kinds[kind].second;
                    const Result own = run_on(uniform, b);
                    for (size_t f = 0; f < r.fields.size(); ++f)
                        for (int i = kind; i < width * height; i += 4)
                            REQUIRE(r.fields[f].values[i] == own.fields[f].values[i]);
                }
            }
        }
}

TEST_CASE(
    "thousands of cells, each of another material, have under a sine the bits that they have on a skin with fewer") {
    Scene few = level(70, 30);
    few.load.envelope = {.kind = Envelope::Kind::sine, .frequency = 3, .phase = 0.4};
    few.output.traces.clear();
    few.output.fields = {{0.2, all}, {0.23, all}}; // after whole steps, and within one
    Scene many = few;
    many.grid.height = 60; // more materials than a table holds
    for (Scene* s : {&few, &many}) {
        s->load.kind = Load::Kind::map;
        for (int i = 0; i < 70 * s->grid.height; ++i) {
            s->material.modulus_map.edit().push_back(1 + 0.001 * i);
            s->load.map.edit().push_back(1);
        }
    }
    for (Precision precision : {Precision::f64, Precision::f32}) {
        const Result a = run_on(few, {Device::cpu(), precision}), b = run_on(many, {Device::cpu(), precision});
        for (size_t f = 0; f < a.fields.size(); ++f)
            for (size_t i = 0; i < 70 * 30; ++i) REQUIRE(b.fields[f].values[i] == a.fields[f].values[i]);
    }
}

TEST_CASE("elastic and viscous cells in one skin: each kind has its impulses, the other none") {
    Scene s = level(2, 1);
    s.load.kind = Load::Kind::map;
    s.load.map = {1, 1};
    s.material.viscosity_map = {0, 4};
    s.receptors.fa2 = Fa2::step_mean;
    s.output.probes = {{0, 0}, {1, 0}};
    RunOptions options{.precision = Precision::f64};
    const Result r = run(s, Device::cpu(), options);
    REQUIRE(r.impulses.size() == 2);
    CHECK(int(r.impulses[0].quantity) == int(Quantity::fa1));
    CHECK(r.impulses[0].probes == std::vector<double>{1 / 1.54, 0});
    CHECK(int(r.impulses[1].quantity) == int(Quantity::fa2));
    CHECK(r.impulses[1].probes == std::vector<double>{0, 0.25});
}

TEST_CASE("a material of its own in each of thousands of cells, and all elements that a material takes: Vulkan has the "
          "bits") {
    const Validated vulkan;
    vulkan::Context& context = *vulkan::context_of(*vulkan.device().impl().backend);
    const auto everywhere = [](int cells) {
        std::vector<double> moduli;
        for (int i = 0; i < cells; ++i) moduli.push_back(1 + 0.0001 * i);
        return moduli;
    };
    SkinDescription many = small_scene(80, 60), eight = small_scene(30, 20);
    many.material.modulus_map = everywhere(80 * 60);
    for (int e = 0; e < 8; ++e) eight.material.elements.push_back({1.0 + e, 0.01 * std::pow(10, e % 4)});
    eight.material.dashpot = 40;
    eight.material.spring = 5;
    SkinDescription both = eight;
    both.material.elements[3].modulus_map = everywhere(30 * 20);
    for (SkinDescription d : {many, eight, both})
        for (const bool sites : {false, true}) {
            for (int i = 0; sites && i < 2000; ++i)
                d.sites.push_back({all_responses[i % 4], {i * 13 % d.grid.width, i * 7 % d.grid.height}});
            check_presses(context, d);
        }
}

TEST_CASE("more materials than a Vulkan device can bind are refused with its limit") {
    const vulkan::Loader loader = shimmed();
    shim.range = 65536;
    const Device device = open_device("0", loader);
    SkinDescription d = small_scene(40, 40);
    for (int i = 0; i < 1600; ++i) d.material.modulus_map.edit().push_back(1 + 0.001 * i);
    CHECK(refusal(Error::Code::bad_input, [&] { Skin(device, d); }) ==
          "1600 different materials in modulus and viscosity need 76800 bytes; allowed: maxStorageBufferRange = 65536");
}
