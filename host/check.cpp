// SPDX-License-Identifier: MIT
#include "host/check.hpp"

#include "host/cpu/stream.hpp"
#include "host/cpu/stepper.hpp"
#include "host/device.hpp"
#include "host/plan/float_environment.hpp"
#include "host/vulkan/runner.hpp"

#include <bit>
#include <optional>

namespace dermis {
namespace {

plan::Plan self_test_plan(Stencil stencil, Edges edges, Precision precision, bool materials, bool framed) {
    Scene s;
    static_cast<SkinDescription&>(s) = plan::sample_skin(stencil, edges, materials);
    s.time = {0.125, 1};
    s.load.envelope.start = 0.2;
    s.load.kind = Load::Kind::map;
    s.load.map = plan::sample_pressure();
    s.output.fields = {{0.3, {Quantity::curvature, Quantity::deformation}}};
    plan::Plan plan = plan::make_plan(s, precision);
    plan.framed = framed;
    return plan;
}

void compare(SelfTest::Kernel& kernel, double device, double cpu) {
    const auto bits = std::bit_cast<uint64_t>(device);
    for (int i = 0; i < 8; ++i) kernel.hash = (kernel.hash ^ (bits >> (8 * i) & 255)) * 1099511628211u;
    ++kernel.values;
    kernel.different += bits != std::bit_cast<uint64_t>(cpu);
}

// Receptors of a skin pressed frame by frame.
void compare_sites(SelfTest::Kernel& kernel, const Device& device, Stencil stencil, Edges edges, Precision precision,
                   bool materials) {
    SkinDescription d = plan::sample_skin(stencil, edges, materials);
    for (int i = 0; i < 100; ++i)
        d.sites.push_back({Quantity(1 + i % 4), {i * 31 % d.grid.width, i * i * 7 % d.grid.height}});
    SkinOptions options;
    options.precision = precision;
    const plan::Plan plan = plan::skin_plan(d, options);
    const plan::ResponseLayout answers = plan::response_layout_of(plan);
    std::optional<vulkan::SkinRunner> runner;
    if (device.impl().context) runner.emplace(device.impl().context, d, options);
    cpu::Frames one(plan, 1), two(plan, 1, simd::plain);
    std::vector<float> before(size_t(plan.pitch) * size_t(d.grid.height)), a(answers.all), b(answers.all);
    const auto press = [&](cpu::Frames& frames, const std::vector<float>& to, std::vector<float>& out) {
        frames.press(0.125, before.data(), to.data(),
                     {out.data() + answers.of[1].first, out.data() + answers.of[2].first,
                      out.data() + answers.of[3].first, out.data() + answers.of[4].first});
    };
    for (const Map& pressure : {plan::sample_pressure(), d.surface.map}) {
        const std::vector<float> to = plan::padded<float>(pressure, plan, "");
        press(two, to, b);
        if (runner) {
            std::copy(to.begin(), to.end(), runner->pressure());
            runner->press(0.125);
            std::copy_n(runner->answers(), a.size(), a.begin());
        } else {
            press(one, to, a);
        }
        before = to;
        for (size_t i = 0; i < a.size(); ++i) compare(kernel, double(a[i]), double(b[i]));
    }
}

} // namespace

SelfTest self_test(const Device& device, bool every_variant) {
    const DefaultFloats guard;
    SelfTest test;
    const std::vector<Quantity> pressed = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1,
                                           Quantity::fa2};
    const std::vector<Quantity> derived = {Quantity::curvature, Quantity::deformation};
    for (auto [stencil, edges, precision, materials, framed] :
         {std::tuple{Stencil::five_point, Edges::mirror, Precision::f32, false, false},
          {Stencil::five_point, Edges::mirror, Precision::f32, true, true},
          {Stencil::fourth_order, Edges::periodic, Precision::f32_compensated, false, true},
          {Stencil::published, Edges::published, Precision::f32, true, false}}) {
        if (!every_variant && (materials || framed || edges != Edges::mirror)) continue;
        const plan::Plan plan = self_test_plan(stencil, edges, precision, materials, framed);
        std::vector<plan::Sample> samples[2];
        const auto take = [&](int i) { return [&samples, i](auto&, auto& sample) { samples[i].push_back(sample); }; };
        const Device::Impl& d = device.impl();
        const auto one = d.context ? vulkan::march(plan, d.context, take(0)) : cpu::march(plan, 1, take(0));
        const auto two = cpu::march(plan, 1, take(1), simd::plain);
        std::vector<std::vector<double>> a, b;
        plan::Timeline timeline(plan);
        for (plan::Step step; timeline.next(step);) {
            if (framed) {
                one->frame(step.keep ? plan.maps.pressure : plan.maps.surface);
                two->frame(step.keep ? plan.maps.pressure : plan.maps.surface);
            }
            one->press(step);
            two->press(step);
            for (const auto& [what, kernel] : {std::pair{&pressed, SelfTest::press}, {&derived, SelfTest::fields}}) {
                one->read(*what, a);
                two->read(*what, b);
                for (size_t q = 0; q < a.size(); ++q)
                    for (size_t i = 0; i < a[q].size(); ++i) compare(test.kernels[kernel], a[q][i], b[q][i]);
            }
        }
        one->finish();
        for (size_t i = 0; i < samples[1].size(); ++i)
            for (int q = 0; q < REDUCED_MAPS; ++q) {
                const plan::Totals a = samples[0][i].totals[q], b = samples[1][i].totals[q];
                compare(test.kernels[SelfTest::reduce], a.mean, b.mean);
                compare(test.kernels[SelfTest::reduce], a.min, b.min);
                compare(test.kernels[SelfTest::reduce], a.max, b.max);
            }
        if (every_variant) compare_sites(test.kernels[SelfTest::sites], device, stencil, edges, precision, materials);
    }
    return test;
}

} // namespace dermis
