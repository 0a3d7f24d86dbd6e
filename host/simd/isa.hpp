// SPDX-License-Identifier: MIT
// The model over the cells of a row, compiled once for each instruction set of the processor's family: same text, same
// bits.
#pragma once

#include "host/simd/model.hpp"

#include <cstddef>
#include <vector>

namespace dermis::simd {

// Row y of a map and the rows that a stencil reads beside it, each from column 0 on, with the weights of the published
// stencil across them.
template <class real> struct RowNeighbours {
    const real *far_low, *low, *here, *high, *far_high;
    real w_low, w_high, w;
    int width, stencil, edges; // as in kernels/layout.h
};

// row(i) is where row i of the map begins. The nearest stencil has no far rows: its near ones stand in their place.
template <class real, class RowOf>
RowNeighbours<real> neighbours(int y, int width, int height, int stencil, int edges, RowOf row) {
    const f64::Axis a = f64::axis(y, height, stencil, edges);
    const bool far = f64::reach(stencil) > 1;
    return {.far_low = row(far ? a.far_low : a.low),
            .low = row(a.low),
            .here = row(y),
            .high = row(a.high),
            .far_high = row(far ? a.far_high : a.high),
            .w_low = real(a.w_low),
            .w_high = real(a.w_high),
            .w = real(a.w),
            .width = width,
            .stencil = stencil,
            .edges = edges};
}

// `count` cells of a row, one step on. The new state may be written in place of the old one. Null: pressure_to without
// frames; material and table under a uniform material; what sums have lost unless they are compensated.
template <class K> struct AdvanceArguments {
    using real = typename K::real;
    int count;
    const real *pressure, *pressure_to; // between frames the pressure runs from one to the other
    const int* material;
    const typename K::Coefficients* table;
    const real *strain, *integral, *strain_lost, *integral_lost;
    real *new_strain, *new_integral, *new_strain_lost, *new_integral_lost;
    real *rate, *acceleration; // at the step's end
};
// What an advance reports: whether strain or integral changed in some cell.
constexpr int strain_changed = 1, integral_changed = 2;

// The responses of columns first .. last - 1, first a multiple of TILE_CELLS. Rows are given from column 0 on.
template <class K> struct RespondArguments {
    using real = typename K::real;
    int first, last;
    RowNeighbours<real> strain; // at the step's end
    const real *integral, *rate, *acceleration, *rest_curvature;
    real* response[4];                        // null: not kept
    typename K::Summary* tiles[REDUCED_MAPS]; // null: not asked for
};

// The line through the point (b, a) along (along_b, along_a), and all that lies to its right.
struct HalfPlane {
    double b, a, along_b, along_a;
};

constexpr int polygon_edges = 8;

// Sums by columns over rows of p, a and b (see host/reduced/moments.hpp), and the range of p.
struct ColumnSums {
    double *p, *a, *b, *least, *greatest;
};

template <class K> struct Loops {
    using real = typename K::real;
    void (*laplacian)(const RowNeighbours<real>&, int first, int last, real* L);
    int (*advance)(const AdvanceArguments<K>&, const typename K::Constants&);
    void (*respond)(const RespondArguments<K>&, const typename K::Constants&);
};

// One instruction set.
struct Isa {
    const char* name;
    bool (*supported)(); // by this processor
    Loops<f32> in_f32;
    Loops<f64> in_f64;
    // a = p*(1 + length*rest) and b = p*(length*(bend*L)) of `width` cells, added to sums
    void (*moments)(const double* p, const double* rest, const double* L, int width, double length, double bend,
                    double* a, double* b, const ColumnSums& sums);
    void (*means)(const double* p, const double* rest, const double* L, int width, double length, double bend,
                  const ColumnSums& sums); // the sums of p, a, b alone
    // way[x] = greatest signed distance of the point (b[x], a[x]) to the edges, of which there are polygon_edges;
    // positive: outside the polygon. Returns whether some point is outside.
    bool (*outside)(const double* a, const double* b, int width, const HalfPlane* edges, double* way);
    // Updates the column maxima of |five - fourth|, |five| and max(|own|, |rest|). Returns whether some cell is a kink:
    // |five - fourth| > |five|/2.
    bool (*compare)(const double* five, const double* fourth, const double* own, const double* rest, int width,
                    double* differ, double* bent, double* curved);
    void (*fence_streams)(); // makes what the loops have streamed past the caches visible to other threads

    template <class K> const Loops<K>& of() const {
        if constexpr (std::is_same_v<K, f32>) return in_f32;
        else return in_f64;
    }
};

extern const Isa plain;
#ifdef DERMIS_X86_64
extern const Isa avx2, avx512;
#endif

const std::vector<const Isa*>& isas(); // those that this processor supports, plain last
inline const Isa& best() { return *isas().front(); }

} // namespace dermis::simd
