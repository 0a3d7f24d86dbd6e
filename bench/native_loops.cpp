// SPDX-License-Identifier: MIT
#include "bench/native_loops.hpp"

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace bench::native {
namespace {

typedef float Vector __attribute__((vector_size(4 * lanes)));
// The same in memory.
typedef Vector Stored __attribute__((may_alias));
typedef Vector Unaligned __attribute__((may_alias, aligned(4)));

Vector load(const float* p) { return *reinterpret_cast<const Stored*>(p); }
Vector load_unaligned(const float* p) { return *reinterpret_cast<const Unaligned*>(p); }
void store(float* p, Vector x) { *reinterpret_cast<Stored*>(p) = x; }

// Writes past the caches; a fence completes the writes.
void stream(float* p, Vector x) {
#if defined(__AVX512F__)
    _mm512_stream_ps(p, (__m512)x);
#elif defined(__SSE2__)
    const float* from = reinterpret_cast<const float*>(&x);
    for (size_t i = 0; i < lanes; i += 4) _mm_stream_ps(p + i, _mm_load_ps(from + i));
#else
    store(p, x);
#endif
}

template <bool past_caches> void put(float* p, Vector x) {
    if constexpr (past_caches) stream(p, x);
    else store(p, x);
}

void fence() {
#ifdef __SSE2__
    _mm_sfence();
#endif
}

// Vectors of cells at the start of a step, and their pressure over it.
struct Cells {
    Vector from, way, strain, r;
};

Cells cells(const ExactStep<float>& k, Vector from, Vector way, Vector strain) {
    return {.from = from, .way = way, .strain = strain, .r = from - k.E * strain};
}

Vector strain_after(const ExactStep<float>& k, const Cells& c) { return c.strain + k.f * c.way + k.b * c.r; }
Vector rate_after(const ExactStep<float>& k, const Cells& c) { return k.v0 * c.r + k.v1 * c.way; }
Vector acceleration_after(const ExactStep<float>& k, const Cells& c) { return k.a0 * c.r + k.a1 * c.way; }
Vector integral_after(const ExactStep<float>& k, const Cells& c, Vector integral) {
    return integral + k.i2 * c.way + k.i1 * c.from + k.i0 * c.strain;
}

// 1 + C of the cells at `here`.
Vector gain(Vector rest, const float* here, Vector above, Vector below) {
    const Vector centre = load(here);
    const Vector across = (load_unaligned(here - 1) - centre) + (load_unaligned(here + 1) - centre);
    return 1.0f + (rest - (across + ((above - centre) + (below - centre))));
}

Cells cells_of(const Frame& f, const ExactStep<float>& k, size_t y, size_t x) {
    const Vector from = load(f.from + y * f.pitch + x);
    return cells(k, from, load(f.to + y * f.pitch + x) - from, load(f.strain + y * f.strain_pitch + x));
}

// In one loop, steps row y, whose new strain is otherwise at `below`, and answers in row y - 1.
template <bool steps, bool answers, bool past_caches>
void press_row(const Frame& f, const ExactStep<float>& k, size_t y, const float* above, const float* below,
               const ThreadRows& rows) {
    float* strain = f.strain + y * f.strain_pitch;
    float* integral = f.integral + y * f.pitch;
    const float* here = strain - f.strain_pitch;
    const size_t answered = (y - 1) * f.pitch;
    for (size_t x = 0; x < f.width; x += lanes) {
        Cells c;
        Vector next;
        if constexpr (steps) {
            c = cells_of(f, k, y, x);
            next = strain_after(k, c);
            store(strain + x, next);
            store(integral + x, integral_after(k, c, load(integral + x)));
        } else next = load(below + x);
        if constexpr (answers) {
            const size_t i = answered + x;
            const Vector g = gain(load(f.rest + i), here + x, load(above + x), next);
            put<past_caches>(f.responses[0] + i, load(here + x) * g);
            put<past_caches>(f.responses[1] + i, load(f.integral + i) * g);
            put<past_caches>(f.responses[2] + i, load(rows.rate + x) * g);
            put<past_caches>(f.responses[3] + i, load(rows.acceleration + x) * g);
        }
        if constexpr (steps) {
            store(rows.rate + x, rate_after(k, c));
            store(rows.acceleration + x, acceleration_after(k, c));
        }
    }
    if constexpr (steps) {
        strain[-1] = strain[0];
        strain[f.width] = strain[f.width - 1];
    }
}

template <bool past_caches> void move_vectors(const Moved& m, size_t first, size_t last) {
    for (size_t i = first; i < last; i += lanes) {
        const Vector joined = (load(m.from + i) + load(m.to + i)) + load(m.rest + i);
        store(m.strain + i, joined - load(m.strain + i));
        store(m.integral + i, joined - load(m.integral + i));
        for (float* response : m.responses) put<past_caches>(response + i, joined);
    }
}

} // namespace

void move_cells(const Moved& m, size_t first, size_t last) {
    if (!m.past_caches) return move_vectors<false>(m, first, last);
    move_vectors<true>(m, first, last);
    fence();
}

void step_beside(const Frame& f, size_t first, size_t last, const ThreadRows& rows) {
    const ExactStep<float> k = f.step;
    for (size_t x = 0; x < f.width; x += lanes) {
        if (first > 0) store(rows.above + x, strain_after(k, cells_of(f, k, first - 1, x)));
        if (last < f.height) store(rows.below + x, strain_after(k, cells_of(f, k, last, x)));
    }
}

namespace {

template <bool past_caches> void press_some(const Frame& f, size_t first, size_t last, const ThreadRows& rows) {
    const ExactStep<float> k = f.step;
    const auto row = [&f](size_t y) { return f.strain + y * f.strain_pitch; };
    // The row above the grid is a copy of its first row, and the row below the grid is a copy of its last row.
    const auto above = [&](size_t y) -> const float* { return y > first ? row(y - 1) : y > 0 ? rows.above : row(0); };
    press_row<true, false, past_caches>(f, k, first, nullptr, nullptr, rows);
    for (size_t y = first + 1; y < last; ++y) press_row<true, true, past_caches>(f, k, y, above(y - 1), nullptr, rows);
    press_row<false, true, past_caches>(f, k, last, above(last - 1), last < f.height ? rows.below : row(last - 1),
                                        rows);
    if (past_caches) fence();
}

} // namespace

void press_rows(const Frame& f, size_t first, size_t last, const ThreadRows& rows, bool past_caches) {
    if (first == last) return;
    (past_caches ? press_some<true> : press_some<false>)(f, first, last, rows);
}

} // namespace bench::native
