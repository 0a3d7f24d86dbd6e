// SPDX-License-Identifier: MIT
#include "host/lab/scenes/spline.hpp"

namespace dermis::scene {
namespace {

// Replaces the numbers of a line that repeats itself by the coefficients of its spline. One recursion runs forwards and
// one backwards (Unser 1999). Each starts with the value that it would have after infinitely many rounds.
void line_to_spline(std::vector<double>& line) {
    const double z = std::sqrt(3.0) - 2, round = 1 - std::pow(z, double(line.size()));
    const size_t n = line.size();
    const auto start = [&](size_t first, size_t step) { // sum of z^k line[first + k step], over all rounds
        double sum = 0, power = 1;
        for (size_t k = 0; k < n && std::abs(power) > 1e-20; ++k, power *= z)
            sum += power * line[(first + k * step) % n];
        return sum / round;
    };
    double before = start(0, n - 1);
    line[0] = before;
    std::vector<double> forward(n);
    forward[0] = before;
    for (size_t i = 1; i < n; ++i) forward[i] = before = line[i] + z * before;
    line = forward;
    double after = -z * start(n - 1, 1);
    line[n - 1] = 6 * after;
    for (size_t i = n - 1; i-- > 0;) {
        after = z * (after - forward[i]);
        line[i] = 6 * after;
    }
}

} // namespace

void to_spline(std::vector<double>& map, int width, int height, Border border) {
    each_line(map, width, height, [&](std::vector<double>& line) {
        if (border == Border::mirrored) // a line and its reflection repeat themselves
            for (size_t i = line.size(); i-- > 0;) line.push_back(line[i]);
        line_to_spline(line);
    });
}

} // namespace dermis::scene
