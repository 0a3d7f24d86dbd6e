// SPDX-License-Identifier: MIT
// An arc tangent with the same bits on every processor.
#pragma once

#include <cmath>
#include <numbers>

namespace dermis {

// Returns the arc tangent, to 4 units of the last bit. It is the arc tangent of the nearest eighth, plus a series.
// std::atan of long double is an instruction of the processor, and its last bits differ between processors. Sums,
// products and quotients have the same bits on all of them.
inline long double arc_tangent(long double t) {
    constexpr long double of_eighths[] = {
        0.000000000000000000000000L, 0.124354994546761435031355L, 0.244978663126864154172082L,
        0.358770670270572220395920L, 0.463647609000806116214256L, 0.558599315343562435971508L,
        0.643501108793284386802809L, 0.718829999621624505417014L, 0.785398163397448309615661L};
    const bool steep = std::abs(t) > 1;
    const long double x = steep ? 1 / std::abs(t) : std::abs(t);
    const int eighths = int(8 * x + 0.5L);
    const long double nearest = eighths / 8.0L, rest = (x - nearest) / (1 + x * nearest), square = rest * rest;
    long double sum = 0;
    for (int n = 8; n >= 0; --n) sum = 1.0L / (2 * n + 1) - square * sum; // square < 0.004
    const long double angle = of_eighths[eighths] + rest * sum;
    return std::copysign(steep ? std::numbers::pi_v<long double> / 2 - angle : angle, t);
}

} // namespace dermis
