// SPDX-License-Identifier: MIT
// A step of one row and the responses of another in one loop over blocks of one register of cells. rows.inl precedes
// this in its namespace. Blocks begin at multiples of their length, so the last one of a row ends within the pitch.

// One register of cells as the `real` of kernels/*.h: the operators and functions that they use, lane by lane.
struct Wide {
    typedef scalar Lanes __attribute__((vector_size(sizeof(Register))));
    typedef Lanes Anywhere __attribute__((aligned(alignof(scalar)), may_alias)); // the same in memory
    using Mask = decltype(Lanes{} < Lanes{});                                    // each lane all ones or 0

    Lanes v;

    Wide() = default;
    explicit Wide(Lanes x) : v(x) {}
    explicit Wide(scalar x) : v(x - Lanes{}) {} // x in every lane: -0 - 0 is -0

    friend Wide operator+(Wide a, Wide b) { return Wide(a.v + b.v); }
    friend Wide operator-(Wide a, Wide b) { return Wide(a.v - b.v); }
    friend Wide operator*(Wide a, Wide b) { return Wide(a.v * b.v); }
    friend Wide operator*(scalar a, Wide b) { return Wide(a) * b; }
    friend Wide operator-(Wide a) { return Wide(-a.v); }
    friend Wide abs(Wide a) { return Wide((Lanes)((Mask)a.v & ~(Mask)Wide(scalar(-0.0)).v)); }
    friend Mask lessThan(Wide a, Wide b) { return a.v < b.v; }
    friend Wide mix(Wide a, Wide b, Mask second) { return Wide(second ? b.v : a.v); }
};

namespace blocks {

using real = Wide;
constexpr int lanes = int(sizeof(Wide) / sizeof(scalar)), line = 64 / int(sizeof(scalar)); // cells of a cache line
// clang-format off
#include "kernels/prelude.h"
#include "kernels/step.h"
#include "kernels/responses.h"
#include "kernels/curvature.h"
// clang-format on
#undef precise

inline real loaded(const scalar* from) { return Wide(*reinterpret_cast<const Wide::Anywhere*>(from)); }
inline void store(scalar* to, real x) { *reinterpret_cast<Wide::Anywhere*>(to) = x.v; }
#include "host/simd/cell.inl"

// The curvature of a block at column x. along: its second difference along the row.
template <int stencil>
inline real curvature_at(const RespondArguments<Kernels>& r, int x, real along, const Constants& c) {
    return curvature_of(loaded(r.rest_curvature + x), add(along, difference_across<stencil>(r.strain, x)), c.bend);
}

// The response i of a block at column x where the skin has the curvature C.
template <bool passed>
inline real response_at(const RespondArguments<Kernels>& r, int i, int x, real C, const Constants& c) {
    return answer_of<passed>(QUANTITY_SA1 + i, loaded(r.signal[i] + x), C, c);
}

// The responses of a cache line of columns, in which no cell is read across an end of the row: each is streamed at
// once, because lines that reach memory in parts cost more.
template <int stencil, bool passed>
inline void respond_line(const RespondArguments<Kernels>& r, int x, const Constants& c) {
    real C[line / lanes];
#pragma GCC unroll 8
    for (int i = 0; i < line; i += lanes)
        C[i / lanes] = curvature_at<stencil>(r, x + i, difference_along<stencil>(r.strain, x + i), c);
#pragma GCC unroll 8
    for (int q = 0; q < RESPONSE_MAPS; ++q)
#pragma GCC unroll 8
        for (int i = 0; i < line; i += lanes)
            stream_register(r.response[q] + x + i, (Register)response_at<passed>(r, q, x + i, C[i / lanes], c).v);
}

// The responses of n <= lanes columns from x on.
template <bool passed>
inline void respond_block(const RespondArguments<Kernels>& r, int x, int n, real C, const Constants& c) {
    for (int q = 0; q < RESPONSE_MAPS; ++q) {
        const real answered = response_at<passed>(r, q, x, C, c);
        if (n == lanes) stream_register(r.response[q] + x, (Register)answered.v);
        else
            for (int lane = 0; lane < n; ++lane) r.response[q][x + lane] = answered.v[lane];
    }
}

// Second differences along a row in columns first .. last - 1 near an end of it. They have an array of their own
// because they are stored cell by cell and loaded as blocks: loaded soon, they would wait until all responses before
// them are in memory.
struct EndDifferences {
    // The difference at `first` is values[lanes]: a block of which a part is wanted is stored whole.
    alignas(real) scalar values[line + 3 * lanes] = {};

