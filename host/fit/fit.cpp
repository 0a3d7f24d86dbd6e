// SPDX-License-Identifier: MIT
#include "host/fit/problem.hpp"
#include "host/scene/float_environment.hpp"
#include "host/scene/memory.hpp"
#include "host/scene/refusal.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace dermis {
namespace fit {

std::vector<double> curve_of(Test test, const std::vector<KelvinVoigt>& chain, const std::vector<double>& times) {
    std::vector<double> curve(times.size());
    if (test == Test::relaxation) {
        const Relaxation r = relaxation_of(chain);
        for (size_t i = 0; i < times.size(); ++i) {
            curve[i] = r.equilibrium;
            for (size_t k = 0; k < r.times.size(); ++k) curve[i] += r.moduli[k] * std::exp(-times[i] / r.times[k]);
        }
        return curve;
    }
    for (const KelvinVoigt& e : chain)
        for (size_t i = 0; i < times.size(); ++i)
            curve[i] += e.modulus == 0     ? times[i] / e.viscosity
                        : e.viscosity == 0 ? 1 / e.modulus
                                           : -std::expm1(-times[i] * e.modulus / e.viscosity) / e.modulus;
    return curve;
}

namespace {

// Refuses numbers whose squares or ratios might leave the range of double.
void need_moderate(const std::string& name, double x) {
    scene::need(x == 0 || (std::abs(x) > 1e-50 && std::abs(x) < 1e50), name.c_str(), x,
                "0, or between 1e-50 and 1e50; other units may help");
}

Problem checked(Test test, const std::vector<double>& times, const std::vector<double>& values, int n,
                Residual residual) {
    const std::string name = test == Test::creep ? "compliances" : "moduli", points = std::to_string(times.size());
    if (n < 1 || n > 8) scene::refuse("n", std::to_string(n), "1 to 8 elements");
    if (values.size() != times.size())
        scene::refuse(name, std::to_string(values.size()) + " numbers", points + ", one for each time");
    if (times.size() < size_t(2 * n + 1))
        scene::refuse("times", points + " numbers",
                      "at least " + std::to_string(2 * n + 1) + " for " + std::to_string(n) + " elements");
    double greatest = 0;
    for (size_t i = 0; i < times.size(); ++i) {
        const std::string time = "times[" + std::to_string(i) + "]";
        scene::need_not_negative(time.c_str(), times[i]);
        need_moderate(time, times[i]);
        const std::string value = name + "[" + std::to_string(i) + "]";
        if (residual == Residual::relative)
            scene::need(scene::finite(values[i]) && values[i] > 0, value.c_str(), values[i],
                        "a finite number > 0; any finite number with an absolute residual");
        scene::need_finite(value.c_str(), values[i]);
        need_moderate(value, values[i]);
        greatest = std::max(greatest, values[i]);
    }
    if (std::none_of(times.begin(), times.end(), [](double t) { return t > 0; }))
        scene::refuse("times", "no time after 0", "at least one");
    if (greatest == 0) scene::refuse(name, "no number > 0", "at least one");
    Problem p{.test = test, .times = times, .values = values, .weights = {}};
    for (double value : values) p.weights.push_back(1 / (residual == Residual::relative ? value : greatest));
    return p;
}

// Refuses a spectrum of no element: all of the data is noise, or on the wrong side of 0.
std::vector<KelvinVoigt> chain_of_spectrum(const Problem& p, const Spectrum& s) {
    if (s.amplitudes.empty())
        scene::refuse(p.test == Test::creep ? "compliances" : "moduli", "a curve that no chain comes near",
                      "a curve that is positive on the whole");
    if (p.test == Test::relaxation) {
        Relaxation r;
        if (s.constant) r.equilibrium = s.amplitudes[0];
        for (size_t k = 0; k < s.log_times.size(); ++k) {
            r.moduli.push_back(s.amplitudes[s.first_time() + k]);
            r.times.push_back(std::exp(s.log_times[k]));
        }
        return chain_of(r);
    }
    std::vector<KelvinVoigt> chain;
    if (s.constant) chain.push_back({1 / s.amplitudes[0], 0});
    for (size_t k = 0; k < s.log_times.size(); ++k) {
        const double modulus = 1 / s.amplitudes[s.first_time() + k];
        chain.push_back({modulus, modulus * std::exp(s.log_times[k])});
    }
    if (s.ramp) chain.push_back({0, 1 / s.amplitudes[s.constant]});
    return chain;
}

double residual_of(const Problem& p, const Spectrum& s) { return std::sqrt(s.squares / double(p.times.size())); }

// Says so if a chain of fewer elements than `used` describes the data as well.
void compare_with_fewer(const Problem& p, const Grid& grid, const Spectrum& s, size_t used, Fit& fit) {
    double least = information(p, s, s.parameters());
    std::string sentence;
    for (int n = int(used) - 1; n > 0; --n) {
        const Spectrum fewer = best_spectrum(p, grid, n);
        const double score = information(p, fewer, fewer.parameters());
        if (fewer.amplitudes.empty() || score > least) continue;
        least = score;
        char text[160];
        std::snprintf(text, sizeof text,
                      "a chain of %zu describes the data as well as one of %zu: residual %.3g and %.3g",
                      chain_of_spectrum(p, fewer).size(), used, residual_of(p, fewer), residual_of(p, s));
        sentence = text;
    }
    if (!sentence.empty()) fit.undetermined.push_back(sentence);
}

Fit fitted(const Problem& p, int n) {
    const Grid grid = grid_of(p);
    const Spectrum s = best_spectrum(p, grid, n);
    Fit fit;
    fit.elements = chain_of_spectrum(p, s);
    fit.residual = residual_of(p, s);
    fit.model = curve_of(p.test, fit.elements, p.times);
    const size_t used = fit.elements.size();
    if (used < size_t(n))
        fit.undetermined.push_back("the data take " + std::to_string(used) + " of " + std::to_string(n) +
                                   " elements: the others would add nothing");
    compare_with_fewer(p, grid, s, used, fit);
    judge(p, fit);
    return fit;
}

std::string needs_of(size_t points, int n) {
    return "a fit of " + std::to_string(n) + " elements to " + std::to_string(points) + " points needs at least " +
           scene::bytes_text(double(points) * (n + 2) * sizeof(double));
}

} // namespace
} // namespace fit

Fit fit_creep(const std::vector<double>& times, const std::vector<double>& compliances, int n, Residual residual) try {
    const DefaultFloats guard;
    return fit::fitted(fit::checked(fit::Test::creep, times, compliances, n, residual), n);
} catch (const std::bad_alloc&) {
    scene::out_of_memory([&] { return fit::needs_of(times.size(), n); });
}

Fit fit_relaxation(const std::vector<double>& times, const std::vector<double>& moduli, int n, Residual residual) try {
    const DefaultFloats guard;
    return fit::fitted(fit::checked(fit::Test::relaxation, times, moduli, n, residual), n);
} catch (const std::bad_alloc&) {
    scene::out_of_memory([&] { return fit::needs_of(times.size(), n); });
}

} // namespace dermis
