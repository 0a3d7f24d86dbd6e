// SPDX-License-Identifier: MIT
#include "host/core/embedding/check.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/cpu/backend.hpp"
#include "host/core/cpu/stream.hpp"

#include <bit>
#include <cstring>

namespace dermis {
namespace {

constexpr int sample_width = 67, sample_height = 13;

std::vector<double> noise(uint32_t random) {
    std::vector<double> map;
    for (int i = 0; i < sample_width * sample_height; ++i) {
        random = random * 1664525u + 1013904223u;
        map.push_back((double(random >> 8) / (1 << 24) - 0.25) * (i % 7 ? 1 : 1e-18));
    }
    return map;
}

Map sample_pressure() { return noise(99); }

SkinDescription sample_skin(Stencil stencil, Edges edges, bool materials, const plan::Chain& chain) {
    SkinDescription d;
    d.grid = {sample_width, sample_height, {}};
    d.stencil = stencil;
    d.edges = edges;
    d.receptors = {0.5, Fa2::step_mean, {0.75, -0.375}};
    d.surface.kind = Surface::Kind::map;
    d.surface.map = noise(12345);
    Map moduli;
    if (materials) {
        moduli = noise(54321);
        for (double& E : moduli.edit()) E += 1.5;
    }
    if (chain.length == 1) {
        d.material.modulus = 2.5;
        d.material.viscosity = 0.75;
        d.material.modulus_map = moduli;
        return d;
    }
    for (size_t i = 100; i < moduli.size(); ++i)
        moduli.edit()[i] = moduli[i % 100]; // few enough for one update of a table
    constexpr size_t most = 8;              // elements of a material; a ninth one of a chain is its dashpot
    for (size_t e = 0; e < std::min(chain.elements(), most); ++e)
        d.material.elements.push_back({2.5 / double(1 + e), 0.75 * double(1 + 3 * e), e == 0 ? moduli : Map()});
    if (chain.elements() > most) d.material.dashpot = 20;
    if (chain.spring) d.material.spring = 8;
    return d;
}

void compare(SelfTest::Kernel& kernel, double device, double cpu) {
    const auto bits = std::bit_cast<uint64_t>(device);
    for (int i = 0; i < 8; ++i) kernel.hash = (kernel.hash ^ (bits >> (8 * i) & 255)) * 1099511628211u;
    ++kernel.values;
    kernel.different += bits != std::bit_cast<uint64_t>(cpu);
}

struct TestVariant {
    Stencil stencil = Stencil::five_point;
    Edges edges = Edges::mirror;
    Precision precision = Precision::f32;
    bool materials = false, framed = false;
    plan::Chain chain;
};

// Prepares a run of which every map is read.
plan::PreparedRun sample_run(const TestVariant& v) {
    Scene s;
    static_cast<SkinDescription&>(s) = sample_skin(v.stencil, v.edges, v.materials, v.chain);
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
            compare(kernel, a[i].totals[q].mean, b[i].totals[q].mean);
            compare(kernel, a[i].totals[q].min, b[i].totals[q].min);
            compare(kernel, a[i].totals[q].max, b[i].totals[q].max);
        }
}

// Compares the kernels press, fields and reduce in a run.
void compare_runs(SelfTest& test, plan::Backend& backend, plan::Backend& plain, const TestVariant& v) {
    const plan::PreparedRun run = sample_run(v);
    std::vector<plan::Sample> samples[2];
    const auto take = [&](int i) { return [&samples, i](auto&, auto& sample) { samples[i].push_back(sample); }; };
    const auto one = backend.stepper(run.skin, run.schedule, v.precision, take(0)),
               two = plain.stepper(run.skin, run.schedule, v.precision, take(1));
    std::vector<Quantity> pressed, derived = {Quantity::curvature, Quantity::deformation};
    for (int q = 0; q < REDUCED_MAPS; ++q) pressed.push_back(Quantity(q));
    std::vector<std::vector<double>> a, b;
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
                for (size_t i = 0; i < a[q].size(); ++i) compare(test.kernels[kernel], a[q][i], b[q][i]);
        }
    }
    one->finish();
    compare_samples(test.kernels[SelfTest::reduce], samples[0], samples[1]);
}

// Compares the kernel sites in a stream of frames.
void compare_sites(SelfTest::Kernel& kernel, plan::Backend& backend, const TestVariant& v) {
    SampleStream::Variant every{.stencil = v.stencil,
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
        (void)stream->press({}, {&SampleStream::dt});                  // true: a sample's coefficients fit float
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
            const plan::ResponseLayout::Range& r = sample.layout().of[size_t(q)];
            const float* response = stream->response(Quantity(q));
            for (size_t k = 0; k < r.count; ++k) compare(kernel, double(response[k]), double(expected[i][r.first + k]));
        }
    }
}

} // namespace

