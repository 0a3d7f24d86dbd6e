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
#include "kernels/cell.h"
#include "kernels/responses.h"
#include "kernels/curvature.h"
#include "kernels/reduce.h"
#include "kernels/spread.h"
// clang-format on
#undef precise
#undef OF_ANY_CELL

inline real loaded(const scalar* from) { return Wide(*reinterpret_cast<const Wide::Anywhere*>(from)); }
inline void store(scalar* to, real x) { *reinterpret_cast<Wide::Anywhere*>(to) = x.v; }
#include "host/core/simd/cell.inl"

// A vector of `count` lanes: lane i is number Index()(i) among the lanes of a and then those of b.
template <int count, class Index, class Vector> inline auto picked(Vector a, Vector b) {
    return []<int... i>(Vector a, Vector b, std::integer_sequence<int, i...>) {
        return __builtin_shufflevector(a, b, Index()(i)...);
    }
    (a, b, std::make_integer_sequence<int, count>());
}

// The bits by which a block's sums differ, lane by lane; sums are equal where all are 0, because no -0 is ever kept.
using Bits = Wide::Mask;
inline Bits differing(Sum a, Sum b) { return ((Bits)a.value.v ^ (Bits)b.value.v) | ((Bits)a.lost.v ^ (Bits)b.lost.v); }
// Whether some of the n lanes of x is not 0. Each lane is joined with the lane `reach` away, for reach = n/2 .. 1.
template <int n, int reach = n / 2, class Vector> inline bool any(Vector x) {
    if constexpr (reach == 0) return x[0] != 0;
    else return any<n, reach / 2>(x | picked<n, decltype([](int lane) { return lane ^ reach; })>(x, x));
}

// The coefficients of a block whose cells have each their own material. They are loaded cell by cell, `side` members
// at a time, and transposed, because to gather each member takes longer.
struct Gathered {
    static constexpr int members = int(sizeof(Coefficients) / sizeof(scalar)), side = lanes < 4 ? lanes : 4;
    static_assert(members % side == 0);
    typedef scalar Side __attribute__((vector_size(side * sizeof(scalar))));
    typedef Side Unaligned __attribute__((aligned(alignof(scalar)), may_alias));

    // Members m .. m + side - 1 of n cells: i, i + side ..
    template <int n, int entries> static auto loaded(const Coefficients* table, const int* material, int m, int i) {
        if constexpr (n == 1) {
            return Side(*reinterpret_cast<const Unaligned*>(
                reinterpret_cast<const scalar*>(table + entries * material[i]) + m));
        } else {
            const auto first = loaded<n / 2, entries>(table, material, m, i),
                       second = loaded<n / 2, entries>(table, material, m, i + n / 2 * side);
            return picked<n * side, decltype([](int lane) { return lane; })>(first, second);
        }
    }

    // The two steps of the transposition. in_turn: lanes of a and b in turn, from the low (half = 0) or high (1) half
    // of each side; pairs: the same with pairs of lanes.
    template <int half> static auto in_turn(Wide::Lanes a, Wide::Lanes b) {
        return picked<lanes, decltype([](int lane) {
                          const int within = lane % side, from = lane - within + half * side / 2 + within / 2;
                          return within % 2 ? lanes + from : from;
                      })>(a, b);
    }
    template <int half> static auto pairs(Wide::Lanes a, Wide::Lanes b) {
        return picked<lanes, decltype([](int lane) {
                          const int within = lane % 4, from = lane - within + half * 2 + within % 2;
                          return within < 2 ? from : lanes + from;
                      })>(a, b);
    }

