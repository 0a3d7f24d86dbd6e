// SPDX-License-Identifier: MIT
// One press in OpenCL C: a work-item has 16 neighbouring cells, and makes the new strain of the four beside them anew.
// The strain is read from one map and written to another, so that no work-item waits for its neighbours.

typedef struct {
    float E, b, f, i0, i1, i2, v0, v1, a0, a1;
} ExactStep;

float16 at(global const float* map, size_t i) { return vload16(0, map + i); }

// Writes past the caches if it is told to and the compiler can.
void stream(global float* map, size_t i, float16 x) {
#if defined(PAST_CACHES) && __has_builtin(__builtin_nontemporal_store)
    __builtin_nontemporal_store(x, (global float16*)(map + i));
#else
    vstore16(x, 0, map + i);
#endif
}

// The cell to the left of each, the first one's being the first itself; likewise to the right.
float16 left_in_row(float16 x) { return (float16)(x.s0, x.s0123, x.s4567, x.s89ab, x.scde); }
float16 right_in_row(float16 x) { return (float16)(x.s123, x.s4567, x.s89ab, x.scdef, x.sf); }

kernel void press(const ExactStep k, const int width, const int height, const int pitch, global const float* restrict rest,
                  global const float* restrict from, global const float* restrict to,
                  global const float* restrict strain_from, global float* restrict strain_to,
                  global float* restrict integral, global float* restrict sa1, global float* restrict sa2, global float* restrict fa1,
                  global float* restrict fa2) {
    const int x = get_global_id(0) * 16, y = get_global_id(1);
    const size_t i = (size_t)y * pitch + x;
#define STRAIN_AFTER(i)                                                                                                 \
    (at(strain_from, i) + k.f * (at(to, i) - at(from, i)) + k.b * (at(from, i) - k.E * at(strain_from, i)))
    const float16 start = at(from, i), way = at(to, i) - start, before = at(strain_from, i), r = start - k.E * before;
    const float16 strain = before + k.f * way + k.b * r;
    const float16 sum = at(integral, i) + k.i2 * way + k.i1 * start + k.i0 * before;
    const float16 left = x > 0 ? STRAIN_AFTER(i - 1) : left_in_row(strain);
    const float16 right = x + 16 < width ? STRAIN_AFTER(i + 1) : right_in_row(strain);
    const float16 above = STRAIN_AFTER(y > 0 ? i - pitch : i), below = STRAIN_AFTER(y + 1 < height ? i + pitch : i);
    const float16 laplacian = (left - strain) + (right - strain) + ((above - strain) + (below - strain));
    const float16 gain = 1.0f + (at(rest, i) - laplacian);
    stream(strain_to, i, strain);
    vstore16(sum, 0, integral + i);
    stream(sa1, i, strain * gain);
    stream(sa2, i, sum * gain);
    stream(fa1, i, (k.v0 * r + k.v1 * way) * gain);
    stream(fa2, i, (k.a0 * r + k.a1 * way) * gain);
}
