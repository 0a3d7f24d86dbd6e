// SPDX-License-Identifier: MIT
#include "host/lab/fit/least_squares.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::fit {
namespace {

double product(const double* a, const double* b, size_t n) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i) sum += a[i] * b[i];
    return sum;
}

// The columns of `a` that are listed, and its last one.
Matrix chosen_columns(const Matrix& a, const std::vector<size_t>& list) {
    Matrix m{a.rows, {}};
    m.numbers.reserve(a.rows * (list.size() + 1));
    for (size_t j : list) m.numbers.insert(m.numbers.end(), a.column(j), a.column(j) + a.rows);
    m.numbers.insert(m.numbers.end(), a.column(a.columns() - 1), a.column(a.columns() - 1) + a.rows);
    return m;
}

std::vector<double> residual_of(const Matrix& m, const std::vector<double>& x) {
    std::vector<double> r(m.column(x.size()), m.column(x.size()) + m.rows);
    for (size_t j = 0; j < x.size(); ++j)
        for (size_t i = 0; i < m.rows; ++i) r[i] -= m(i, j) * x[j];
    return r;
}

// Least squares over the columns in `active`, ascending; 0 for the others.
std::vector<double> free_solution(const Matrix& m, const std::vector<size_t>& active) {
    const std::vector<double> some = back_substituted(triangle_of(chosen_columns(m, active)), active.size());
    std::vector<double> x(m.columns() - 1);
    for (size_t k = 0; k < active.size(); ++k) x[active[k]] = some[k];
    return x;
}

// Goes from x >= 0 to the least squares over `active`. Whatever becomes 0 on the way leaves `active`.
void settle(const Matrix& m, std::vector<double>& x, std::vector<size_t>& active) {
    while (!active.empty()) {
        const std::vector<double> target = free_solution(m, active);
        size_t first = target.size(); // the first to become 0 on the way, if any does
        double way = 1;
        for (size_t j : active)
            if (const double until = x[j] > 0 ? x[j] / (x[j] - target[j]) : 0; target[j] <= 0 && until <= way) {
                way = until;
                first = j;
            }
        for (size_t j : active) x[j] += way * (target[j] - x[j]);
        if (first == target.size()) return;
        x[first] = 0;
        active.erase(std::find(active.begin(), active.end(), first));
    }
}

} // namespace

Matrix triangle_of(Matrix m) {
    const size_t rank = std::min(m.rows, m.columns());
    std::vector<double> v(m.rows);
    for (size_t j = 0; j < rank; ++j) {
        const size_t n = m.rows - j;
        double* pivot = m.column(j) + j;
        const double length = std::sqrt(product(pivot, pivot, n));
        if (length == 0) continue;
        std::copy_n(pivot, n, v.begin());
        v[0] += std::copysign(length, pivot[0]);
        const double squares = product(v.data(), v.data(), n);
        for (size_t k = j; k < m.columns(); ++k) {
            double* column = m.column(k) + j;
            const double scale = 2 * product(v.data(), column, n) / squares;
            for (size_t i = 0; i < n; ++i) column[i] -= scale * v[i];
        }
    }
    Matrix triangle{rank, std::vector<double>(rank * m.columns())};
    for (size_t j = 0; j < m.columns(); ++j) std::copy_n(m.column(j), std::min(j + 1, rank), triangle.column(j));
    return triangle;
}

std::vector<double> back_substituted(const Matrix& triangle, size_t n) {
    std::vector<double> x(n);
    for (size_t i = n; i-- > 0;) {
        double rest = i < triangle.rows ? triangle(i, n) : 0;
        for (size_t j = i + 1; j < n; ++j) rest -= triangle(i, j) * x[j];
        const double pivot = i < triangle.rows ? triangle(i, i) : 0;
        x[i] = pivot == 0 ? 0 : rest / pivot;
    }
    return x;
}

Solution nonnegative_solution(const Matrix& all, const std::vector<size_t>& chosen) {
    const Matrix m = triangle_of(chosen_columns(all, chosen));
    const size_t n = chosen.size();
    Solution s{.x = std::vector<double>(n)};
    const double scale = std::sqrt(product(m.column(n), m.column(n), m.rows));
    std::vector<size_t> active;
    std::vector<double> r = residual_of(m, s.x);
    for (size_t steps = 0; steps < 3 * n; ++steps) {
        size_t steepest = n;
        double slope = 1e-15 * scale;
        for (size_t j = 0; j < n; ++j) {
            if (std::count(active.begin(), active.end(), j)) continue;
            const double length = std::sqrt(product(m.column(j), m.column(j), m.rows));
            const double gain = length > 0 ? product(m.column(j), r.data(), m.rows) / length : 0;
            if (gain > slope) {
                slope = gain;
                steepest = j;
            }
        }
        if (steepest == n) break;
        active.insert(std::upper_bound(active.begin(), active.end(), steepest), steepest);
        settle(m, s.x, active);
        r = residual_of(m, s.x);
        if (!std::count(active.begin(), active.end(), steepest)) break; // only rounding made it look useful
    }
    s.squares = product(r.data(), r.data(), m.rows);
    return s;
}

} // namespace dermis::fit
