#version 450
// SPDX-License-Identifier: MIT
// One step of every cell and, if asked, its responses:
//   eps, I -> eps, I at the step's end       X*(1 + l*C), X = eps, I, eps', eps'', C = L(S) - h*L(eps)
// Four cells of a row per invocation: a software driver moves vec4s faster than floats. A neighbour's new strain
// is computed again from its old state, so one dispatch is enough; hence two copies of the state.
#extension GL_GOOGLE_include_directive : require
#define real vec4
#include "prelude.h"
#include "layout.h"
#include "press.h"
#include "curvature.h"

layout(local_size_x = PRESS_X, local_size_y = PRESS_Y) in;
layout(constant_id = 0) const int STENCIL = STENCIL_FIVE_POINT;
layout(constant_id = 1) const int EDGES = EDGES_MIRROR;
layout(constant_id = 2) const int COMPENSATED = 0; // the state carries what its sums have lost
layout(constant_id = 3) const int MATERIALS = 0; // rows differ from cell to cell
layout(constant_id = 4) const int FRAMES = 0;    // pressure runs from one map to another
layout(constant_id = 5) const int RESPONSES = 15; // which are asked for: bits SA1, SA2, FA1, FA2
layout(push_constant) uniform Push { Constants c; };
// All of pitch/4 times the rows bound, a state STATE_PLANES times that; a row's last cells may lie beyond its width.
layout(std430, binding = PRESS_PRESSURE_FROM) readonly buffer PressureFrom { vec4 pressure_from[]; };
layout(std430, binding = PRESS_PRESSURE_TO) readonly buffer PressureTo { vec4 pressure_to[]; };
layout(std430, binding = PRESS_REST_CURVATURE) readonly restrict buffer Rest { vec4 rest_curvature[]; };
layout(std430, binding = PRESS_STATE_FROM) readonly buffer StateFrom { vec4 state_from[]; };
layout(std430, binding = PRESS_STATE_TO) writeonly restrict buffer StateTo { vec4 state_to[]; };
layout(std430, binding = PRESS_SA1) writeonly restrict buffer Sa1 { vec4 sa1[]; };
layout(std430, binding = PRESS_SA2) writeonly restrict buffer Sa2 { vec4 sa2[]; };
layout(std430, binding = PRESS_FA1) writeonly restrict buffer Fa1 { vec4 fa1[]; };
layout(std430, binding = PRESS_FA2) writeonly restrict buffer Fa2 { vec4 fa2[]; };
layout(std430, binding = PRESS_COEFFICIENTS) readonly restrict buffer Table { Coefficients table[]; };
layout(std430, binding = PRESS_MATERIAL) readonly buffer Material { ivec4 material[]; };
layout(std430, binding = PRESS_INVALID) restrict buffer Invalid { uint invalid; }; // pressures met that are not finite
// the same maps, cell by cell
layout(std430, binding = PRESS_PRESSURE_FROM) readonly buffer PressureFromCells { float pressure_from_cells[]; };
layout(std430, binding = PRESS_PRESSURE_TO) readonly buffer PressureToCells { float pressure_to_cells[]; };
layout(std430, binding = PRESS_STATE_FROM) readonly buffer StateCells { float state_cells[]; };
layout(std430, binding = PRESS_MATERIAL) readonly buffer MaterialCells { int material_cells[]; };

// Where in a map, in cells, row y begins; in vec4s, where cells x .. x + 3 of such a row are in a map and in a state, and
// how far the rows of a state are apart.
int row_at(int y) { return (y - c.base_row) * c.pitch; }
int in_map(int row, int x) { return (row + x) >> 2; }
int in_state(int row, int x) { return (row * STATE_PLANES(COMPENSATED, RESPONSES) + x) >> 2; }
#define NEXT_PLANE (c.pitch >> 2)

LaneCoefficients lanes_of_four(Coefficients a, Coefficients b, Coefficients d, Coefficients e) {
    LaneCoefficients r;
    r.E = vec4(a.E, b.E, d.E, e.E);
    r.b = vec4(a.b, b.b, d.b, e.b);
    r.f = vec4(a.f, b.f, d.f, e.f);
    r.i0 = vec4(a.i0, b.i0, d.i0, e.i0);
    r.i1 = vec4(a.i1, b.i1, d.i1, e.i1);
    r.i2 = vec4(a.i2, b.i2, d.i2, e.i2);
    r.leak = vec4(a.leak, b.leak, d.leak, e.leak);
    r.v0 = vec4(a.v0, b.v0, d.v0, e.v0);
    r.v1 = vec4(a.v1, b.v1, d.v1, e.v1);
    r.a0 = vec4(a.a0, b.a0, d.a0, e.a0);
    r.a1 = vec4(a.a1, b.a1, d.a1, e.a1);
    r.a2 = vec4(a.a2, b.a2, d.a2, e.a2);
    return r;
}

