#version 450
// SPDX-License-Identifier: MIT
// One step of every cell and, if asked, its responses:
//   eps, I -> eps, I at the step's end (cell.h)      X*(1 + l*C), X = eps, I, eps', eps'', C = L(S) - h*L(eps)
// An invocation takes four cells of a row, because a software driver moves vec4s faster than floats. It computes the new
// strain of neighbours again from their old state, so one dispatch is enough; hence two copies of the state.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require // maps.glsl
#define real vec4
#include "prelude.h"
#include "layout.h"
#include "step.h"
#include "responses.h"
#include "curvature.h"
#include "maps.glsl"

layout(constant_id = VARIANT_STENCIL) const int STENCIL = STENCIL_FIVE_POINT;
layout(constant_id = VARIANT_EDGES) const int EDGES = EDGES_MIRROR;
layout(constant_id = VARIANT_COMPENSATED) const int COMPENSATED = 0;
layout(constant_id = VARIANT_MATERIALS) const int MATERIALS = 0;
layout(constant_id = VARIANT_FRAMES) const int FRAMES = 0;
layout(constant_id = VARIANT_RESPONSES) const int RESPONSES = (1 << RESPONSE_MAPS) - 1;
layout(constant_id = VARIANT_ELEMENTS) const int ELEMENTS = 1;
layout(constant_id = VARIANT_SPRING) const int SPRING = 0;
layout(constant_id = VARIANT_STRAIN) const int STRAIN = 0;
layout(constant_id = VARIANT_PADS) const int PADS = 0;
layout(constant_id = VARIANT_HOLD) const int HOLD = 0;
// Planes of a cell's state: their number; of sum s, the strain of element s or the integral; of the spring's rate; of the
// frame before.
#define PLANES STATE_PLANES(ELEMENTS, COMPENSATED, STRAIN, INTEGRATED, CARRIES_RATE, HOLD)
#define SUM_PLANE(s) STATE_SUM(s, COMPENSATED, STRAIN)
#define RATE STATE_RATE(ELEMENTS, COMPENSATED, STRAIN, INTEGRATED)
#define PREVIOUS STATE_PREVIOUS(ELEMENTS, COMPENSATED, STRAIN, INTEGRATED, CARRIES_RATE)
#define INTEGRATED ((RESPONSES >> (QUANTITY_SA2 - 1)) & 1)
#define CARRIES_RATE (SPRING & FRAMES & (RESPONSES >> (QUANTITY_FA2 - 1)))

// Whether the coefficients are in a table. Otherwise the constants hold the coefficients of the only element.
bool tabled() { return ELEMENTS + SPRING + MATERIALS + PADS / 2 + HOLD > 1; }
// The index, in a table, of the first Coefficients of the element with this index.
#define IN_TABLE(element) ((1 + HOLD) * (element))

bool asked(int quantity) { return (RESPONSES & RESPONSE_BIT(quantity)) != 0; }

// A pressure that is not finite counts as 0.
bvec4 finite(vec4 p) { return notEqual(floatBitsToUint(p) & 0x7f800000u, uvec4(0x7f800000u)); }
vec4 valid(vec4 p) { return mix(vec4(0.0), p, finite(p)); }

