#version 450
// SPDX-License-Identifier: MIT
// One step of every cell and, if asked, its responses:
//   eps, I -> eps, I at the step's end       X*(1 + l*C), X = eps, I, eps', eps'', C = L(S) - h*L(eps)
// A neighbour's new strain is computed again from its old state, so one dispatch is enough; hence two copies of the state.
#extension GL_GOOGLE_include_directive : require
#include "prelude.h"
#include "layout.h"
#include "press.h"
#include "curvature.h"

layout(local_size_x = WORKGROUP_CELLS) in;
layout(constant_id = 0) const int STENCIL = STENCIL_FIVE_POINT;
layout(constant_id = 1) const int EDGES = EDGES_MIRROR;
layout(push_constant) uniform Push { Constants c; };
// all of pitch*height floats
layout(std430, binding = PRESS_PRESSURE) readonly restrict buffer Pressure { float pressure[]; };
layout(std430, binding = PRESS_REST_CURVATURE) readonly restrict buffer Rest { float rest_curvature[]; };
layout(std430, binding = PRESS_STRAIN_FROM) readonly restrict buffer StrainFrom { float strain_from[]; };
layout(std430, binding = PRESS_SUM_FROM) readonly restrict buffer SumFrom { float sum_from[]; };
layout(std430, binding = PRESS_STRAIN_TO) writeonly restrict buffer StrainTo { float strain_to[]; };
layout(std430, binding = PRESS_SUM_TO) writeonly restrict buffer SumTo { float sum_to[]; };
layout(std430, binding = PRESS_SA1) writeonly restrict buffer Sa1 { float sa1[]; };
layout(std430, binding = PRESS_SA2) writeonly restrict buffer Sa2 { float sa2[]; };
layout(std430, binding = PRESS_FA1) writeonly restrict buffer Fa1 { float fa1[]; };
layout(std430, binding = PRESS_FA2) writeonly restrict buffer Fa2 { float fa2[]; };

real strain_at(int x, int y) {
    int i = y * c.pitch + x;
    return strain_after(strain_from[i], load_of(pressure[i], c), c.row);
}
#include "gather.h"

void main() {
    int x = int(gl_GlobalInvocationID.x);
    int y = int(gl_GlobalInvocationID.y);
    if (x >= c.width || y >= c.height) return;
    int i = y * c.pitch + x;
    Load load = load_of(pressure[i], c);
    real eps = strain_from[i];
    real after = strain_after(eps, load, c.row);
    real sum = sum_after(eps, sum_from[i], load, c.row);
    strain_to[i] = after;
    sum_to[i] = sum;
    if (c.respond == 0) return;
    real L = add(laplacian_along_x(x, y, after, c.width, STENCIL, EDGES),
                 laplacian_along_y(x, y, after, c.height, STENCIL, EDGES));
    real C = curvature_of(rest_curvature[i], L, c.bend);
    sa1[i] = response(after, C, c.curvature_length);
    sa2[i] = response(sum, C, c.curvature_length);
    fa1[i] = response(rate_after(eps, load, c.row), C, c.curvature_length);
    real a = response(acceleration_after(eps, load, c.row), C, c.curvature_length);
    fa2[i] = rectified(a, c.gain_plus, c.gain_minus);
}
