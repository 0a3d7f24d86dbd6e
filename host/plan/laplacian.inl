// SPDX-License-Identifier: MIT
// The Laplacian of a stored map, in the `real` of the namespace that includes this: gather.h, and the same bits faster
// for a run of columns.

struct Stored {
    const real* map;
    int pitch, width, height, stencil, edges;
    real strain_at(int x, int y) const { return map[size_t(y) * pitch + x]; }
#include "kernels/gather.h"

    real laplacian_at(int x, int y) const {
        Stored look = *this; // GLSL knows no const member
        const real centre = strain_at(x, y);
        return add(look.laplacian_along_x(x, y, centre, width, stencil, edges),
                   look.laplacian_along_y(x, y, centre, height, stencil, edges));
    }

    // Columns first .. last - 1 of row y.
    void laplacian(int y, int first, int last, real* __restrict L) const {
        const int reach = stencil == STENCIL_FIVE_POINT ? 1 : 2;
        const int begin = std::min(std::max(first, reach), last), end = std::max(std::min(last, width - reach), begin);
        for (int x = first; x < begin; ++x) L[x - first] = laplacian_at(x, y);
        if (stencil == STENCIL_FIVE_POINT) inner<STENCIL_FIVE_POINT>(y, begin, end, L + (begin - first));
        else if (stencil == STENCIL_FOURTH_ORDER) inner<STENCIL_FOURTH_ORDER>(y, begin, end, L + (begin - first));
        else inner<STENCIL_PUBLISHED>(y, begin, end, L + (begin - first));
        for (int x = end; x < last; ++x) L[x - first] = laplacian_at(x, y);
    }

  private:
    // Away from the ends of a row every cell looks at the same distances, so loops vectorize.
    template <int kind> void inner(int y, int begin, int end, real* __restrict L) const {
        if (begin >= end) return;
        const Axis across = axis(y, height, kind, edges);
        const auto row = [&](int at) { return map + size_t(at) * pitch + begin; };
        const real *here = row(y), *far_low = row(across.far_low), *low = row(across.low), *high = row(across.high),
                   *far_high = row(across.far_high);
        Axis along = across; // the weights of an inner cell
        along.w_low = along.w_high = along.w = real(0.5);
        for (int i = 0; i < end - begin; ++i) {
            if constexpr (kind == STENCIL_FIVE_POINT)
                L[i] = add(second_difference(here[i - 1], here[i], here[i + 1]),
                           second_difference(low[i], here[i], high[i]));
            else if constexpr (kind == STENCIL_FOURTH_ORDER)
                L[i] = add(fourth_order(here[i - 2], here[i - 1], here[i], here[i + 1], here[i + 2]),
                           fourth_order(far_low[i], low[i], here[i], high[i], far_high[i]));
            else
                L[i] = add(published_difference(here[i - 2], here[i], here[i], here[i + 2], along),
                           published_difference(far_low[i], low[i], high[i], far_high[i], across));
        }
    }
};
