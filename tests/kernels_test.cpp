// SPDX-License-Identifier: MIT
// One text of the model in float, double and four cells at a time.
#include "host/device.hpp"
#include "host/simd/model.hpp"
#include "tests/support.hpp"

#include <bit>

namespace vec4 {
using real = glm::vec4;
using scalar = float;
#include "kernels/model.h"
} // namespace vec4

namespace {

// Everything a cell's press goes through, in the reals of whichever namespace.
#define PRESS_ONE_CELL(space)                                                                                          \
    space::real press_##space(space::real p, space::real eps, space::real I, space::real rest) {                       \
        using real = space::real;                                                                                      \
        space::Coefficients row{};                                                                                              \
        const auto r = [](double x) { return space::scalar(float(x)); };                                               \
        row.E = r(1.5);                                                                                                \
        row.b = r(0.3);                                                                                                \
        row.f = r(0.1);                                                                                                \
        row.i0 = r(0.2);                                                                                               \
        row.i1 = r(0.07);                                                                                              \
        row.i2 = r(0.01);                                                                                              \
        row.leak = r(0.05);                                                                                            \
        row.v0 = r(0.6);                                                                                               \
        row.v1 = r(0.11);                                                                                              \
        row.a0 = r(-0.9);                                                                                              \
        row.a1 = r(0.4);                                                                                               \
        row.a2 = r(0.2);                                                                                               \
        space::Constants c{};                                                                                          \
        c.start = r(0.9);                                                                                              \
        c.rise = r(-0.3);                                                                                              \
        c.jump = r(0.7);                                                                                               \
        const space::LaneCoefficients k = space::lanes_of(row);                                                                     \
        const space::Load held = space::load_of(p, c);                                                                 \
        const space::Load s = space::load_between(held.s0, held.ds, c);                                                \
        const real after = space::added(eps, space::strain_step(eps, s, k));                                           \
        const real sum = space::added_compensated(I, rest, space::sum_step(eps, I, s, k)).value;                       \
        const real C = space::curvature_of(rest, space::second_difference(eps, after, I), r(0.5));                     \
        const real x = space::response(space::acceleration_after(eps, s, k), C, r(1.1));                               \
        return space::join(space::summary_of(space::rectified(x, r(0.8), r(-0.4))), space::summary_of(after + sum))    \
                   .sum +                                                                                              \
               space::rate_after(eps, s, k) + space::deformation_of(rest, eps, r(0.3));                                \
    }
PRESS_ONE_CELL(vec4)
namespace f32 = dermis::f32;
namespace f64 = dermis::f64;
PRESS_ONE_CELL(f32)
PRESS_ONE_CELL(f64)

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
        const glm::vec4 four = press_vec4(p, eps, I, rest);
        for (int lane = 0; lane < 4; ++lane) {
            const float one = press_f32(p[lane], eps[lane], I[lane], rest[lane]);
            REQUIRE(std::bit_cast<uint32_t>(four[lane]) == std::bit_cast<uint32_t>(one));
            CHECK(double(one) ==
                  doctest::Approx(press_f64(p[lane], eps[lane], I[lane], rest[lane])).epsilon(1e-5).scale(1));
        }
    }
}

TEST_CASE("what is below 2^-64 is stored as +0, what is not is kept") {
    const float limit = 0x1p-64f;
    for (float x : {0.0f, -0.0f, 0x1p-65f, -0x1.fffffep-65f, 0x1p-149f, -0x1p-149f})
        CHECK(std::bit_cast<uint32_t>(f32::flush(x)) == 0);
    for (float x : {limit, -limit, 1.0f, -0x1.000002p-64f}) CHECK(f32::flush(x) == x);
}

TEST_CASE("modules need no capability but Shader, and declare round-to-nearest-even where a device offers it") {
    constexpr uint32_t shader = 1, rounding_mode_rte = 4467, op_capability = 17, op_execution_mode = 16;
    namespace vulkan = dermis::vulkan;
    for (auto module : {vulkan::press_module, vulkan::fields_module, vulkan::reduce_module, vulkan::sites_module})
        for (bool rounds : {false, true}) {
            const vulkan::Module m = module(rounds);
            int declared = 0, modes = 0;
            for (size_t i = 5; i < m.bytes / 4; i += m.code[i] >> 16) {
                if ((m.code[i] & 0xffff) == op_capability) {
                    CHECK((m.code[i + 1] == shader || (rounds && m.code[i + 1] == rounding_mode_rte)));
                    declared += m.code[i + 1] == rounding_mode_rte;
                }
                modes += (m.code[i] & 0xffff) == op_execution_mode && m.code[i + 2] == 4462;
            }
            CHECK(declared == rounds);
            CHECK(modes == rounds);
        }
    const test::Validated validated;
    CHECK(validated.device().impl().context->pipelines().gpu().rounds); // lavapipe offers it
}
