// SPDX-License-Identifier: MIT
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"
#include "host/lab/fit/problem.hpp"

#include <algorithm>
#include <cmath>
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
    if (p.points <= most_points || p.test == Test::history) return p;
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

void need_count(int n, size_t points) {
    if (n < 0 || n > 8) scene::refuse("n", std::to_string(n), "1 to 8 elements, or 0: as few as describe the data");
    const size_t fewest = n ? size_t(2 * n + 1) : 3;
    if (points < fewest)
        scene::refuse("times", std::to_string(points) + " numbers",
                      "at least " + std::to_string(fewest) + (n ? " for " + std::to_string(n) + " elements" : ""));
}

// Checks a number that is fitted. Returns its magnitude.
double checked_value(const std::string& name, double value, Residual residual) {
    if (residual == Residual::relative)
        scene::need(finite(value) && value > 0, name.c_str(), value,
                    "a finite number > 0; any finite number with an absolute residual");
    scene::need_finite(name.c_str(), value);
    need_moderate(name, value);
    return std::abs(value);
}

void set_weights(Problem& p, double greatest, Residual residual) {
    for (double value : p.values) p.weights.push_back(1 / (residual == Residual::relative ? value : greatest));
}

Problem checked(Test test, const std::vector<double>& times, const std::vector<double>& values, int n,
                Residual residual) {
    const std::string name = test == Test::creep ? "compliances" : "moduli", points = std::to_string(times.size());
    if (values.size() != times.size())
        scene::refuse(name, std::to_string(values.size()) + " numbers", points + ", one for each time");
    need_count(n, times.size());
    double greatest = 0;
    for (size_t i = 0; i < times.size(); ++i) {
        const std::string time = "times[" + std::to_string(i) + "]";
        scene::need_not_negative(time.c_str(), times[i]);
        need_moderate(time, times[i]);
        checked_value(name + "[" + std::to_string(i) + "]", values[i], residual);
        greatest = std::max(greatest, values[i]);
    }
    if (std::ranges::none_of(times, [](double t) { return t > 0; }))
        scene::refuse("times", "no time after 0", "at least one");
    if (greatest == 0) scene::refuse(name, "no number > 0", "at least one");
    Problem p{.test = test, .times = times, .values = values, .weights = {}, .points = times.size()};
    set_weights(p, greatest, residual);
    return p;
}

void append_history(Problem& p, const History& h, const std::string& name, Residual residual, double& greatest) {
    const std::string points = std::to_string(h.times.size());
    for (auto [member, numbers] : {std::pair{".strains", &h.strains}, {".stresses", &h.stresses}})
        if (numbers->size() != h.times.size())
            scene::refuse(name + member, std::to_string(numbers->size()) + " numbers", points + ", one for each time");
    p.starts.push_back(p.times.size());
    for (size_t i = 0; i < h.times.size(); ++i) {
        const std::string at = "[" + std::to_string(i) + "]", time = name + ".times" + at,
                          strain = name + ".strains" + at;
        scene::need_finite(time.c_str(), h.times[i]);
        need_moderate(time, h.times[i]);
        scene::need(i == 0 || h.times[i] >= h.times[i - 1], time.c_str(), h.times[i],
                    "no time before the one before it");
        scene::need_finite(strain.c_str(), h.strains[i]);
        need_moderate(strain, h.strains[i]);
        greatest = std::max(greatest, checked_value(name + ".stresses" + at, h.stresses[i], residual));
        p.times.push_back(h.times[i]);
        p.strains.push_back(h.strains[i]);
        p.values.push_back(h.stresses[i]);
    }
}

Problem checked(const std::vector<History>& histories, int n, Residual residual) {
    constexpr size_t most = 20000;
    Problem p{.test = Test::history, .times = {}, .values = {}, .weights = {}, .points = 0};
    double greatest = 0;
    bool lasts = false;
    for (size_t k = 0; k < histories.size(); ++k) {
        const History& h = histories[k];
        append_history(p, h, "histories[" + std::to_string(k) + "]", residual, greatest);
        lasts |= !h.times.empty() && h.times.back() > h.times.front();
    }
    p.points = p.times.size();
    need_count(n, p.points);
    scene::need(p.points <= most, "histories", double(p.points), "at most 20000 points in all");
    if (!lasts) scene::refuse("histories", "no time after the first one", "at least one");
    if (greatest == 0) scene::refuse("histories", "no stress but 0", "at least one");
    set_weights(p, greatest, residual);
    return p;
}

