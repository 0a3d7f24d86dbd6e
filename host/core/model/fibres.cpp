// SPDX-License-Identifier: MIT
#include "host/core/model/fibres.hpp"

#include "host/core/base/finite.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace dermis::model {
namespace {

constexpr int most_substeps = 65536, least_bisections = 12, rows = FIBRE_OUTPUTS, columns = rows + 2;

// y(n) + back[n-1]*y(n-1) + .. + back[0]*y = back[0]*w, where y(i) is the i-th derivative of y, and the greatest pole.
struct Filter {
    int poles = 0;
    std::array<double, rows> back{};
    double fastest = 0; // 1/s
};

Filter filter_of(const AfferentModel& m) {
    Filter f;
    std::array<double, rows + 3> product = {1}; // a polynomial in s, from s^0 on, with a leading coefficient of 1
    const auto multiply = [&](double c0, double c1,
                              int degree) { // by s^degree + c1*s + c0, where c1 may be the leading one
        std::array<double, rows + 3> next{};
        for (int i = 0; i <= f.poles; ++i) {
            next[size_t(i)] += c0 * product[size_t(i)];
            next[size_t(i) + 1] += c1 * product[size_t(i)];
            if (degree == 2) next[size_t(i) + 2] += product[size_t(i)];
        }
        product = next;
        f.poles += degree;
    };
    for (double time : m.time_constants) {
        multiply(1 / time, 1, 1);
        f.fastest = std::max(f.fastest, 1 / time);
    }
    if (m.frequency) {
        const double w = 2 * std::numbers::pi * *m.frequency, half = w / *m.quality / 2;
        multiply(w * w, 2 * half, 2);
        f.fastest = std::max(f.fastest, half > w ? half + std::sqrt(half * half - w * w) : w);
    }
    std::copy_n(product.begin(), rows, f.back.begin());
    return f;
}

constexpr int numbers = 2 * rows + 2; // y, y', y'', what V gains by each, w and what it gains
enum { gained_by_first = rows, drive_w = 2 * rows, drive_gained };
using Matrix = std::array<std::array<double, numbers>, numbers>;

Matrix times(const Matrix& a, const Matrix& b) {
    Matrix c{};
    for (int i = 0; i < numbers; ++i)
        for (int k = 0; k < numbers; ++k)
            for (int j = 0; j < numbers; ++j)
                c[size_t(i)][size_t(j)] += a[size_t(i)][size_t(k)] * b[size_t(k)][size_t(j)];
    return c;
}

// exp(m), by its series at 2^-10 of m, which is squared ten times. The entries of m are of the order of 1.
Matrix exponential(Matrix m) {
    constexpr int squarings = 10, terms = 8;
    for (auto& row : m)
        for (double& x : row) x = std::ldexp(x, -squarings);
    Matrix sum{}, term{};
    for (size_t i = 0; i < numbers; ++i) term[i][i] = 1;
    // sum = exp(m) - 1, so that squaring loses nothing of small numbers
    for (int k = 1; k <= terms; ++k) {
        term = times(term, m);
        for (size_t i = 0; i < numbers; ++i)
            for (size_t j = 0; j < numbers; ++j) sum[i][j] += term[i][j] /= k;
    }
    for (int s = 0; s < squarings; ++s) {
        const Matrix squared = times(sum, sum);
        for (size_t i = 0; i < numbers; ++i)
            for (size_t j = 0; j < numbers; ++j) sum[i][j] = 2 * sum[i][j] + squared[i][j];
    }
    for (size_t i = 0; i < numbers; ++i) sum[i][i] += 1;
    return sum;
}

// How fast the filter's derivatives and V change, per substep of h seconds. loss: h over the membrane time.
Matrix motion_of(const Filter& f, double h, double loss) {
    Matrix m{};
    const double scale = std::pow(h, f.poles);
    for (int i = 0; i + 1 < f.poles; ++i) m[size_t(i)][size_t(i) + 1] = 1;
    const size_t last = size_t(f.poles - 1);
    for (int i = 0; i < f.poles; ++i) m[last][size_t(i)] = -f.back[size_t(i)] * std::pow(h, f.poles - i);
    m[last][drive_w] = f.back[0] * scale;
    for (size_t j = 0; j < size_t(f.poles); ++j) {
        m[gained_by_first + j][gained_by_first + j] = -loss;
        m[gained_by_first + j][j] = loss;
    }
    m[drive_w][drive_gained] = 1;
    return m;
}

// Derivatives 0 to rows of y at a substep's start, in shares, as factors of w, what w gains, y, y' and y''.
std::array<std::array<double, columns>, rows + 1> derivatives_of(const Filter& f, double h) {
    std::array<std::array<double, columns>, rows + 1> all{};
    for (int i = 0; i <= rows; ++i) {
        auto& row = all[size_t(i)];
        if (i < f.poles) {
            row[size_t(i) + 2] = std::pow(h, i);
            continue;
        }
        const double drive = f.back[0] * std::pow(h, f.poles);
        if (i - f.poles < 2) row[size_t(i - f.poles)] = drive;
        for (int j = 0; j < f.poles; ++j)
            for (int c = 0; c < columns; ++c)
                row[size_t(c)] -=
                    f.back[size_t(j)] * std::pow(h, f.poles - j) * all[size_t(i - f.poles + j)][size_t(c)];
    }
    return all;
}

double gained_by_current(double loss, double own) { // loss * integral of exp(-loss*(1 - s))*exp(-own*s)
    const double d = loss - own;
    return std::abs(d) < 1e-300 ? loss * std::exp(-loss) : loss * std::exp(-loss) * std::expm1(d) / d;
}

template <class Constants> void fill_matrices(const Filter& f, double h, double loss, Constants& k) {
    using scalar = std::remove_reference_t<decltype(k.keep)>;
    const Matrix step = exponential(motion_of(f, h, loss));
    const auto derivatives = derivatives_of(f, h);
    for (int i = 0; i < rows; ++i)
        for (int c = 0; c < columns; ++c) {
            const int j = c - 2; // of y
            const size_t at = size_t(columns * i + c), from = size_t(j < 0 ? drive_w + c : j);
            const double in_seconds = std::pow(h, std::max(j, 0) - i);
            k.filter_step[at] = scalar(i < f.poles ? step[size_t(i)][from] * in_seconds : 0);
            k.membrane_step[at] = scalar(i < f.poles ? step[size_t(gained_by_first + i)][from] * in_seconds : 0);
            k.start[at] = scalar(derivatives[size_t(i)][size_t(c)]);
        }
    for (size_t c = 0; c < columns; ++c) // in shares it is the next derivative
        k.highest[c] = scalar(derivatives[size_t(f.poles)][c] * std::pow(h, 1 - f.poles));
    for (int j = 0; j < f.poles; ++j) k.back[rows - f.poles + j] = scalar(f.back[size_t(j)] * std::pow(h, f.poles - j));
    const double drive = f.back[0] * std::pow(h, f.poles);
    k.driven[0] = scalar(f.poles == 3 ? drive : 0);
    k.driven[1] = scalar(f.poles == 2 ? drive : 0);
    k.driven[2] = scalar(f.poles == 3 ? drive : 0);
}

template <class Constants> void fill_currents(const AfferentModel& m, double h, double loss, Constants& k) {
    using scalar = std::remove_reference_t<decltype(k.keep)>;
    for (size_t i = 0; i < m.after.size(); ++i) {
        const double own = h / m.after[i].time;
        k.after_keep[i] = scalar(std::exp(-own));
        k.after_loss[i] = scalar(own);
        k.after_gain[i] = scalar(gained_by_current(loss, own));
        k.amplitude[i] = scalar(m.after[i].amplitude);
        k.after |= m.after[i].amplitude != 0;
    }
}

template <class Constants> bool all_finite(const Constants& k) {
    using scalar = std::remove_reference_t<decltype(k.keep)>;
    constexpr size_t scalars = offsetof(Constants, poles) / sizeof(scalar);
    const auto* from = reinterpret_cast<const scalar*>(&k);
    return std::all_of(from, from + scalars, [](scalar x) { return finite(double(x)); });
}

} // namespace

