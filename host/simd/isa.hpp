// SPDX-License-Identifier: MIT
// The model over cells of a row, compiled once for each instruction set of the processor's family: same text, same
// bits.
#pragma once

#include "host/simd/model.hpp"

#include <cstddef>
#include <vector>

namespace dermis::simd {

template <class real> struct Of;
template <> struct Of<float> {
    using Constants = f32::Constants;
    using Coefficients = f32::Coefficients;
    using Summary = f32::Summary;
};
template <> struct Of<double> {
    using Constants = f64::Constants;
    using Coefficients = f64::Coefficients;
    using Summary = f64::Summary;
};

// A row of a map and the rows that a stencil looks at beside it, each from column 0 on; the weights of the published
// one.
template <class real> struct Lines {
    const real *far_low, *low, *here, *high, *far_high;
    real w_low, w_high, w;
    int width, stencil, edges; // as in kernels/layout.h
};

// Coefficients y of a map of which row(i) is row i.
template <class real, class RowOf> Lines<real> lines(int y, int width, int height, int stencil, int edges, RowOf row) {
    const f64::Axis a = f64::axis(y, height, stencil, edges);
    return {row(a.far_low), row(a.low), row(y),  row(a.high), row(a.far_high), real(a.w_low), real(a.w_high),
            real(a.w),      width,      stencil, edges};
}

// `count` cells of a row, one step on. In place or not: state_to may be the same as state_from. Null: q without frames,
// material and table under a uniform material, what sums have lost unless compensated. Returns which of strain (1) and
// integral (2) are not what they were in some cell.
template <class real> struct Advance {
    int count;
    const real *p, *q; // pressure, or the pressures it runs between
    const int* material;
    const typename Of<real>::Coefficients* table;
    const real *eps, *sum, *eps_lost, *sum_lost;
    real *eps_to, *sum_to, *eps_lost_to, *sum_lost_to;
    real *rate, *acceleration; // at the step's end
};

// Responses of columns first .. last - 1, first a multiple of TILE_CELLS. Everything is from column 0 on.
template <class real> struct Respond {
    int first, last;
    Lines<real> after; // strain
    const real *sum, *rate, *acceleration, *rest;
    real* response[4];                               // null: not kept
    typename Of<real>::Summary* tiles[REDUCED_MAPS]; // null: not asked for
};

// A line through the point (b, a) along which (along_b, along_a) runs.
struct Edge {
    double b, a, along_b, along_a;
};

constexpr int fence_edges = 8;

// Sums by columns over rows of p, a and b (see host/reduced/moments.hpp), and the range of p.
struct Columns {
    double *p, *a, *b, *least, *greatest;
};

template <class real> struct Loops {
    void (*laplacian)(const Lines<real>&, int first, int last, real* L);
    int (*advance)(const Advance<real>&, const typename Of<real>::Constants&);
    void (*respond)(const Respond<real>&, const typename Of<real>::Constants&);
};

struct Isa {
    const char* name;
    bool (*supported)(); // whether this processor has it
    Loops<float> f32;
    Loops<double> f64;
    // a = p*(1 + length*rest) and b = p*(length*(bend*L)) of `width` cells, added to sums
    void (*shape)(const double* p, const double* rest, const double* L, int width, double length, double bend,
                  double* a, double* b, const Columns& sums);
    void (*means)(const double* p, const double* rest, const double* L, int width, double length, double bend,
                  const Columns& sums); // p, a, b alone
    // How far each point (b[x], a[x]) lies to the left of the edge that it is furthest to the left of, of fence_edges;
    // true where some point is to the left of one.
    bool (*beside)(const double* a, const double* b, int width, const Edge* edges, double* way);
    // Widens the greatest |five - fourth|, |five| and |own| or |rest| of each column; true where the first is beyond
    // half of |five| somewhere.
    bool (*compare)(const double* five, const double* fourth, const double* own, const double* rest, int width,
                    double* differ, double* bent, double* curved);
    void (*fence_streams)(); // what loops have written can be read by other threads

    template <class real> const Loops<real>& of() const {
        if constexpr (sizeof(real) == 4) return f32;
        else return f64;
    }
};

extern const Isa plain;
#ifdef DERMIS_X86_64
extern const Isa avx2, avx512;
#endif

const std::vector<const Isa*>& isas(); // this processor's, plain last
inline const Isa& best() { return *isas().front(); }

} // namespace dermis::simd
