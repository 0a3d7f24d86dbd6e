// SPDX-License-Identifier: MIT
#include "tests/oracle/oracle.hpp"

#include <cmath>
#include <utility>

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

Fields model(const Skin& skin, const Map& surface, const Map& pressure, double t) {
    const int w = skin.width, h = skin.height;
    const double tau = skin.viscosity / skin.modulus, decay = std::exp(-t / tau);
    Fields f;
    for (size_t i = 0; i < surface.size(); ++i) {
        f.strain.push_back(pressure[i] / skin.modulus * (1 - decay));
        f.deformation.push_back(surface[i] - skin.thickness * f.strain[i]);
    }
    // the deformed surface with two cells added on every side
    const auto beyond = [&](int i, int n) {
        while (i < 0 || i >= n) {
            if (skin.outside == Outside::periodic) i += i < 0 ? n : -n;
            else i = i < 0 ? -i - 1 : 2 * n - i - 1;
        }
        return i;
    };
    const auto deformed = [&](int x, int y) { return f.deformation[size_t(beyond(y, h)) * w + beyond(x, w)]; };
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            double sum = 0;
            for (auto [dx, dy] : {std::pair{1, 0}, {0, 1}}) {
                const double near = deformed(x - dx, y - dy) + deformed(x + dx, y + dy) - 2 * deformed(x, y);
                const double far =
                    deformed(x - 2 * dx, y - 2 * dy) + deformed(x + 2 * dx, y + 2 * dy) - 2 * deformed(x, y);
                sum += skin.fourth_order ? (16 * near - far) / 12 : near;
            }
            const double C = sum / (skin.spacing * skin.spacing), gain = 1 + skin.curvature_length * C;
            const size_t i = size_t(y) * w + x;
            f.curvature.push_back(C);
            f.sa1.push_back(f.strain[i] * gain);
            f.sa2.push_back(pressure[i] / skin.modulus * (t - tau * (1 - decay)) * gain);
            f.fa1.push_back(pressure[i] / skin.viscosity * decay * gain);
            f.fa2.push_back(-pressure[i] * skin.modulus / (skin.viscosity * skin.viscosity) * decay * gain);
        }
    return f;
}

} // namespace oracle
