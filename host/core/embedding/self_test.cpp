// SPDX-License-Identifier: MIT
#include "host/core/embedding/self_test.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/cpu/backend.hpp"
#include "host/core/embedding/check.hpp"
#include "host/core/model/coefficients_in.hpp"

#include <bit>
#include <cmath>

namespace dermis {
namespace {

using plan::Variant;

// A step of every test march: at rest, on to a jump of the load, over it, on to a look between two outputs, and
// further.
struct SampleStep {
    double start, rise, length; // s
    double since = 0;           // s before the step's end the load begins; 0: it holds
    bool impulse = false, keep = true, sampled = true;
    bool operator==(const SampleStep&) const = default;
};

std::vector<SampleStep> sample_steps() {
    constexpr double dt = SampleStream::dt, jump = 0.2, look = 0.3; // s
    std::vector<SampleStep> steps = {{0, 0, 0},
                                     {0, 0, dt},
                                     {.start = 0, .rise = 1, .length = jump - dt, .impulse = true, .keep = false},
                                     {.start = 0, .rise = 1, .length = dt, .since = 2 * dt - jump},
                                     {.start = 1, .rise = 0, .length = look - 2 * dt, .keep = false, .sampled = false}};
    steps.resize(10, {1, 0, dt});
    return steps;
}

class SampleCoefficients : public plan::StepCoefficients {
  public:
    const SampleStep step;
    SampleCoefficients(const SampleStep& s, const plan::PreparedSkin& skin, bool bent)
        : step(s), skin_(skin), time_{s.length, bent ? std::optional(SampleStream::dt) : std::nullopt} {}
    void fill(const int* material, int cells, f32::Coefficients* to) const override {
        fill_in<f32>(material, cells, to);
    }
    void fill(const int* material, int cells, f64::Coefficients* to) const override {
        fill_in<f64>(material, cells, to);
    }

  private:
    f64::Coefficients of(const plan::Element& m) const {
        f64::Coefficients k = exact_coefficients(m, skin_.rule, step.length);
        if (step.since > 0) plan::begin_within(k, exact_coefficients(m, skin_.rule, step.since), step.length);
        if (step.impulse) plan::force_impulse<f64>(k, m, 1, false, true);
        return k;
    }

    template <class K> void fill_in(const int* material, int cells, typename K::Coefficients* to) const {
        const size_t length = skin_.chain.length, count = material ? size_t(cells) : skin_.materials.size() / length;
        plan::SeriesCoefficients k, past;
        for (size_t i = 0; i < count; ++i) {
            const plan::Element* m = &skin_.materials[material ? size_t(material[i]) : i * length];
            const auto of_element = [&](size_t e) { return of(m[e]); };
            plan::join_series(m, skin_.chain, skin_.rule, time_, of_element, k, past);
            if (skin_.chain.spring && step.impulse) k[length - 1].b = k[length - 1].f = 0; // before the jump
            for (size_t e = 0; e < length; ++e) {
                *to++ = plan::rounded<K>(k[e]);
                if (time_.before) *to++ = plan::rounded<K>(past[e]);
            }
        }
    }

