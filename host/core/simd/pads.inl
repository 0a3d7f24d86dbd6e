// SPDX-License-Identifier: MIT
// The responses of pads, a register of cells at a time. blocks.inl precedes this in its namespace. The last register of
// a pad ends at the pad's last cell, and takes some cells again where a pad is no multiple of it.

namespace blocks {

// Neighbour n of a stencil of each cell of a block. strain: of the block's first cell. here: of all its cells.
template <int stencil, int n, bool mirrored>
inline real neighbour(const PadResponses& p, const scalar* strain, real here, Wide::Mask edge) {
    constexpr int near = stencil == STENCIL_PUBLISHED ? 0 : 1, far = n % 4 == 0 || n % 4 == 3 ? 2 : near;
    const int inner = (n % 4 < 2 ? -far : far) * (n < 4 ? 1 : p.width);
    real x = loaded(strain + inner);
#pragma GCC unroll 2
    for (int i = 0; i < (far > 1 ? 2 : 1); ++i)
        x = mix(x, mirrored ? here : loaded(strain + p.edge_distance[n][i]), (edge & 1 << (2 * n + i)) != 0);
    return x;
}

// The second difference along a row (first = 0) or across rows (first = 4). i: the block's first cell.
template <int stencil, int first, bool mirrored>
inline real difference_of_pad(const PadResponses& p, int i, real here, Wide::Mask edge) {
    const scalar* strain = p.strain + i;
    real far_low = here, far_high = here; // not read within one cell
    Axis a{};
    if constexpr (stencil != STENCIL_FIVE_POINT) {
        far_low = neighbour<stencil, first, false>(p, strain, here, edge);
        far_high = neighbour<stencil, first + 3, false>(p, strain, here, edge);
    }
    if constexpr (stencil == STENCIL_PUBLISHED) {
        const scalar* const* w = p.weight + first / 4 * 3;
        a.w_low = loaded(w[0] + i);
        a.w_high = loaded(w[1] + i);
        a.w = loaded(w[2] + i);
    }
    return difference(far_low, neighbour<stencil, first + 1, mirrored>(p, strain, here, edge), here,
                      neighbour<stencil, first + 2, mirrored>(p, strain, here, edge), far_high, a, stencil);
}

template <int stencil, bool passed, bool mirrored> void respond_pads_in(const PadResponses given, const Constants c) {
    PadResponses p = given;
    for (int pad = 0; pad < p.pads; ++pad) {
        for (int block = 0; block < p.cells; block += lanes) {
            const int i = max(min(block, p.cells - lanes), 0);
            const real here = loaded(p.strain + i);
            const Wide::Mask edge = (Wide::Mask)loaded(reinterpret_cast<const scalar*>(p.edge + i)).v;
            const real along = difference_of_pad<stencil, 0, mirrored>(p, i, here, edge),
                       across = difference_of_pad<stencil, 4, mirrored>(p, i, here, edge),
                       gain = gain_at(curvature_of(loaded(p.rest_curvature + i), add(along, across), c.bend), c);
#pragma GCC unroll 8
            for (int q = 0; q < RESPONSE_MAPS; ++q) {
                if (!p.response[q]) continue;
                const real answered = answer_of<passed>(QUANTITY_SA1 + q, loaded(p.signal[q] + i), gain, c);
                if (p.cells >= lanes) store(p.response[q] + i, answered);
                else
                    for (int lane = 0; lane < p.cells; ++lane) p.response[q][lane] = answered.v[lane];
            }
        }
        p.strain += p.pitch;
        for (int q = 0; q < RESPONSE_MAPS; ++q) {
            if (!p.response[q]) continue;
            p.signal[q] += p.pitch;
            p.response[q] += p.cells;
        }
    }
}

} // namespace blocks

void respond_pads(const PadResponses& p, const Constants& c) {
    with_bool(passes(c), [&](auto passed) {
        with_stencil(p.stencil, [&](auto stencil) {
            if (stencil.number == STENCIL_FIVE_POINT && p.mirrored)
                blocks::respond_pads_in<stencil.number, passed.number, true>(p, c);
            else blocks::respond_pads_in<stencil.number, passed.number, false>(p, c);
        });
    });
    end_vector_code();
}