layout(local_size_x_id = VARIANT_GROUP_X, local_size_y_id = VARIANT_GROUP_Y, local_size_z_id = VARIANT_GROUP_Z) in;
layout(push_constant) uniform Push { Constants c; };
// Each map has pitch/4 vec4s per bound row, a state PLANES times as many. The last cells of a row may be padding. Pads
// stand one after another in pressures, states and responses; rest curvature and materials are the same for all.
MAP(PRESS_PRESSURE_FROM, PressureFrom, pressure_from);
MAP(PRESS_PRESSURE_TO, PressureTo, pressure_to);
MAP(PRESS_REST_CURVATURE, Rest, rest_curvature);
MAP(PRESS_STATE_FROM, StateFrom, state_from);
layout(std430, binding = PRESS_STATE_TO) writeonly restrict buffer StateTo { vec4 state_to[]; };
#ifdef SITES
// The variant of sites: an invocation takes an entry of a list. Cells that no site needs are not computed.
layout(std430, binding = PRESS_SITES) readonly restrict buffer Sites { SiteEntry sites[]; };
layout(std430, binding = PRESS_SITES_RESPONSE) writeonly restrict buffer Response { float responses[]; };
#else
layout(std430, binding = PRESS_RESPONSE(QUANTITY_SA1)) writeonly restrict buffer Sa1 { vec4 sa1[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_SA2)) writeonly restrict buffer Sa2 { vec4 sa2[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_FA1)) writeonly restrict buffer Fa1 { vec4 fa1[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_FA2)) writeonly restrict buffer Fa2 { vec4 fa2[]; };
#endif
layout(std430, binding = PRESS_COEFFICIENTS) readonly restrict buffer Table { Coefficients table[]; };
layout(std430, binding = PRESS_COEFFICIENTS) readonly buffer List { PadEntry pads[]; };
layout(std430, binding = PRESS_MATERIAL) readonly buffer Material { ivec4 material[]; };
layout(std430, binding = PRESS_INVALID) restrict buffer Invalid { uint invalid; }; // counts pressures that are not finite
#ifdef SIGNALS
// The variant of receptors at depths, whose cells have one material: writes the cells' gain, and signals for responses.
layout(std430, binding = PRESS_MATERIAL) writeonly buffer Gains { vec4 gains[]; };
#endif
// The same material as scalars.
layout(std430, binding = PRESS_MATERIAL) readonly buffer MaterialCells { int material_cells[]; };

// The invocation's pad: its number, its first cell in a map, and the index of its first coefficients.
int pad_number = 0;
int pad_start = 0;
int pad_table = 0;

// row_start: the index of row y's first cell in a map. of_all_pads: a map's vec4 index i in a map that all pads share.
// in_map, in_state: the vec4 index of cells x .. x + 3 of a row in a map and in a state. NEXT_PLANE: vec4s from plane
// to plane of a state.
int row_start(int y) { return pad_start + (y - c.base_row) * c.pitch; }
int of_all_pads(int i) { return i - (pad_start >> 2); }
int in_map(int start, int x) { return (start + x) >> 2; }
int in_state(int start, int x) { return (start * PLANES + x) >> 2; }
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

// The coefficients of the elements e of cells with these materials: the first ones, or the `second`.
LaneCoefficients tabled_with(ivec4 materials, int e, int second) {
    int at = pad_table + IN_TABLE(e) + second;
    return MATERIALS == 0 ? lanes_of(table[at]) : coefficients_of(IN_TABLE(materials) + at);
}
LaneCoefficients element_with(ivec4 materials, int e) {
    return tabled() ? tabled_with(materials, e, 0) : lanes_of(c.coefficients);
}

ivec4 materials_at(int i) { return MATERIALS == 0 ? ivec4(0) : material[of_all_pads(i)]; }

Load load_at(int i) {
    vec4 p = FOUR(pressure_from, i);
    return FRAMES != 0 ? load_between(valid(p), valid(FOUR(pressure_to, i)), c) : load_of(p, c);
}

// Four cells of a row: the vec4 index of their first plane in a state, their materials, and whether the step is kept.
struct Cell {
    int state;
    ivec4 materials;
    bool kept;
};
Cell cell_at(int x, int y, bool kept) {
    int start = row_start(y);
    return Cell(in_state(start, x), materials_at(in_map(start, x)), kept);
}
LaneCoefficients element_of(Cell cell, int e) { return element_with(cell.materials, e); }
LaneCoefficients past_of(Cell cell, int e) { return tabled_with(cell.materials, e, 1); }
real number_from(Cell cell, int plane) { return FOUR(state_from, cell.state + plane * NEXT_PLANE); }
void store_number(Cell cell, int plane, real x) {
    if (cell.kept) state_to[cell.state + plane * NEXT_PLANE] = x;
}
// The state of a Cell (cell.h), by its planes in layout.h.
int elements_of(Cell cell) { return ELEMENTS; }
bool has_spring(Cell cell) { return SPRING != 0; }
bool has_rate(Cell cell) { return CARRIES_RATE != 0; }
bool has_integral(Cell cell) { return INTEGRATED != 0; }
int is_compensated(Cell cell) { return COMPENSATED; }

Sum sum_from(Cell cell, int s) {
    return sum_of(number_from(cell, SUM_PLANE(s)), COMPENSATED != 0 ? number_from(cell, SUM_PLANE(s) + 1) : real(0.0));
}
void store(Cell cell, int s, Sum before, Sum after) {
    store_number(cell, SUM_PLANE(s), after.value);
    if (COMPENSATED != 0) store_number(cell, SUM_PLANE(s) + 1, after.lost);
}