    const plan::PreparedSkin& skin_;
    const plan::FrameStep time_;
};

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

// Compares the kernels press, fields and reduce in a march of the sample skin.
void compare_marches(SelfTest& test, plan::Backend& backend, const plan::PreparedSkin& skin, const Variant& variant,
                     Precision precision) {
    const Map pressure = sample_pressure();
    const std::vector<Cell> no_points;
    const plan::MarchPlan plan{.skin = skin,
                               .variant = variant,
                               .precision = precision,
                               .pressed = skin.whole(),
                               .pressure = pressure,
                               .points = no_points,
                               .keeps_maps = true,
                               .derives = true};
    const bool in_double = precision == Precision::f64;
    const auto number = [&](const void* map, int i) {
        return in_double ? static_cast<const double*>(map)[i] : double(static_cast<const float*>(map)[i]);
    };
    std::vector<Quantity> pressed, all = {Quantity::curvature, Quantity::deformation};
    for (int q = 0; q < REDUCED_MAPS; ++q)
        if (variant.wanted[size_t(q)]) pressed.push_back(Quantity(q));
    all.insert(all.end(), pressed.begin(), pressed.end());
    cpu::CpuBackend plain(1, simd::plain);
    const std::unique_ptr<plan::March> marches[] = {backend.march(plan), plain.march(plan)};
    std::shared_ptr<const SampleCoefficients> coefficients;
    for (const SampleStep& step : sample_steps()) {
        if (!coefficients || !(coefficients->step == step))
            coefficients = std::make_shared<SampleCoefficients>(step, skin, variant.bent);
        plan::Sample samples[2];
        std::vector<const void*> maps[2];
        for (int i : {0, 1}) {
            if (variant.framed) marches[i]->frame(step.keep ? pressure : skin.heights);
            marches[i]->press({.coefficients = coefficients,
                               .start = step.start,
                               .rise = step.rise,
                               .keep = step.keep,
                               .respond = true,
                               .sample = step.sampled ? &samples[i] : nullptr});
            maps[i] = marches[i]->maps(all);
        }
        for (size_t m = 0; m < all.size(); ++m) {
            const Quantity q = all[m];
            std::vector<double> expected;
            for (int i = 0; i < skin.pitch * skin.height(); ++i) {
                if (i % skin.pitch >= skin.width()) continue;
                expected.push_back(number(maps[1][m], i));
                test.kernels[q < Quantity::curvature ? SelfTest::press : SelfTest::fields].compare(
                    number(maps[0][m], i), expected.back());
            }
            if (!step.sampled || q >= Quantity::curvature) continue;
            const plan::Totals &a = samples[0].totals[size_t(q)], &b = samples[1].totals[size_t(q)];
            for (auto total : {&plan::Totals::mean, &plan::Totals::min, &plan::Totals::max})
                test.kernels[SelfTest::reduce].compare(a.*total, b.*total);
            if (!step.impulse)
                compare_totals(test.kernels[SelfTest::others], a, expected, in_double ? 0x1p-53 : 0x1p-24);
        }
    }
}

// Compares the responses of a stream of frames.
void compare_presses(SelfTest::Kernel& kernel, plan::Backend& backend, const SampleStream& sample) {
    const auto pressures = sample.pressures(), found = sample.pressed(*backend.stream(sample.skin()), pressures),
               expected = sample.expected(pressures);
    for (size_t i = 0; i < found.size(); ++i)
        for (size_t k = 0; k < found[i].size(); ++k) kernel.compare(double(found[i][k]), double(expected[i][k]));
}

// The same of a kind of variant.
struct Kind {
    SampleStream::Options options;
    bool framed = false, f64 = false;
    void compare(SelfTest& test, plan::Backend& backend) const {
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

SelfTest self_test(plan::Backend& backend) {
    const DefaultFloats guard;
    SelfTest test;
    const plan::Chain chain{.length = 3}, with_spring{.length = 3, .spring = true};
    for (Kind kind :
         {Kind{},
          {{.materials = true}, true},
          {{.stencil = Stencil::fourth_order, .edges = Edges::periodic, .precision = Precision::f32_compensated}, true},
          {{.stencil = Stencil::published, .edges = Edges::published, .materials = true}},
          {{.precision = Precision::f32_compensated, .chain = with_spring}, true},
          {{.stencil = Stencil::fourth_order, .edges = Edges::periodic, .materials = true, .chain = chain}}}) {
        kind.compare(test, backend);
        kind.options.sites = true;
        compare_presses(test.kernels[SelfTest::sites], backend, SampleStream(kind.options));
    }
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

bool presses_exactly(plan::Backend& backend, const plan::StreamedSkin& like) {
    const DefaultFloats guard;
    SelfTest::Kernel kernel{"presses"};
    compare_presses(kernel, backend, SampleStream(like));
    return kernel.different == 0;
}

bool marches_exactly(plan::Backend& backend, const Variant& v) {
    const DefaultFloats guard;
    SelfTest test;
    const SampleStream sample(
        {.stencil = Stencil(v.stencil), .edges = Edges(v.edges), .materials = v.materials, .chain = v.chain});
    compare_marches(test, backend, sample.skin().skin, v, v.compensated ? Precision::f32_compensated : Precision::f32);
    return test.exact();
}

} // namespace dermis
