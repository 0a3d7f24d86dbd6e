// SPDX-License-Identifier: MIT
// Searches the times of a spectrum: first on a grid of start times, then by variable projection. Amplitudes follow from
// times by nonnegative least squares.
#include "host/lab/fit/problem.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dermis::fit {
namespace {

// Bounds of the logarithm of a time: a tenth of the shortest time of the data to ten times the longest.
struct LogTimes {
    double least, most;
};
LogTimes log_times_of(const Problem& p) {
    double least = HUGE_VAL, most = 0;
    if (p.test == Test::history) { // the shortest step, and the longest history
        for (size_t i = 1, start = 0; i < p.times.size(); ++i) {
            if (std::ranges::binary_search(p.starts, i)) {
                start = i;
                continue;
            }
            if (p.times[i] > p.times[i - 1]) least = std::min(least, p.times[i] - p.times[i - 1]);
            most = std::max(most, p.times[i] - p.times[start]);
        }
        return {std::log(least / 10), std::log(most * 10)};
    }
    for (double t : p.times)
        if (t > 0) {
            least = std::min(least, t);
            most = std::max(most, t);
        }
    return {std::log(least / 10), std::log(most * 10)};
}

template <class Term> std::vector<double> weighted(const Problem& p, Term term) {
    std::vector<double> column(p.times.size());
    for (size_t i = 0; i < column.size(); ++i) column[i] = p.weights[i] * term(i);
    return column;
}

std::vector<double> exponential(const Problem& p, double log_time) {
    if (p.test == Test::history) {
        const Hereditary h = hereditary(p, std::exp(log_time));
        return weighted(p, [&](size_t i) { return h.values[i]; });
    }
    const double rate = std::exp(-log_time);
    return weighted(p, [&](size_t i) {
        const double z = p.times[i] * rate;
        return p.test == Test::creep ? -std::expm1(-z) : std::exp(-z);
    });
}

// The derivative of amplitude*exponential by the logarithm of the time.
std::vector<double> slope_of_exponential(const Problem& p, double log_time, double amplitude) {
    if (p.test == Test::history) {
        const Hereditary h = hereditary(p, std::exp(log_time));
        return weighted(p, [&](size_t i) { return amplitude * h.slopes[i]; });
    }
    const double rate = std::exp(-log_time), factor = p.test == Test::creep ? -amplitude : amplitude;
    return weighted(p, [&](size_t i) { return factor * (p.times[i] * rate) * std::exp(-p.times[i] * rate); });
}

// Columns for the terms that `s` has, in the order of its amplitudes.
Matrix columns_of(const Problem& p, const Spectrum& s) {
    Matrix m{p.times.size(), {}};
    if (s.constant) m.append(p.test == Test::history ? weighted(p, [&](size_t i) { return p.strains[i]; }) : p.weights);
    if (s.ramp) m.append(weighted(p, [&](size_t i) { return p.times[i]; }));
    for (double time : s.log_times) m.append(exponential(p, time));
    return m;
}

std::vector<double> target_of(const Problem& p) {
    return weighted(p, [&](size_t i) { return p.values[i]; });
}

std::vector<size_t> first(size_t n) {
    std::vector<size_t> list(n);
    std::iota(list.begin(), list.end(), size_t(0));
    return list;
}

// Fills in the best amplitudes for these times.
void set_amplitudes(const Problem& p, Spectrum& s) {
    Matrix m = columns_of(p, s);
    m.append(target_of(p));
    Solution solution = nonnegative_solution(m, first(m.columns() - 1));
    s.amplitudes = std::move(solution.x);
    s.squares = solution.squares + p.scatter;
}

// The columns of the triangle for the terms that `s` has beside exponentials.
std::vector<size_t> fixed_columns(const Spectrum& s) {
    std::vector<size_t> columns;
    if (s.constant) columns.push_back(0);
    if (s.ramp) columns.push_back(1);
    return columns;
}

constexpr size_t first_exponential = 2; // of the triangle's columns

// Chooses start times one by one, each where it helps most, and after each moves all while that helps.
std::vector<double> chosen_times(const StartTimes& starts, const Spectrum& s, size_t count) {
    std::vector<size_t> columns = fixed_columns(s);
    const size_t fixed = columns.size(), begin = first_exponential, end = begin + starts.log_times.size();
    double best = HUGE_VAL;
    const auto improves = [&](size_t place, size_t column) {
        const size_t before = columns[place];
        columns[place] = column;
        const double squares = nonnegative_solution(starts.triangle, columns).squares;
        if (squares < best) {
            best = squares;
            return true;
        }
        columns[place] = before;
        return false;
    };
    while (columns.size() < fixed + count) {
        columns.push_back(begin);
        best = HUGE_VAL;
        for (size_t column = begin; column < end; ++column) improves(columns.size() - 1, column);
        for (bool moved = true; moved;) {
            moved = false;
            for (size_t place = fixed; place < columns.size(); ++place) {
                while (columns[place] > begin && improves(place, columns[place] - 1)) moved = true;
                while (columns[place] + 1 < end && improves(place, columns[place] + 1)) moved = true;
            }
        }
    }
    std::vector<double> times;
    for (size_t place = fixed; place < columns.size(); ++place)
        times.push_back(starts.log_times[columns[place] - begin]);
    return times;
}

// Takes the start times to which nonnegative least squares gives amplitudes, and joins the nearest two of them until
// `count` are left.
std::vector<double> joined_times(const StartTimes& starts, const Spectrum& s, size_t count) {
    if (count == 0) return {};
    std::vector<size_t> columns = fixed_columns(s);
    const size_t fixed = columns.size();
    for (size_t k = 0; k < starts.log_times.size(); ++k) columns.push_back(first_exponential + k);
    const std::vector<double> amplitudes = nonnegative_solution(starts.triangle, columns).x;
    std::vector<double> times, shares;
    for (size_t k = 0; k < starts.log_times.size(); ++k)
        if (amplitudes[fixed + k] > 0) {
            times.push_back(starts.log_times[k]);
            shares.push_back(amplitudes[fixed + k]);
        }
    while (times.size() > count) {
        size_t nearest = 0;
        for (size_t k = 1; k + 1 < times.size(); ++k)
            if (times[k + 1] - times[k] < times[nearest + 1] - times[nearest]) nearest = k;
        const double share = shares[nearest + 1] / (shares[nearest] + shares[nearest + 1]);
        times[nearest] += share * (times[nearest + 1] - times[nearest]);
        shares[nearest] += shares[nearest + 1];
        times.erase(times.begin() + std::ptrdiff_t(nearest) + 1);
        shares.erase(shares.begin() + std::ptrdiff_t(nearest) + 1);
    }
    return times;
}

// The Gauss-Newton equations of the logarithms of the times, from which the amplitudes are eliminated (variable
// projection, in Kaufman's form); the last column is the right side.
Matrix equations_of_times(const Problem& p, const Spectrum& s) {
    const Matrix terms = columns_of(p, s);
    Matrix m{p.times.size(), {}};
    std::vector<double> rest = target_of(p);
    for (size_t j = 0; j < terms.columns(); ++j) {
        if (s.amplitudes[j] > 0) m.numbers.insert(m.numbers.end(), terms.column(j), terms.column(j) + terms.rows);
        for (size_t i = 0; i < rest.size(); ++i) rest[i] -= s.amplitudes[j] * terms(i, j);
    }
    const size_t eliminated = m.columns(), n = s.log_times.size();
    for (size_t k = 0; k < n; ++k) m.append(slope_of_exponential(p, s.log_times[k], s.amplitudes[s.first_time() + k]));
    m.append(rest);
    const Matrix triangle = triangle_of(std::move(m));
    Matrix equations{n + 1, std::vector<double>((n + 1) * (n + 1))};
    for (size_t j = 0; j <= n; ++j)
        for (size_t i = 0; i <= j && eliminated + i < triangle.rows; ++i)
            equations(i, j) = triangle(eliminated + i, eliminated + j);
    return equations;
}

// The step of Levenberg and Marquardt.
std::vector<double> damped_step(const Matrix& equations, double damping) {
    const size_t n = equations.columns() - 1;
    Matrix m{2 * n + 1, std::vector<double>((2 * n + 1) * (n + 1))};
    for (size_t j = 0; j <= n; ++j) {
        double squares = 0;
        for (size_t i = 0; i <= n; ++i) {
            m(i, j) = equations(i, j);
            squares += equations(i, j) * equations(i, j);
        }
        if (j < n) m(n + 1 + j, j) = std::sqrt(damping * squares);
    }
    return back_substituted(triangle_of(std::move(m)), n);
}

// Moves the times from where they are to the nearest least squares, and sorts them.
void refine(const Problem& p, Spectrum& s) {
    const LogTimes range = log_times_of(p);
    set_amplitudes(p, s);
    double damping = 1e-3;
    int small_gains = 0;
    Matrix equations = equations_of_times(p, s);
    for (int trials = 0; trials < 400 && damping < 1e12 && small_gains < 4 && !s.log_times.empty(); ++trials) {
        const std::vector<double> step = damped_step(equations, damping);
        Spectrum moved = s;
        for (size_t k = 0; k < step.size(); ++k)
            moved.log_times[k] = std::clamp(s.log_times[k] + std::clamp(step[k], -1.0, 1.0), range.least, range.most);
        if (moved.log_times == s.log_times) break;
        set_amplitudes(p, moved);
        if (!(moved.squares < s.squares)) {
            damping *= 10;
            continue;
        }
        small_gains = moved.squares > (1 - 1e-10) * s.squares ? small_gains + 1 : 0;
        damping = std::max(damping / 10, 1e-14);
        s = std::move(moved);
        equations = equations_of_times(p, s);
    }
    std::ranges::sort(s.log_times);
    set_amplitudes(p, s);
}

// Whether an exponential is seen anywhere in the curve.
bool contributes(const Problem& p, const Spectrum& s, size_t k) {
    double greatest = 0;
    for (double x : exponential(p, s.log_times[k])) greatest = std::max(greatest, std::abs(x));
    return s.amplitudes[s.first_time() + k] * greatest > exact_data;
}

// Exponentials of times closer than this, in their logarithm, differ by less than exact_data.
constexpr double same_time = 1e-3;

// Removes terms without amplitude, and all but one of times that have met; then the others move again.
void simplify(const Problem& p, Spectrum& s) {
    for (;;) {
        std::vector<double> kept;
        for (size_t k = 0; k < s.log_times.size(); ++k) {
            const auto meets = [&](double time) { return std::abs(time - s.log_times[k]) < same_time; };
            if (contributes(p, s, k) && std::ranges::none_of(kept, meets)) kept.push_back(s.log_times[k]);
        }
        const bool constant = s.constant && s.amplitudes[0] > 0, ramp = s.ramp && s.amplitudes[s.constant] > 0;
        if (kept.size() == s.log_times.size() && constant == s.constant && ramp == s.ramp) return;
        s = {.constant = constant, .ramp = ramp, .log_times = std::move(kept)};
        refine(p, s);
    }
}

} // namespace