// Refuses a spectrum of no element: all of the data is noise, or on the wrong side of 0.
std::vector<KelvinVoigt> chain_of_spectrum(const Problem& p, const Spectrum& s) {
    if (s.amplitudes.empty())
        scene::refuse(p.test == Test::creep     ? "compliances"
                      : p.test == Test::history ? "histories"
                                                : "moduli",
                      "a curve that no chain comes near", "a curve that is positive on the whole");
    if (p.test != Test::creep) {
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

// Returns the spectrum that the data need, of no more than the last one: of the least information criterion.
const Spectrum& needed_of(const Problem& p, const std::vector<Spectrum>& spectra) {
    const Spectrum* needed = &spectra.back();
    for (size_t n = spectra.size() - 1; n-- > 0;) {
        const Spectrum& fewer = spectra[n];
        if (!fewer.amplitudes.empty() &&
            information(p, fewer, fewer.parameters()) <= information(p, *needed, needed->parameters()))
            needed = &fewer;
    }
    return *needed;
}

// Returns the spectrum that is chosen: of the needed elements without the ones that hardly lower the residual.
const Spectrum& chosen_of(const Problem& p, const std::vector<Spectrum>& spectra) {
    constexpr double hardly = 1.05;
    const Spectrum& needed = needed_of(p, spectra);
    const double most = hardly * hardly * needed.squares;
    for (const Spectrum& s : spectra)
        if (!s.amplitudes.empty() && s.squares <= most) return s;
    return needed;
}

// Says so if a chain of fewer elements than `used` describes the data as well.
void compare_with_fewer(const Problem& p, const Spectrum& needed, const Spectrum& s, size_t used, Fit& fit) {
    const size_t fewer = chain_of_spectrum(p, needed).size();
    if (fewer >= used) return;
    fit.undetermined.push_back("a chain of " + std::to_string(fewer) + " describes the data as well as one of " +
                               std::to_string(used) + ": residual " + shown(residual_of(p, needed)) + " and " +
                               shown(residual_of(p, s)));
}

// Says why a spectrum was chosen: what its neighbours leave of the data.
std::string choice_of(const Problem& p, const std::vector<Spectrum>& spectra, const Spectrum& chosen) {
    const size_t used = chain_of_spectrum(p, chosen).size();
    std::string why = std::to_string(used) + (used == 1 ? " element" : " elements");
    const auto size_of = [&](const Spectrum& s) { return s.amplitudes.empty() ? 0 : chain_of_spectrum(p, s).size(); };
    for (size_t n = spectra.size(); n-- > 0;)
        if (const size_t fewer = size_of(spectra[n]); fewer > 0 && fewer < used) {
            why += ", because " + std::to_string(fewer) + (fewer == 1 ? " leaves" : " leave") + " a residual of " +
                   shown(residual_of(p, spectra[n])) + " and " + std::to_string(used) + " one of " +
                   shown(residual_of(p, chosen));
            break;
        }
    for (const Spectrum& s : spectra)
        if (const size_t more = size_of(s); more > used) {
            why += "; " + std::to_string(more) + " would leave " + shown(residual_of(p, s)) +
                   ", which is hardly less, or less by chance";
            break;
        }
    return why;
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

Fit fitted(const Problem& measured, int n) {
    const Problem p = condensed(measured);
    const int most = n ? n : int(std::min<size_t>(8, (p.points - 1) / 2));
    const std::vector<Spectrum> spectra = best_spectra(p, start_times_of(p), most);
    const Spectrum& s = n ? spectra.back() : chosen_of(p, spectra);
    Fit fit;
    fit.elements = chain_of_spectrum(p, s);
    fit.model = model_of(measured, fit.elements);
    fit.residual = residual_of(measured, fit.model);
    if (p.test != Test::history) doubt_kind(p, fit);
    const size_t used = fit.elements.size();
    if (n == 0) fit.choice = choice_of(p, spectra, s);
    if (used < size_t(n))
        fit.undetermined.push_back("the data take " + std::to_string(used) + " of " + std::to_string(n) +
                                   " elements: the others would add nothing");
    if (n) compare_with_fewer(p, needed_of(p, spectra), s, used, fit);
    judge(p, fit);
    return fit;
}

// Runs a fit of `points` points.
template <class Work> Fit within_memory(int n, size_t points, Work&& work) try {
    const DefaultFloats guard;
    return work();
} catch (const std::bad_alloc&) {
    scene::out_of_memory([&] {
        return (n ? "a fit of " + std::to_string(n) + " elements to " : "a fit to ") + std::to_string(points) +
               " points needs at least " + scene::bytes_text(double(points) * 4 * sizeof(double));
    });
}

Fit fitted(Test test, const std::vector<double>& times, const std::vector<double>& values, int n, Residual residual) {
    return within_memory(n, times.size(), [&] { return fitted(checked(test, times, values, n, residual), n); });
}

} // namespace
} // namespace fit

Fit fit_creep(const std::vector<double>& times, const std::vector<double>& compliances, int n, Residual residual) {
    return fit::fitted(fit::Test::creep, times, compliances, n, residual);
}

Fit fit_relaxation(const std::vector<double>& times, const std::vector<double>& moduli, int n, Residual residual) {
    return fit::fitted(fit::Test::relaxation, times, moduli, n, residual);
}

Fit fit_histories(const std::vector<History>& histories, int n, Residual residual) {
    size_t points = 0;
    for (const History& h : histories) points += h.times.size();
    return fit::within_memory(n, points, [&] { return fit::fitted(fit::checked(histories, n, residual), n); });
}

} // namespace dermis
