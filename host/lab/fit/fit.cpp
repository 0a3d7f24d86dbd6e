// SPDX-License-Identifier: MIT
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"
#include "host/lab/fit/problem.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

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

Problem condensed(Problem p) {
    constexpr double width = 1e-3; // of the logarithm of the time
    if (p.points <= most_points) return p;
    // Sums over the points of an interval; weights are squared, values are taken from the first one's.
    struct Sums {
        double first, weight, time, value, time_time, time_value, value_value;
    };
    std::map<double, Sums> intervals; // by the logarithm at their middle
    for (size_t i = 0; i < p.times.size(); ++i) {
        const double middle = (std::floor(std::log(p.times[i]) / width) + 0.5) * width; // -inf of time 0
        const auto [at, is_new] = intervals.try_emplace(middle, Sums{.first = p.values[i]});
        Sums& s = at->second;
        const double w = p.weights[i] * p.weights[i], v = p.values[i] - s.first,
                     t = p.times[i] > 0 ? std::log(p.times[i]) - middle : 0;
        s.weight += w;
        s.time += w * t;
        s.value += w * v;
        s.time_time += w * t * t;
        s.time_value += w * t * v;
        s.value_value += w * v * v;
    }
    Problem few{.test = p.test, .times = {}, .values = {}, .weights = {}, .points = p.points};
    for (const auto& [middle, s] : intervals) {
        few.times.push_back(std::exp(middle + s.time / s.weight));
        few.values.push_back(s.first + s.value / s.weight);
        few.weights.push_back(std::sqrt(s.weight));
        // The scatter around a straight line in the logarithm of the time: here every curve is one.
        const double times = s.time_time - s.time * s.time / s.weight,
                     both = s.time_value - s.time * s.value / s.weight,
                     values = s.value_value - s.value * s.value / s.weight;
        few.scatter += std::max(0.0, values - (times > 0 ? both * both / times : 0));
    }
    return few;
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
            scene::need(finite(values[i]) && values[i] > 0, value.c_str(), values[i],
                        "a finite number > 0; any finite number with an absolute residual");
        scene::need_finite(value.c_str(), values[i]);
        need_moderate(value, values[i]);
        greatest = std::max(greatest, values[i]);
    }
    if (std::ranges::none_of(times, [](double t) { return t > 0; }))
        scene::refuse("times", "no time after 0", "at least one");
    if (greatest == 0) scene::refuse(name, "no number > 0", "at least one");
    Problem p{.test = test, .times = times, .values = values, .weights = {}, .points = times.size()};
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

double residual_of(const Problem& p, const std::vector<double>& model) {
    double squares = 0;
    for (size_t i = 0; i < model.size(); ++i) squares += std::pow(p.weights[i] * (model[i] - p.values[i]), 2);
    return std::sqrt(squares / double(model.size()));
}

double residual_of(const Problem& p, const Spectrum& s) { return std::sqrt(s.squares / double(p.points)); }

// Says so if a chain of fewer elements than `used` describes the data as well.
void compare_with_fewer(const Problem& p, const std::vector<Spectrum>& spectra, const Spectrum& s, size_t used,
                        Fit& fit) {
    double least = information(p, s, s.parameters());
    std::string sentence;
    for (int n = int(used) - 1; n > 0; --n) {
        const Spectrum& fewer = spectra[size_t(n) - 1];
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

// Says so where the values run the wrong way in time, by more than three standard deviations of the count of pairs
// among values without order (Mann and Kendall's test).
void doubt_kind(const Problem& p, Fit& fit) {
    double sum = 0;
    const double n = double(p.times.size());
    for (size_t i = 0; i < p.times.size(); ++i)
        for (size_t j = 0; j < i; ++j) {
            const double product = (p.times[i] - p.times[j]) * (p.values[i] - p.values[j]);
            sum += double(product > 0) - double(product < 0);
        }
    const double deviations = sum / std::sqrt(n * (n - 1) * (2 * n + 5) / 18);
    if (p.test == Test::creep && deviations < -3)
        fit.undetermined.push_back("the compliances fall with time, as in no creep");
    if (p.test == Test::relaxation && deviations > 3)
        fit.undetermined.push_back("the moduli rise with time, as in no relaxation");
}

Fit fitted(Test test, const std::vector<double>& times, const std::vector<double>& values, int n,
           Residual residual) try {
    const DefaultFloats guard;
    const Problem measured = checked(test, times, values, n, residual);
    const Problem p = condensed(measured);
    const std::vector<Spectrum> spectra = best_spectra(p, start_times_of(p), n);
    const Spectrum& s = spectra.back();
    Fit fit;
    fit.elements = chain_of_spectrum(p, s);
    fit.model = curve_of(p.test, fit.elements, measured.times);
    fit.residual = residual_of(measured, fit.model);
    doubt_kind(p, fit);
    const size_t used = fit.elements.size();
    if (used < size_t(n))
        fit.undetermined.push_back("the data take " + std::to_string(used) + " of " + std::to_string(n) +
                                   " elements: the others would add nothing");
    compare_with_fewer(p, spectra, s, used, fit);
    judge(p, fit);
    return fit;
} catch (const std::bad_alloc&) {
    scene::out_of_memory([&] {
        return "a fit of " + std::to_string(n) + " elements to " + std::to_string(times.size()) +
               " points needs at least " + scene::bytes_text(double(times.size()) * 4 * sizeof(double));
    });
}

} // namespace
} // namespace fit

Fit fit_creep(const std::vector<double>& times, const std::vector<double>& compliances, int n, Residual residual) {
    return fit::fitted(fit::Test::creep, times, compliances, n, residual);
}

Fit fit_relaxation(const std::vector<double>& times, const std::vector<double>& moduli, int n, Residual residual) {
    return fit::fitted(fit::Test::relaxation, times, moduli, n, residual);
}

} // namespace dermis
