// SPDX-License-Identifier: MIT
// Histories: the hereditary integral of strains that run along lines, in closed form.
#include "host/core/base/refusal.hpp"
#include "host/lab/fit/problem.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::fit {

Hereditary hereditary(const Problem& p, double time) {
    Hereditary h{std::vector<double>(p.times.size()), std::vector<double>(p.times.size())};
    for (size_t i = 0; i < p.times.size(); ++i) {
        if (std::ranges::binary_search(p.starts, i)) {
            h.values[i] = p.strains[i]; // a step from rest
            continue;
        }
        const double step = p.times[i] - p.times[i - 1], change = p.strains[i] - p.strains[i - 1];
        const double z = step / time, left = std::exp(-z);
        // The mean of e^(-x) for x from 0 to z, and its derivative by the logarithm of the time.
        const double mean = z > 0 ? -std::expm1(-z) / z : 1, slope = z > 1e-8 ? mean - left : z / 2;
        h.values[i] = left * h.values[i - 1] + change * mean;
        h.slopes[i] = left * (h.slopes[i - 1] + z * h.values[i - 1]) + change * slope;
    }
    return h;
}

std::vector<double> model_of(const Problem& p, const std::vector<KelvinVoigt>& chain) {
    if (p.test != Test::history) return curve_of(p.test, chain, p.times);
    const Relaxation r = relaxation_of(chain);
    std::vector<double> stress(p.times.size());
    for (size_t i = 0; i < stress.size(); ++i) stress[i] = r.equilibrium * p.strains[i];
    for (size_t k = 0; k < r.times.size(); ++k) {
        const Hereditary h = hereditary(p, r.times[k]);
        for (size_t i = 0; i < stress.size(); ++i) stress[i] += r.moduli[k] * h.values[i];
    }
    return stress;
}

} // namespace dermis::fit
