// SPDX-License-Identifier: MIT
#include "tests/oracle/oracle.hpp"

namespace oracle {
namespace {

using Map = std::vector<double>;

// Central difference along an axis, one-sided at its ends, unit spacing.
Map gradient(const Map& f, int width, int height, bool along_y) {
    Map g(f.size());
    const int n = along_y ? height : width;
    const size_t stride = along_y ? size_t(width) : 1;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const size_t here = size_t(y) * width + x;
            const int i = along_y ? y : x;
            if (i == 0) g[here] = f[here + stride] - f[here];
            else if (i == n - 1) g[here] = f[here] - f[here - stride];
            else g[here] = (f[here + stride] - f[here - stride]) / 2.0;
        }
    return g;
}

} // namespace

void study(const Map& surface, const Map& pressure, int width, int height, double modulus, double viscosity, double dt,
           int steps, const std::function<void(int, const Frame&)>& each) {
    const size_t cells = surface.size();
    Map strain(cells, 0.0), sum(cells, 0.0), rate_before(cells, 0.0), rate(cells, 0.0), rate_after(cells);
    for (int n = 0; n < steps; ++n) {
        Frame f;
        f.curvature.assign(cells, 0.0);
        if (n > 0) {
            Map deformed(cells);
            for (size_t i = 0; i < cells; ++i) {
                strain[i] = strain[i] + rate[i] * dt;
                sum[i] = sum[i] + strain[i];
                deformed[i] = surface[i] - strain[i];
            }
            const Map y = gradient(gradient(deformed, width, height, true), width, height, true);
            const Map x = gradient(gradient(deformed, width, height, false), width, height, false);
            for (size_t i = 0; i < cells; ++i) f.curvature[i] = y[i] + x[i];
        }
        for (size_t i = 0; i < cells; ++i) rate_after[i] = (pressure[i] - modulus * strain[i]) / viscosity;
        const bool inside = n > 0 && n < steps - 1;
        for (size_t i = 0; i < cells; ++i) {
            const double gain = 1 + f.curvature[i];
            f.strain.push_back(strain[i]);
            f.sa1.push_back(strain[i] * gain);
            f.sa2.push_back(sum[i] * dt * gain);
            f.fa1.push_back(rate[i] * gain);
            f.fa2.push_back(inside ? (rate_after[i] - rate_before[i]) / (2 * dt) * gain : 0.0);
        }
        each(n, f);
        rate_before = rate;
        rate = rate_after;
    }
}

} // namespace oracle