SelfTest self_test(plan::Backend& backend, bool every_variant) {
    const DefaultFloats guard;
    SelfTest test;
    const auto plain = cpu::backend(1, simd::plain);
    const TestVariant simplest;
    compare_runs(test, backend, *plain, simplest);
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
        compare_runs(test, backend, *plain, v);
        compare_sites(test.kernels[SelfTest::sites], backend, v);
    }
    return test;
}

SampleStream::SampleStream(const Variant& v) {
    SkinDescription d = sample_skin(v.stencil, v.edges, v.materials, v.chain);
    SkinOptions options;
    options.precision = v.precision;
    options.responses.clear();
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
        if (v.wanted[size_t(q)]) options.responses.push_back(Quantity(q));
    for (int i = 0; v.sites && i < 100; ++i)
        d.sites.push_back({options.responses[size_t(i) % options.responses.size()],
                           {i * 31 % d.grid.width, i * i * 7 % d.grid.height}});
    options.count = v.pads ? 2 : 1;
    streamed_ = plan::streamed_skin(d, options);
    layout_ = response_layout_of(streamed_);
}

SampleStream::SampleStream(const plan::StreamedSkin& like)
    : SampleStream({.stencil = *like.skin.description.stencil,
                    .edges = *like.skin.description.edges,
                    .precision = like.precision,
                    .materials = !like.skin.uniform(),
                    .sites = !like.skin.description.sites.empty(),
                    .pads = like.pads > 1,
                    .chain = like.skin.chain,
                    .wanted = like.wanted}) {}

std::vector<float> SampleStream::pressure(int i) const {
    std::vector<float> all;
    for (int pad = 0; pad < streamed_.pads; ++pad) {
        std::vector<float> own(streamed_.skin.padded_cells(), 0.0f);
        if (i > 0)
            own = plan::padded<float>((i + pad) % 2 ? sample_pressure() : streamed_.skin.description.surface.map,
                                      streamed_.skin, "");
        all.insert(all.end(), own.begin(), own.end());
    }
    return all;
}

std::vector<float> SampleStream::frame(const std::vector<float>& pressure) const {
    const size_t width = size_t(streamed_.skin.width()), pitch = size_t(streamed_.skin.pitch);
    std::vector<float> frame;
    for (size_t at = 0; at < pressure.size(); at += pitch)
        frame.insert(frame.end(), pressure.data() + at, pressure.data() + at + width);
    return frame;
}

std::array<size_t, 2> SampleStream::read_cells() const {
    const auto at = [&](Cell c) { return size_t(c.y) * size_t(streamed_.skin.pitch) + size_t(c.x); };
    const std::vector<Site>& sites = streamed_.skin.description.sites;
    if (sites.empty()) return {at({3, 2}), at({66, 12})};
    return {at(sites[0].cell), at(sites[1].cell)};
}

std::vector<std::vector<float>> SampleStream::expected(const std::vector<std::vector<float>>& pressures) const {
    const std::unique_ptr<plan::Stream> stream = cpu::stream(streamed_, 1, simd::plain);
    const size_t width = size_t(streamed_.skin.width()), pitch = size_t(streamed_.skin.pitch),
                 row = streamed_.skin.description.sites.empty() ? width : 0; // of responses
    std::vector<std::vector<float>> all;
    for (size_t i = 1; i < pressures.size(); ++i) { // the first one is that of a skin at rest
        const plan::PadList pads{.count = size_t(streamed_.pads)};
        (void)stream->take(pads, frame(pressures[i]).data());
        (void)stream->press(pads, {&dt});
        std::vector<float>& out = all.emplace_back(layout_.all);
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
            const plan::ResponseLayout::Range& r = layout_.of[size_t(q)];
            for (size_t k = 0; k < r.count; k += row ? pitch : r.count)
                std::copy_n(stream->response(Quantity(q)) + (row ? k / pitch * row : k), row ? row : r.count,
                            out.data() + r.first + k);
        }
    }
    return all;
}

bool SampleStream::same(const float* a, const float* b) const {
    const bool fields = streamed_.skin.description.sites.empty();
    const size_t pitch = size_t(streamed_.skin.pitch), width = size_t(streamed_.skin.width());
    for (const plan::ResponseLayout::Range& r : layout_.of)
        for (size_t k = 0; k < r.count; ++k) {
            if (fields && k % pitch >= width) continue;
            if (std::memcmp(a + r.first + k, b + r.first + k, sizeof(float)) != 0) return false;
        }
    return true;
}

} // namespace dermis
