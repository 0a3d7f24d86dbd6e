#version 450
// SPDX-License-Identifier: MIT
// The upper limit of kernels/press.comp on a device: it reads and writes the same 44 bytes of a cell, four cells at a time,
// and computes nothing. It reads storage buffers on every device, also where `press` reads texels (kernels/maps.glsl).
#extension GL_GOOGLE_include_directive : require
#define real vec4
#include "prelude.h"
#include "layout.h"

layout(local_size_x = PRESS_X, local_size_y = PRESS_Y) in;
layout(push_constant) uniform Push { Constants c; };
layout(std430, binding = PRESS_PRESSURE_FROM) readonly restrict buffer PressureFrom { vec4 pressure_from[]; };
layout(std430, binding = PRESS_PRESSURE_TO) readonly restrict buffer PressureTo { vec4 pressure_to[]; };
layout(std430, binding = PRESS_REST_CURVATURE) readonly restrict buffer Rest { vec4 rest_curvature[]; };
layout(std430, binding = PRESS_STATE_FROM) readonly restrict buffer StateFrom { vec4 state_from[]; };
layout(std430, binding = PRESS_STATE_TO) writeonly restrict buffer StateTo { vec4 state_to[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_SA1)) writeonly restrict buffer Sa1 { vec4 sa1[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_SA2)) writeonly restrict buffer Sa2 { vec4 sa2[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_FA1)) writeonly restrict buffer Fa1 { vec4 fa1[]; };
layout(std430, binding = PRESS_RESPONSE(QUANTITY_FA2)) writeonly restrict buffer Fa2 { vec4 fa2[]; };

void main() {
    int x = int(gl_GlobalInvocationID.x) * PRESS_CELLS;
    int y = int(gl_GlobalInvocationID.y);
    if (x >= c.width || y >= c.height) return;
    int i = (y * c.pitch + x) >> 2;
    int state = (2 * y * c.pitch + x) >> 2;
    vec4 eps = state_from[state];
    vec4 sum = state_from[state + (c.pitch >> 2)];
    state_to[state] = sum;
    state_to[state + (c.pitch >> 2)] = eps;
    sa1[i] = pressure_from[i];
    sa2[i] = pressure_to[i];
    fa1[i] = rest_curvature[i];
    fa2[i] = eps;
}
