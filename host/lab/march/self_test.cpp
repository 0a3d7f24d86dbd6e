// SPDX-License-Identifier: MIT
#include "host/lab/march/self_test.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/embedding/check.hpp"
#include "host/lab/march/march.hpp"

#include <bit>
#include <cmath>

namespace dermis {
namespace {

using model::Variant;

// A step of every test march: at rest, under a rising load, two looks ahead, and two further steps.
struct SampleStep {
    double start, rise, length; // s
    bool keep = true, sampled = true;
};
constexpr double step_length = SampleStream::dt;
constexpr SampleStep sample_steps[] = {
    {0, 0, 0},           {0, 1, step_length}, {1, 0, step_length / 2, false}, {1, 0, step_length / 4, false, false},
    {1, 0, step_length}, {1, 0, step_length}};

// Compares totals with plain sums over a map that came the same way.
void compare_totals(SelfTest::Kernel& kernel, const model::Totals& t, const std::vector<double>& map, double unit) {
    long double sum = 0, magnitudes = 0;
    for (double v : map) sum += v, magnitudes += std::abs(v);
    const double mean = double(sum / static_cast<long double>(map.size()));
    const bool close = std::abs(t.mean - mean) <= 16 * unit * double(magnitudes) / double(map.size());
    kernel.compare(close ? mean : t.mean, mean);
    kernel.compare(t.min, *std::ranges::min_element(map));
    kernel.compare(t.max, *std::ranges::max_element(map));
}

// Compares the kernels press and reduce in a march of the sample skin.
void compare_marches(SelfTest& test, model::Backend& backend, const model::PreparedSkin& skin, const Variant& variant,
                     Precision precision) {
    const Map pressure = sample_pressure();
    const std::vector<Cell> no_points;
    const model::MarchPlan plan{.skin = skin,
                                .variant = variant,
                                .precision = precision,
                                .pressed = skin.whole(),
                                .pressure = pressure,
                                .points = no_points,
                                .keeps_maps = true};
    const bool in_double = precision == Precision::f64;
    const auto number = [&](const void* map, int i) {
        return in_double ? static_cast<const double*>(map)[i] : double(static_cast<const float*>(map)[i]);
    };
    std::vector<Quantity> all;
    for (int q = 0; q < REDUCED_MAPS; ++q)
        if (q == QUANTITY_STRAIN || variant.wanted[size_t(q)]) all.push_back(Quantity(q)); // every march has strain
    const std::unique_ptr<model::March> marches[] = {march(backend, plan), cpu::march(plan, 1, simd::plain)};
    for (const SampleStep& step : sample_steps) {
        model::Sample samples[2];
        std::vector<const void*> maps[2];
        for (int i : {0, 1}) {
            if (variant.framed) marches[i]->frame(step.keep ? pressure : skin.heights);
            const model::Step taken{.start = step.start,
                                    .rise = step.rise,
                                    .parabolic = variant.parabolic,
                                    .before = variant.parabolic ? step_length : 0,
                                    .length = step.length,
                                    .keep = step.keep,
                                    .trace = 0};
            marches[i]->press(taken, step.sampled ? &samples[i] : nullptr);
            maps[i] = marches[i]->maps(all);
        }
        for (size_t m = 0; m < all.size(); ++m) {
            const Quantity q = all[m];
            std::vector<double> expected;
            for (int i = 0; i < skin.pitch * skin.height(); ++i) {
                if (i % skin.pitch >= skin.width()) continue;
                expected.push_back(number(maps[1][m], i));
                test.kernels[SelfTest::press].compare(number(maps[0][m], i), expected.back());
            }
            if (!step.sampled || !variant.wanted[size_t(q)]) continue;
            const model::Totals &a = samples[0].totals[size_t(q)], &b = samples[1].totals[size_t(q)];
            for (auto total : {&model::Totals::mean, &model::Totals::min, &model::Totals::max})
                test.kernels[SelfTest::reduce].compare(a.*total, b.*total);
            compare_totals(test.kernels[SelfTest::others], a, expected, in_double ? 0x1p-53 : 0x1p-24);
        }
    }
}

// Compares the responses of a stream of frames.
void compare_presses(SelfTest::Kernel& kernel, model::Backend& backend, const SampleStream& sample) {
    const auto pressures = sample.pressures(), found = sample.pressed(*backend.stream(sample.skin()), pressures),
               expected = sample.expected(pressures);
    for (size_t i = 0; i < found.size(); ++i)
        for (size_t k = 0; k < found[i].size(); ++k) kernel.compare(double(found[i][k]), double(expected[i][k]));
}

// The same of a kind of variant.
struct Kind {
    SampleStream::Options options;
    bool framed = false, f64 = false;
    void compare(SelfTest& test, model::Backend& backend) const {
        const SampleStream sample(options);
        Variant variant = sample.skin().variant();
        variant.wanted.fill(true);
        variant.framed = framed;
        variant.compensated |= f64;
        variant.keeps_strain = variant.chain.length > 1;
        compare_marches(test, backend, sample.skin().skin, variant, f64 ? Precision::f64 : options.precision);
    }
};

} // namespace

void SelfTest::Kernel::compare(double device, double cpu) {
    const auto bits = std::bit_cast<uint64_t>(device);
    for (int i = 0; i < 8; ++i) hash = fnv1a(hash, static_cast<unsigned char>(bits >> (8 * i)));
    ++values;
    different += bits != std::bit_cast<uint64_t>(cpu);
}

SelfTest self_test(model::Backend& backend) {
    const DefaultFloats guard;
    SelfTest test;
    const model::Chain chain{.length = 3}, with_spring{.length = 3, .spring = true};
    for (Kind kind :
         {Kind{},
          {{.materials = true}, true},
          {{.stencil = Stencil::fourth_order, .edges = Edges::periodic, .precision = Precision::f32_compensated}, true},
          {{.stencil = Stencil(STENCIL_PUBLISHED), .edges = Edges(EDGES_PUBLISHED), .materials = true}},
          {{.precision = Precision::f32_compensated, .chain = with_spring}, true},
          {{.stencil = Stencil::fourth_order, .edges = Edges::periodic, .materials = true, .chain = chain}}}) {
        kind.compare(test, backend);
        kind.options.sites = true;
        compare_presses(test.kernels[SelfTest::sites], backend, SampleStream(kind.options));
    }
    // Level 0 with a stencil, levels without, and a class at the surface.
    for (const bool pads : {false, true})
        compare_presses(test.kernels[SelfTest::spread], backend,
                        SampleStream({.pads = pads, .depth = {3, 11, {}, 20}, .kernel = DepthKernel::strain}));
    SelfTest::Kernel& others = test.kernels[SelfTest::others];
    for (const Kind& kind : {Kind{{.gains = false}},
                             {{.gains = false}, true},
                             {{.gains = false}, false, true},
                             {{.materials = true}, true, true},
                             {{.materials = true, .chain = with_spring}, false, true}}) {
        if (kind.f64 && !backend.capabilities().f64) continue;
        SelfTest more;
        kind.compare(more, backend);
        for (const SelfTest::Kernel& k : more.kernels) {
            if (!kind.f64) others.hash ^= k.hash;
            others.values += k.values;
            others.different += k.different;
        }
    }
    return test;
}

bool marches_exactly(model::Backend& backend, const Variant& v) {
    const DefaultFloats guard;
    SelfTest test;
    const SampleStream sample(
        {.stencil = Stencil(v.stencil), .edges = Edges(v.edges), .materials = v.materials, .chain = v.chain});
    compare_marches(test, backend, sample.skin().skin, v, v.compensated ? Precision::f32_compensated : Precision::f32);
    return test.exact();
}

} // namespace dermis