    // entries: Coefficients in the table for each element.
    template <int entries> static LaneCoefficients of(const Coefficients* table, const int* material) {
        Wide all[members];
#pragma GCC unroll 8
        for (int m = 0; m < members; m += side) {
            Wide::Lanes cell[4]; // the first `side` are used
#pragma GCC unroll 4
            for (int j = 0; j < side; ++j) cell[j] = loaded<lanes / side, entries>(table, material, m, j);
            if constexpr (side == 2) {
                all[m] = Wide(in_turn<0>(cell[0], cell[1]));
                all[m + 1] = Wide(in_turn<1>(cell[0], cell[1]));
            } else {
                const auto a = in_turn<0>(cell[0], cell[1]), b = in_turn<1>(cell[0], cell[1]),
                           c = in_turn<0>(cell[2], cell[3]), d = in_turn<1>(cell[2], cell[3]);
                all[m] = Wide(pairs<0>(a, c));
                all[m + 1] = Wide(pairs<1>(a, c));
                all[m + 2] = Wide(pairs<0>(b, d));
                all[m + 3] = Wide(pairs<1>(b, d));
            }
        }
        LaneCoefficients k;
        __builtin_memcpy(&k, all, sizeof k);
        return k;
    }
};

// The material of the cache line of cells at i, or -1 if it has several.
inline int material_of_line(const AdvanceArguments<Kernels>& a, int i) {
    return a.line_material ? a.line_material[i / PITCH_CELLS] : -1;
}

// The first cell behind the lines from i on that have the material of the line at i; at most `end`.
inline int end_of_material(const AdvanceArguments<Kernels>& a, int i, int end) {
    const int material = material_of_line(a, i);
    do i += line;
    while (i < end && material_of_line(a, i) == material);
    return i;
}

inline bool is_chain(const AdvanceArguments<Kernels>& a) { return a.elements > 1 || a.spring; }

// Steps a row, a cache line of cells at a time.
template <Hold hold, bool materials, bool compensated, bool chain>
int advance_in(const AdvanceArguments<Kernels> a, const Constants c) {
    constexpr int entries = entries_of(hold);
    Bits changed[state_sums] = {};
    const bool apart = a.to.strain != a.to.value[sum_strain]; // the strains of chains, and of pads
    const auto step = [&](int i, auto coefficients) {
        const real strain = step_at < hold, compensated,
                   chain ? 0 : 1 > (a, i, c, coefficients, [&](int sum, Sum before, Sum after) {
                                   changed[sum] |= differing(before, after);
                               });
        if (chain || apart) store(a.to.strain + i, strain);
    };
    int material = materials ? *a.material : 0;
    LaneCoefficients k = lanes_of(materials ? a.table[entries * material] : chain ? a.table[0] : c.coefficients);
    for (int begin = 0; begin < a.count; begin += line) {
        const int of_line = materials ? material_of_line(a, begin) : 0;
        if (of_line < 0) {
            for (int i = begin; i < begin + line; i += lanes)
                step(i, [&](int n) { return Gathered::of<entries>(a.table + n, a.material + i); });
            continue;
        }
        if (materials && of_line != material) k = lanes_of(a.table[entries * (material = of_line)]);
#pragma GCC unroll 8
        for (int i = begin; i < begin + line; i += lanes)
            step(i, [&](int n) { return chain && n > 0 ? lanes_of(a.table[entries * material + n]) : k; });
    }
    int bits = 0;
    for (int s = 0; s < state_sums; ++s) bits |= int(any<lanes>(changed[s])) << s;
    return bits;
}

template <Hold hold> int advance_for(const AdvanceArguments<Kernels>& a, const Constants& c) {
    return with_bool(a.material, [&](auto materials) {
        return with_bool(a.from.lost[sum_strain], [&](auto compensated) {
            if constexpr (hold !=
                          Hold::parabolic) // as a chain of any length, because its coefficients are always in the table
                if (!is_chain(a)) return advance_in<hold, materials.number, compensated.number, false>(a, c);
            return advance_in<hold, materials.number, compensated.number, true>(a, c);
        });
    });
}

// The gains of a block at column x. along: its second difference along the row.
template <int stencil>
__attribute__((always_inline)) inline real gains_at(const RespondArguments<Kernels>& r, int x, real along,
                                                    const Constants& c) {
    const real L = add(along, difference_across<stencil>(r.strain, x));
    return gain_at(curvature_of(loaded(r.rest_curvature + x), L, c.bend), c);
}

