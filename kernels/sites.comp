#version 450
// SPDX-License-Identifier: MIT
// One step of the cells that the receptors' stencils read, and the response of each receptor; no other cell is computed.
// An invocation takes one cell or one receptor. The new strain beside a receptor is computed again from the old state, so
// one dispatch is enough.
#extension GL_GOOGLE_include_directive : require
#include "prelude.h"
#include "layout.h"
#include "step.h"
#include "responses.h"
#include "curvature.h"
#include "cells.glsl"

layout(local_size_x = SITES_X) in;
layout(push_constant) uniform Push { SiteConstants s; };
layout(std430, binding = SITES_PRESSURE_FROM) readonly buffer PressureFrom { float pressure_from[]; };
layout(std430, binding = SITES_PRESSURE_TO) readonly buffer PressureTo { float pressure_to[]; };
layout(std430, binding = SITES_CELLS) readonly restrict buffer Cells { SiteCell cells[]; };
layout(std430, binding = SITES_SITES) readonly restrict buffer Sites { SiteStencil sites[]; };
// A state has STATE_PLANES numbers per cell.
layout(std430, binding = SITES_STATE_FROM) readonly restrict buffer StateFrom { float state_from[]; };
layout(std430, binding = SITES_STATE_TO) writeonly restrict buffer StateTo { float state_to[]; };
layout(std430, binding = SITES_RESPONSE) writeonly restrict buffer Response { float responses[]; };
layout(std430, binding = SITES_COEFFICIENTS) readonly restrict buffer Table { Coefficients table[]; };
layout(std430, binding = SITES_INVALID) restrict buffer Invalid { uint invalid; }; // counts pressures that are not finite

// The index of a cell in the pressures that are bound. `rank` is its index in `cells`.
int bound(int rank) { return cells[rank].cell - s.c.base_row * s.c.pitch; }

Load load_at(int rank) {
    int i = bound(rank);
    return load_between(valid(pressure_from[i]), valid(pressure_to[i]), s.c);
}

LaneCoefficients coefficients_at(int rank) {
    if (MATERIALS == 0) return lanes_of(s.c.coefficients);
    return lanes_of(table[cells[rank].material]);
}

int state_at(int rank) { return rank * STATE_PLANES(COMPENSATED, RESPONSES); }

Sum strain_from(int state) { return sum_of(state_from[state], COMPENSATED != 0 ? state_from[state + 1] : 0.0); }

CellState state_of(int rank) {
    CellState cell;
    cell.strain = strain_from(state_at(rank));
    cell.integral = sum_of(0.0, 0.0);
    if (asked(QUANTITY_SA2)) cell.integral = strain_from(state_at(rank) + STATE_INTEGRAL(COMPENSATED));
    return cell;
}

void store(Sum sum, int state) {
    state_to[state] = sum.value;
    if (COMPENSATED != 0) state_to[state + 1] = sum.lost;
}

void advance(int rank) {
    if (!finite(pressure_to[bound(rank)])) atomicAdd(invalid, 1u);
    CellState after = advanced(state_of(rank), load_at(rank), coefficients_at(rank), COMPENSATED);
    store(after.strain, state_at(rank));
    if (asked(QUANTITY_SA2)) store(after.integral, state_at(rank) + STATE_INTEGRAL(COMPENSATED));
}

float strain_at(int rank) {
    return advanced_strain(strain_from(state_at(rank)), load_at(rank), coefficients_at(rank), COMPENSATED).value;
}

float along(int far_low, int low, float centre, int high, int far_high, Axis a) {
    bool far = reach(STENCIL) > 1;
    return difference(far ? strain_at(far_low) : centre, strain_at(low), centre, strain_at(high),
                      far ? strain_at(far_high) : centre, a, STENCIL);
}

void respond(SiteStencil site) {
    int cell = cells[site.here].cell;
    Load load = load_at(site.here);
    LaneCoefficients k = coefficients_at(site.here);
    CellState before = state_of(site.here);
    CellState after = advanced(before, load, k, COMPENSATED);
    float eps = after.strain.value;
    float L = add(along(site.x_far_low, site.x_low, eps, site.x_high, site.x_far_high,
                        axis(cell % s.c.pitch, s.c.width, STENCIL, EDGES)),
                  along(site.y_far_low, site.y_low, eps, site.y_high, site.y_far_high,
                        axis(cell / s.c.pitch, s.c.height, STENCIL, EDGES)));
    float C = curvature_of(site.rest_curvature, L, s.c.bend);
    responses[site.response] = answer(site.quantity, signal(site.quantity, before, after, load, k), C, s.c);
}

void main() {
    int i = int((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * SITES_X + gl_LocalInvocationID.x);
    if (i < s.cells) advance(s.first_cell + i);
    else if (i < s.cells + s.sites) respond(sites[s.first_site + i - s.cells]);
}