// Of cells 4i .. 4i + 3.
LaneCoefficients coefficients_at(int i) {
    if (MATERIALS == 0) return lanes_of(c.row);
    ivec4 m = material[i];
    return lanes_of_four(table[m.x], table[m.y], table[m.z], table[m.w]);
}

// Frames come from anywhere: what is not finite counts as 0.
bvec4 finite(vec4 p) { return notEqual(floatBitsToUint(p) & 0x7f800000u, uvec4(0x7f800000u)); }
vec4 valid(vec4 p) { return mix(vec4(0.0), p, finite(p)); }

Load load_at(int i) {
    return FRAMES != 0 ? load_between(valid(pressure_from[i]), valid(pressure_to[i]), c) : load_of(pressure_from[i], c);
}

// New strain of cells that have eps and lost.
vec4 stepped(vec4 eps, vec4 lost, Load load, LaneCoefficients k) {
    vec4 step = strain_step(eps, load, k);
    return COMPENSATED != 0 ? added_compensated(eps, lost, step).value : added(eps, step);
}

// New strain of the cells low, high, far_low, far_high beside x .. x + cells - 1; a column beyond an end is the one that
// the edge rule names. All at once, because one alone would cost as much. The nearest stencil has no far ones.
vec4 strains_beside(int x, int y, int cells) {
    bool far = STENCIL != STENCIL_FIVE_POINT;
    int low = wrapped(x - 1, c.width, EDGES);
    int high = wrapped(x + cells, c.width, EDGES);
    int far_low = far ? wrapped(x - 2, c.width, EDGES) : low;
    int far_high = far ? wrapped(x + cells + 1, c.width, EDGES) : high;
#define BESIDE(map, row) \
    (far ? vec4(map[(row) + low], map[(row) + high], map[(row) + far_low], map[(row) + far_high]) \
         : vec2(map[(row) + low], map[(row) + high]).xyxy)
    int row = row_at(y);
    int state = row * STATE_PLANES(COMPENSATED, RESPONSES);
    vec4 eps = BESIDE(state_cells, state);
    vec4 lost = vec4(0.0);
    if (COMPENSATED != 0) lost = BESIDE(state_cells, state + c.pitch);
    vec4 p = BESIDE(pressure_from_cells, row);
    Load load = load_of(p, c);
    if (FRAMES != 0) load = load_between(valid(p), valid(BESIDE(pressure_to_cells, row)), c);
    LaneCoefficients k = lanes_of(c.row);
    if (MATERIALS != 0)
        k = lanes_of_four(table[material_cells[row + low]], table[material_cells[row + high]],
                         table[material_cells[row + far_low]], table[material_cells[row + far_high]]);
    return stepped(eps, lost, load, k);
}

// New strain of cells x .. x + 3; those beyond the width are of no use.
vec4 strains(int x, int y) {
    int row = row_at(y);
    int i = in_map(row, x);
    int state = in_state(row, x);
    vec4 lost = COMPENSATED != 0 ? state_from[state + NEXT_PLANE] : vec4(0.0);
    return stepped(state_from[state], lost, load_at(i), coefficients_at(i));
}