// The response i of a block at column x. passed: passes(c).
__attribute__((always_inline)) inline real response_at(const RespondArguments<Kernels>& r, int i, int x, real gain,
                                                       bool passed, const Constants& c) {
    const real signal = loaded(r.signal[i] + x);
    return passed ? answer_of<true>(QUANTITY_SA1 + i, signal, gain, c)
                  : answer_of<false>(QUANTITY_SA1 + i, signal, gain, c);
}

// How many cells lie between the beginning of a cache line and an address in that line.
inline int beyond_line(const scalar* address) { return int((size_t)address / sizeof(scalar)) & (line - 1); }
// The same for the row of the first response that is stored; the rows of the others begin as far from a line.
inline int beyond_line(const RespondArguments<Kernels>& r) {
    for (const scalar* response : r.response)
        if (response) return beyond_line(response);
    return 0;
}
// The first column at which the responses begin a cache line.
inline int first_line(const RespondArguments<Kernels>& r) { return -beyond_line(r) & (line - 1); }

// Stores a register of responses.
template <bool streams> __attribute__((always_inline)) inline void store_response(scalar* to, real x) {
    if constexpr (streams) stream_register(to, (Register)x.v);
    else store(to, x);
}

// The responses of a cache line of columns whose stencils read no cell across an end of the row. A line of each
// response is stored at once, because lines that reach memory in parts cost more.
template <int stencil, bool streams>
__attribute__((always_inline)) inline void respond_line(const RespondArguments<Kernels>& r, int x, bool passed,
                                                        const Constants& c) {
    real gain[line / lanes];
#pragma GCC unroll 8
    for (int i = 0; i < line; i += lanes)
        gain[i / lanes] = gains_at<stencil>(r, x + i, difference_along<stencil>(r.strain, x + i), c);
#pragma GCC unroll 8
    for (int q = 0; q < RESPONSE_MAPS; ++q) {
        if (!r.response[q]) continue;
#pragma GCC unroll 8
        for (int i = 0; i < line; i += lanes)
            store_response<streams>(r.response[q] + x + i, response_at(r, q, x + i, gain[i / lanes], passed, c));
    }
}

// The responses of n <= lanes columns from x on. streams: they go past the caches.
__attribute__((always_inline)) inline void respond_block(const RespondArguments<Kernels>& r, int x, int n, real gain,
                                                         bool passed, bool streams, const Constants& c) {
    for (int q = 0; q < RESPONSE_MAPS; ++q) {
        if (!r.response[q]) continue;
        const real answered = response_at(r, q, x, gain, passed, c);
        if (n == lanes && streams) store_response<true>(r.response[q] + x, answered);
        else if (n == lanes) store(r.response[q] + x, answered);
        else
            for (int lane = 0; lane < n; ++lane) r.response[q][x + lane] = answered.v[lane];
    }
}

// Second differences along a row in columns first .. last - 1 near an end of it. They have an array of their own
// because they are stored cell by cell and loaded as blocks: loaded soon, they would wait until all responses before
// them are in memory.
struct EndDifferences {
    // The difference at `first` is values[lanes]: a block of which only a part is wanted is stored whole.
    alignas(real) scalar values[TILE_CELLS + 3 * lanes];

    template <int stencil> void fill(const scalar* row, const EndCells<stencil>& ends, int first, int last) {
        RowNeighbours<scalar> l{}; // nothing else of it is read, and to copy the rest for each row takes longer
        l.here = row;
        l.width = ends.width;
        l.stencil = stencil;
        l.edges = ends.edges;
        const int far = ends.far, after = l.width - far, inside = after - lanes; // the last block inside
        scalar* to = values + lanes;
        if (inside < far) {
            for (int x = first; x < last; ++x) to[x - first] = difference_at(l, x);
            return;
        }
        for (int x = max(first, far); x < min(last, after); x += lanes) {
            const int at = min(x, inside);
            store(to + (at - first), difference_along<stencil>(l, at));
        }
        for (int x = first; x < min(far, last); ++x) to[x - first] = difference_by<stencil>(row, x, ends.low[x]);
        for (int x = max(after, first); x < last; ++x)
            to[x - first] = difference_by<stencil>(row, x, ends.high[x - after]);
    }
};

