// SPDX-License-Identifier: MIT
// Prints a hash of every number of some results, a line each: "<name> <hash>". The coefficients of those whose name
// begins with "given" come of + - * / alone; others need exponentials and sines of the C library.
//
// Arguments: threads=N; device=NAME, which leaves out what no device computes; early=MODE and late=MODE, which change
// the caller's floating-point environment before and after the device is opened. MODE: up, down, zero (rounding) or
// flush (of denormal numbers).
#include <dermis/dermis.hpp>

#include <cfenv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace {

using namespace dermis;

// The hash is FNV-1a.
class Hash {
  public:
    template <class Number> void add(Number x) {
        if (x != x) x = Number(NAN); // any NaN is as good as any other
        unsigned char bytes[sizeof x];
        std::memcpy(bytes, &x, sizeof x);
        for (unsigned char byte : bytes) value_ = (value_ ^ byte) * 1099511628211u;
    }
    template <class Numbers> void add_all(const Numbers& numbers) {
        for (auto x : numbers) add(x);
    }
    void print(const std::string& name) const { std::printf("%s %016llx\n", name.c_str(), (unsigned long long)value_); }

  private:
    uint64_t value_ = 14695981039346656037u;
};

// Makes numbers that are the same on every machine, some of them so small that they are stored as 0.
Map noise(int count, uint32_t random, double offset) {
    Map map;
    for (int i = 0; i < count; ++i) {
        random = random * 1664525u + 1013904223u;
        map.edit().push_back(offset + (double(random >> 8) / (1 << 24) - 0.25) * (i % 7 ? 1 : 1e-18));
    }
    return map;
}

constexpr int width = 131, height = 37, cells = width * height;

// Makes a scene whose maps are noise, under a load that is held.
Scene given() {
    Scene s;
    s.grid = {width, height, {}};
    s.surface.kind = Surface::Kind::map;
    s.surface.map = noise(cells, 1, 0);
    s.load.kind = Load::Kind::map;
    s.load.map = noise(cells, 2, 0);
    s.load.envelope.start = 0.0625;
    s.material.modulus = 2.5;
    s.material.viscosity = 0.75;
    s.method = Method::crank_nicolson;
    s.model = Model::march;
    s.time = {0.03125, 1};
    s.output.probes = {{0, 0}, {width / 2, height / 2}};
    s.output.fields = {{0.5, {Quantity::curvature, Quantity::sa2, Quantity::fa2}}, {0.75, {Quantity::deformation}}};
    return s;
}

Scene varied() {
    Scene s = given();
    s.stencil = Stencil::fourth_order;
    const Map moduli = noise(64, 3, 1.5);
    for (size_t i = 0; i < size_t(cells); ++i) s.material.modulus_map.edit().push_back(moduli[i % moduli.size()]);
    return s;
}

void hash(const std::string& name, const Scene& scene, Precision precision, const Device& device) {
    RunOptions options;
    if (scene.model == Model::march) options.precision = precision;
    const Result r = run(scene, device, options);
    Hash h;
    h.add_all(r.time);
    for (const Trace& t : r.traces) {
        for (const auto* numbers : {&t.mean, &t.min, &t.max}) h.add_all(*numbers);
        for (const std::vector<double>& probe : t.probes) h.add_all(probe);
    }
    for (const Impulse& i : r.impulses) h.add_all(std::vector<double>{i.time, i.mean, i.min, i.max});
    for (const Field& f : r.fields) h.add_all(f.values);
    h.add_all(r.responses);
    h.print(name);
}

// Prints a hash for each precision that the device has.
void hash_each(const std::string& name, const Scene& scene, const Device& device) {
    for (Precision p : {Precision::f32, Precision::f32_compensated, Precision::f64})
        if (p != Precision::f64 || !device.info().vulkan) hash(name + "_" + dermis::name(p), scene, p, device);
}

// Makes a scene on a surface of the published study, with a load that changes within steps.
Scene study(Surface::Kind surface, Envelope::Kind envelope) {
    Scene s;
    s.grid = {150, 90, {}};
    s.surface.kind = surface;
    s.load.envelope.kind = envelope;
    s.load.envelope.frequency = 7;
    s.load.envelope.phase = 0.3;
    s.load.envelope.length = 0.11;
    s.load.envelope.period = 0.29;
    s.load.envelope.times = {0, 0.1, 0.35};
    s.load.envelope.values = {0, 1, -0.5};
    s.model = Model::march;
    s.time = {0.0013, 1.5}; // so often that functions of two C libraries differ somewhere
    return s;
}

Scene chain() {
    Scene s = study(Surface::Kind::wave, Envelope::Kind::ramp);
    s.material.elements = {{2.5, 0.01, {}, {}}, {4, 0.7, {}, {}}, {6, 11, {}, {}}};
    s.material.spring = 8;
    s.material.dashpot = 300;
    return s;
}

