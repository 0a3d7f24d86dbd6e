// SPDX-License-Identifier: MIT
// This file tells what the data say about the elements of a fit: errors from the Jacobian, and sentences about
// what is open.
#include "host/lab/fit/problem.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace dermis::fit {
namespace {

// A number is open if the data fix it to no better than this factor.
constexpr double open_factor = 2;

// A number of the chain that is not 0.
struct Parameter {
    size_t element;
    double KelvinVoigt::*member;
};

std::vector<Parameter> parameters_of(const std::vector<KelvinVoigt>& chain) {
    std::vector<Parameter> list;
    for (size_t k = 0; k < chain.size(); ++k)
        for (auto member : {&KelvinVoigt::modulus, &KelvinVoigt::viscosity})
            if (chain[k].*member > 0) list.push_back({k, member});
    return list;
}

// Derivatives of the residuals by the logarithms of the parameters, as central differences.
Matrix jacobian_of(const Problem& p, const std::vector<KelvinVoigt>& chain, const std::vector<Parameter>& parameters) {
    constexpr double step = 1e-4;
    Matrix m{p.times.size(), {}};
    for (const Parameter& parameter : parameters) {
        std::vector<KelvinVoigt> more = chain, less = chain;
        more[parameter.element].*parameter.member *= std::exp(step);
        less[parameter.element].*parameter.member *= std::exp(-step);
        std::vector<double> column = model_of(p, more);
        const std::vector<double> below = model_of(p, less);
        for (size_t i = 0; i < column.size(); ++i) column[i] = p.weights[i] * (column[i] - below[i]) / (2 * step);
        m.append(column);
    }
    return m;
}

// The rows of the inverse of the triangle: scaled by the standard deviation of a residual, the length of row i is the
// standard error of parameter i, and the length of a difference of rows is the error of the parameters' difference.
std::vector<std::vector<double>> inverse_rows(Matrix triangle) {
    const size_t n = triangle.columns();
    std::vector<std::vector<double>> rows(n, std::vector<double>(n));
    for (size_t j = 0; j < n; ++j) {
        double squares = 0;
        for (size_t i = 0; i <= j; ++i) squares += triangle(i, j) * triangle(i, j);
        const double least = std::max(1e-14 * std::sqrt(squares), 1e-100); // below that it is no direction of its own
        if (std::abs(triangle(j, j)) < least) triangle(j, j) = least;
    }
    for (size_t k = 0; k < n; ++k)
        for (size_t i = k + 1; i-- > 0;) {
            double rest = i == k;
            for (size_t j = i + 1; j <= k; ++j) rest -= triangle(i, j) * rows[j][k];
            rows[i][k] = rest / triangle(i, i);
        }
    return rows;
}

std::string called(const std::vector<KelvinVoigt>& chain, size_t k) {
    if (chain[k].viscosity == 0) return "the spring";
    if (chain[k].modulus == 0) return "the dashpot";
    return "element " + std::to_string(k + 1) + " (retardation time " + shown(chain[k].viscosity / chain[k].modulus) +
           " s)";
}

// Returns how badly the data fix a number; empty if they fix it well.
std::string how_open(const char* number, double error) {
    const double factor = std::exp(2 * error);
    if (factor < open_factor) return "";
    return std::string("its ") + number +
           (factor < 1000 ? " within a factor of " + shown(factor) : " not within a factor of 1000");
}

// Describes each element with an open number. twins: the neighbour whose retardation time may be the same.
void name_open_elements(Fit& fit, const std::vector<std::optional<size_t>>& twins) {
    for (size_t k = 0; k < fit.elements.size(); ++k) {
        const std::string modulus = how_open("modulus", fit.errors[k].modulus),
                          viscosity = how_open("viscosity", fit.errors[k].viscosity);
        if (modulus.empty() && viscosity.empty()) continue;
        const std::string both = modulus.empty() || viscosity.empty() ? "" : ", ";
        fit.undetermined.push_back("the data hardly fix " + called(fit.elements, k) + ": " + modulus + both +
                                   viscosity +
                                   (twins[k] ? "; they cannot tell it from " + called(fit.elements, *twins[k]) : ""));
    }
}

// Returns for each element the neighbour with a retardation time so near that the data do not tell which is longer.
// error_apart: standard error of the logarithm of the ratio of the times of elements k and k + 1.
template <class Error>
std::vector<std::optional<size_t>> twins_of(const std::vector<KelvinVoigt>& chain, Error error_apart) {
    std::vector<std::optional<size_t>> twins(chain.size());
    std::vector<double> nearest(chain.size(), HUGE_VAL);
    for (size_t k = 0; k + 1 < chain.size(); ++k) {
        const KelvinVoigt &a = chain[k], &b = chain[k + 1];
        if (a.viscosity == 0 || b.modulus == 0) continue;
        const double apart = std::log(b.viscosity / b.modulus / (a.viscosity / a.modulus));
        if (apart >= 2 * error_apart(k)) continue;
        if (apart < nearest[k]) twins[k] = k + 1;
        twins[k + 1] = k;
        nearest[k + 1] = apart;
    }
    return twins;
}

// The share of Student's distribution within +- sqrt(freedom)*tan(angle).
double share_within(double angle, size_t freedom) {
    const size_t odd = freedom % 2;
    const double c = std::cos(angle);
    double sum = 0, term = odd ? c : 1;
    for (size_t power = odd; power + 2 <= freedom; power += 2) {
        sum += term;
        term *= c * c * double(power + 1) / double(power + 2);
    }
    return odd ? (angle + std::sin(angle) * sum) * 2 / 3.141592653589793 : std::sin(angle) * sum;
}

} // namespace

std::string shown(double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", x);
    return text;
}

double students_quantile(size_t freedom) {
    freedom = std::min(freedom, size_t(10000)); // beyond, it changes by 1e-4
    double least = 0, most = 3.141592653589793 / 2;
    for (int i = 0; i < 60; ++i) {
        const double middle = (least + most) / 2;
        (share_within(middle, freedom) < 0.95 ? least : most) = middle;
    }
    return std::sqrt(double(freedom)) * std::tan(least);
}

void judge(const Problem& p, Fit& fit) {
    const std::vector<Parameter> parameters = parameters_of(fit.elements);
    auto rows = inverse_rows(triangle_of(jacobian_of(p, fit.elements, parameters)));
    const size_t freedom = p.points - parameters.size();
    // Scaled, so that two standard errors are the interval of 95 %.
    const double deviation = students_quantile(freedom) / 2 *
                             std::max(fit.residual * std::sqrt(double(p.points) / double(freedom)), exact_data);
    const auto length = [&](const std::vector<double>& row) {
        double squares = 0;
        for (double x : row) squares += x * x;
        return deviation * std::sqrt(squares);
    };
    const auto minus = [](std::vector<double> a, const std::vector<double>& b) {
        for (size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
        return a;
    };
    fit.errors.assign(fit.elements.size(), {});
    for (size_t i = 0; i < parameters.size(); ++i)
        fit.errors[parameters[i].element].*parameters[i].member = length(rows[i]);

    // An element with a time has two parameters that follow one another, modulus and viscosity.
    const auto error_apart = [&](size_t k) {
        size_t i = 0;
        while (parameters[i].element != k) ++i;
        return length(minus(minus(rows[i + 3], rows[i + 2]), minus(rows[i + 1], rows[i])));
    };
    name_open_elements(fit, twins_of(fit.elements, error_apart));
}

} // namespace dermis::fit