constexpr int blocks_of_tile = TILE_CELLS / lanes;

// The first levels of the tree of kernels/reduce.h over a tile: the levels that join whole registers.
__attribute__((always_inline)) inline Summary summary_of_blocks(const real (&x)[blocks_of_tile]) {
    Summary s[blocks_of_tile];
#pragma GCC unroll 32
    for (int i = 0; i < blocks_of_tile; ++i) s[i] = summary_of(x[i]);
#pragma GCC unroll 8
    for (int reach = blocks_of_tile / 2; reach > 0; reach /= 2)
#pragma GCC unroll 16
        for (int i = 0; i < reach; ++i) s[i] = join(s[i], s[i + reach]);
    return s[0];
}

// The rest of the tree, for several quantities at once. Cells `reach` apart are to be joined, in x and in y. Lanes
// whose number has the bit `reach` clear come from x, all others from y, so that no lane is idle. second = 0 picks the
// lower cell of each pair, 1 the cell `reach` above it.
template <int reach, int second> inline Wide halves(Wide x, Wide y) {
    return Wide(picked<lanes, decltype([](int lane) {
                           return lane & reach ? lanes + lane - (second ? 0 : reach) : lane + (second ? reach : 0);
                       })>(x.v, y.v));
}
template <int reach, int second> inline Summary halves(const Summary& x, const Summary& y) {
    Summary s;
    s.sum = halves<reach, second>(x.sum, y.sum);
    s.low = halves<reach, second>(x.low, y.low);
    s.high = halves<reach, second>(x.high, y.high);
    return s;
}
// The summary of s[i] comes to lane lane_of(i) of register i / lanes.
template <int reach, int n> inline void join_lanes(const Summary (&s)[n], Summary* all) {
    constexpr int pairs = (n + 1) / 2;
    Summary joined[pairs];
#pragma GCC unroll 8
    for (int i = 0; i < pairs; ++i) {
        const Summary &x = s[2 * i], &y = s[min(2 * i + 1, n - 1)];
        joined[i] = join(halves<reach, 0>(x, y), halves<reach, 1>(x, y));
    }
    if constexpr (reach > 1) join_lanes<reach / 2>(joined, all);
    else
        for (int i = 0; i < pairs; ++i) all[i] = joined[i];
}
constexpr int lane_of(int i) {
    int lane = 0;
    for (int bit = 1, from = lanes / 2; from > 0; bit *= 2, from /= 2) lane += i & bit ? from : 0;
    return lane;
}

// Stores the summaries of a tile that are asked for.
__attribute__((always_inline)) inline void store_summaries(const Summary (&of_blocks)[REDUCED_MAPS],
                                                           Kernels::Summary* const (&tiles)[REDUCED_MAPS], int tile) {
    Summary all[(REDUCED_MAPS + lanes - 1) / lanes];
    join_lanes<lanes / 2>(of_blocks, all);
#pragma GCC unroll 8
    for (int q = 0; q < REDUCED_MAPS; ++q) {
        if (!tiles[q]) continue;
        const Summary& from = all[q / lanes];
        tiles[q][tile].sum = from.sum.v[lane_of(q)];
        tiles[q][tile].low = from.low.v[lane_of(q)];
        tiles[q][tile].high = from.high.v[lane_of(q)];
    }
}