real rate_from(Cell cell) { return number_from(cell, RATE); }
void store_rate(Cell cell, real rate) { store_number(cell, RATE, rate); }

bool has_past(Cell cell) { return HOLD != 0; }
real previous_from(Cell cell) { return number_from(cell, PREVIOUS); }
void store_previous(Cell cell, real p) { store_number(cell, PREVIOUS, p); }
#include "cell.h"

// New strain of the cells low, high, far_low, far_high beside x .. x + cells - 1; the edge rule replaces columns beyond the
// ends. All four are computed at once, because one alone would cost as much. The five-point stencil has no far cells.
vec4 strains_beside(int x, int y, int cells) {
    bool far = reach(STENCIL) > 1;
    int low = wrapped(x - 1, c.width, EDGES);
    int high = wrapped(x + cells, c.width, EDGES);
    int far_low = far ? wrapped(x - 2, c.width, EDGES) : low;
    int far_high = far ? wrapped(x + cells + 1, c.width, EDGES) : high;
#define BESIDE(map, at) \
    (far ? vec4(ONE(map, (at) + low), ONE(map, (at) + high), ONE(map, (at) + far_low), ONE(map, (at) + far_high)) \
         : vec2(ONE(map, (at) + low), ONE(map, (at) + high)).xyxy)
    int start = row_start(y);
    int state = start * PLANES;
    vec4 p = BESIDE(pressure_from, start);
    Load load = load_of(p, c);
    if (FRAMES != 0) load = load_between(valid(p), valid(BESIDE(pressure_to, start)), c);
    ivec4 materials = ivec4(0);
    if (MATERIALS != 0)
        materials = ivec4(material_cells[start - pad_start + low], material_cells[start - pad_start + high],
                          material_cells[start - pad_start + far_low], material_cells[start - pad_start + far_high]);
    if (HOLD != 0) load.past = change_before(BESIDE(state_from, state + PREVIOUS * c.pitch), load);
    vec4 eps = vec4(0.0);
    for (int e = 0; e < ELEMENTS; ++e) {
        int plane = state + SUM_PLANE(e) * c.pitch;
        Sum strain = sum_of(BESIDE(state_from, plane), vec4(0.0));
        if (COMPENSATED != 0) strain.lost = BESIDE(state_from, plane + c.pitch);
        LaneCoefficients k = element_with(materials, e);
        Sum after = advanced_strain(strain, load, k, COMPENSATED);
        if (HOLD != 0)
            after = advanced_strain_with_past(strain, load, k, tabled_with(materials, e, 1), COMPENSATED);
        eps = e == 0 ? after.value : in_series(eps, after.value);
    }
    if (SPRING != 0) eps = in_series(eps, spring_strain(load, element_with(materials, ELEMENTS)));
    return eps;
}

// New strain of cells x .. x + 3; cells beyond the width are not used.
vec4 strains(int x, int y) {
    return step_of(cell_at(x, y, false), load_at(in_map(row_start(y), x))).motion.strain;
}

// The published stencil near the ends of a row, where weights differ from cell to cell. `columns` are x - 2 .. x + 5.
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
    // Columns x - 2 .. x + 5 as far_low, low, own, next. Columns beyond the width come from the edge rule; they are
    // selected without a branch, because a software driver executes both sides of one.
    int cells = min(c.width - x, 4);
    vec4 beside = strains_beside(x, y, cells);
    float low = beside.x;
    float high = beside.y;
    float far_low = beside.z;
    float far_high = beside.w;
    ivec4 lane = ivec4(0, 1, 2, 3);
    vec4 own = mix(mix(here, vec4(high), equal(lane, ivec4(cells))), vec4(far_high), equal(lane, ivec4(cells + 1)));
    vec2 next = vec2(cells == 4 ? high : far_high, far_high);
    if (EDGES == EDGES_PUBLISHED)
        return published_at_ends(float[8](far_low, low, own.x, own.y, own.z, own.w, next.x, next.y), x);
    bool skips = STENCIL == STENCIL_PUBLISHED; // it reads its own cell in place of the nearest
    return difference(vec4(far_low, low, own.xy), skips ? here : vec4(low, own.xyz), here,
                      skips ? here : vec4(own.yzw, next.x), vec4(own.zw, next), axis(x, c.width, STENCIL, EDGES),
                      STENCIL);
}

