#version 450
// SPDX-License-Identifier: MIT
// The kernel that kernels/press.comp is compared with: the same streamed frame by the bare model, one cell per invocation.
#extension GL_GOOGLE_include_directive : require
#include "prelude.h"
#include "layout.h"
#include "step.h"
#include "responses.h"
#include "curvature.h"

layout(local_size_x = 64) in;
layout(push_constant) uniform Push { Constants c; };
layout(std430, binding = PRESS_PRESSURE_FROM) readonly buffer PressureFrom { float pressure_from[]; };
layout(std430, binding = PRESS_PRESSURE_TO) readonly buffer PressureTo { float pressure_to[]; };
layout(std430, binding = PRESS_REST_CURVATURE) readonly buffer Rest { float rest_curvature[]; };
layout(std430, binding = PRESS_STATE_FROM) readonly buffer StateFrom { float state_from[]; };
layout(std430, binding = PRESS_STATE_TO) writeonly buffer StateTo { float state_to[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_SA1)) writeonly buffer Sa1 { float sa1[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_SA2)) writeonly buffer Sa2 { float sa2[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_FA1)) writeonly buffer Fa1 { float fa1[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_FA2)) writeonly buffer Fa2 { float fa2[]; };

float strain_of(int x, int y) {
    int i = wrapped(y, c.height, EDGES_MIRROR) * c.pitch + wrapped(x, c.width, EDGES_MIRROR);
    Load load = load_between(pressure_from[i], pressure_to[i], c);
    return advanced_strain(sum_of(state_from[i], 0.0), load, lanes_of(c.coefficients), 0).value;
}

void main() {
    int x = int(gl_GlobalInvocationID.x);
    int y = int(gl_GlobalInvocationID.y);
    if (x >= c.width) return;
    int i = y * c.pitch + x;
    int map = c.pitch * c.height;
    LaneCoefficients k = lanes_of(c.coefficients);
    Load load = load_between(pressure_from[i], pressure_to[i], c);
    float before = state_from[i];
    float after = advanced_strain(sum_of(before, 0.0), load, k, 0).value;
    Motion m = motion_of(before, after, load, k);
    float integral = advanced_integral(sum_of(state_from[i + map], 0.0), m.gained, k, 0).value;
    state_to[i] = after;
    state_to[i + map] = integral;
    float L = add(second_difference(strain_of(x - 1, y), after, strain_of(x + 1, y)),
                  second_difference(strain_of(x, y - 1), after, strain_of(x, y + 1)));
    float C = curvature_of(rest_curvature[i], L, c.bend);
    sa1[i] = answer(QUANTITY_SA1, signal(QUANTITY_SA1, m, integral), C, c);
    sa2[i] = answer(QUANTITY_SA2, signal(QUANTITY_SA2, m, integral), C, c);
    fa1[i] = answer(QUANTITY_FA1, signal(QUANTITY_FA1, m, integral), C, c);
    fa2[i] = answer(QUANTITY_FA2, signal(QUANTITY_FA2, m, integral), C, c);
}
