// SPDX-License-Identifier: MIT
// Pads with buffers of their own, and short ways to write contacts, depths and taxels.
#pragma once

#include "dermis/contact.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace test::contacts {

using namespace dermis::contact;

inline constexpr double quarter = 2.5e-4; // m
inline constexpr double pi = 3.14159265358979323846;

struct Random {
    std::mt19937_64 bits{1};
    double unit() { return double(bits() >> 11) * 0x1p-53; }
    double within(double low, double high) { return low + (high - low) * unit(); }
    double decades(double low, double high) { return std::pow(10, within(low, high)); }
};

// A pad with a buffer of its own.
struct Buffer {
    std::vector<float> pressure;
    Pad pad;

    Buffer(int width, int height, double spacing = quarter)
        : pressure(size_t(width) * height), pad{width, height, spacing, pressure.data()} {}
    double force() const { return std::accumulate(pressure.begin(), pressure.end(), 0.0) * pad.spacing * pad.spacing; }
    double of(int x, int y) const { return pressure[size_t(y) * pad.width + x]; }
    int pressed() const {
        return int(std::count_if(pressure.begin(), pressure.end(), [](float p) { return p != 0; }));
    }
};

inline double difference(const std::vector<float>& a, const std::vector<float>& b) {
    REQUIRE(a.size() == b.size());
    double most = 0, worst = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        most = std::max(most, std::abs(double(b[i])));
        worst = std::max(worst, std::abs(double(a[i]) - double(b[i])));
    }
    return worst / most;
}

inline Contact at(double x, double y, double force, double radius) {
    Contact c;
    c.x = x, c.y = y, c.force = force, c.radius = radius;
    return c;
}

inline DepthMap depths_of(const std::vector<float>& depth, double force, double stiffness = 0) {
    DepthMap d;
    d.depth = depth.data(), d.force = force, d.stiffness = stiffness;
    return d;
}

inline TaxelReadings taxels_of(const std::vector<float>& values, int columns, int rows, double width, double height) {
    TaxelReadings t;
    t.values = values.data(), t.columns = columns, t.rows = rows, t.width = width, t.height = height;
    return t;
}

} // namespace test::contacts
