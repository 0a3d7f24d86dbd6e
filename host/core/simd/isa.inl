// SPDX-License-Identifier: MIT
// The loops of one instruction set. Everything here has internal linkage, and nothing of the standard library or GLM is
// called: code for one processor must never be shared with code for all.
#include "host/core/simd/isa.hpp"

#if defined(__AVX__) || defined(__SSE2__)
#include <immintrin.h>
#endif

namespace dermis::simd {
namespace {

constexpr int chunk = 4 * TILE_CELLS; // columns at a time; their intermediate values stay in the first-level cache

// A register of this instruction set, and its store past the caches, to an address that is a multiple of its size.
#if defined(__AVX512F__)
using Register = __m512i;
inline void stream_register(void* to, Register x) { _mm512_stream_si512(static_cast<__m512i*>(to), x); }
#elif defined(__AVX__)
using Register = __m256i;
inline void stream_register(void* to, Register x) { _mm256_stream_si256(static_cast<__m256i*>(to), x); }
#elif defined(__SSE2__)
using Register = __m128i;
inline void stream_register(void* to, Register x) { _mm_stream_si128(static_cast<__m128i*>(to), x); }
#else
typedef long long Register __attribute__((vector_size(16)));
inline void stream_register(void* to, Register x) { __builtin_memcpy(to, &x, sizeof x); }
#endif

bool is_aligned(const void* address) { return reinterpret_cast<size_t>(address) % sizeof(Register) == 0; }

// Copies past the caches if alignment and size allow it, because nobody reads responses again soon.
void stream(void* to, const void* from, size_t bytes) {
    if (!is_aligned(to) || bytes % sizeof(Register) != 0) {
        __builtin_memcpy(to, from, bytes);
        return;
    }
    for (size_t i = 0; i < bytes; i += sizeof(Register)) {
        Register x;
        __builtin_memcpy(&x, static_cast<const char*>(from) + i, sizeof x);
        stream_register(static_cast<char*>(to) + i, x);
    }
}

void fence_streams() {
#ifdef __SSE2__
    _mm_sfence();
#endif
}

// Every loop that other files call ends with this: code for all processors stalls for hundreds of cycles on registers
// that are still wide, and GCC 12 does not always insert the instruction itself.
inline void end_vector_code() {
#ifdef __AVX__
    _mm256_zeroupper();
#endif
}

inline int min(int a, int b) { return b < a ? b : a; }
inline int max(int a, int b) { return a < b ? b : a; }

namespace loops_f32 {
using Kernels = f32;
using real = float;
inline real abs(real x) { return __builtin_fabsf(x); }
#include "host/core/simd/rows.inl"

#include "host/core/simd/blocks.inl"

#include "host/core/simd/fibres.inl"

#include "host/core/simd/spread.inl"

#include "host/core/simd/pads.inl"
} // namespace loops_f32

namespace loops_f64 {
using Kernels = f64;
using real = double;
inline real abs(real x) { return __builtin_fabs(x); }
#include "host/core/simd/rows.inl"

#include "host/core/simd/blocks.inl"

#include "host/core/simd/fibres.inl"

#include "host/core/simd/spread.inl"
} // namespace loops_f64

// Adds to a column's sum.
inline void add(const LongSums& sums, int x, double value) {
    const f64::LongSum s = f64::joined({sums.sum[x], sums.rest[x]}, {value, 0});
    sums.sum[x] = s.sum;
    sums.rest[x] = s.rest;
}

void moments(const double* p, const double* rest, const double* L, int width, double length, double bend, double* a,
             double* b, const ColumnSums& sums) {
#pragma GCC ivdep
    for (int x = 0; x < width; ++x) {
        a[x] = p[x] * (1 + length * rest[x]);
        b[x] = p[x] * (length * (bend * L[x]));
        add(sums.p, x, p[x]);
        add(sums.a, x, a[x]);
        add(sums.b, x, b[x]);
        sums.least[x] = p[x] < sums.least[x] ? p[x] : sums.least[x];
        sums.greatest[x] = sums.greatest[x] < p[x] ? p[x] : sums.greatest[x];
    }
    end_vector_code();
}

// moments() without a and b, with the same bits in the sums.
void means(const double* p, const double* rest, const double* L, int width, double length, double bend,
           const ColumnSums& sums) {
#pragma GCC ivdep
    for (int x = 0; x < width; ++x) {
        add(sums.p, x, p[x]);
        add(sums.a, x, p[x] * (1 + length * rest[x]));
        add(sums.b, x, p[x] * (length * (bend * L[x])));
    }
    end_vector_code();
}

bool outside(const double* a, const double* b, int width, const HalfPlane* edges, double* distance) {
    HalfPlane k[polygon_edges];
    for (int e = 0; e < polygon_edges; ++e) k[e] = edges[e];
    long long any = 0;
#pragma GCC ivdep
    for (int x = 0; x < width; ++x) {
        double furthest = (a[x] - k[0].a) * k[0].along_b - (b[x] - k[0].b) * k[0].along_a;
#pragma GCC unroll 8
        for (int e = 1; e < polygon_edges; ++e) {
            const double left = (a[x] - k[e].a) * k[e].along_b - (b[x] - k[e].b) * k[e].along_a;
            furthest = left < furthest ? furthest : left;
        }
        distance[x] = furthest;
        any |= furthest > 0;
    }
    end_vector_code();
    return any != 0;
}

bool compare(const double* five, const double* fourth, const double* own, const double* rest, int width, double* differ,
             double* bent, double* curved) {
    long long kinked = 0;
#pragma GCC ivdep
    for (int x = 0; x < width; ++x) {
        const double differs = __builtin_fabs(five[x] - fourth[x]), bend = __builtin_fabs(five[x]);
        const double C = __builtin_fabs(own[x]), R = __builtin_fabs(rest[x]), larger = C < R ? R : C;
        differ[x] = differ[x] < differs ? differs : differ[x];
        bent[x] = bent[x] < bend ? bend : bent[x];
        curved[x] = curved[x] < larger ? larger : curved[x];
        kinked |= differs > bend / 2;
    }
    end_vector_code();
    return kinked != 0;
}

bool supported() { return DERMIS_SUPPORTED; }

#define DERMIS_TEXT(x) #x
#define DERMIS_NAME(x) DERMIS_TEXT(x)

#define DERMIS_LOOPS(of)                                                                                               \
    {                                                                                                                  \
        .laplacian = of::laplacian, .advance = of::advance, .respond = of::respond, .join_tiles = of::join_tiles,      \
        .step_rows = of::step_rows, .press_fibres = of::fibres::press, .beside = of::blocks::lanes,                    \
        .halve_row = of::halve_row, .widen_row = of::widen_row, .spread_row = of::spread_row,                          \
        .gain_row = of::gain_row, .to_beside = of::to_beside, .from_beside = of::from_beside                           \
    }

} // namespace

const Isa DERMIS_ISA = {
    .name = DERMIS_NAME(DERMIS_ISA),
    .supported = supported,
    .in_f32 = DERMIS_LOOPS(loops_f32),
    .in_f64 = DERMIS_LOOPS(loops_f64),
    .respond_pads = loops_f32::respond_pads,
    .moments = moments,
    .means = means,
    .outside = outside,
    .compare = compare,
    .fence_streams = fence_streams,
};

} // namespace dermis::simd
