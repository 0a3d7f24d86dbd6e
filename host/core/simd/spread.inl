// SPDX-License-Identifier: MIT
// The passes of kernels/spread.h over a row of nodes, a register at a time. blocks.inl precedes this in its namespace.
// `beside` is the number of pads whose nodes stand side by side: 1, or a register of them; then a node's neighbour is a
// register away, and no lane moves. Rows of levels have zeros around them; what a register computes behind a row's end
// is 0, or is not written.

namespace blocks {

constexpr auto even_lane = [](int i) { return 2 * i; };
constexpr auto odd_lane = [](int i) { return 2 * i + 1; };
template <int half> constexpr auto zipped = [](int i) { return half * lanes / 2 + i / 2 + i % 2 * lanes; };

// Where the register behind the one at i begins in a row of n numbers: the last register ends with the row.
inline int behind(int i, int n) { return i + lanes >= n ? n : std::min(i + lanes, n - lanes); }
inline real loaded_part(const scalar* from, int n) {
    if (n >= lanes) return loaded(from);
    Wide x(scalar(0));
    for (int i = 0; i < n; ++i) x.v[i] = from[i];
    return x;
}
inline void store_part(scalar* to, real x, int n) {
    if (n >= lanes) return store(to, x);
    for (int i = 0; i < n; ++i) to[i] = x.v[i];
}

template <int beside> void halve_in(const HalveRow<Kernels>& h) {
    const int n = (h.high - h.low + 1) * beside;
    for (int i = 0; i < n; i = behind(i, n)) {
        real r[7];
#pragma GCC unroll 7
        for (int k = 0; k < 7; ++k) r[k] = loaded_part(h.row[k] + i, n);
        store(h.column + i, halved(r[0], r[1], r[2], r[3], r[4], r[5], r[6]));
    }
    for (int i = std::max(n, lanes); i < n + 6 * lanes + 8 * beside; i += lanes) store(h.column + i, Wide(scalar(0)));
    const scalar* v = h.column + (2 * h.coarse_low - h.low) * beside; // the column of the first coarse node
    const auto node = [&](int i) { return loaded(v + i * beside); };
    if constexpr (beside > 1) {
        for (int k = 0; k < h.count; ++k)
            store(h.to + k * beside, halved(node(2 * k - 3), node(2 * k - 2), node(2 * k - 1), node(2 * k),
                                            node(2 * k + 1), node(2 * k + 2), node(2 * k + 3)));
    } else {
        for (int k = -lanes; k < h.count + lanes; k += lanes) {
            const auto a = loaded(v + 2 * k).v, b = loaded(v + 2 * k + lanes).v;
            store(h.even + k, Wide(picked<lanes, decltype(even_lane)>(a, b)));
            store(h.odd + k, Wide(picked<lanes, decltype(odd_lane)>(a, b)));
        }
        for (int k = 0; k < h.count; k += lanes)
            store(h.to + k,
                  halved(loaded(h.odd + k - 2), loaded(h.even + k - 1), loaded(h.odd + k - 1), loaded(h.even + k),
                         loaded(h.odd + k), loaded(h.even + k + 1), loaded(h.odd + k + 1)));
    }
}

// Nodes 2k and 2k + 1 of the finer level for k = 0 .. pairs - 1.
template <int beside> void widen_in(const scalar* from, int pairs, scalar* to) {
    for (int k = 0; k<pairs; k += beside> 1 ? 1 : lanes) {
        const scalar* at = from + k * beside;
        const real b = loaded(at - beside), c = loaded(at), d = loaded(at + beside), e = loaded(at + 2 * beside),
                   first = at_node(b, c, d), second = between_nodes(b, c, d, e);
        scalar* pair = to + 2 * k * beside;
        store(pair, beside > 1 ? first : Wide(picked<lanes, decltype(zipped<0>)>(first.v, second.v)));
        store(pair + lanes, beside > 1 ? second : Wide(picked<lanes, decltype(zipped<1>)>(first.v, second.v)));
    }
}

// The stencil's sum at the nodes from `i` on.
template <int radius, int beside> inline real stencil_of(const SpreadRow<Kernels>& s, const real* weight, int i) {
    real sum(scalar(0));
#pragma GCC unroll 8
    for (int b = 0; b <= radius; ++b) {
        const scalar* v = (b > 0 ? s.fold[b] : s.here) + i;
        const real* w = weight + b * (radius + 1);
        real row = weighted(w[0], loaded(v));
#pragma GCC unroll 8
        for (int a = 1; a <= radius; ++a)
            row = together(row, weighted(w[a], together(loaded(v - a * beside), loaded(v + a * beside))));
        sum = b > 0 ? together(sum, row) : row;
    }
    return sum;
}

// radius: -1 for a level without a stencil.
template <int radius, int beside> void spread_in(const SpreadRow<Kernels>& s, const Constants& c) {
    const int n = s.count * beside;
    constexpr int edge = (radius * beside + lanes - 1) / lanes * lanes;
    for (int b = 1; b <= radius; ++b)
        for (int i = -edge; i < n + edge; i += lanes)
            store(s.fold[b] + i, together(loaded(s.low[b] + i), loaded(s.high[b] + i)));
    constexpr int weights = radius < 0 ? 1 : (radius + 1) * (radius + 1);
    real weight[weights];
    for (int k = 0; radius >= 0 && k < weights; ++k) weight[k] = Wide(s.weight[k]);
    with_bool(s.odd, [&](auto odd) {
        for (int i = 0; i < n; i = behind(i, n)) {
            real sum(scalar(0));
            if constexpr (radius >= 0) sum = stencil_of<radius, beside>(s, weight, i);
            else if (!s.wide[0]) sum = loaded_part(s.here + i, n); // the skin's surface
            if (s.wide[0]) {
                const real b = loaded(s.wide[0] + i), m = loaded(s.wide[1] + i), d = loaded(s.wide[2] + i);
                const real up = odd.number ? between_nodes(b, m, d, loaded(s.wide[3] + i)) : at_node(b, m, d);
                sum = radius >= 0 ? together(sum, up) : up;
            }
            if (s.quantity) sum = answer(s.quantity, sum, s.gain ? loaded_part(s.gain + i, n) : real(scalar(1)), c);
            store_part(s.to + i, sum, n);
        }
    });
}

template <int beside, int radius = 7> void spread_by(const SpreadRow<Kernels>& s, const Constants& c) {
    if (s.radius == radius) return spread_in<radius, beside>(s, c);
    if constexpr (radius >= 0) spread_by<beside, radius - 1>(s, c);
}

// The gain of a row of cells in pads that stand side by side.
void gain_beside(const RowNeighbours<scalar>& l, const scalar* rest, const Constants& c, scalar* gain) {
    for (int x = 0; x < l.width; ++x) {
        const auto a = Kernels::axis(x, l.width, l.stencil, l.edges);
        Axis weights{};
        weights.w_low = Wide(a.w_low), weights.w_high = Wide(a.w_high), weights.w = Wide(a.w);
        const auto at = [x](const scalar* row) { return loaded(row + x * lanes); };
        const auto in_row = [&](int i) { return loaded(l.here + i * lanes); };
        const real L =
            add(difference(in_row(a.far_low), in_row(a.low), in_row(x), in_row(a.high), in_row(a.far_high), weights,
                           l.stencil),
                difference(at(l.far_low), at(l.low), at(l.here), at(l.high), at(l.far_high), across(l), l.stencil));
        store(gain + x * lanes, gain_at(curvature_of(Wide(rest[x]), L, c.bend), c));
    }
}

// Turns a square of lanes x lanes numbers, halves of halves at a time.
template <int reach = lanes / 2> inline void turn(Wide (&rows)[lanes]) {
    if constexpr (reach > 0) {
        constexpr auto low = [](int i) { return i & reach ? lanes + i - reach : i; };
        constexpr auto high = [](int i) { return i & reach ? lanes + i : i + reach; };
#pragma GCC unroll 16
        for (int i = 0; i < lanes; ++i)
            if (!(i & reach)) {
                const auto a = rows[i].v, b = rows[i + reach].v;
                rows[i].v = picked<lanes, decltype(low)>(a, b);
                rows[i + reach].v = picked<lanes, decltype(high)>(a, b);
            }
        turn<reach / 2>(rows);
    }
}

} // namespace blocks

