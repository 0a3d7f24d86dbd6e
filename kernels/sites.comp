#version 450
// SPDX-License-Identifier: MIT
// One step of the cells that some receptor looks at, and the response of each receptor: no other cell is touched. An
// invocation takes one cell or one receptor; the new strain beside a receptor is computed again from the old state, so
// one dispatch is enough.
#extension GL_GOOGLE_include_directive : require
#include "prelude.h"
#include "layout.h"
#include "press.h"
#include "curvature.h"

layout(local_size_x = SITES_X) in;
layout(constant_id = 0) const int STENCIL = STENCIL_FIVE_POINT;
layout(constant_id = 1) const int EDGES = EDGES_MIRROR;
layout(constant_id = 2) const int COMPENSATED = 0;
layout(constant_id = 3) const int MATERIALS = 0;
layout(constant_id = 5) const int RESPONSES = 15;
layout(push_constant) uniform Push { SiteConstants s; };
layout(std430, binding = SITES_PRESSURE_FROM) readonly buffer PressureFrom { float pressure_from[]; };
layout(std430, binding = SITES_PRESSURE_TO) readonly buffer PressureTo { float pressure_to[]; };
layout(std430, binding = SITES_CELLS) readonly restrict buffer Cells { SiteCell cells[]; };
layout(std430, binding = SITES_SITES) readonly restrict buffer Sites { SiteStencil sites[]; };
// STATE_PLANES numbers for each of the cells
layout(std430, binding = SITES_STATE_FROM) readonly restrict buffer StateFrom { float state_from[]; };
layout(std430, binding = SITES_STATE_TO) writeonly restrict buffer StateTo { float state_to[]; };
layout(std430, binding = SITES_RESPONSE) writeonly restrict buffer Response { float answers[]; };
layout(std430, binding = SITES_COEFFICIENTS) readonly restrict buffer Table { Coefficients table[]; };
layout(std430, binding = SITES_INVALID) restrict buffer Invalid { uint invalid; }; // pressures met that are not finite

bool finite(float p) { return (floatBitsToUint(p) & 0x7f800000u) != 0x7f800000u; }
float valid(float p) { return finite(p) ? p : 0.0; }

int bound(int rank) { return cells[rank].cell - s.c.base_row * s.c.pitch; }

Load load_at(int rank) {
    int i = bound(rank);
    return load_between(valid(pressure_from[i]), valid(pressure_to[i]), s.c);
}

LaneCoefficients coefficients_at(int rank) {
    if (MATERIALS == 0) return lanes_of(s.c.row);
    return lanes_of(table[cells[rank].row]);
}

int state_at(int rank) { return rank * STATE_PLANES(COMPENSATED, RESPONSES); }

// At the step's end; compensated or not, `lost` is then what the sum has lost.
Compensated strain_after(int rank, Load load, LaneCoefficients k) {
    int at = state_at(rank);
    float eps = state_from[at];
    float step = strain_step(eps, load, k);
    if (COMPENSATED != 0) return added_compensated(eps, state_from[at + 1], step);
    Compensated after;
    after.value = added(eps, step);
    after.lost = 0.0;
    return after;
}

Compensated sum_after(int rank, Load load, LaneCoefficients k) {
    int at = state_at(rank) + STATE_INTEGRAL(COMPENSATED);
    float I = state_from[at];
    float gained = sum_step(state_from[state_at(rank)], I, load, k);
    if (COMPENSATED != 0) return added_compensated(I, state_from[at + 1], gained);
    Compensated after;
    after.value = added(I, gained);
    after.lost = 0.0;
    return after;
}

void advance(int rank) {
    if (!finite(pressure_to[bound(rank)])) atomicAdd(invalid, 1u);
    Load load = load_at(rank);
    LaneCoefficients k = coefficients_at(rank);
    int at = state_at(rank);
    Compensated strain = strain_after(rank, load, k);
    state_to[at] = strain.value;
    if (COMPENSATED != 0) state_to[at + 1] = strain.lost;
    if ((RESPONSES & 2) == 0) return;
    at += STATE_INTEGRAL(COMPENSATED);
    Compensated sum = sum_after(rank, load, k);
    state_to[at] = sum.value;
    if (COMPENSATED != 0) state_to[at + 1] = sum.lost;
}

float strain_at(int rank) { return strain_after(rank, load_at(rank), coefficients_at(rank)).value; }

float along(int far_low, int low, float centre, int high, int far_high, Axis a) {
    if (STENCIL == STENCIL_FIVE_POINT) return second_difference(strain_at(low), centre, strain_at(high));
    if (STENCIL == STENCIL_FOURTH_ORDER)
        return fourth_order(strain_at(far_low), strain_at(low), centre, strain_at(high), strain_at(far_high));
    return published_difference(strain_at(far_low), strain_at(low), strain_at(high), strain_at(far_high), a);
}

void respond(SiteStencil site) {
    int cell = cells[site.here].cell;
    Load load = load_at(site.here);
    LaneCoefficients k = coefficients_at(site.here);
    float eps = state_from[state_at(site.here)];
    float after = strain_after(site.here, load, k).value;
    Axis x = axis(cell % s.c.pitch, s.c.width, STENCIL, EDGES);
    Axis y = axis(cell / s.c.pitch, s.c.height, STENCIL, EDGES);
    float L = add(along(site.x_far_low, site.x_low, after, site.x_high, site.x_far_high, x),
                  along(site.y_far_low, site.y_low, after, site.y_high, site.y_far_high, y));
    float C = curvature_of(site.rest_curvature, L, s.c.bend);
    float l = s.c.curvature_length;
    float answer = response(after, C, l);
    if ((RESPONSES & 2) != 0 && site.quantity == 2) answer = response(sum_after(site.here, load, k).value, C, l);
    if (site.quantity == 3) answer = response(rate_after(eps, load, k), C, l);
    if (site.quantity == 4)
        answer = rectified(response(acceleration_after(eps, load, k), C, l), s.c.gain_plus, s.c.gain_minus);
    answers[site.answer] = answer;
}

void main() {
    int i = int((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * SITES_X + gl_LocalInvocationID.x);
    if (i < s.cells) advance(s.first_cell + i);
    else if (i < s.cells + s.sites) respond(sites[s.first_site + i - s.cells]);
}
