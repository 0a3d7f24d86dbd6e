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
// A state has PLANES numbers per cell.
layout(std430, binding = SITES_STATE_FROM) readonly restrict buffer StateFrom { float state_from[]; };
layout(std430, binding = SITES_STATE_TO) writeonly restrict buffer StateTo { float state_to[]; };
layout(std430, binding = SITES_RESPONSE) writeonly restrict buffer Response { float responses[]; };
layout(std430, binding = SITES_COEFFICIENTS) readonly restrict buffer Table { Coefficients table[]; };
layout(std430, binding = SITES_COEFFICIENTS) readonly buffer List { PadEntry pads[]; };
layout(std430, binding = SITES_INVALID) restrict buffer Invalid { uint invalid; }; // counts pressures that are not finite

// The invocation's pad: its number, and the index of its first coefficients. Pads stand one after another in pressures,
// states and the responses of each class.
int pad = 0;
int pad_table = 0;

// The index of a cell in the pressures that are bound. `rank` is its index in `cells`.
int bound(int rank) { return cells[rank].cell + (pad * s.c.height - s.c.base_row) * s.c.pitch; }

Load load_at(int rank) {
    int i = bound(rank);
    return load_between(valid(pressure_from[i]), valid(pressure_to[i]), s.c);
}

// A cell by its index in `cells`, and whether the step is kept.
struct Cell {
    int rank;
    bool kept;
};
LaneCoefficients tabled_of(Cell cell, int e, int second) {
    return lanes_of(table[pad_table + IN_TABLE((MATERIALS == 0 ? 0 : cells[cell.rank].material) + e) + second]);
}
LaneCoefficients element_of(Cell cell, int e) { return tabled() ? tabled_of(cell, e, 0) : lanes_of(s.c.coefficients); }
LaneCoefficients past_of(Cell cell, int e) { return tabled_of(cell, e, 1); }
int plane_of(Cell cell, int plane) { return (pad * s.cells + cell.rank) * PLANES + plane; }
real number_from(Cell cell, int plane) { return state_from[plane_of(cell, plane)]; }
void store_number(Cell cell, int plane, real x) {
    if (cell.kept) state_to[plane_of(cell, plane)] = x;
}
#include "state.glsl"
#include "cell.h"

void advance(int rank) {
    if (!finite(pressure_to[bound(rank)])) atomicAdd(invalid, 1u);
    step_of(Cell(rank, true), load_at(rank));
}

CellStep step_at(int rank) { return step_of(Cell(rank, false), load_at(rank)); }
float strain_at(int rank) { return step_at(rank).motion.strain; }

float along(int far_low, int low, float centre, int high, int far_high, Axis a) {
    bool far = reach(STENCIL) > 1;
    return difference(far ? strain_at(far_low) : centre, strain_at(low), centre, strain_at(high),
                      far ? strain_at(far_high) : centre, a, STENCIL);
}

void respond(SiteStencil site) {
    int cell = cells[site.here].cell;
    CellStep step = step_at(site.here);
    float eps = step.motion.strain;
    float L = add(along(site.x_far_low, site.x_low, eps, site.x_high, site.x_far_high,
                        axis(cell % s.c.pitch, s.c.width, STENCIL, EDGES)),
                  along(site.y_far_low, site.y_low, eps, site.y_high, site.y_far_high,
                        axis(cell / s.c.pitch, s.c.height, STENCIL, EDGES)));
    float C = curvature_of(site.rest_curvature, L, s.c.bend);
    responses[site.response + pad * site.of_class] =
        answer(site.quantity, signal(site.quantity, step.motion, step.integral), gain_at(C, s.c), s.c);
}

void main() {
    if (PADS != 0) {
        pad = pads[gl_WorkGroupID.z].pad;
        pad_table = pads[gl_WorkGroupID.z].table;
    }
    int i = int((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * SITES_X + gl_LocalInvocationID.x);
    if (i < s.cells) advance(s.first_cell + i);
    else if (i < s.cells + s.sites) respond(sites[s.first_site + i - s.cells]);
}