double information(const Problem& p, const Spectrum& s, size_t parameters) {
    const double points = double(p.points);
    const double mean_square = std::max(s.squares / points, exact_data * exact_data);
    return points * std::log(mean_square) + double(parameters) * std::log(points);
}

StartTimes start_times_of(const Problem& p) {
    const LogTimes range = log_times_of(p);
    const double decades = (range.most - range.least) / std::log(10.0);
    const int intervals = std::clamp(int(std::ceil(10 * decades)), 1, 200);
    Spectrum all{.constant = true, .ramp = true};
    for (int i = 0; i <= intervals; ++i)
        all.log_times.push_back(range.least + i * (range.most - range.least) / intervals);
    Matrix m = columns_of(p, all);
    m.append(target_of(p));
    return {all.log_times, triangle_of(std::move(m))};
}

namespace {

// Whether no residual is left but rounding of the data.
bool is_exact(const Problem& p, const Spectrum& s) { return s.squares <= exact_data * exact_data * double(p.points); }

// Returns the best spectrum of these terms and up to `times` times. Further starts are tried while a residual stays.
Spectrum best_of_terms(const Problem& p, const StartTimes& starts, bool constant, bool ramp, size_t times) {
    Spectrum best{.constant = constant, .ramp = ramp, .squares = HUGE_VAL};
    for (const auto start : {chosen_times, joined_times}) {
        Spectrum s{.constant = constant, .ramp = ramp};
        s.log_times = start(starts, s, times);
        refine(p, s);
        simplify(p, s);
        if (s.squares < best.squares) best = std::move(s);
        if (is_exact(p, best)) break;
    }
    return best;
}

Spectrum best_spectrum(const Problem& p, const StartTimes& starts, int n) {
    Spectrum best;
    double least = HUGE_VAL;
    for (bool constant : {true, false})
        for (bool ramp : {false, true}) {
            // In creep a spring and a dashpot are elements of their own; in relaxation every spectrum has a spring.
            const int times = p.test == Test::creep ? n - constant - ramp : n - 1;
            if (times < 0 || (p.test != Test::creep && (ramp || times + constant == 0))) continue;
            Spectrum s = best_of_terms(p, starts, constant, ramp, size_t(times));
            // Every kind of spectrum is scored by all terms that it offers: noise must not make one look better that
            // uses fewer.
            const size_t offered = size_t(2 * times + constant + ramp);
            const double score = information(p, s, is_exact(p, s) ? s.parameters() : offered);
            if (score >= least) continue;
            least = score;
            best = std::move(s);
        }
    return best;
}

} // namespace

std::vector<Spectrum> best_spectra(const Problem& p, const StartTimes& starts, int n) {
    std::vector<Spectrum> spectra;
    for (int k = 1; k <= n; ++k) {
        Spectrum s = best_spectrum(p, starts, k);
        // The kinds of spectra are told apart by more than their residual.
        if (k > 1 && (s.squares > spectra.back().squares || is_exact(p, spectra.back()))) s = spectra.back();
        spectra.push_back(std::move(s));
    }
    return spectra;
}

} // namespace dermis::fit