vec4 laplacian_along_x(int x, int y, vec4 here) {
    // Columns x - 2 .. x + 5 as far_low, low, row, next. Beyond the width the edge rule takes over: in the row's last
    // cells, without a branch, because a software driver walks both sides of one.
    int cells = min(c.width - x, 4);
    vec4 beside = strains_beside(x, y, cells);
    float low = beside.x;
    float high = beside.y;
    float far_low = beside.z;
    float far_high = beside.w;
    ivec4 lane = ivec4(0, 1, 2, 3);
    vec4 row = mix(mix(here, vec4(high), equal(lane, ivec4(cells))), vec4(far_high), equal(lane, ivec4(cells + 1)));
    vec2 next = vec2(cells == 4 ? high : far_high, far_high);
    vec4 two_low = vec4(far_low, low, row.xy);
    vec4 two_high = vec4(row.zw, next);
    if (STENCIL == STENCIL_FIVE_POINT) return second_difference(vec4(low, row.xyz), here, vec4(row.yzw, next.x));
    if (STENCIL == STENCIL_FOURTH_ORDER)
        return fourth_order(two_low, vec4(low, row.xyz), here, vec4(row.yzw, next.x), two_high);
    if (EDGES != EDGES_PUBLISHED) return published_difference(two_low, here, here, two_high, axis(x, c.width, STENCIL, EDGES));
    float columns[8] = float[8](far_low, low, row.x, row.y, row.z, row.w, next.x, next.y);
    int first = x - 2;
    vec4 sum;
    for (int i = 0; i < 4; ++i) { // at its ends each cell has weights of its own
        Axis a = axis(min(x + i, c.width - 1), c.width, STENCIL, EDGES);
        sum[i] = published_difference(vec4(columns[a.far_low - first]), vec4(columns[a.low - first]),
                                      vec4(columns[a.high - first]), vec4(columns[a.far_high - first]), a).x;
    }
    return sum;
}

vec4 laplacian_along_y(int x, int y, vec4 here) {
    Axis a = axis(y, c.height, STENCIL, EDGES);
    vec4 low = strains(x, a.low);
    vec4 high = strains(x, a.high);
    if (STENCIL == STENCIL_FIVE_POINT) return second_difference(low, here, high);
    vec4 far_low = strains(x, a.far_low);
    vec4 far_high = strains(x, a.far_high);
    if (STENCIL == STENCIL_FOURTH_ORDER) return fourth_order(far_low, low, here, high, far_high);
    return published_difference(far_low, low, high, far_high, a);
}

void count(vec4 pressure, int x) {
    bvec4 bad = not(finite(pressure));
    if (!any(bad)) return;
    uvec4 met = uvec4(bad) * uvec4(lessThan(ivec4(x, x + 1, x + 2, x + 3), ivec4(c.width)));
    atomicAdd(invalid, met.x + met.y + met.z + met.w);
}

void main() {
    int x = int(gl_GlobalInvocationID.x) * PRESS_CELLS + c.first_column;
    int y = int(gl_GlobalInvocationID.y) + c.first_row;
    if (x >= c.width || y >= c.height) return;
    int row = row_at(y);
    int i = in_map(row, x);
    int state = in_state(row, x);
    vec4 pressure = FRAMES != 0 ? pressure_to[i] : vec4(0.0);
    Load load = FRAMES != 0 ? load_between(valid(pressure_from[i]), valid(pressure), c) : load_at(i);
    LaneCoefficients k = coefficients_at(i);
    vec4 eps = state_from[state];
    vec4 step = strain_step(eps, load, k);
    vec4 after;
    if (COMPENSATED != 0) {
        Compensated carried = added_compensated(eps, state_from[state + NEXT_PLANE], step);
        after = carried.value;
        state_to[state + NEXT_PLANE] = carried.lost;
    } else {
        after = added(eps, step);
    }
    state_to[state] = after;
    vec4 sum = vec4(0.0);
    if ((RESPONSES & 2) != 0) {
        int at = state + STATE_INTEGRAL(COMPENSATED) * NEXT_PLANE;
        vec4 integral = state_from[at];
        vec4 gained = sum_step(eps, integral, load, k);
        if (COMPENSATED != 0) {
            Compensated carried = added_compensated(integral, state_from[at + NEXT_PLANE], gained);
            sum = carried.value;
            state_to[at + NEXT_PLANE] = carried.lost;
        } else {
            sum = added(integral, gained);
        }
        state_to[at] = sum;
    }
    if (FRAMES != 0) count(pressure, x);
    if (c.respond == 0 || RESPONSES == 0) return;
    vec4 L = add(laplacian_along_x(x, y, after), laplacian_along_y(x, y, after));
    vec4 C = curvature_of(rest_curvature[i], L, c.bend);
    scalar l = c.curvature_length;
    if ((RESPONSES & 1) != 0) sa1[i] = response(after, C, l);
    if ((RESPONSES & 2) != 0) sa2[i] = response(sum, C, l);
    if ((RESPONSES & 4) != 0) fa1[i] = response(rate_after(eps, load, k), C, l);
    if ((RESPONSES & 8) == 0) return;
    vec4 a = response(acceleration_after(eps, load, k), C, l);
    fa2[i] = rectified(a, c.gain_plus, c.gain_minus);
}