void halve_row(const HalveRow<Kernels>& h) {
    h.beside > 1 ? blocks::halve_in<blocks::lanes>(h) : blocks::halve_in<1>(h);
    end_vector_code();
}

void widen_row(const real* from, int pairs, int beside, real* to) {
    beside > 1 ? blocks::widen_in<blocks::lanes>(from, pairs, to) : blocks::widen_in<1>(from, pairs, to);
    end_vector_code();
}

void spread_row(const SpreadRow<Kernels>& s, const Constants& c) {
    s.beside > 1 ? blocks::spread_by<blocks::lanes>(s, c) : blocks::spread_by<1>(s, c);
    end_vector_code();
}

void gain_row(const RowNeighbours<real>& l, int beside, const real* rest, const Constants& c, real* gain) {
    if (beside > 1) {
        blocks::gain_beside(l, rest, c, gain);
    } else {
        laplacian_over(l, 0, l.width, gain);
#pragma GCC ivdep
        for (int x = 0; x < l.width; ++x) gain[x] = gain_at(curvature_of(rest[x], gain[x], c.bend), c);
    }
    end_vector_code();
}

// Copies the maps of pads, `count` numbers each, to where they stand side by side, or back.
void to_beside(const real* const* pads, int count, real* to) {
    using namespace blocks;
    int i = 0;
    for (; i + lanes <= count; i += lanes) {
        Wide rows[lanes];
        for (int p = 0; p < lanes; ++p) rows[p] = blocks::loaded(pads[p] + i);
        turn(rows);
        for (int k = 0; k < lanes; ++k) blocks::store(to + (i + k) * lanes, rows[k]);
    }
    for (; i < count; ++i)
        for (int p = 0; p < lanes; ++p) to[i * lanes + p] = pads[p][i];
    end_vector_code();
}
void from_beside(const real* from, int count, real* const* pads) {
    using namespace blocks;
    int i = 0;
    for (; i + lanes <= count; i += lanes) {
        Wide rows[lanes];
        for (int k = 0; k < lanes; ++k) rows[k] = blocks::loaded(from + (i + k) * lanes);
        turn(rows);
        for (int p = 0; p < lanes; ++p) blocks::store(pads[p] + i, rows[p]);
    }
    for (; i < count; ++i)
        for (int p = 0; p < lanes; ++p) pads[p][i] = from[i * lanes + p];
    end_vector_code();
}