// Computes the responses of the tile at column x: its sums, its map, or both. inner: the tile reads no cell beyond an
// end of its row.
template <int stencil, bool passed, bool inner>
inline void respond_tile(const RespondArguments<Kernels>& r, const EndCells<stencil>& end_cells, int x,
                         const Constants& c) {
    real values[blocks_of_tile], gain[blocks_of_tile];
    Summary all[REDUCED_MAPS]{};
    if (r.tiles[QUANTITY_STRAIN]) {
#pragma GCC unroll 32
        for (int i = 0; i < blocks_of_tile; ++i) values[i] = loaded(r.strain.here + x + i * lanes);
        all[QUANTITY_STRAIN] = summary_of_blocks(values);
    }
    EndDifferences ends;
    if constexpr (!inner) ends.fill<stencil>(r.strain.here, end_cells, x, x + TILE_CELLS);
#pragma GCC unroll 32
    for (int i = 0; i < blocks_of_tile; ++i) {
        const int at = x + i * lanes;
        gain[i] = gains_at<stencil>(
            r, at, inner ? difference_along<stencil>(r.strain, at) : loaded(ends.values + (i + 1) * lanes), c);
    }
#pragma GCC unroll 8
    for (int q = 0; q < RESPONSE_MAPS; ++q) {
        if (!r.tiles[QUANTITY_SA1 + q] && !r.response[q]) continue;
#pragma GCC unroll 32
        for (int i = 0; i < blocks_of_tile; ++i) {
            values[i] = response_at(r, q, x + i * lanes, gain[i], passed, c);
            if (r.response[q]) store(r.response[q] + x + i * lanes, values[i]);
        }
        if (r.tiles[QUANTITY_SA1 + q]) all[QUANTITY_SA1 + q] = summary_of_blocks(values);
    }
    store_summaries(all, r.tiles, x / TILE_CELLS);
}

// Computes the responses of whole tiles.
template <int stencil, bool passed> void respond_tiles_in(const RespondArguments<Kernels> r, const Constants c) {
    const int far = reach(stencil);
    const EndCells<stencil> ends(r.strain);
    for (int x = r.first; x + TILE_CELLS <= r.last; x += TILE_CELLS)
        if (x >= far && x + TILE_CELLS <= r.strain.width - far) respond_tile<stencil, passed, true>(r, ends, x, c);
        else respond_tile<stencil, passed, false>(r, ends, x, c);
}

bool sums(const RespondArguments<Kernels>& r) {
    bool asked = false;
    for (int q = 0; q < REDUCED_MAPS; ++q) asked = asked || r.tiles[q];
    return asked;
}

// Steps cell i between frames. series: as a RowCell has it. k, more: the first coefficients of the first element, and
// all coefficients of all elements in series.
template <Hold hold, bool compensated, int series>
__attribute__((always_inline)) inline void step_between(const AdvanceArguments<Kernels>& a, int i, const Constants& c,
                                                        const LaneCoefficients& k, const Coefficients* more) {
    const auto nothing = [](int, Sum, Sum) {};
    if constexpr (series != 1)
        store(a.to.strain + i, step_at<hold, compensated, series>(
                                   a, i, c, [&](int n) { return n > 0 ? lanes_of(more[n]) : k; }, nothing));
    else // by reference: a copy for each block would go through memory
        step_at<hold, compensated, series>(
            a, i, c, [&](int) -> const LaneCoefficients& { return k; }, nothing);
}

// Moves the arguments from one pair of rows to the next pair.
__attribute__((always_inline)) inline void lead_on(RowSteps<Kernels>& s) {
    const auto lead = [](auto*& row, size_t cells) { row = row ? row + cells : nullptr; };
    AdvanceArguments<Kernels>& a = s.advance;
    RespondArguments<Kernels>& r = s.respond;
    for (const scalar** row : {&a.pressure, &a.pressure_to, &r.strain.far_low, &r.strain.low, &r.strain.here,
                               &r.strain.high, &r.strain.far_high, &r.rest_curvature, &r.signal[0], &r.signal[1]})
        lead(*row, s.pitch);
    lead(a.material, s.pitch);
    lead(a.line_material, s.pitch / PITCH_CELLS);
    for (StateRow<scalar>* state : {&a.from, &a.to})
        for (scalar** row : {&state->value[0], &state->value[1], &state->lost[0], &state->lost[1], &state->strain,
                             &state->rate, &state->previous})
            lead(*row, s.pitch);
    for (scalar*& row : r.response) lead(row, s.response_pitch);
    for (auto*& row : r.tiles) lead(row, s.tiles);
    const int stepped = ++s.stepped, answered = stepped - s.behind;
    for (int i = 0; i < STEP_SIGNALS; ++i) {
        if (a.signal[i]) a.signal[i] = s.signal[i][stepped % 3] + r.first;
        r.signal[QUANTITY_FA1 - QUANTITY_SA1 + i] = s.signal[i][answered % 3];
    }
    if (!s.strain[0]) return;
    const auto strain = [&](int row) { return s.strain[row % 5]; };
    const int near = r.strain.stencil == STENCIL_PUBLISHED ? 0 : 1; // as difference_along() has it
    a.to.strain = strain(stepped) + r.first;
    r.strain.far_low = strain(answered - s.behind);
    r.strain.low = strain(answered - near);
    r.strain.here = strain(answered);
    r.strain.high = strain(answered + near);
    r.strain.far_high = strain(stepped);
    r.signal[0] = r.strain.here; // SA1
}

