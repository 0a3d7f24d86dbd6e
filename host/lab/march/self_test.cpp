// SPDX-License-Identifier: MIT
#include "host/lab/march/self_test.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/cpu/backend.hpp"
#include "host/core/embedding/check.hpp"
#include "host/lab/march/march.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace dermis {
namespace {

struct TestVariant {
    Stencil stencil = Stencil::five_point;
    Edges edges = Edges::mirror;
    Precision precision = Precision::f32;
    bool materials = false, framed = false, gains = true;
    plan::Chain chain;
};

// Prepares a run that reads every map.
plan::PreparedRun sample_run(const TestVariant& v) {
    Scene s;
    static_cast<SkinDescription&>(s) = sample_skin(v.stencil, v.edges, v.materials, v.chain);
    if (!v.gains) s.receptors.fa2_gains = {1, -1};
    s.time = {0.125, 1};
    s.load.envelope.start = 0.2;
    s.load.kind = Load::Kind::map;
    s.load.map = sample_pressure();
    s.output.fields = {{0.3, {Quantity::curvature, Quantity::deformation}}};
    plan::PreparedRun run = plan::prepare_run(s);
    run.schedule.wanted.fill(true);
    run.schedule.framed = v.framed;
    return run;
}

void compare_samples(SelfTest::Kernel& kernel, const std::vector<plan::Sample>& a, const std::vector<plan::Sample>& b) {
    for (size_t i = 0; i < b.size(); ++i)
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            kernel.compare(a[i].totals[q].mean, b[i].totals[q].mean);
            kernel.compare(a[i].totals[q].min, b[i].totals[q].min);
            kernel.compare(a[i].totals[q].max, b[i].totals[q].max);
        }
}

// Compares totals with plain sums over a map that came the same way.
void compare_totals(SelfTest::Kernel& kernel, const plan::Totals& t, const std::vector<double>& map, double unit) {
    long double sum = 0, magnitudes = 0;
    for (double v : map) sum += v, magnitudes += std::abs(v);
    const double mean = double(sum / static_cast<long double>(map.size()));
    const bool close = std::abs(t.mean - mean) <= 16 * unit * double(magnitudes) / double(map.size());
    kernel.compare(close ? mean : t.mean, mean);
    kernel.compare(t.min, *std::ranges::min_element(map));
    kernel.compare(t.max, *std::ranges::max_element(map));
}

// Compares the kernels press, fields and reduce in a run.
void compare_runs(SelfTest& test, plan::Backend& backend, plan::Backend& plain, const TestVariant& v) {
    const plan::PreparedRun run = sample_run(v);
    std::vector<plan::Sample> samples[2], outputs; // outputs: of the first, without impulses
    const auto take = [&](int i) {
        return [&samples, &outputs, i](auto& step, auto& sample) {
            samples[i].push_back(sample);
            if (i == 0 && step.trace >= 0) outputs.push_back(sample);
        };
    };
    const auto one = plan::march(backend, run.skin, run.schedule, v.precision, take(0)),
               two = plan::march(plain, run.skin, run.schedule, v.precision, take(1));
    std::vector<Quantity> pressed, derived = {Quantity::curvature, Quantity::deformation};
    for (int q = 0; q < REDUCED_MAPS; ++q) pressed.push_back(Quantity(q));
    std::vector<std::vector<double>> a, b;
    std::vector<std::vector<double>> traced; // where traces are, each map
    plan::Timeline timeline(run.schedule, run.skin);
    for (plan::Step step; timeline.next(step);) {
        for (plan::Stepper* stepper : {one.get(), two.get()}) {
            if (v.framed) stepper->frame(step.keep ? run.schedule.pressure : run.skin.heights);
            stepper->press(step);
        }
        for (const auto& [quantities, kernel] : {std::pair{&pressed, SelfTest::press}, {&derived, SelfTest::fields}}) {
            one->read(*quantities, a);
            two->read(*quantities, b);
            for (size_t q = 0; q < a.size(); ++q)
                for (size_t i = 0; i < a[q].size(); ++i) test.kernels[kernel].compare(a[q][i], b[q][i]);
            for (size_t q = 0; kernel == SelfTest::press && step.trace >= 0 && q < b.size(); ++q)
                traced.push_back(b[q]);
        }
    }
    one->finish();
    two->finish();
    compare_samples(test.kernels[SelfTest::reduce], samples[0], samples[1]);
    for (size_t i = 0; i < traced.size(); ++i)
        compare_totals(test.kernels[SelfTest::others], outputs[i / REDUCED_MAPS].totals[i % REDUCED_MAPS], traced[i],
                       v.precision == Precision::f64 ? 0x1p-53 : 0x1p-24);
}