vec4 laplacian_along_y(int x, int y, vec4 here) {
    Axis a = axis(y, c.height, STENCIL, EDGES);
    bool far = reach(STENCIL) > 1;
    return difference(far ? strains(x, a.far_low) : here, strains(x, a.low), here, strains(x, a.high),
                      far ? strains(x, a.far_high) : here, a, STENCIL);
}

#ifdef SIGNALS
// The vec4 index of cells in a map with a margin (spread.h).
int in_margin(int x, int y) {
    int pitch = ((c.width + 3) & ~3) + 2 * SPREAD_MARGIN;
    return ((pad_number * (c.height + 2 * SPREAD_MARGIN) + y + SPREAD_MARGIN) * pitch + x + SPREAD_MARGIN) >> 2;
}

// 0 beyond the width.
vec4 of_width(vec4 v, int x) {
    return mix(v, vec4(0.0), greaterThanEqual(ivec4(x, x + 1, x + 2, x + 3), ivec4(c.width)));
}
#endif

#ifdef SITES
SiteEntry own;
SiteEntry own_entry() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return sites[group * gl_WorkGroupSize.x + gl_LocalInvocationID.x];
}
uvec4 needed(int x) { return uvec4(own.needed) >> uvec4(0, 1, 2, 3) & 1u; }
#else
uvec4 needed(int x) { return uvec4(lessThan(ivec4(x, x + 1, x + 2, x + 3), ivec4(c.width))); }
#endif

void count(vec4 pressure, int x) {
    bvec4 bad = not(finite(pressure));
    if (!any(bad)) return;
    uvec4 counted = uvec4(bad) * needed(x);
    atomicAdd(invalid, counted.x + counted.y + counted.z + counted.w);
}

void main() {
#ifdef SITES
    own = own_entry();
    int x = own.x;
    int y = own.y;
    bool kept = own.needed != 0;
#else
    int x = int(gl_GlobalInvocationID.x) * PRESS_CELLS + c.first_column;
    int y = int(gl_GlobalInvocationID.y) + c.first_row;
    const bool kept = true;
#endif
    if (x >= c.width || y >= c.height) return;
    if (PADS != 0) {
        PadEntry pad = pads[gl_GlobalInvocationID.z];
        if (pad.pad < 0) return;
        pad_number = pad.pad;
        pad_start = pad.pad * c.height * c.pitch;
        pad_table = pad.table;
    }
    int i = in_map(row_start(y), x);
    vec4 pressure = FRAMES != 0 ? FOUR(pressure_to, i) : vec4(0.0);
    Load load = FRAMES != 0 ? load_between(valid(FOUR(pressure_from, i)), valid(pressure), c) : load_at(i);
    Cell cell = cell_at(x, y, kept);
    CellStep step = step_of(cell, load);
    Motion m = step.motion;
    if (STRAIN != 0) store_number(cell, 0, m.strain);
    if (FRAMES != 0) count(pressure, x);
    if (c.respond == 0 || RESPONSES == 0) return;
#ifdef SITES
    if (own.quantity == 0) return;
#endif

    vec4 L = add(laplacian_along_x(x, y, m.strain), laplacian_along_y(x, y, m.strain));
    vec4 gain = gain_at(curvature_of(FOUR(rest_curvature, of_all_pads(i)), L, c.bend), c);
#ifdef SITES
    responses[own.response + pad_number * own.of_class] =
        answer(own.quantity, signal(own.quantity, m, step.integral), gain, c)[own.lane];
#else
#ifdef SIGNALS
    i = in_margin(x, y);
    gains[i] = gain;
#define RESPONSE(quantity) of_width(response(signal(quantity, m, step.integral), vec4(1.0)), x)
#else
#define RESPONSE(quantity) answer(quantity, signal(quantity, m, step.integral), gain, c)
#endif
    if (asked(QUANTITY_SA1)) sa1[i] = RESPONSE(QUANTITY_SA1);
    if (asked(QUANTITY_SA2)) sa2[i] = RESPONSE(QUANTITY_SA2);
    if (asked(QUANTITY_FA1)) fa1[i] = RESPONSE(QUANTITY_FA1);
    if (asked(QUANTITY_FA2)) fa2[i] = RESPONSE(QUANTITY_FA2);
#endif
}
