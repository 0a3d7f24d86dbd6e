// SPDX-License-Identifier: MIT
// The kernels' text in numbers that count their errors (host/lab/planner/counted.hpp), function by function.
#include "host/lab/planner/counted.hpp"

#include "host/lab/schedule/extended.hpp"
#include "tests/support.hpp"

#include <random>

using namespace dermis;

namespace {

constexpr size_t terms = 17; // coefficients, load, strain and integral

// What the text makes of numbers in K. make(x, state): a number; whether it is a sum of the state.
template <class K, class Make> std::vector<typename K::real> made(const std::array<float, terms>& x, Make make) {
    typename K::LaneCoefficients k;
    size_t i = 0;
#define TAKE(name) k.name = make(x[i++], false);
    COEFFICIENTS(TAKE)
#undef TAKE
    const auto load = K::load(make(x[12], false), make(x[13], false), make(x[14], false));
    const auto eps = make(x[15], true), I = make(x[16], true);
    const auto gained = K::integral_gained(eps, load, k);
    const auto first = K::motion_of(eps, typename K::real(0.0), load, k),
               both = K::with_element(first, eps, eps, load, k);
    return {K::excess_stress(eps, load, k),
            K::strain_step(eps, load, k),
            gained,
            K::integral_step(gained, I, k),
            K::rate_after(eps, load, k),
            K::acceleration_after(eps, load, k),
            both.gained,
            both.rate,
            both.acceleration,
            K::spring_strain(load, k),
            K::spring_rate(eps, load, k)};
}

} // namespace

TEST_CASE(
    "numbers that count their roundings bound each function of a step in float, by no more than twice its error") {
    const planner::Rounding rounding{.u = 0x1p-24, .single = true};
    const planner::Known of_state{.sum = true};
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(-2, 2);
    std::vector<double> nearest(11); // greatest error over bound
    for (int n = 0; n < 100000; ++n) {
        std::array<float, terms> x;
        for (float& number : x) number = uniform(random);
        const auto in_float = made<f32>(x, [](float v, bool) { return v; });
        const auto exact = made<extended>(x, [](float v, bool) { return static_cast<long double>(v); });
        const auto numbers = made<counted>(
            x, [&](float v, bool state) { return planner::Counted(v, 0, 0, &rounding, state ? &of_state : nullptr); });
        REQUIRE(numbers.size() == nearest.size());
        for (size_t i = 0; i < nearest.size(); ++i) {
            const double error = double(std::abs(in_float[i] - exact[i]));
            if (error > 0) nearest[i] = std::max(nearest[i], error / numbers[i].off);
        }
    }
    for (double ratio : nearest) {
        CHECK(ratio <= 1);
        CHECK(ratio > 0.5);
    }
}