// Compares the kernel sites in a stream of frames.
void compare_sites(SelfTest::Kernel& kernel, plan::Backend& backend, const TestVariant& v) {
    SampleStream::Options every{.stencil = v.stencil,
                                .edges = v.edges,
                                .precision = v.precision,
                                .materials = v.materials,
                                .sites = true,
                                .chain = v.chain};
    every.wanted.fill(true);
    const SampleStream sample(every);
    const auto stream = backend.stream(sample.skin());
    std::vector<std::vector<float>> pressures;
    for (int i = 0; i <= SampleStream::presses; ++i) pressures.push_back(sample.pressure(i));
    const std::vector<std::vector<float>> expected = sample.expected(pressures);
    for (size_t i = 0; i < SampleStream::presses; ++i) {
        (void)stream->take({}, sample.frame(pressures[i + 1]).data()); // true: noise is finite
        (void)stream->prepare({}, {&SampleStream::dt});                // null: a sample's coefficients fit float
        stream->press({}, {&SampleStream::dt});
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
            const plan::ResponseLayout::Range& r = sample.layout().of[size_t(q)];
            const float* response = stream->response(Quantity(q));
            for (size_t k = 0; k < r.count; ++k) kernel.compare(double(response[k]), double(expected[i][r.first + k]));
        }
    }
}

} // namespace

void SelfTest::Kernel::compare(double device, double cpu) {
    const auto bits = std::bit_cast<uint64_t>(device);
    for (int i = 0; i < 8; ++i) hash = fnv1a(hash, static_cast<unsigned char>(bits >> (8 * i)));
    ++values;
    different += bits != std::bit_cast<uint64_t>(cpu);
}

SelfTest self_test(plan::Backend& backend, bool every_variant) {
    const DefaultFloats guard;
    SelfTest test;
    cpu::CpuBackend plain(1, simd::plain);
    const TestVariant simplest;
    compare_runs(test, backend, plain, simplest);
    if (!every_variant) return test;
    compare_sites(test.kernels[SelfTest::sites], backend, simplest);
    for (const TestVariant& v :
         {TestVariant{.materials = true, .framed = true},
          TestVariant{.stencil = Stencil::fourth_order,
          .edges = Edges::periodic,
          .precision = Precision::f32_compensated,
          .framed = true},
          TestVariant{.stencil = Stencil::published, .edges = Edges::published, .materials = true},
          TestVariant{.precision = Precision::f32_compensated, .framed = true, .chain = {.length = 3, .spring = true}},
          TestVariant{
              .stencil = Stencil::fourth_order, .edges = Edges::periodic, .materials = true, .chain = {.length = 3}}}) {
        compare_runs(test, backend, plain, v);
        compare_sites(test.kernels[SelfTest::sites], backend, v);
    }
    SelfTest::Kernel& others = test.kernels[SelfTest::others];
    for (const TestVariant& v :
         {TestVariant{.gains = false}, TestVariant{.framed = true, .gains = false},
          TestVariant{.precision = Precision::f64, .gains = false},
          TestVariant{.precision = Precision::f64, .materials = true, .framed = true},
          TestVariant{.precision = Precision::f64, .materials = true, .chain = {.length = 3, .spring = true}}}) {
        if (v.precision == Precision::f64 && backend.threads() == 0) continue; // devices have none
        SelfTest more;
        compare_runs(more, backend, plain, v);
        for (const SelfTest::Kernel& k : more.kernels) {
            if (v.precision == Precision::f32) others.hash ^= k.hash;
            others.values += k.values;
            others.different += k.different;
        }
    }
    return test;
}

} // namespace dermis
