// SPDX-License-Identifier: MIT
// Prints the bits of results: however this program is compiled, and whatever it does to its floating-point environment,
// they are the same. With FLUSHED denormal numbers are zero here, and must still be after each call.
#include <dermis/dermis.hpp>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <utility>

#if defined(FLUSHED) && defined(__SSE2__)
#include <immintrin.h>
#endif

namespace {

uint64_t hash;

void add(double value) {
    uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 8; ++i) hash = (hash ^ (bits >> (8 * i) & 255)) * 1099511628211u;
}

void add(const std::vector<double>& values) {
    for (double value : values) add(value);
}

uint64_t hash_of(const dermis::Result& r) {
    hash = 14695981039346656037u;
    add(r.time);
    for (const dermis::Trace& t : r.traces) {
        add(t.mean), add(t.min), add(t.max);
        for (const std::vector<double>& probe : t.probes) add(probe);
    }
    for (const dermis::Impulse& i : r.impulses) {
        add(i.mean), add(i.min), add(i.max);
        add(i.probes);
    }
    for (const dermis::Field& f : r.fields) add(f.values);
    add(r.responses);
    add(r.stencil_estimate), add(r.greatest_gain), add(r.tau_min), add(r.tau_max);
    return hash;
}

bool flushes() {
    volatile double least = 2.2250738585072014e-308, half = 0.5;
    volatile double result = least * half;
    uint64_t bits;
    double value = result;
    std::memcpy(&bits, &value, sizeof bits);
    return bits == 0;
}

#ifdef FLUSHED
constexpr bool flushed = true;
#else
constexpr bool flushed = false;
#endif

// Enough cells for two threads. Pressures that are denormal as float, as double, and once multiplied.
dermis::Scene scene() {
    using dermis::Quantity;
    dermis::Scene s;
    s.grid.width = 512;
    s.grid.height = 256;
    s.surface.kind = dermis::Surface::Kind::wave;
    s.material.modulus = 1e-3;
    s.material.viscosity = 1e-4;
    s.load.kind = dermis::Load::Kind::map;
    const double pressures[] = {1, 0.3, 0, 1e-30, 1e-39, 4e-42, 1e-300, 3e-308, 1e-310, 5e-324, -0.7};
    std::vector<double>& map = s.load.map.edit();
    for (int i = 0; i < s.grid.width * s.grid.height; ++i) map.push_back(pressures[(i + i / 512) % 11]);
    s.load.envelope.kind = dermis::Envelope::Kind::sine;
    s.load.envelope.frequency = 3;
    s.time.step = 0.01;
    s.time.duration = 0.2;
    for (int x = 0; x < 11; ++x) s.output.probes.push_back({200 + x, 100});
    return s;
}

} // namespace

int main() {
#if defined(FLUSHED) && defined(__SSE2__)
    _mm_setcsr(_mm_getcsr() | 0x8040); // denormal operands and results are zero
#endif
    using dermis::Model;
    using dermis::Precision;
    const dermis::Device device = dermis::Device::cpu(2);
    for (auto [model, precision] : {std::pair{Model::moments, Precision::f64},
                                    {Model::maps, Precision::f64},
                                    {Model::sites, Precision::f64},
                                    {Model::march, Precision::f32},
                                    {Model::march, Precision::f32_compensated},
                                    {Model::march, Precision::f64}}) {
        dermis::Scene s = scene();
        s.model = model;
        s.precision = precision;
        if (model == Model::maps || model == Model::march)
            s.output.fields = {{0.1, {dermis::Quantity::strain, dermis::Quantity::fa1, dermis::Quantity::deformation}}};
        if (model == Model::sites) {
            s.output.traces.clear();
            s.output.probes.clear();
            for (int i = 0; i < 6000; ++i) s.sites.push_back({dermis::Quantity(1 + i % 4), {i * 17 % 512, i / 24}});
        }
        const dermis::Result r = dermis::run(s, device);
        std::printf("%s %s %016llx\n", name(r.model), name(r.precision), static_cast<unsigned long long>(hash_of(r)));
        if (flushes() != flushed) {
            std::fputs("the floating-point environment is not what it was\n", stderr);
            return 1;
        }
    }
    // The shared library's exception is this program's.
    dermis::Scene bad = scene();
    bad.time.step = -1;
    try {
        dermis::run(bad, device);
    } catch (const dermis::Error& e) {
        std::printf("%s\n", e.parameter().c_str());
        return 0;
    }
    return 1;
}