// Makes a scene of a fingertip of which only receptors are computed.
Scene receptors() {
    Scene s{fingertip()};
    s.sites = population(s.grid, {}, 7);
    s.sites.resize(100);
    s.load.intensity = 1e4;
    s.load.envelope.kind = Envelope::Kind::sine;
    s.load.envelope.frequency = 40;
    s.output.traces.clear();
    s.model = Model::sites;
    s.time = {0.002, 0.1};
    return s;
}

Scene product(Model model) {
    Scene s = study(Surface::Kind::spiral, Envelope::Kind::sine);
    s.model = model;
    if (model == Model::maps) s.output.fields = {{0.26, {Quantity::strain, Quantity::fa1}}};
    else s.time.duration = 20;
    return s;
}

// Makes a scene of a fingertip over whose crests a texture slides, its pressure along parabolas between frames.
Scene touch() {
    Scene s{fingertip()};
    s.grid = {.width = width, .height = height, .spacing = 5e-5};
    s.load.intensity = 1e4;
    s.load.contact = Load::Contact::crests;
    s.load.hold = Hold::parabolic;
    s.load.texture = Texture{.map = noise(11 * 8, 4, 1), .width = 11, .height = 8, .velocity = {0.05, 0.02}};
    s.model = Model::march;
    s.time = {0.0013, 0.1};
    return s;
}

// The same for receptors below it.
Scene touch_below() {
    Scene s = touch();
    s.receptors.depth = {.sa1 = 3e-4, .sa2 = 1e-3, .fa1 = 3e-4, .fa2 = 2e-3};
    s.sites = population(s.grid, {}, 7);
    s.output.traces.clear();
    s.model = Model::sites;
    return s;
}

// Pads that are pressed frame by frame.
struct Presses {
    std::string name;
    SkinDescription description;
    SkinOptions options;
    std::vector<std::vector<float>> frames;
};

// Makes one skin and a batch with a material for each pad, both of fields and of sites.
std::vector<Presses> presses() {
    std::vector<Presses> all;
    for (const int pads : {1, 3})
        for (const bool sites : {false, true}) {
            Presses p{std::string(pads > 1 ? "batch" : "skin") + (sites ? "_of_sites" : ""), given(), {}, {}};
            for (int i = 0; sites && i < 60; ++i)
                p.description.sites.push_back({Quantity(1 + i % 4), {i * 31 % width, i * i * 7 % height}});
            p.options.count = pads;
            for (int i = 0; pads > 1 && i < pads; ++i) {
                p.options.materials.push_back(p.description.material);
                p.options.materials.back().viscosity = 0.5 + i;
            }
            for (uint32_t frame = 0; frame < 5; ++frame) {
                const Map map = noise(cells * pads, 10 + frame, 0);
                p.frames.emplace_back(map.begin(), map.end());
            }
            all.push_back(p);
        }
    return all;
}

void hash(const Presses& p, const Device& device) {
    Skin skin(device, p.description, p.options);
    Hash h;
    double dt = 0x1p-10;
    for (const std::vector<float>& frame : p.frames) {
        skin.press(frame, dt);
        for (Quantity q : {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2}) h.add_all(skin.response(q));
        dt *= 4;
    }
    h.print(p.name);
}

void set_floats(const std::string& mode) {
    if (mode == "up") std::fesetround(FE_UPWARD);
    if (mode == "down") std::fesetround(FE_DOWNWARD);
    if (mode == "zero") std::fesetround(FE_TOWARDZERO);
#if defined(__x86_64__)
    if (mode == "flush") _mm_setcsr(_mm_getcsr() | 0x8040); // results and operands
#endif
}

std::string argument(int argc, char** argv, const std::string& key) {
    for (int i = 1; i < argc; ++i)
        if (std::strncmp(argv[i], (key + "=").c_str(), key.size() + 1) == 0) return argv[i] + key.size() + 1;
    return "";
}

} // namespace

int main(int argc, char** argv) {
    // Made before the environment is changed: a scene's numbers are the caller's.
    const Scene same = given(), different = varied(), ramp = study(Surface::Kind::wave, Envelope::Kind::ramp),
                sine = study(Surface::Kind::spiral, Envelope::Kind::sine), elements = chain(), sites = receptors(),
                moments = product(Model::moments), maps = product(Model::maps), crests = touch(), below = touch_below();
    const std::vector<Presses> skins = presses();
    set_floats(argument(argc, argv, "early"));
    const std::string name = argument(argc, argv, "device");
    const Device device =
        name.empty() ? Device::cpu(std::atoi(argument(argc, argv, "threads").c_str())) : Device::open(name);
    set_floats(argument(argc, argv, "late"));
    hash_each("given", same, device);
    hash_each("given_varied", different, device);
    hash_each("ramp", ramp, device);
    hash_each("sine", sine, device);
    hash_each("chain", elements, device);
    hash_each("touch", crests, device);
    for (const Presses& p : skins) hash(p, device);
    if (device.info().vulkan) return 0;
    hash("sites", sites, {}, device);
    hash("moments", moments, {}, device);
    hash("maps", maps, {}, device);
    hash("below", below, {}, device);
    return 0;
}
