// SPDX-License-Identifier: MIT
// The loops of one instruction set. Everything here has internal linkage, and nothing of the standard library is
// called: code for one processor must never be shared with code for all.
#include "host/core/contact/loops.hpp"

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace dermis::contact {
namespace {

// Four lines at once.
typedef double Four __attribute__((vector_size(32)));
using Mask4 = decltype(Four{} < Four{});
inline Four all(double x) { return x - Four{}; } // x in every lane: -0 - 0 is -0
inline int lesser(int a, int b) { return b < a ? b : a; }
inline Four lesser(Four a, Four b) { return b < a ? b : a; }
inline Four greater(Four a, Four b) { return a < b ? b : a; }
inline Four size_of(Four a) { return (Four)((Mask4)a & ~(Mask4)all(-0.0)); }
inline Four root(Four a) {
#ifdef __AVX__
    return (Four)_mm256_sqrt_pd((__m256d)a);
#else
    return Four{__builtin_sqrt(a[0]), __builtin_sqrt(a[1]), __builtin_sqrt(a[2]), __builtin_sqrt(a[3])};
#endif
}

// A register of numbers, or the first n of them, from memory and to it.
template <class Number> struct Register {
    typedef Number Type __attribute__((vector_size(32)));
    static constexpr int size = 32 / sizeof(Number);
};
template <class Number> inline auto loaded(const Number* from, int n = Register<Number>::size) {
    typename Register<Number>::Type x{};
    if (n == Register<Number>::size) __builtin_memcpy(&x, from, sizeof x);
    else __builtin_memcpy(&x, from, size_t(n) * sizeof(Number));
    return x;
}
template <class Number> inline void store(Number* to, const auto& x, int n = Register<Number>::size) {
    if (n * sizeof(Number) == sizeof x) __builtin_memcpy(to, &x, sizeof x);
    else __builtin_memcpy(to, &x, size_t(n) * sizeof(Number));
}

constexpr double infinite = __builtin_inf();
constexpr double parallel = 1e-12; // the sine of an angle below which a line runs along a face

// The places from + t*along of a line that are in a body: near <= t <= far; none if near > far.
struct Stretch {
    Four near, far;
};
inline Stretch both(Stretch a, Stretch b) { return {greater(a.near, b.near), lesser(a.far, b.far)}; }

struct Vec {
    Four x, y, z;
};
inline Four product(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Where a*t^2 + 2*b*t + c <= 0, of a > 0.
inline Stretch within_quadric(Four a, Four b, Four c) {
    const Four under = b * b - a * c, half = under < 0 ? all(-infinite) : root(greater(under, Four{})), scale = 1 / a;
    return {(-b - half) * scale, (-b + half) * scale};
}

// Between two faces across an axis, `half` from the body's middle. A line that runs along them is taken to meet them
// very far away.
inline Stretch within_slab(Four from, Four along, double half) {
    const Four scale = 1 / (size_of(along) < parallel ? all(parallel) : along), one = (-half - from) * scale,
               other = (half - from) * scale;
    return {lesser(one, other), greater(one, other)};
}

// In a ball around the origin. The direction has length 1.
inline Stretch within_ball(Vec from, Vec along, double radius) {
    return within_quadric(all(1), product(from, along), product(from, from) - radius * radius);
}

// In a cylinder along z without ends.
inline Stretch within_tube(Vec from, Vec along, double radius) {
    const Four a = along.x * along.x + along.y * along.y, c = from.x * from.x + from.y * from.y - radius * radius;
    return within_quadric(greater(a, all(parallel * parallel)), from.x * along.x + from.y * along.y, c);
}

// Where a line is in a body of each kind, by Body::Kind.
template <int kind> inline Stretch within(const double* size, Vec from, Vec along);

template <> inline Stretch within<0>(const double* size, Vec from, Vec along) { // sphere
    return within_ball(from, along, size[0]);
}

// A capsule: the far end alone counts, where the line leaves a ball or the side of the cylinder between them.
template <> inline Stretch within<1>(const double* size, Vec from, Vec along) {
    const Stretch side = within_tube(from, along, size[0]);
    const Mask4 meets = size_of(from.z + side.far * along.z) <= size[1];
    const Stretch low = within_ball({from.x, from.y, from.z + size[1]}, along, size[0]),
                  high = within_ball({from.x, from.y, from.z - size[1]}, along, size[0]);
    return {lesser(meets ? side.near : all(infinite), lesser(low.near, high.near)),
            greater(meets ? side.far : all(-infinite), greater(low.far, high.far))};
}

template <> inline Stretch within<2>(const double* size, Vec from, Vec along) { // box
    return both(both(within_slab(from.x, along.x, size[0]), within_slab(from.y, along.y, size[1])),
                within_slab(from.z, along.z, size[2]));
}

// A plane: a line along it, or out of it, is in no part of it that has an end.
template <> inline Stretch within<3>(const double*, Vec from, Vec along) {
    const Mask4 ends = along.z > parallel;
    const Four scale = 1 / (ends ? along.z : all(1));
    return {all(-infinite), ends ? -from.z * scale : all(-infinite)};
}

template <> inline Stretch within<4>(const double* size, Vec from, Vec along) { // cylinder
    return both(within_tube(from, along, size[0]), within_slab(from.z, along.z, size[1]));
}

template <> inline Stretch within<5>(const double* size, Vec from, Vec along) { // ellipsoid
    const double a = 1 / size[0], b = 1 / size[1], c = 1 / size[2];
    const Vec p = {from.x * a, from.y * b, from.z * c}, d = {along.x * a, along.y * b, along.z * c};
    return within_quadric(product(d, d), product(p, d), product(p, p) - 1);
}

// A hull: on the inner side of each face.
inline Stretch within_hull(const LineRow& l, Vec from, Vec along) {
    Stretch s{all(-infinite), all(infinite)};
    for (size_t i = 0; i < l.face_count; ++i) {
        const double* f = l.faces + 4 * i;
        const Vec normal = {all(f[0]), all(f[1]), all(f[2])};
        const Four speed = product(normal, along), runs = size_of(speed) < parallel ? all(parallel) : speed,
                   t = (f[3] - product(normal, from)) / runs;
        s.near = runs < 0 ? greater(s.near, t) : s.near, s.far = runs > 0 ? lesser(s.far, t) : s.far;
    }
    return s;
}

// depth[0 .. n - 1]: the greater of what they hold and the ends of the lines.
template <int kind>
inline void deepen_four(const double* size, Vec from, Vec along, const LineRow& l, double* depth, int n) {
    Stretch s;
    if constexpr (kind == 6) s = within_hull(l, from, along);
    else s = within<kind>(size, from, along);
    const double deepest = l.deepest;
    // A line beside the body has no near <= far, and minus infinity may be both.
    const Four end = ((s.near <= s.far) & (s.far <= deepest) & (s.far >= -deepest)) ? s.far : all(not_below);
    store(depth, greater(loaded(depth, n), end), n);
}

inline Vec vec(const double* v) { return {all(v[0]), all(v[1]), all(v[2])}; }
inline Vec stepped(Vec o, Four x, Vec step) { return {o.x + x * step.x, o.y + x * step.y, o.z + x * step.z}; }

template <int kind> void deepen_by(const double* size, const LineRow& l, const Block& b, double* depth) {
    const double own[3] = {size[0], size[1], size[2]};
    const Vec origin = vec(l.origin), step_x = vec(l.step_x), step_y = vec(l.step_y), down = vec(l.down);
    for (int j = 0; j < b.rows; ++j)
        for (int i = 0; i < b.columns; i += 4) {
            double* to = depth + size_t(j) * b.pitch + i;
            const int n = lesser(b.columns - i, 4);
            if (l.flat) {
                const Four x = b.scattered ? loaded(l.from[0] + i) : Four{0, 1, 2, 3} + (b.x + i),
                           y = b.scattered ? loaded(l.from[1] + i) : all(b.y + j);
                deepen_four<kind>(own, stepped(stepped(origin, y, step_y), x, step_x), down, l, to, n);
            } else
                deepen_four<kind>(own, {loaded(l.from[0] + i), loaded(l.from[1] + i), loaded(l.from[2] + i)},
                                  {loaded(l.along[0] + i), loaded(l.along[1] + i), loaded(l.along[2] + i)}, l, to, n);
        }
}

void deepen(int kind, const double* size, const LineRow& lines, const Block& block, double* depth) {
    constexpr decltype(&deepen_by<0>) by[] = {deepen_by<0>, deepen_by<1>, deepen_by<2>, deepen_by<3>,
                                              deepen_by<4>, deepen_by<5>, deepen_by<6>};
    by[kind](size, lines, block, depth);
}

// Eight cells of a row.
constexpr int lanes = 8;
typedef float Eight __attribute__((vector_size(4 * lanes)));
using Mask8 = decltype(Eight{} < Eight{});

inline Eight where(Mask8 m, Eight x) { return m ? x : Eight{}; }
inline double total(Eight v) {
    const Eight pairs = v + __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3),
                fours = pairs + __builtin_shufflevector(pairs, pairs, 2, 3, 0, 1, 6, 7, 4, 5);
    return double(fours[0] + fours[1]);
}
// A sum of many floats, in doubles.
struct Long {
    Four low{}, high{};
    void add(Eight x) {
        low += __builtin_convertvector(__builtin_shufflevector(x, x, 0, 1, 2, 3), Four);
        high += __builtin_convertvector(__builtin_shufflevector(x, x, 4, 5, 6, 7), Four);
    }
    double total() const {
        const Four fours = low + high;
        return fours[0] + fours[2] + (fours[1] + fours[3]);
    }
};
inline Eight counted(float first) { return Eight{0, 1, 2, 3, 4, 5, 6, 7} + first; }

double settle(const double* deep, size_t count, float* depth, float* share) {
    Four most = all(not_below);
    for (size_t i = 0; i < count; i += 4) {
        most = greater(most, loaded(deep + i));
    }
    double deepest = most[0];
    for (int l = 1; l < 4; ++l) deepest = most[l] > deepest ? most[l] : deepest;
    for (size_t i = 0; i < count; i += 4) {
        typedef float Floats __attribute__((vector_size(16)));
        const Four d = loaded(deep + i);
        const Floats relative = __builtin_convertvector(d - deepest, Floats),
                     all = __builtin_convertvector(d > 0.5 * not_below ? Four{1, 1, 1, 1} : Four{}, Floats);
        store(depth + i, relative, 4);
        if (share) store(share + i, all, 4);
    }
    return deepest;
}

// Calls each(first column, first row, end of columns, end of rows) for squares of cells, of which sums are floats.
template <class Each> inline void each_square(int width, int height, const Each& each) {
    constexpr int side = 64;
    for (int top = 0; top < height; top += side)
        for (int left = 0; left < width; left += side)
            each(left, top, lesser(left + side, width), lesser(top + side, height));
}

void level(const BedCells& bed, float level, int step, double* n, double* e) {
    double counts = 0, excesses = 0;
    each_square(bed.width, bed.height, [&](int left, int top, int right, int bottom) {
        Eight count{}, sum{};
        for (int j = top; j < bottom; j += step)
            for (int i = left; i < right; i += lanes) {
                const size_t at = size_t(j) * bed.pitch + size_t(i);
                const Eight d = loaded(bed.depth + at) + level, w = where(d > 0, loaded(bed.share + at));
                count += w, sum += w * d;
            }
        counts += total(count), excesses += total(sum);
    });
    *n = counts, *e = excesses;
}

void sums(const BedCells& bed, const Plane& p, Sums* all) {
    Sums s{};
    const float left_x = float(0.5 - 0.5 * bed.width), top_y = float(0.5 - 0.5 * bed.height);
    const float along_x = float(p.along_x), along_y = float(p.along_y), height = float(p.level);
    each_square(bed.width, bed.height, [&](int left, int top, int right, int bottom) {
        Eight n{}, nx{}, ny{}, nxx{}, nxy{}, nyy{}, e{}, ex{}, ey{}, exx{}, exy{}, eyy{}, ee{};
        for (int i = left; i < right; i += lanes) {
            const Eight x = counted(left_x + float(i)), row = height + along_x * x;
            Eight cn{}, cy{}, ce{}, cey{};
            for (int j = top; j < bottom; ++j) {
                const size_t at = size_t(j) * bed.pitch + size_t(i);
                const float y = top_y + float(j);
                const Eight d = loaded(bed.depth + at) + (row + along_y * y);
                const Eight w = where(d > 0, loaded(bed.share + at)), q = w * d, wy = w * y, qy = q * y;
                cn += w, cy += wy, nyy += wy * y;
                ce += q, cey += qy, eyy += qy * y, ee += q * d;
            }
            n += cn, nx += cn * x, nxx += cn * x * x, ny += cy, nxy += cy * x;
            e += ce, ex += ce * x, exx += ce * x * x, ey += cey, exy += cey * x;
        }
        s.n += total(n), s.x += total(nx), s.y += total(ny);
        s.xx += total(nxx), s.xy += total(nxy), s.yy += total(nyy);
        s.e += total(e), s.ex += total(ex), s.ey += total(ey);
        s.exx += total(exx), s.exy += total(exy), s.eyy += total(eyy), s.ee += total(ee);
    });
    *all = s;
}

double write(const BedCells& bed, const Plane& p, float* excess) {
    Long sum;
    const float left_x = float(0.5 - 0.5 * bed.width), top_y = float(0.5 - 0.5 * bed.height);
    const float along_x = float(p.along_x), along_y = float(p.along_y), height = float(p.level);
    each_square(bed.width, bed.height, [&](int left, int top, int right, int bottom) {
        for (int i = left; i < right; i += lanes) {
            const Eight row = height + along_x * counted(left_x + float(i));
            Eight all{};
            for (int j = top; j < bottom; ++j) {
                const size_t at = size_t(j) * bed.pitch + size_t(i);
                const Eight d = loaded(bed.depth + at) + (row + along_y * (top_y + float(j)));
                const Eight e = where(d > 0, loaded(bed.share + at) * d);
                all += e;
                store(excess + at, e);
            }
            sum.add(all);
        }
    });
    return sum.total();
}

Gained add(const AddedRows& r) {
    Gained g{.left = r.width, .right = -1, .top = r.height, .bottom = -1};
    Long all, all_x, all_y, all_placed;
    Eight greatest{}, cells{}, low = Eight{} + float(r.width), high = Eight{} - 1;
    each_square(r.width, r.height, [&](int left, int top, int right, int bottom) {
        for (int j = top; j < bottom; ++j) {
            Mask8 any{};
            Eight pressed{}, px{}, placed{};
            for (int i = left; i < right; i += lanes) {
                const int n = lesser(right - i, lanes);
                const size_t at = size_t(j) * r.pitch + size_t(i);
                const Eight x = counted(float(i)),
                            p = loaded(r.pressure + size_t(j) * r.bed_pitch + size_t(i), n) * r.scale,
                            before = loaded(r.to + at, n), after = before + p;
                store(r.to + at, after, n);
                pressed += p, px += p * x, placed += after - before;
                const Mask8 here = p != 0;
                any |= here;
                greatest = (here & (after > greatest)) ? after : greatest;
                cells += where(here & (before == 0) & (after != 0), Eight{1, 1, 1, 1, 1, 1, 1, 1});
                low = (here & (x < low)) ? x : low, high = (here & (x > high)) ? x : high;
                const auto drag = [&](float* map, auto by) {
                    if (map) store(map + at, loaded(map + at, n) + where(here, p * by), n);
                };
                drag(r.shear_x, r.drag_x - r.twist * float(j)), drag(r.shear_y, r.drag_y + r.twist * x);
            }
            all.add(pressed), all_x.add(px), all_y.add(pressed * float(j)), all_placed.add(placed);
            int some = 0;
            for (int l = 0; l < lanes; ++l) some |= any[l];
            if (some) g.top = lesser(g.top, j), g.bottom = j > g.bottom ? j : g.bottom;
        }
    });
    g.pressed = all.total(), g.x = all_x.total(), g.y = all_y.total(), g.placed = all_placed.total();
    for (int l = 0; l < lanes; ++l) {
        g.greatest = greatest[l] > g.greatest ? greatest[l] : g.greatest;
        g.left = lesser(g.left, int(low[l]));
        g.right = int(high[l]) > g.right ? int(high[l]) : g.right;
        g.cells += int(cells[l]);
    }
    return g;
}

} // namespace

extern const CellLoops DERMIS_LOOPS;
const CellLoops DERMIS_LOOPS = {deepen, settle, level, sums, write, add};

} // namespace dermis::contact