// The coefficients of a skin's elements in series, `entries` of each. It is a copy, because the compiler cannot know
// that no store changes the table itself.
struct SeriesTable {
    Coefficients all[entries_of(Hold::parabolic) * most_in_series];
    SeriesTable(const AdvanceArguments<Kernels>& a, int entries) {
        for (int n = 0; n < entries * (a.elements + a.spring); ++n) all[n] = a.table[n];
    }
};

// The fused loop of step_rows: it steps a row and answers another one, row after row. The arguments are copied and
// their address is never passed on: the compiler then knows that no store changes them.
template <int stencil, Hold hold, bool compensated, int series, bool materials = false>
void step_rows_in(const RowSteps<Kernels>& given, const Constants& constants) {
    RowSteps<Kernels> s = given;
    const Constants c = constants;
    const AdvanceArguments<Kernels>& a = s.advance;
    const RespondArguments<Kernels>& r = s.respond;
    const int far = reach(stencil), begin = r.first < far ? min(r.first + line, r.last) : r.first,
              end = begin + max(min(r.last, r.strain.width - far) - begin, 0) / line * line;
    const EndCells<stencil> ends(r.strain);
    const bool passed = passes(c);
    const LaneCoefficients k = lanes_of(series != 1 || materials ? a.table[0] : c.coefficients);
    const SeriesTable table(a, series == 1 ? 0 : entries_of(hold));
    const auto of_block = [&](int i) -> decltype(auto) {
        if constexpr (materials) return Gathered::of<1>(a.table, a.material + i);
        else return (k);
    };
    // Steps n cells, in whole blocks. of(i): the coefficients of the block at i.
    const auto step_cells = [&](int first, int n, const auto& of) __attribute__((always_inline)) {
#pragma GCC unroll 8
        for (int i = first; i < first + n; i += lanes)
            step_between<hold, compensated, series>(a, i, c, of(i), table.all);
    };
    for (int row = 0; row < s.rows; ++row, lead_on(s)) {
        // lines are answered from a column on where the responses begin a cache line
        const int first = r.streams ? first_line(r) : 0, shift = end > begin ? first : 0, answered = begin + shift,
                  rest = shift ? end - line + shift : end;
        EndDifferences low, high;
        low.fill<stencil>(r.strain.here, ends, r.first, answered);
        high.fill<stencil>(r.strain.here, ends, rest, r.last);
        const auto press_lines = [&](auto streams, int x, int to, const auto& of) __attribute__((always_inline)) {
            // answers one line behind, because they would wait until the strain of their own line is stored
            for (; x < to; x += line) {
                step_cells(x - r.first, line, of);
                if (x > begin) respond_line<stencil, streams.number>(r, x - line + shift, passed, c);
            }
        };
        const auto press_inside = [&](auto streams) __attribute__((always_inline)) {
            for (int x = begin, to = end; x < end; x = to) { // lines of one material together
                const int material = materials ? material_of_line(a, x - r.first) : -1;
                if (materials) to = r.first + end_of_material(a, x - r.first, end - r.first);
                const LaneCoefficients one = material < 0 ? k : lanes_of(a.table[material]);
                if (material < 0) press_lines(streams, x, to, of_block);
                else press_lines(streams, x, to, [&](int) -> const LaneCoefficients& { return one; });
            }
            if (end > begin && shift == 0) respond_line<stencil, streams.number>(r, end - line, passed, c);
        };
        const auto answer_end = [&](int x, int last, const scalar* along) __attribute__((always_inline)) {
            for (int n; x < last; x += n, along += n) { // to a multiple of a block's length, then block by block
                n = min(last - x, lanes - x % lanes);
                const real gain = gains_at<stencil>(r, x, loaded(along), c);
                respond_block(r, x, n, gain, passed, r.streams && first == 0, c);
            }
        };
        for (int x = r.first; x < begin; x += lanes) step_cells(x - r.first, lanes, of_block);
        with_bool(r.streams, press_inside);
        for (int x = end; x < r.last; x += lanes) step_cells(x - r.first, lanes, of_block);
        answer_end(r.first, answered, low.values + lanes);
        answer_end(rest, r.last, high.values + lanes);
    }
}

