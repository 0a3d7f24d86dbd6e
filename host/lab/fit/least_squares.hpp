// SPDX-License-Identifier: MIT
// Dense linear least squares for a few unknowns and many equations.
#pragma once

#include <cstddef>
#include <vector>

namespace dermis::fit {

// Stored column by column.
struct Matrix {
    size_t rows = 0;
    std::vector<double> numbers;

    size_t columns() const { return rows ? numbers.size() / rows : 0; }
    double* column(size_t j) { return numbers.data() + j * rows; }
    const double* column(size_t j) const { return numbers.data() + j * rows; }
    double& operator()(size_t i, size_t j) { return numbers[j * rows + i]; }
    double operator()(size_t i, size_t j) const { return numbers[j * rows + i]; }
    void append(const std::vector<double>& column) { numbers.insert(numbers.end(), column.begin(), column.end()); }
};

// Returns the upper triangle R of A = Q*R, by Householder reflections. A least-squares problem among columns of A has
// the same solution among the same columns of R.
Matrix triangle_of(Matrix);

struct Solution {
    std::vector<double> x;
    double squares = 0; // sum of the squares of a*x - b
};

// Least squares of a*x = b, x >= 0, where b is the last column and a the columns that `chosen` lists (the active set
// method of Lawson and Hanson).
Solution nonnegative_solution(const Matrix&, const std::vector<size_t>& chosen);

// Solves R*x = b, where R is the first n columns of a triangle and b its column n.
std::vector<double> back_substituted(const Matrix& triangle, size_t n);

} // namespace dermis::fit
