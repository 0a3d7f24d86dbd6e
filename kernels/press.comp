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
#include "step.h"
#include "responses.h"
#include "curvature.h"
#include "cells.glsl"

layout(local_size_x = PRESS_X, local_size_y = PRESS_Y) in;
layout(push_constant) uniform Push { Constants c; };
// Each map has pitch/4 vec4s for each row bound, a state STATE_PLANES times that; a row's last cells may lie beyond its width.
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
layout(std430, binding = PRESS_INVALID) restrict buffer Invalid { uint invalid; }; // counts pressures that are not finite
// the same maps, cell by cell
layout(std430, binding = PRESS_PRESSURE_FROM) readonly buffer PressureFromCells { float pressure_from_cells[]; };
layout(std430, binding = PRESS_PRESSURE_TO) readonly buffer PressureToCells { float pressure_to_cells[]; };
layout(std430, binding = PRESS_STATE_FROM) readonly buffer StateCells { float state_cells[]; };
layout(std430, binding = PRESS_MATERIAL) readonly buffer MaterialCells { int material_cells[]; };

// Where row y begins in a map, in cells; where cells x .. x + 3 of such a row stand in a map and in a state, in vec4s; and
// how far apart the planes of a state are.
int row_at(int y) { return (y - c.base_row) * c.pitch; }
int in_map(int row, int x) { return (row + x) >> 2; }
int in_state(int row, int x) { return (row * STATE_PLANES(COMPENSATED, RESPONSES) + x) >> 2; }
#define NEXT_PLANE (c.pitch >> 2)

LaneCoefficients lanes_of_four(Coefficients a, Coefficients b, Coefficients d, Coefficients e) {
    LaneCoefficients lanes;
#define JOIN(name) lanes.name = vec4(a.name, b.name, d.name, e.name);
    COEFFICIENTS(JOIN)
#undef JOIN
    return lanes;
}

LaneCoefficients coefficients_of(ivec4 materials) {
    return lanes_of_four(table[materials.x], table[materials.y], table[materials.z], table[materials.w]);
}

LaneCoefficients coefficients_at(int i) {
    if (MATERIALS == 0) return lanes_of(c.coefficients);
    return coefficients_of(material[i]);
}

Load load_at(int i) {
    return FRAMES != 0 ? load_between(valid(pressure_from[i]), valid(pressure_to[i]), c) : load_of(pressure_from[i], c);
}

Sum strain_from(int state) {
    return sum_of(state_from[state], COMPENSATED != 0 ? state_from[state + NEXT_PLANE] : vec4(0.0));
}

Sum integral_from(int state) {
    if (!asked(QUANTITY_SA2)) return sum_of(vec4(0.0), vec4(0.0));
    return strain_from(state + STATE_INTEGRAL(COMPENSATED) * NEXT_PLANE);
}

void store(Sum sum, int state) {
    state_to[state] = sum.value;
    if (COMPENSATED != 0) state_to[state + NEXT_PLANE] = sum.lost;
}

// New strain of the cells low, high, far_low, far_high beside x .. x + cells - 1; a column beyond an end is the one that
// the edge rule names. All at once, because one alone would cost as much. The nearest stencil has no far ones.
vec4 strains_beside(int x, int y, int cells) {
    bool far = reach(STENCIL) > 1;
    int low = wrapped(x - 1, c.width, EDGES);
    int high = wrapped(x + cells, c.width, EDGES);
    int far_low = far ? wrapped(x - 2, c.width, EDGES) : low;
    int far_high = far ? wrapped(x + cells + 1, c.width, EDGES) : high;
#define BESIDE(map, row) \
    (far ? vec4(map[(row) + low], map[(row) + high], map[(row) + far_low], map[(row) + far_high]) \
         : vec2(map[(row) + low], map[(row) + high]).xyxy)
    int row = row_at(y);
    int state = row * STATE_PLANES(COMPENSATED, RESPONSES);
    Sum strain = sum_of(BESIDE(state_cells, state), vec4(0.0));
    if (COMPENSATED != 0) strain.lost = BESIDE(state_cells, state + c.pitch);
    vec4 p = BESIDE(pressure_from_cells, row);
    Load load = load_of(p, c);
    if (FRAMES != 0) load = load_between(valid(p), valid(BESIDE(pressure_to_cells, row)), c);
    LaneCoefficients k = lanes_of(c.coefficients);
    if (MATERIALS != 0)
        k = coefficients_of(ivec4(material_cells[row + low], material_cells[row + high], material_cells[row + far_low],
                                  material_cells[row + far_high]));
    return advanced_strain(strain, load, k, COMPENSATED).value;
}

// New strain of cells x .. x + 3; those beyond the width are of no use.
vec4 strains(int x, int y) {
    int row = row_at(y);
    int i = in_map(row, x);
    return advanced_strain(strain_from(in_state(row, x)), load_at(i), coefficients_at(i), COMPENSATED).value;
}

// The published stencil at the ends of a row, where each cell has weights of its own. `columns` are x - 2 .. x + 5.
vec4 published_at_ends(float columns[8], int x) {
    int first = x - 2;
    vec4 sum;
    for (int i = 0; i < 4; ++i) {
        Axis a = axis(min(x + i, c.width - 1), c.width, STENCIL, EDGES);
        sum[i] = published_difference(vec4(columns[a.far_low - first]), vec4(columns[a.low - first]),
                                      vec4(columns[a.high - first]), vec4(columns[a.far_high - first]), a).x;
    }
    return sum;
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
    if (EDGES == EDGES_PUBLISHED)
        return published_at_ends(float[8](far_low, low, row.x, row.y, row.z, row.w, next.x, next.y), x);
    bool skips = STENCIL == STENCIL_PUBLISHED; // it reads its own cell in place of the nearest ones
    return difference(vec4(far_low, low, row.xy), skips ? here : vec4(low, row.xyz), here,
                      skips ? here : vec4(row.yzw, next.x), vec4(row.zw, next), axis(x, c.width, STENCIL, EDGES), STENCIL);
}

vec4 laplacian_along_y(int x, int y, vec4 here) {
    Axis a = axis(y, c.height, STENCIL, EDGES);
    bool far = reach(STENCIL) > 1;
    return difference(far ? strains(x, a.far_low) : here, strains(x, a.low), here, strains(x, a.high),
                      far ? strains(x, a.far_high) : here, a, STENCIL);
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
    CellState before;
    before.strain = strain_from(state);
    before.integral = integral_from(state);

    CellState after = advanced(before, load, k, COMPENSATED);
    store(after.strain, state);
    if (asked(QUANTITY_SA2)) store(after.integral, state + STATE_INTEGRAL(COMPENSATED) * NEXT_PLANE);
    if (FRAMES != 0) count(pressure, x);
    if (c.respond == 0 || RESPONSES == 0) return;

    vec4 L = add(laplacian_along_x(x, y, after.strain.value), laplacian_along_y(x, y, after.strain.value));
    vec4 C = curvature_of(rest_curvature[i], L, c.bend);
#define ANSWER(quantity) answer(quantity, signal(quantity, before, after, load, k), C, c)
    if (asked(QUANTITY_SA1)) sa1[i] = ANSWER(QUANTITY_SA1);
    if (asked(QUANTITY_SA2)) sa2[i] = ANSWER(QUANTITY_SA2);
    if (asked(QUANTITY_FA1)) fa1[i] = ANSWER(QUANTITY_FA1);
    if (asked(QUANTITY_FA2)) fa2[i] = ANSWER(QUANTITY_FA2);
}
