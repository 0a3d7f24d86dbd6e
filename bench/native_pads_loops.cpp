// SPDX-License-Identifier: MIT
#include "bench/native_pads_loops.hpp"

#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace bench::native {
namespace {

#if defined(__AVX512F__)
constexpr size_t lanes = 16;
#elif defined(__AVX__)
constexpr size_t lanes = 8;
#else
constexpr size_t lanes = 4;
#endif
typedef float Vector __attribute__((vector_size(4 * lanes)));
typedef int Mask __attribute__((vector_size(4 * lanes)));
typedef Vector Unaligned __attribute__((may_alias, aligned(4)));
typedef Mask UnalignedMask __attribute__((may_alias, aligned(4)));

Vector load(const float* p) { return *reinterpret_cast<const Unaligned*>(p); }
Mask load(const int* p) { return *reinterpret_cast<const UnalignedMask*>(p); }
void store(float* p, Vector x) { *reinterpret_cast<Unaligned*>(p) = x; }
Vector absolute(Vector x) { return (Vector)((Mask)x & 0x7fffffff); }
Vector flushed(Vector x) { return absolute(x) < 5.421010862427522e-20f ? Vector{} : x; }

inline void advance(const PadStep& k, Vector from, Vector to, float* strain, float* integral, float* rate,
                    float* acceleration) {
    const Vector way = to - from, s = from + k.start * way, ds = k.rise * way, x = load(strain), y = load(integral);
    const Vector r = s - k.E * x, stepped = k.b * r + k.f * ds, gained = (k.i0 * x + k.i1 * s) + k.i2 * ds;
    store(rate, k.v0 * r + k.v1 * ds);
    store(acceleration, (k.a0 * r + k.a1 * ds) + k.a2 * (k.jump * from));
    store(strain, flushed(x + stepped));
    store(integral, flushed(y + (gained - k.leak * y)));
}

inline void store_some(float* p, Vector x, size_t n) {
#ifdef __AVX512F__
    _mm512_mask_storeu_ps(p, __mmask16((1u << n) - 1), (__m512)x);
#else
    for (size_t i = 0; i < n; ++i) p[i] = x[i];
#endif
}

inline void answer(const PadBatch& p, const PadStep& k, size_t i, size_t n, const float* strain, const float* integral,
                   const float* scratch, float* const (&responses)[4]) {
    const Vector x = load(strain + i);
    const Vector left = load(p.inside[0] + i) ? load(strain + i - 1) : x,
                 right = load(p.inside[1] + i) ? load(strain + i + 1) : x,
                 above = load(p.inside[2] + i) ? load(strain + i - p.width) : x,
                 below = load(p.inside[3] + i) ? load(strain + i + p.width) : x;
    const Vector laplacian = ((right - x) + (left - x)) + ((below - x) + (above - x)),
                 C = load(p.rest + i) - k.bend * laplacian, gain = 1.0f + k.length * C;
    const Vector signals[4] = {x, load(integral + i), load(scratch + i), load(scratch + p.pitch + i)};
    for (size_t q = 0; q < 4; ++q)
        if (n == lanes) store(responses[q] + i, flushed(signals[q] * gain));
        else store_some(responses[q] + i, flushed(signals[q] * gain), n);
}

} // namespace

bool take_pads(const PadBatch& p, size_t first, size_t last, const float* pressure) {
    Mask bad{};
    for (size_t pad = first; pad < last; ++pad) {
        const float* from = pressure + pad * p.cells;
        float* to = p.to + pad * p.pitch;
        size_t i = 0;
        for (; i + lanes <= p.cells; i += lanes) {
            const Vector x = load(from + i);
            bad |= ~(absolute(x) < __builtin_inff());
            store(to + i, x);
        }
        for (; i < p.cells; ++i) {
            bad[0] |= __builtin_isfinite(from[i]) ? 0 : 1;
            to[i] = from[i];
        }
    }
    for (size_t i = 1; i < lanes; ++i) bad[0] |= bad[i];
    return bad[0] == 0;
}

void press_pads(const PadBatch& p, size_t first, size_t last, float* scratch) {
    const PadStep k = p.step;
    for (size_t pad = first; pad < last; ++pad) {
        float *strain = p.strain + pad * p.pitch, *integral = p.integral + pad * p.pitch;
        const float *from = p.from + pad * p.pitch, *to = p.to + pad * p.pitch;
        for (size_t i = 0; i < p.pitch; i += lanes)
            advance(k, load(from + i), load(to + i), strain + i, integral + i, scratch + i, scratch + p.pitch + i);
        float* responses[4];
        for (size_t q = 0; q < 4; ++q) responses[q] = p.responses[q] + pad * p.cells;
        size_t i = 0;
        for (; i + lanes <= p.cells; i += lanes) answer(p, k, i, lanes, strain, integral, scratch, responses);
        if (i < p.cells) answer(p, k, i, p.cells - i, strain, integral, scratch, responses);
    }
}

} // namespace bench::native
