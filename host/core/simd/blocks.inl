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
            Wide::Lanes cell[side];
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

// Whether a cache line of cells has one material.
inline bool alike(const int* material) {
    constexpr int in_register = int(sizeof(Register) / sizeof(int)), ints = in_register < line ? in_register : line;
    typedef int Ints __attribute__((vector_size(ints * sizeof(int))));
    typedef Ints Unaligned __attribute__((aligned(alignof(int)), may_alias));
    const Ints first = material[0] - Ints{};
    Ints other{};
#pragma GCC unroll 8
    for (int i = 0; i < line; i += ints) other |= *reinterpret_cast<const Unaligned*>(material + i) ^ first;
    return !any<ints>(other);
}

inline bool is_chain(const AdvanceArguments<Kernels>& a) { return a.elements > 1 || a.spring; }

// Steps a row, a cache line of cells at a time.
template <Path path, bool materials, bool compensated, bool chain>
int advance_in(const AdvanceArguments<Kernels> a, const Constants c) {
    constexpr int entries = entries_of(path);
    Bits changed[state_sums] = {};
    const bool apart = a.to.strain != a.to.value[sum_strain]; // the strains of chains, and of pads
    const auto step = [&](int i, auto coefficients) {
        const real strain = step_at<path, compensated, chain>(
            a, i, c, coefficients, [&](int sum, Sum before, Sum after) { changed[sum] |= differing(before, after); });
        if (chain || apart) store(a.to.strain + i, strain);
    };
    int material = materials ? *a.material : 0;
    LaneCoefficients k = lanes_of(materials ? a.table[entries * material] : chain ? a.table[0] : c.coefficients);
    for (int begin = 0; begin < a.count; begin += line) {
        if (materials && !alike(a.material + begin)) {
            for (int i = begin; i < begin + line; i += lanes)
                step(i, [&](int n) { return Gathered::of<entries>(a.table + n, a.material + i); });
            continue;
        }
        if (materials && a.material[begin] != material) k = lanes_of(a.table[entries * (material = a.material[begin])]);
#pragma GCC unroll 8
        for (int i = begin; i < begin + line; i += lanes)
            step(i, [&](int n) { return chain && n > 0 ? lanes_of(a.table[entries * material + n]) : k; });
    }
    int bits = 0;
    for (int s = 0; s < state_sums; ++s) bits |= int(any<lanes>(changed[s])) << s;
    return bits;
}

template <Path path> int advance_for(const AdvanceArguments<Kernels>& a, const Constants& c) {
    return with_bool(a.material, [&](auto materials) {
        return with_bool(a.from.lost[sum_strain], [&](auto compensated) {
            if constexpr (path !=
                          Path::bent) // as a chain of any length, because its coefficients are always in the table
                if (!is_chain(a)) return advance_in<path, materials.number, compensated.number, false>(a, c);
            return advance_in<path, materials.number, compensated.number, true>(a, c);
        });
    });
}

// The curvature of a block at column x. along: its second difference along the row.
template <int stencil>
__attribute__((always_inline)) inline real curvature_at(const RespondArguments<Kernels>& r, int x, real along,
                                                        const Constants& c) {
    return curvature_of(loaded(r.rest_curvature + x), add(along, difference_across<stencil>(r.strain, x)), c.bend);
}

// The response i of a block at column x where the skin has the curvature C.
template <bool passed>
__attribute__((always_inline)) inline real response_at(const RespondArguments<Kernels>& r, int i, int x, real C,
                                                       const Constants& c) {
    return answer_of<passed>(QUANTITY_SA1 + i, loaded(r.signal[i] + x), C, c);
}

// Stores a register of responses.
template <bool streams> __attribute__((always_inline)) inline void store_response(scalar* to, real x) {
    if constexpr (streams) stream_register(to, (Register)x.v);
    else store(to, x);
}

// The responses of a cache line of columns whose stencils read no cell across an end of the row. A line of each
// response is stored at once, because lines that reach memory in parts cost more.
template <int stencil, bool passed, bool streams>
__attribute__((always_inline)) inline void respond_line(const RespondArguments<Kernels>& r, int x, const Constants& c) {
    real C[line / lanes];
#pragma GCC unroll 8
    for (int i = 0; i < line; i += lanes)
        C[i / lanes] = curvature_at<stencil>(r, x + i, difference_along<stencil>(r.strain, x + i), c);
#pragma GCC unroll 8
    for (int q = 0; q < RESPONSE_MAPS; ++q) {
        if (!r.response[q]) continue;
#pragma GCC unroll 8
        for (int i = 0; i < line; i += lanes)
            store_response<streams>(r.response[q] + x + i, response_at<passed>(r, q, x + i, C[i / lanes], c));
    }
}

