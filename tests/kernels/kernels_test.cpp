// SPDX-License-Identifier: MIT
// labels: device threads
// One text of the model in float, double and four cells at a time.
#include "host/core/embedding/backend.hpp"
#include "host/core/press/device.hpp"
#include "host/core/simd/model.hpp"
#include "tests/support.hpp"

#include <bit>
#include <set>

namespace dermis::kernels {
struct vec4 {
    using real = glm::vec4;
    using scalar = float;
#include "kernels/model.h"
};
} // namespace dermis::kernels

namespace {

// Everything a cell's press goes through, in the reals of K.
template <class K>
typename K::real press_one(typename K::real p, typename K::real eps, typename K::real I, typename K::real rest) {
    using real = typename K::real;
    const auto r = [](double x) { return typename K::scalar(float(x)); };
    typename K::Constants c{};
    typename K::Coefficients& k = c.coefficients;
    k.E = r(1.5);
    k.b = r(0.3);
    k.f = r(0.1);
    k.i0 = r(0.2);
    k.i1 = r(0.07);
    k.i2 = r(0.01);
    k.leak = r(0.05);
    k.v0 = r(0.6);
    k.v1 = r(0.11);
    k.a0 = r(-0.9);
    k.a1 = r(0.4);
    k.a2 = r(0.2);
    c.start = r(0.9);
    c.rise = r(-0.3);
    c.jump = r(0.7);
    c.curvature_length = r(1.1);
    c.gain_plus = r(0.8);
    c.gain_minus = r(-0.4);
    const typename K::LaneCoefficients lanes = K::lanes_of(k);
    const typename K::Load held = K::load_of(p, c), load = K::load_between(held.s0, held.ds, c);
    const auto strain = [&](int compensated) {
        return K::advanced_strain(K::sum_of(eps, rest), load, lanes, compensated).value;
    };
    const real plain = strain(0), after = strain(1);
    typename K::Motion m = K::motion_of(eps, after, load, lanes);
    m = K::with_element(m, rest, plain, load, lanes);
    m.strain = K::in_series(m.strain, K::spring_strain(load, lanes));
    const real integral = K::advanced_integral(K::sum_of(I, rest), m.gained, lanes, 1).value;
    const real C = K::curvature_of(rest, K::difference(I, eps, after, plain, p, K::axis(1, 3, 1, 0), 1), r(0.5));
    typename K::Summary all = K::summary_of(plain + integral);
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
        all = K::join(all, K::summary_of(K::answer(q, K::signal(q, m, integral), K::gain_at(C, c), c)));
    const typename K::LongSum sum = K::joined(K::joined(K::long_sum(eps), K::long_sum(C)), K::long_sum(rest));
    return all.sum + sum.sum * r(0x1p28) + sum.rest + K::deformation_of(rest, eps, r(0.3));
}

using dermis::f32;
using dermis::f64;
using dermis::kernels::vec4;
using test::absolute;

} // namespace

TEST_CASE("four cells at a time have the bits of one") {
    uint32_t random = 7;
    const auto next = [&] {
        return (random = random * 1664525u + 1013904223u, float(random >> 8) / (1 << 24) * 4 - 2);
    };
    for (int i = 0; i < 1000; ++i) {
        glm::vec4 p, eps, I, rest;
        for (int lane = 0; lane < 4; ++lane) {
            p[lane] = next();
            eps[lane] = next();
            I[lane] = next();
            rest[lane] = next();
        }
        const glm::vec4 four = press_one<vec4>(p, eps, I, rest);
        for (int lane = 0; lane < 4; ++lane) {
            const float one = press_one<f32>(p[lane], eps[lane], I[lane], rest[lane]);
            REQUIRE(std::bit_cast<uint32_t>(four[lane]) == std::bit_cast<uint32_t>(one));
            // The sum's terms cancel.
            CHECK(double(one) == absolute(press_one<f64>(p[lane], eps[lane], I[lane], rest[lane]), 1e-5));
        }
    }
}

TEST_CASE("what is below 2^-64 is stored as +0, what is not is kept") {
    const float limit = 0x1p-64f;
    for (float x : {0.0f, -0.0f, 0x1p-65f, -0x1.fffffep-65f, 0x1p-149f, -0x1p-149f})
        CHECK(std::bit_cast<uint32_t>(f32::flush(x)) == 0);
    for (float x : {limit, -limit, 1.0f, -0x1.000002p-64f}) CHECK(f32::flush(x) == x);
}

TEST_CASE("modules need no capability but Shader, and declare the rules of floats that a device offers") {
    constexpr uint32_t shader = 1, keeps_nans = 4466, rounding_mode_rte = 4467, op_capability = 17,
                       op_execution_mode = 16;
    constexpr uint32_t sampled_buffer = 46; // every device has it, but modules for hardware do without
    // The order of a module's first instructions: capabilities, extensions, imports, memory model, entry points, modes.
    const std::vector<uint32_t> order = {op_capability, 10, 11, 14, 15, op_execution_mode};
    namespace vulkan = dermis::vulkan;
    std::vector<vulkan::Module> modules = {vulkan::fibres_module()};
    for (auto module : {vulkan::press_module, vulkan::press_signals_module, vulkan::press_sites_module,
                        vulkan::reduce_module, vulkan::halve_module, vulkan::spread_module})
        modules.insert(modules.end(), {module(false), module(true)});
    for (const vulkan::Module& m : modules)
        for (const vulkan::FloatRules rules :
             {vulkan::FloatRules{}, {.rounds_to_even = true}, {.keeps_nans = true}, {true, true}}) {
            const std::vector<uint32_t> words = vulkan::declare(rules, m);
            std::set<uint32_t> declared, modes;
            size_t i = 5, before = 0;
            for (; i < words.size(); i += words[i] >> 16) {
                const uint32_t op = words[i] & 0xffff;
                const bool own = m.texels != 0 && words[i + 1] == sampled_buffer;
                if (op == op_capability && words[i + 1] != shader && !own) declared.insert(words[i + 1]);
                if (const auto found = std::find(order.begin(), order.end(), op); found != order.end()) {
                    CHECK(before <= size_t(found - order.begin()));
                    before = size_t(found - order.begin());
                }
                if (op == op_execution_mode && words[i + 2] >= 4459) modes.insert(words[i + 2] + 5);
            }
            CHECK(i == words.size());
            const size_t asked = size_t(rules.rounds_to_even) + size_t(rules.keeps_nans);
            CHECK(words.size() == m.bytes / 4 + 6 * asked + (asked > 0 ? 7 : 0));
            std::set<uint32_t> wanted;
            if (rules.keeps_nans) wanted.insert(keeps_nans);
            if (rules.rounds_to_even) wanted.insert(rounding_mode_rte);
            CHECK(declared == wanted);
            CHECK(modes == wanted);
        }
    const test::Validated validated;
    const auto context = vulkan::context_of(*validated.device().impl().backend);
    VkPhysicalDeviceFloatControlsProperties floats{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES};
    VkPhysicalDeviceProperties2 offered{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &floats, {}};
    const vulkan::Handles handles = context->handles();
    reinterpret_cast<PFN_vkGetPhysicalDeviceProperties2>(
        handles.get_instance_proc_addr(handles.instance, "vkGetPhysicalDeviceProperties2"))(handles.physical, &offered);
    const vulkan::FloatRules& used = context->pipelines().device().floats;
    CHECK(used.rounds_to_even == bool(floats.shaderRoundingModeRTEFloat32));
    CHECK(used.keeps_nans == bool(floats.shaderSignedZeroInfNanPreserveFloat32));
}
