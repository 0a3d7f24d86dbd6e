// SPDX-License-Identifier: MIT
// A press of nerve fibres, in registers of neighbouring fibres. blocks.inl precedes this in its namespace. Each substep
// is taken twice: all fibres in a straight step, and those to which something may happen again, gathered into full
// registers, from event to event.

namespace fibres {

using real = Wide;
using mask = Wide::Mask;
using FibreConstants = Kernels::FibreConstants;
using FibreEntry = Kernels::FibreEntry;
constexpr int lanes = blocks::lanes;
inline mask both(mask a, mask b) { return a & b; }
inline mask either(mask a, mask b) { return a | b; }
inline mask differ(mask a, mask b) { return a ^ b; }
inline mask negated(mask a) { return ~a; }
inline bool some(mask a) { return blocks::any<lanes>(a); }
// clang-format off
#include "kernels/prelude.h"
#include "kernels/afferent.h"
// clang-format on
#undef precise
#undef OF_ANY_CELL
#undef FIBRE_ROW

constexpr int together = 1024; // fibres whose planes stay in the first-level cache
using Arguments = FibreArguments<Kernels>;

// A bit for each lane that is set.
inline unsigned lanes_set(mask m) {
#if defined(__AVX512F__)
    if constexpr (sizeof(scalar) == 4) return _mm512_cmplt_epi32_mask((__m512i)m, _mm512_setzero_si512());
    else return _mm512_cmplt_epi64_mask((__m512i)m, _mm512_setzero_si512());
#elif defined(__AVX__)
    if constexpr (sizeof(scalar) == 4) return unsigned(_mm256_movemask_ps((__m256)m));
    else return unsigned(_mm256_movemask_pd((__m256d)m));
#else
    unsigned set = 0;
    for (int lane = 0; lane < lanes; ++lane) set |= unsigned(m[lane] != 0) << lane;
    return set;
#endif
}

inline scalar* plane(const Arguments& a, int p) { return a.state + size_t(p) * a.plane; }

// Calls one(plane, number) for each number of a fibre's state that is not always 0.
template <class F, class One> __attribute__((always_inline)) inline void each_number(F& f, const FibreConstants& k, One one) {
    one(FIBRE_Y0, f.y0);
    if (k.poles > 1) one(FIBRE_Y1, f.y1);
    if (k.poles > 2) one(FIBRE_Y2, f.y2);
    one(FIBRE_MEMBRANE, f.membrane);
    one(FIBRE_REST, f.rest);
    if (k.after == 0) return;
    one(FIBRE_AFTER0, f.after0);
    one(FIBRE_AFTER1, f.after1);
}

inline Fibre fibre_at_rest() {
    Fibre f;
    f.y0 = f.y1 = f.y2 = f.membrane = f.rest = f.after0 = f.after1 = Wide(scalar(0));
    return f;
}

// Steps fibres begin .. begin + count - 1 in straight steps, but those to which something may happen. Returns their
// number, and the list of them.
inline int step_straight(const Arguments& a, int begin, int count, const scalar* change, int part, int* list) {
    const FibreConstants& k = *a.constants;
    int listed = 0;
    for (int i = begin; i < begin + count; i += lanes) {
        Fibre f = fibre_at_rest();
        each_number(f, k, [&](int p, real& x) { x = blocks::loaded(plane(a, p) + i); });
        const Drive d =
            drive_of(blocks::loaded(plane(a, FIBRE_INPUT) + i), blocks::loaded(change + i - begin), part, k);
        Straight s = straight_step(f, d, k);
        if (unsigned set = lanes_set(s.eventful)) {
            for (; set; set &= set - 1) list[listed++] = i + __builtin_ctz(set);
            Fibre kept = f;
            real* to = &s.fibre.y0;
            const real* from = &kept.y0;
            for (int n = 0; n < int(sizeof f / sizeof(real)); ++n) to[n] = mix(to[n], from[n], s.eventful);
        }
        each_number(s.fibre, k, [&](int p, real x) { blocks::store(plane(a, p) + i, x); });
    }
    return listed;
}

// Steps listed fibres from event to event and appends their spikes. Returns the number of spikes.
inline int step_listed(const Arguments& a, const int* list, int listed, int begin, const scalar* change, int part,
                       FibreEntry* spikes) {
    const FibreConstants& k = *a.constants;
    int fired = 0;
    for (int first = 0; first < listed; first += lanes) {
        const int used = min(lanes, listed - first);
        Fibre f = fibre_at_rest();
        Wide from, gained;
        const auto gather = [&](const scalar* numbers, int offset) {
            Wide x;
            for (int lane = 0; lane < lanes; ++lane)
                x.v[lane] = numbers[list[first + (lane < used ? lane : 0)] - offset];
            return x;
        };
        each_number(f, k, [&](int p, real& x) { x = gather(plane(a, p), 0); });
        from = gather(plane(a, FIBRE_INPUT), 0);
        gained = gather(change, begin);
        Fired end = through_events(f, drive_of(from, gained, part, k), k);
        each_number(end.fibre, k, [&](int p, real x) {
            for (int lane = 0; lane < used; ++lane) plane(a, p)[list[first + lane]] = x.v[lane];
        });
        const real share = share_of(end.share, part, k);
        for (int lane = 0; lane < used; ++lane)
            if (!(end.share.v[lane] < 0)) spikes[fired++] = {list[first + lane], share.v[lane]};
    }
    return fired;
}

// Brings spikes into the order of their fibres, and of each fibre in that of time, in which they come.
inline void order(FibreEntry* spikes, int count) {
    for (int i = 1; i < count; ++i) {
        const FibreEntry s = spikes[i];
        int j = i;
        for (; j > 0 && s.fibre < spikes[j - 1].fibre; --j) spikes[j] = spikes[j - 1];
        spikes[j] = s;
    }
}

int press(const Arguments& a) {
    int fired = 0;
    for (int begin = a.first; begin < a.last; begin += together) {
        const int count = min(together, a.last - begin);
        scalar change[together];
        int list[together + lanes], of_these = 0;
        scalar* input = plane(a, FIBRE_INPUT);
        for (int i = 0; i < count; i += lanes)
            blocks::store(change + i, change_of(blocks::loaded(input + begin + i), blocks::loaded(a.input + begin + i),
                                                *a.constants));
        for (int part = 0; part < a.constants->substeps; ++part) {
            const int listed = step_straight(a, begin, count, change, part, list);
            of_these += step_listed(a, list, listed, begin, change, part, a.spikes + fired + of_these);
        }
        for (int i = 0; i < count; ++i) input[begin + i] = a.input[begin + i];
        order(a.spikes + fired, of_these);
        fired += of_these;
    }
    end_vector_code();
    return fired;
}

} // namespace fibres
