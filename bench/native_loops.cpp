// SPDX-License-Identifier: MIT
#include "bench/native_loops.hpp"

#ifdef __SSE2__
#include <immintrin.h>
#endif

// The cells of the loop behind it do not depend on each other.
#ifdef __clang__
#define DERMIS_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define DERMIS_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace bench::native {
namespace {

typedef float Vector __attribute__((vector_size(4 * lanes)));
typedef double Doubles __attribute__((vector_size(8 * lanes)));
typedef int Indices __attribute__((vector_size(4 * lanes)));
// The same in memory.
typedef Vector Stored __attribute__((may_alias));
typedef Vector Unaligned __attribute__((may_alias, aligned(4)));
typedef Indices StoredIndices __attribute__((may_alias));

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

Vector all(float x) { return Vector{} + x; }

ExactStep<Vector> broadcast(const ExactStep<float>& k) {
    return {.E = all(k.E),
            .b = all(k.b),
            .f = all(k.f),
            .i0 = all(k.i0),
            .i1 = all(k.i1),
            .i2 = all(k.i2),
            .v0 = all(k.v0),
            .v1 = all(k.v1),
            .a0 = all(k.a0),
            .a1 = all(k.a1)};
}

// Vectors of cells at the start of a step, and their pressure over it.
struct Cells {
    Vector from, way, strain, r;
};

Cells cells(const ExactStep<Vector>& k, Vector from, Vector way, Vector strain) {
    return {.from = from, .way = way, .strain = strain, .r = from - k.E * strain};
}

Vector strain_after(const ExactStep<Vector>& k, const Cells& c) { return c.strain + k.f * c.way + k.b * c.r; }
Vector rate_after(const ExactStep<Vector>& k, const Cells& c) { return k.v0 * c.r + k.v1 * c.way; }
Vector acceleration_after(const ExactStep<Vector>& k, const Cells& c) { return k.a0 * c.r + k.a1 * c.way; }
Vector integral_after(const ExactStep<Vector>& k, const Cells& c, Vector integral) {
    return integral + k.i2 * c.way + k.i1 * c.from + k.i0 * c.strain;
}

// 1 + C of the cells at `here`.
Vector gain(Vector rest, const float* here, Vector above, Vector below) {
    const Vector centre = load(here);
    const Vector across = (load_unaligned(here - 1) - centre) + (load_unaligned(here + 1) - centre);
    return 1.0f + (rest - (across + ((above - centre) + (below - centre))));
}

Cells cells_of(const Frame& f, const ExactStep<Vector>& k, size_t y, size_t x) {
    const Vector from = load(f.from + y * f.pitch + x);
    return cells(k, from, load(f.to + y * f.pitch + x) - from, load(f.strain + y * f.strain_pitch + x));
}

// In one loop, steps row y, whose new strain is otherwise at `below`, and answers in row y - 1.
template <bool steps, bool answers, bool past_caches>
void press_row(const Frame& f, const ExactStep<Vector>& k, size_t y, const float* above, const float* below,
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
    const ExactStep<Vector> k = broadcast(f.step);
    for (size_t x = 0; x < f.width; x += lanes) {
        if (first > 0) store(rows.above + x, strain_after(k, cells_of(f, k, first - 1, x)));
        if (last < f.height) store(rows.below + x, strain_after(k, cells_of(f, k, last, x)));
    }
}

namespace {

template <bool past_caches> void press_some(const Frame& f, size_t first, size_t last, const ThreadRows& rows) {
    const ExactStep<Vector> k = broadcast(f.step);
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

void advance_rows(const Frame& f, size_t first, size_t last, float* rates, float* accelerations) {
    const ExactStep<float> k = f.step;
    for (size_t y = first; y < last; ++y) {
        const float *from = f.from + y * f.pitch, *to = f.to + y * f.pitch;
        float* strain = f.strain + y * f.strain_pitch;
        float* integral = f.integral + y * f.pitch;
        float* rate = rates + y * f.pitch;
        float* acceleration = accelerations + y * f.pitch;
        DERMIS_INDEPENDENT
        for (size_t x = 0; x < f.width; ++x) {
            const float way = to[x] - from[x], before = strain[x], r = from[x] - k.E * before;
            integral[x] += k.i0 * before + k.i1 * from[x] + k.i2 * way;
            rate[x] = k.v0 * r + k.v1 * way;
            acceleration[x] = k.a0 * r + k.a1 * way;
            strain[x] = before + k.b * r + k.f * way;
        }
        strain[-1] = strain[0];
        strain[f.width] = strain[f.width - 1];
    }
}

void answer_rows(const Frame& f, size_t first, size_t last, const float* rates, const float* accelerations) {
    for (size_t y = first; y < last; ++y) {
        const size_t i = y * f.pitch;
        const float *here = f.strain + y * f.strain_pitch, *above = y > 0 ? here - f.strain_pitch : here,
                    *below = y + 1 < f.height ? here + f.strain_pitch : here, *rest = f.rest + i,
                    *integral = f.integral + i, *rate = rates + i, *acceleration = accelerations + i;
        float* sa1 = f.responses[0] + i;
        float* sa2 = f.responses[1] + i;
        float* fa1 = f.responses[2] + i;
        float* fa2 = f.responses[3] + i;
        DERMIS_INDEPENDENT
        for (size_t x = 0; x < f.width; ++x) {
            const float e = here[x];
            const float across = (here[x - 1] - e) + (here[x + 1] - e);
            const float gain = 1 + (rest[x] - (across + ((above[x] - e) + (below[x] - e))));
            sa1[x] = e * gain;
            sa2[x] = integral[x] * gain;
            fa1[x] = rate[x] * gain;
            fa2[x] = acceleration[x] * gain;
        }
    }
}

namespace {

Vector looked_up(Vector table, Indices i) {
#ifdef __clang__
    Vector x;
    for (size_t k = 0; k < lanes; ++k) x[k] = table[i[k]];
    return x;
#else
    return __builtin_shuffle(table, i);
#endif
}

// The step of each cell: one for all, or looked up by the cell's material in vectors that hold every material's.
template <bool uniform> struct StepOfCells {
    ExactStep<Vector> table;

    StepOfCells(const ExactStep<float>* of_material, size_t materials) : table(broadcast(of_material[0])) {
        for (size_t m = 1; m < materials; ++m) {
            const ExactStep<float>& k = of_material[m];
            table.E[m] = k.E;
            table.b[m] = k.b;
            table.f[m] = k.f;
            table.i0[m] = k.i0;
            table.i1[m] = k.i1;
            table.i2[m] = k.i2;
            table.v0[m] = k.v0;
            table.v1[m] = k.v1;
            table.a0[m] = k.a0;
            table.a1[m] = k.a1;
        }
    }

    ExactStep<Vector> of(const int* material) const {
        if constexpr (uniform) return table;
        const Indices i = *reinterpret_cast<const StoredIndices*>(material);
        return {.E = looked_up(table.E, i),
                .b = looked_up(table.b, i),
                .f = looked_up(table.f, i),
                .i0 = looked_up(table.i0, i),
                .i1 = looked_up(table.i1, i),
                .i2 = looked_up(table.i2, i),
                .v0 = looked_up(table.v0, i),
                .v1 = looked_up(table.v1, i),
                .a0 = looked_up(table.a0, i),
                .a1 = looked_up(table.a1, i)};
    }
};

struct LaneStatistics {
    Doubles sum{};
    Vector sum_of_row{}, least = all(__FLT_MAX__), greatest = all(-__FLT_MAX__);

    void take(Vector x) {
        sum_of_row += x;
        least = x < least ? x : least;
        greatest = x > greatest ? x : greatest;
    }
    void end_row() {
        sum += __builtin_convertvector(sum_of_row, Doubles);
        sum_of_row = Vector{};
    }
    void add_to(Statistics& s, size_t quantity) const {
        for (size_t k = 0; k < lanes; ++k) {
            s.sum[quantity] += sum[k];
            if (least[k] < s.least[quantity]) s.least[quantity] = least[k];
            if (greatest[k] > s.greatest[quantity]) s.greatest[quantity] = greatest[k];
        }
    }
};

template <bool uniform> class TileStep {
  public:
    TileStep(const Tile& t, const StepOfCells<uniform>& k, Envelope e)
        : t_(t), k_(k), start_(all(e.start)), rise_(all(e.rise)) {}

    void take(Statistics& s) const {
        for (size_t x = 0; x < t_.width; x += lanes) {
            step_strain(lanes + x);
            step_strain((t_.height + 1) * t_.pitch + lanes + x);
        }
        for (size_t row = 1; row <= t_.height; ++row) {
            step_strain(row * t_.pitch);
            step_strain(row * t_.pitch + lanes + t_.width);
        }
        LaneStatistics lane[5];
        row<true, false>(0, lane);
        for (size_t y = 1; y < t_.height; ++y) row<true, true>(y, lane);
        row<false, true>(t_.height, lane);
        for (size_t q = 0; q < 5; ++q) lane[q].add_to(s, q);
    }

  private:
    Cells cells_at(const ExactStep<Vector>& k, size_t at) const {
        const Vector pressure = load(t_.pressure + at);
        return cells(k, pressure * start_, pressure * rise_, load(t_.strain + at));
    }

    void step_strain(size_t at) const {
        const ExactStep<Vector> k = k_.of(t_.material + at);
        store(t_.strain + at, strain_after(k, cells_at(k, at)));
    }

    // In one loop, steps row y, and answers in row y - 1.
    template <bool steps, bool answers> void row(size_t y, LaneStatistics (&lane)[5]) const {
        LaneStatistics s[5] = {lane[0], lane[1], lane[2], lane[3], lane[4]}; // stays in registers
        for (size_t x = 0; x < t_.width; x += lanes) {
            const size_t at = (y + 1) * t_.pitch + lanes + x;
            ExactStep<Vector> k;
            Cells c;
            if constexpr (steps) {
                k = k_.of(t_.material + at);
                c = cells_at(k, at);
                float* integral = t_.integral + y * t_.width + x;
                store(t_.strain + at, strain_after(k, c));
                store(integral, integral_after(k, c, load(integral)));
            }
            if constexpr (answers) {
                const float* here = t_.strain + at - t_.pitch;
                const size_t i = (y - 1) * t_.width + x;
                const Vector g = gain(load(t_.rest + i), here, load(here - t_.pitch), load(here + t_.pitch));
                s[0].take(load(here));
                s[1].take(load(here) * g);
                s[2].take(load(t_.integral + i) * g);
                s[3].take(load(t_.rate + x) * g);
                s[4].take(load(t_.acceleration + x) * g);
            }
            if constexpr (steps) {
                store(t_.rate + x, rate_after(k, c));
                store(t_.acceleration + x, acceleration_after(k, c));
            }
        }
        for (size_t q = 0; q < 5; ++q) {
            s[q].end_row();
            lane[q] = s[q];
        }
    }

    const Tile& t_;
    const StepOfCells<uniform>& k_;
    const Vector start_, rise_;
};

template <bool uniform>
void march(const Tile& t, const StepOfCells<uniform>& k, const Envelope* envelope, size_t steps, Statistics* s) {
    for (size_t i = 0; i < steps; ++i) TileStep<uniform>(t, k, envelope[i]).take(s[i]);
}

} // namespace

void march_tile(const Tile& t, const ExactStep<float>* of_material, size_t materials, const Envelope* envelope,
                size_t steps, Statistics* s) {
    if (materials == 1) march(t, StepOfCells<true>(of_material, 1), envelope, steps, s);
    else march(t, StepOfCells<false>(of_material, materials), envelope, steps, s);
}

} // namespace bench::native