// The responses of n <= lanes columns from x on.
template <bool passed>
__attribute__((always_inline)) inline void respond_block(const RespondArguments<Kernels>& r, int x, int n, real C,
                                                         const Constants& c) {
    for (int q = 0; q < RESPONSE_MAPS; ++q) {
        if (!r.response[q]) continue;
        const real answered = response_at<passed>(r, q, x, C, c);
        if (n == lanes && r.streams) store_response<true>(r.response[q] + x, answered);
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
    real values[blocks_of_tile], C[blocks_of_tile];
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
        C[i] = curvature_at<stencil>(
            r, at, inner ? difference_along<stencil>(r.strain, at) : loaded(ends.values + (i + 1) * lanes), c);
    }
#pragma GCC unroll 8
    for (int q = 0; q < RESPONSE_MAPS; ++q) {
        if (!r.tiles[QUANTITY_SA1 + q] && !r.response[q]) continue;
#pragma GCC unroll 32
        for (int i = 0; i < blocks_of_tile; ++i) {
            values[i] = response_at<passed>(r, q, x + i * lanes, C[i], c);
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

// Steps cell i between frames. k, more: the first coefficients of the first element, and all coefficients of all
// elements in series.
template <Path path, bool compensated, bool chain>
__attribute__((always_inline)) inline void step_between(const AdvanceArguments<Kernels>& a, int i, const Constants& c,
                                                        const LaneCoefficients& k, const Coefficients* more) {
    const auto nothing = [](int, Sum, Sum) {};
    if constexpr (chain)
        store(a.to.strain + i, step_at<path, compensated, true>(
                                   a, i, c, [&](int n) { return n > 0 ? lanes_of(more[n]) : k; }, nothing));
    else // by reference: a copy for each block would go through memory
        step_at<path, compensated, false>(
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
    for (StateRow<scalar>* state : {&a.from, &a.to})
        for (scalar** row : {&state->value[0], &state->value[1], &state->lost[0], &state->lost[1], &state->strain,
                             &state->rate, &state->previous})
            lead(*row, s.pitch);
    for (scalar*& row : r.response) lead(row, s.response_pitch);
    for (auto*& row : r.tiles) lead(row, s.tiles);
    s.stepped = s.stepped == 2 ? 0 : s.stepped + 1;
    s.answered = s.answered == 2 ? 0 : s.answered + 1;
    for (int i = 0; i < STEP_SIGNALS; ++i) {
        if (a.signal[i]) a.signal[i] = s.signal[i][s.stepped] + r.first;
        r.signal[QUANTITY_FA1 - QUANTITY_SA1 + i] = s.signal[i][s.answered];
    }
}

// The fused loop of step_rows: it steps a row and answers another one, row after row. The arguments are copied and
// their address is never passed on: the compiler then knows that no store changes them.
template <int stencil, Path path, bool compensated, bool chain, bool passed>
void step_rows_in(const RowSteps<Kernels>& given, const Constants& constants) {
    RowSteps<Kernels> s = given;
    const Constants c = constants;
    const AdvanceArguments<Kernels>& a = s.advance;
    const RespondArguments<Kernels>& r = s.respond;
    const int far = reach(stencil), begin = r.first < far ? min(r.first + line, r.last) : r.first,
              end = begin + max(min(r.last, r.strain.width - far) - begin, 0) / line * line;
    const EndCells<stencil> ends(r.strain);
    const LaneCoefficients k = lanes_of(chain ? a.table[0] : c.coefficients);
    constexpr int entries = entries_of(path);
    // a copy, because the compiler cannot know that no store changes a.table
    Coefficients table[entries * most_in_series];
    for (int n = 0; chain && n < entries * (a.elements + a.spring); ++n) table[n] = a.table[n];
    for (int row = 0; row < s.rows; ++row, lead_on(s)) {
        EndDifferences low, high;
        low.fill<stencil>(r.strain.here, ends, r.first, begin);
        high.fill<stencil>(r.strain.here, ends, end, r.last);
        const auto step_lines = [&](auto streams) __attribute__((always_inline)) {
            for (int x = begin; x < end; x += line) {
#pragma GCC unroll 8
                for (int i = 0; i < line; i += lanes)
                    step_between<path, compensated, chain>(a, x + i - r.first, c, k, table);
                respond_line<stencil, passed, streams.number>(r, x, c);
            }
        };
        with_bool(r.streams, step_lines);
        for (int side = 0; side < 2; ++side) {
            const scalar* along = (side ? high : low).values + lanes;
            for (int x = side ? end : r.first, last = side ? r.last : begin; x < last; x += lanes, along += lanes) {
                step_between<path, compensated, chain>(a, x - r.first, c, k, table);
                respond_block<passed>(r, x, min(last - x, lanes), curvature_at<stencil>(r, x, loaded(along), c), c);
            }
        }
    }
}

template <bool compensated, bool passed> void step_rows_for(const RowSteps<Kernels>& s, const Constants& c) {
    with_stencil(s.respond.strain.stencil, [&](auto stencil) {
        if (s.advance.to.previous) step_rows_in<stencil.number, Path::bent, compensated, true, passed>(s, c);
        else if (is_chain(s.advance)) step_rows_in<stencil.number, Path::linear, compensated, true, passed>(s, c);
        else step_rows_in<stencil.number, Path::linear, compensated, false, passed>(s, c);
    });
}

} // namespace blocks

int advance(const AdvanceArguments<Kernels>& a, const Constants& c) {
    using namespace blocks;
    const int changed = !a.pressure_to  ? advance_for<Path::held>(a, c)
                        : a.to.previous ? advance_for<Path::bent>(a, c)
                                        : advance_for<Path::linear>(a, c);
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

// Whether the fused loop serves: frames, a uniform material, and no sums.
bool in_blocks(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r) {
    bool serves = a.pressure_to && !a.material && !blocks::sums(r);
    for (int i = 0; i < RESPONSE_MAPS; ++i) serves = serves && (!r.streams || is_aligned(r.response[i] + r.first));
    return serves;
}

// Skins are pressed in f32, so only that has the fused loop. In f64 only a field between two outputs of a run could use
// it, and takes the two loops.
int step_rows(const RowSteps<Kernels>& given, const Constants& c) {
    if constexpr (std::is_same_v<scalar, float>)
        if (in_blocks(given.advance, given.respond)) {
            with_bool(given.advance.from.lost[sum_strain], [&](auto compensated) {
                with_bool(passes(c),
                          [&](auto passed) { blocks::step_rows_for<compensated.number, passed.number>(given, c); });
            });
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
