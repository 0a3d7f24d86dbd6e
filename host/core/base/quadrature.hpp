// SPDX-License-Identifier: MIT
// Integrals as sums over a few points, by the rules of Gauss and Legendre.
#pragma once

#include <span>

namespace dermis {

template <class T> struct RulePoint {
    T at, weight; // from 0 to 1; the other half of a rule are the points 1 - at, with the same weights
};
template <class T> using Rule = std::span<const RulePoint<T>>;

template <class T>
inline constexpr RulePoint<T> four_points[] = {{0.069431844202973712388L, 0.17392742256872692869L},
                                               {0.33000947820757186760L, 0.32607257743127307131L}};
template <class T>
inline constexpr RulePoint<T> eight_points[] = {{0.019855071751231884158L, 0.050614268145188129576L},
                                                {0.10166676129318663020L, 0.11119051722668723527L},
                                                {0.23723379504183550709L, 0.15685332293894364367L},
                                                {0.40828267875217509753L, 0.18134189168918099148L}};
template <class T>
inline constexpr RulePoint<T> sixteen_points[] = {
    {0.0052995325041750337019L, 0.013576229705877047426L}, {0.027712488463383711961L, 0.031126761969323946431L},
    {0.067184398806084128060L, 0.047579255841246392405L},  {0.12229779582249848305L, 0.062314485627766936026L},
    {0.19106187779867812578L, 0.074797994408288366041L},   {0.27099161117138630683L, 0.084578259697501269095L},
    {0.35919822461037054338L, 0.091301707522461794433L},   {0.45249374508118127991L, 0.094725305227534248143L}};

// Returns the integral of f from `from` to from + length.
template <class T, class F> T integral(Rule<T> rule, T from, T length, F f) {
    T sum = 0;
    for (const auto& [at, weight] : rule) sum += weight * (f(from + length * at) + f(from + length * (1 - at)));
    return length * sum;
}

} // namespace dermis
