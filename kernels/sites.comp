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

LaneCoefficients element_at(int rank, int e) {
    if (!tabled()) return lanes_of(s.c.coefficients);
    return lanes_of(table[pad_table + (MATERIALS == 0 ? 0 : cells[rank].material) + e]);
}

int state_at(int rank) { return (pad * s.cells + rank) * PLANES; }

Sum sum_from(int state) { return sum_of(state_from[state], COMPENSATED != 0 ? state_from[state + 1] : 0.0); }

void store(Sum sum, int state) {
    state_to[state] = sum.value;
    if (COMPENSATED != 0) state_to[state + 1] = sum.lost;
}

Sum strain_after(int rank, int e, Load load) {
    return advanced_strain(sum_from(state_at(rank) + ELEMENT(e)), load, element_at(rank, e), COMPENSATED);
}

float spring_rate_after(int rank, Load load) {
    return spring_rate(state_from[state_at(rank) + RATE], load, element_at(rank, ELEMENTS));
}

// The motion of a cell at the step's end.
Motion motion_at(int rank, Load load) {
    Motion m;
    for (int e = 0; e < ELEMENTS; ++e) {
        LaneCoefficients k = element_at(rank, e);
        float before = state_from[state_at(rank) + ELEMENT(e)];
        float after = strain_after(rank, e, load).value;
        m = e == 0 ? motion_of(before, after, load, k) : with_element(m, before, after, load, k);
    }
    if (SPRING != 0) m.strain = in_series(m.strain, spring_strain(load, element_at(rank, ELEMENTS)));
    if (CARRIES_RATE != 0)
        m = with_spring_rates(m, state_from[state_at(rank) + RATE], spring_rate_after(rank, load),
                              element_at(rank, ELEMENTS));
    return m;
}

Sum integral_after(int rank, Motion m) {
    if (!asked(QUANTITY_SA2)) return sum_of(0.0, 0.0);
    return advanced_integral(sum_from(state_at(rank) + INTEGRAL), m.gained, element_at(rank, 0), COMPENSATED);
}

void advance(int rank) {
    if (!finite(pressure_to[bound(rank)])) atomicAdd(invalid, 1u);
    Load load = load_at(rank);
    for (int e = 0; e < ELEMENTS; ++e) store(strain_after(rank, e, load), state_at(rank) + ELEMENT(e));
    if (asked(QUANTITY_SA2)) store(integral_after(rank, motion_at(rank, load)), state_at(rank) + INTEGRAL);
    if (CARRIES_RATE != 0) state_to[state_at(rank) + RATE] = spring_rate_after(rank, load);
}

float strain_at(int rank) { return motion_at(rank, load_at(rank)).strain; }

float along(int far_low, int low, float centre, int high, int far_high, Axis a) {
    bool far = reach(STENCIL) > 1;
    return difference(far ? strain_at(far_low) : centre, strain_at(low), centre, strain_at(high),
                      far ? strain_at(far_high) : centre, a, STENCIL);
}

void respond(SiteStencil site) {
    int cell = cells[site.here].cell;
    Motion m = motion_at(site.here, load_at(site.here));
    float eps = m.strain;
    float L = add(along(site.x_far_low, site.x_low, eps, site.x_high, site.x_far_high,
                        axis(cell % s.c.pitch, s.c.width, STENCIL, EDGES)),
                  along(site.y_far_low, site.y_low, eps, site.y_high, site.y_far_high,
                        axis(cell / s.c.pitch, s.c.height, STENCIL, EDGES)));
    float C = curvature_of(site.rest_curvature, L, s.c.bend);
    responses[site.response + pad * site.of_class] =
        answer(site.quantity, signal(site.quantity, m, integral_after(site.here, m).value), C, s.c);
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
