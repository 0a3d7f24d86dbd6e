// SPDX-License-Identifier: MIT
// Real numbers of many bits: as much of MPFR as the closed forms need.
#pragma once

#include <mpfr.h>

#include <cmath>
#include <utility>

namespace oracle {

// A number of 113 bits.
__extension__ typedef __float128 Wide;

// A number of Real::bits bits, which stay the same while numbers are in use together.
class Real {
  public:
    static inline thread_local mpfr_prec_t bits = 320;

    Real(double value = 0) {
        mpfr_init2(x_, bits);
        mpfr_set_d(x_, value, MPFR_RNDN);
    }
    Real(const Real& other) {
        mpfr_init2(x_, mpfr_get_prec(other.x_));
        mpfr_set(x_, other.x_, MPFR_RNDN);
    }
    Real(Real&& other) noexcept : Real() { mpfr_swap(x_, other.x_); }
    Real& operator=(Real other) noexcept {
        mpfr_swap(x_, other.x_);
        return *this;
    }
    ~Real() { mpfr_clear(x_); }

    static Real pi() {
        Real r;
        mpfr_const_pi(r.x_, MPFR_RNDN);
        return r;
    }
    // 2^n.
    static Real power_of_two(long n) {
        Real r;
        mpfr_set_si_2exp(r.x_, 1, n, MPFR_RNDN);
        return r;
    }

    friend Real operator+(const Real& a, const Real& b) { return binary(mpfr_add, a, b); }
    friend Real operator-(const Real& a, const Real& b) { return binary(mpfr_sub, a, b); }
    friend Real operator*(const Real& a, const Real& b) { return binary(mpfr_mul, a, b); }
    friend Real operator/(const Real& a, const Real& b) { return binary(mpfr_div, a, b); }
    friend Real operator-(const Real& a) { return unary(mpfr_neg, a); }
    Real& operator+=(const Real& b) {
        mpfr_add(x_, x_, b.x_, MPFR_RNDN);
        return *this;
    }
    Real& operator*=(const Real& b) {
        mpfr_mul(x_, x_, b.x_, MPFR_RNDN);
        return *this;
    }
    friend bool operator<(const Real& a, const Real& b) { return mpfr_less_p(a.x_, b.x_); }
    friend bool operator<=(const Real& a, const Real& b) { return mpfr_lessequal_p(a.x_, b.x_); }
    friend bool operator==(const Real& a, const Real& b) { return mpfr_equal_p(a.x_, b.x_); }

    friend Real exp(const Real& a) { return unary(mpfr_exp, a); }
    friend Real abs(const Real& a) { return unary(mpfr_abs, a); }
    friend Real sqrt(const Real& a) { return unary(mpfr_sqrt, a); }
    friend Real atan2(const Real& y, const Real& x) { return binary(mpfr_atan2, y, x); }
    friend std::pair<Real, Real> sine_and_cosine(const Real& a) {
        std::pair<Real, Real> r;
        mpfr_sin_cos(r.first.x_, r.second.x_, a.x_, MPFR_RNDN);
        return r;
    }
    // The nearest whole number.
    friend Real whole(const Real& a) {
        Real r;
        mpfr_round(r.x_, a.x_);
        return r;
    }
    long double rounded() const { return mpfr_get_ld(x_, MPFR_RNDN); }
    Wide wide() const {
        const long double high = rounded();
        if (!std::isfinite(high)) return high;
        Real rest;
        mpfr_set_ld(rest.x_, high, MPFR_RNDN);
        mpfr_sub(rest.x_, x_, rest.x_, MPFR_RNDN);
        return Wide(high) + rest.rounded();
    }

  private:
    template <class Operation> static Real binary(Operation operation, const Real& a, const Real& b) {
        Real r;
        operation(r.x_, a.x_, b.x_, MPFR_RNDN);
        return r;
    }
    template <class Operation> static Real unary(Operation operation, const Real& a) {
        Real r;
        operation(r.x_, a.x_, MPFR_RNDN);
        return r;
    }

    mpfr_t x_;
};

} // namespace oracle