    template <int stencil> void fill(const RowNeighbours<scalar>& l, int first, int last) {
        const int far = reach(stencil), inside = l.width - far - lanes; // the last block inside
        const bool any = far <= inside;
        scalar* to = values + lanes;
        for (int x = max(first, far); any && x < min(last, l.width - far); x += lanes) {
            const int at = min(x, inside);
            store(to + (at - first), difference_along<stencil>(l, at));
        }
        for (int x = first; x < last; ++x)
            if (!any || x < far || x >= l.width - far) to[x - first] = difference_at(l, x);
    }
};

// A step and the responses of columns x .. last - 1 near an end of the row.
template <int stencil, bool compensated, bool passed>
__attribute__((noinline)) void step_end(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r,
                                        const Constants& c, int x, int last, const EndDifferences& along) {
    for (const scalar* at = along.values + lanes; x < last; x += lanes, at += lanes) {
        step_at<true, compensated>(a, x - r.first, c, lanes_of(c.coefficients));
        respond_block<passed>(r, x, min(last - x, lanes), curvature_at<stencil>(r, x, loaded(at), c), c);
    }
}

template <int stencil, bool compensated, bool passed>
void step_row_in(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r, const Constants& c) {
    const int far = reach(stencil), begin = r.first < far ? min(r.first + line, r.last) : r.first,
              end = begin + max(min(r.last, r.strain.width - far) - begin, 0) / line * line;
    EndDifferences low, high;
    low.fill<stencil>(r.strain, r.first, begin);
    high.fill<stencil>(r.strain, end, r.last);
    [begin, end, a = a, r = r, c = c] { // copies: nothing that is stored may change them
        const LaneCoefficients k = lanes_of(c.coefficients);
        for (int x = begin; x < end; x += line) {
#pragma GCC unroll 8
            for (int i = 0; i < line; i += lanes) step_at<true, compensated>(a, x + i - r.first, c, k);
            respond_line<stencil, passed>(r, x, c);
        }
    }();
    step_end<stencil, compensated, passed>(a, r, c, r.first, begin, low);
    step_end<stencil, compensated, passed>(a, r, c, end, r.last, high);
}

template <bool compensated, bool passed>
void step_row_for(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r, const Constants& c) {
    with_stencil(r.strain.stencil, [&](auto stencil) { step_row_in<stencil.number, compensated, passed>(a, r, c); });
}

} // namespace blocks

// Whether the loop of blocks serves: frames, a uniform material, all responses, aligned, and no sums.
bool in_blocks(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r) {
    bool all = a.pressure_to && !a.material;
    for (int i = 0; i < RESPONSE_MAPS; ++i) all = all && r.response[i] && is_aligned(r.response[i] + r.first);
    for (int i = 0; i < REDUCED_MAPS; ++i) all = all && !r.tiles[i];
    return all;
}

int step_row(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r, const Constants& c) {
    if (!in_blocks(a, r)) {
        const int changed = advance(a, c);
        respond(r, c);
        return changed;
    }
    const bool compensated = a.from.lost[sum_strain], passed = c.gain_plus == real(1) && c.gain_minus == real(-1);
    if (compensated) passed ? blocks::step_row_for<true, true>(a, r, c) : blocks::step_row_for<true, false>(a, r, c);
    else passed ? blocks::step_row_for<false, true>(a, r, c) : blocks::step_row_for<false, false>(a, r, c);
    end_vector_code();
    return (1 << state_sums) - 1;
}
