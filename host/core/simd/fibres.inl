// SPDX-License-Identifier: MIT
// A press of nerve fibres, in registers of neighbouring fibres. blocks.inl precedes this in its namespace. Each substep
// is taken twice: all endings in a straight step, and the endings to which something may happen again, gathered into
// full registers, from event to event.

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

constexpr int together = 1024; // endings that are stepped at once: their numbers fit the first-level cache
static_assert(together >= 64 * lanes, "a fibre has up to 64 endings");
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
template <class F, class One>
__attribute__((always_inline)) inline void each_number(F& f, const FibreConstants& k, One one) {
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

// Steps endings begin .. begin + count - 1 in straight steps, but those to which something may happen. Returns their
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

// Steps listed endings from event to event and appends their spikes, at shares of the substep. Returns their number.
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
        for (int lane = 0; lane < used; ++lane)
            if (!(end.share.v[lane] < 0)) spikes[fired++] = {list[first + lane], end.share.v[lane]};
    }
    return fired;
}

// Leaves of the spikes of endings in a substep the first one of each fibre, which sets the fibre's other endings back.
// begin: the first fibre. Returns the number of spikes left. Shares are of the substep: of the press two may be equal.
inline int first_of_fibres(const Arguments& a, int begin, FibreEntry* spikes, int count) {
    int kept = 0, known[together]; // the spike of each fibre
    for (int n = 0; n < count; ++n) known[spikes[n].fibre % a.of_pad - begin] = -1;
    for (int n = 0; n < count; ++n) {
        int& earlier = known[spikes[n].fibre % a.of_pad - begin];
        if (earlier >= 0 && !(spikes[n].share < spikes[earlier].share)) continue;
        if (earlier < 0) earlier = kept++;
        spikes[earlier] = spikes[n];
    }
    for (int n = 0; n < kept; ++n) {
        const int fires = spikes[n].fibre, fibre = fires % a.of_pad;
        for (int e = 0; e < a.endings; ++e)
            for (int p = FIBRE_MEMBRANE; p <= FIBRE_AFTER1; ++p) plane(a, p)[fibre + e * a.of_pad] = plane(a, p)[fires];
        spikes[n].fibre = fibre;
    }
    return kept;
}

// Presses fibres begin .. begin + count - 1, of at most `together` endings. Returns the number of spikes, which come by
// substep.
inline int press_some(const Arguments& a, int begin, int count, FibreEntry* spikes) {
    scalar change[together];
    int list[together + lanes], fired = 0;
    for (int e = 0; e < a.endings; ++e)
        for (int i = 0; i < count; i += lanes) {
            const int at = begin + e * a.of_pad + i;
            blocks::store(change + e * count + i, change_of(blocks::loaded(plane(a, FIBRE_INPUT) + at),
                                                            blocks::loaded(a.input + at), *a.constants));
        }
    for (int part = a.part; part < a.end; ++part) {
        int now = 0; // spikes of the substep
        for (int e = 0; e < a.endings; ++e) {
            const int first = begin + e * a.of_pad;
            const int listed = step_straight(a, first, count, change + e * count, part, list);
            now += step_listed(a, list, listed, first, change + e * count, part, spikes + fired + now);
        }
        for (int kept = a.endings > 1 ? first_of_fibres(a, begin, spikes + fired, now) : now; kept > 0; --kept, ++fired)
            spikes[fired].share = share_of(Wide(spikes[fired].share), part, *a.constants).v[0];
    }
    return fired;
}

int press(const Arguments& a) {
    const int at_once = together / a.endings / lanes * lanes;
    int fired = 0;
    for (int begin = a.first; begin < a.last; begin += at_once)
        fired += press_some(a, begin, min(at_once, a.last - begin), a.spikes + fired);
    end_vector_code();
    return fired;
}

} // namespace fibres