template <bool compensated> void step_rows_for(const RowSteps<Kernels>& s, const Constants& c) {
    const AdvanceArguments<Kernels>& a = s.advance;
    with_stencil(s.respond.strain.stencil, [&](auto of_skin) {
        constexpr int stencil = of_skin.number;
        if (a.to.previous) return step_rows_in<stencil, Hold::parabolic, compensated, 0>(s, c);
        if (a.material) return step_rows_in<stencil, Hold::linear, compensated, 1, true>(s, c);
        if (!is_chain(a)) return step_rows_in<stencil, Hold::linear, compensated, 1>(s, c);
        if constexpr (stencil == STENCIL_FIVE_POINT) {
            if (a.elements == 2 && !a.spring) return step_rows_in<stencil, Hold::linear, compensated, 2>(s, c);
            if (a.elements == 3 && !a.spring) return step_rows_in<stencil, Hold::linear, compensated, 3>(s, c);
        }
        step_rows_in<stencil, Hold::linear, compensated, 0>(s, c);
    });
}

} // namespace blocks

int advance(const AdvanceArguments<Kernels>& a, const Constants& c) {
    using namespace blocks;
    const int changed = !a.pressure_to  ? advance_for<Hold::held>(a, c)
                        : a.to.previous ? advance_for<Hold::parabolic>(a, c)
                                        : advance_for<Hold::linear>(a, c);
    end_vector_code();
    return changed;
}

void respond(const RespondArguments<Kernels>& r, const Constants& c) {
    RespondArguments<Kernels> rest = r; // the columns that are left
    with_bool(passes(c), [&](auto passed) {
        if (blocks::sums(r)) {
            with_stencil(r.strain.stencil,
                         [&](auto stencil) { blocks::respond_tiles_in<stencil.number, passed.number>(r, c); });
            rest.first += (r.last - r.first) / TILE_CELLS * TILE_CELLS;
        }
        respond_in<passed.number>(rest, c);
    });
    end_vector_code();
}

// Whether the fused loop serves: frames, no sums, and not several materials of chains or under parabolic hold.
[[maybe_unused]] bool in_blocks(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r) {
    bool serves = a.pressure_to && !(a.material && (blocks::is_chain(a) || a.to.previous)) && !blocks::sums(r);
    for (int i = 0; i < RESPONSE_MAPS; ++i) // one shift serves all
        serves =
            serves && (!r.streams || !r.response[i] || blocks::beyond_line(r.response[i]) == blocks::beyond_line(r));
    return serves;
}

// Skins are pressed in f32, so only that has the fused loop. In f64 only a field between two outputs of a run could use
// it, and takes the two loops.
int step_rows(const RowSteps<Kernels>& given, const Constants& c) {
    if constexpr (std::is_same_v<scalar, float>)
        if (in_blocks(given.advance, given.respond)) {
            with_bool(given.advance.from.lost[sum_strain],
                      [&](auto compensated) { blocks::step_rows_for<compensated.number>(given, c); });
            end_vector_code();
            return (1 << state_sums) - 1;
        }
    RowSteps<Kernels> s = given;
    int changed = 0;
    for (int row = 0; row < s.rows; ++row, blocks::lead_on(s)) {
        changed |= advance(s.advance, c);
        respond(s.respond, c);
    }
    return changed;
}