int fibre_substeps(const AfferentModel& m, double dt, const FibreAccuracy& accuracy) {
    double fastest = std::max(filter_of(m).fastest, 1 / m.membrane_time);
    for (const AfterCurrent& a : m.after)
        if (a.amplitude != 0) fastest = std::max(fastest, 1 / a.time);
    const double longest = std::min(m.refractory_time, accuracy.resolution / fastest);
    int n = 1;
    while (n <= most_substeps && !(dt / n <= longest)) n *= 2;
    return n <= most_substeps ? n : 0;
}

template <class K> bool fill_fibre_constants(const AfferentModel& m, double dt, typename K::FibreConstants& k) {
    using scalar = typename K::real;
    k = {};
    k.substeps = fibre_substeps(m, dt, fibre_accuracy<K>);
    if (k.substeps == 0) return false;
    const Filter f = filter_of(m);
    k.poles = f.poles;
    const double h = dt / k.substeps, loss = h / m.membrane_time;
    fill_matrices(f, h, loss, k);
    fill_currents(m, h, loss, k);
    double factorial = 1;
    for (int i = 0; i <= COURSE_DEGREE; factorial *= ++i) k.per_factorial[i] = scalar(1 / factorial);
    for (int i = 0; i < COURSE_DEGREE; ++i) k.per_next[i] = scalar(1.0 / (i + 1));
    int outputs = 0;
    for (int j = 0; j < rows; ++j) {
        k.per_scale[j] = scalar(std::pow(h, -j));
        k.gain[2 * j] = scalar(m.gains[size_t(j)][0]);
        k.gain[2 * j + 1] = scalar(-m.gains[size_t(j)][1]);
        if (m.gains[size_t(j)][0] == 0 && m.gains[size_t(j)][1] == 0) continue;
        k.outputs |= 1 << j;
        ++outputs;
    }
    k.keep = scalar(std::exp(-loss));
    k.loss = scalar(loss);
    k.value = scalar(m.value);
    k.rate = scalar(m.rate / h);
    k.step = scalar(h);
    k.per_step = scalar(1 / h);
    k.per_substeps = scalar(1.0 / k.substeps);
    k.refractory = scalar(std::max(1.0, m.refractory_time / h));
    k.reset = scalar(m.reset);
    const double halvings = std::ceil(std::log2(h / fibre_accuracy<K>.tolerance));
    k.bisections = std::max(int(halvings), least_bisections);
    k.turn_bisections = k.bisections / 2 + 2;
    k.events = 3 + 2 * outputs;
    return all_finite(k);
}

template bool fill_fibre_constants<f32>(const AfferentModel&, double, f32::FibreConstants&);
template bool fill_fibre_constants<f64>(const AfferentModel&, double, f64::FibreConstants&);

} // namespace dermis::model
