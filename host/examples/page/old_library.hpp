// SPDX-License-Identifier: MIT
// The parts of the C++20 standard library that the core uses and that emscripten 3.1.6, the emscripten of Debian 12,
// does not have. The build of the page includes this header before every file; a newer emscripten needs none of it.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <iterator>

namespace std {

template <class To, class From> constexpr To bit_cast(const From& from) noexcept {
    return __builtin_bit_cast(To, from);
}

// The shortest text that reads back as the same number. The buffers of the core hold every number.
inline to_chars_result to_chars(char* begin, char* end, double value) {
    for (int digits = 1; digits <= 17; ++digits) {
        const int length = snprintf(begin, size_t(end - begin), "%.*g", digits, value);
        if (digits == 17 || strtod(begin, nullptr) == value) return {begin + length, errc()};
    }
    return {end, errc::value_too_large};
}

namespace ranges {

struct Same {
    template <class T> constexpr T&& operator()(T&& value) const { return static_cast<T&&>(value); }
};

// Compares what a projection makes of two elements, or of an element and a value.
template <class Less, class Projection> auto both(Less less, Projection projection) {
    return [=](auto&& a, auto&& b) { return invoke(less, invoke(projection, a), invoke(projection, b)); };
}
template <class R, class Less = std::less<>, class Projection = Same>
void sort(R&& r, Less less = {}, Projection projection = {}) {
    std::sort(begin(r), end(r), both(less, projection));
}
template <class I, class Projection, class Less = std::less<>> void sort(I first, I last, Less less, Projection by) {
    std::sort(first, last, both(less, by));
}
template <class R, class Less = std::less<>, class Projection = Same>
bool is_sorted(R&& r, Less less = {}, Projection projection = {}) {
    return std::is_sorted(begin(r), end(r), both(less, projection));
}
template <class R, class V, class Less = std::less<>, class Projection = Same>
auto lower_bound(R&& r, const V& value, Less less = {}, Projection projection = {}) {
    return std::lower_bound(begin(r), end(r), value,
                            [&](auto&& a, auto&& v) { return invoke(less, invoke(projection, a), v); });
}
template <class R, class V, class Less = std::less<>, class Projection = Same>
auto upper_bound(R&& r, const V& value, Less less = {}, Projection projection = {}) {
    return std::upper_bound(begin(r), end(r), value,
                            [&](auto&& v, auto&& b) { return invoke(less, v, invoke(projection, b)); });
}
template <class R, class V, class Projection, class Less = std::less<>>
auto equal_range(R&& r, const V& v, Less less, Projection by) {
    return std::pair(ranges::lower_bound(r, v, less, by), ranges::upper_bound(r, v, less, by));
}
template <class R, class V> bool binary_search(R&& r, const V& value) {
    return std::binary_search(begin(r), end(r), value);
}
template <class R, class V> auto find(R&& r, const V& value) { return std::find(begin(r), end(r), value); }
template <class R, class V, class Projection> auto find(R&& r, const V& value, Projection projection) {
    return std::find_if(begin(r), end(r), [&](auto&& a) { return invoke(projection, a) == value; });
}
template <class R, class F> auto find_if(R&& r, F f) { return std::find_if(begin(r), end(r), f); }
template <class R, class F, class Projection = Same> bool any_of(R&& r, F f, Projection projection = {}) {
    return std::any_of(begin(r), end(r), [&](auto&& a) -> bool { return invoke(f, invoke(projection, a)); });
}
template <class R, class F, class Projection = Same> bool all_of(R&& r, F f, Projection projection = {}) {
    return std::all_of(begin(r), end(r), [&](auto&& a) -> bool { return invoke(f, invoke(projection, a)); });
}
template <class R, class F, class Projection = Same> bool none_of(R&& r, F f, Projection projection = {}) {
    return !ranges::any_of(r, f, projection);
}
template <class R, class O> auto copy(R&& r, O out) { return std::copy(begin(r), end(r), out); }
template <class R, class V> void fill(R&& r, const V& value) { std::fill(begin(r), end(r), value); }
template <class R, class O, class F> auto transform(R&& r, O out, F f) {
    return std::transform(begin(r), end(r), out, [&](auto&& a) -> decltype(auto) { return invoke(f, a); });
}

} // namespace ranges
} // namespace std
