#version 450
// SPDX-License-Identifier: MIT
// The curvature C = L(S) - h*L(eps) and the deformed surface D = S - h*eps of a state.
#extension GL_GOOGLE_include_directive : require
#include "prelude.h"
#include "layout.h"
#include "curvature.h"
#include "cells.glsl"

layout(local_size_x = FIELDS_X) in;
layout(push_constant) uniform Push { Constants c; };
// Each map has pitch floats per bound row; a state has PLANES times as many, the strain first.
layout(std430, binding = FIELDS_SURFACE) readonly restrict buffer Surface { float surface[]; };
layout(std430, binding = FIELDS_REST_CURVATURE) readonly restrict buffer Rest { float rest_curvature[]; };
layout(std430, binding = FIELDS_STRAIN) readonly restrict buffer Strain { float strain[]; };
layout(std430, binding = FIELDS_CURVATURE) writeonly restrict buffer Curvature { float curvature[]; };
layout(std430, binding = FIELDS_DEFORMATION) writeonly restrict buffer Deformation { float deformation[]; };

real strain_at(int x, int y) { return strain[(y - c.base_row) * PLANES * c.pitch + x]; }
#include "gather.h"

void main() {
    int x = int(gl_GlobalInvocationID.x);
    int y = int(gl_GlobalInvocationID.y) + c.first_row;
    if (x >= c.width || y >= c.height) return;
    int i = (y - c.base_row) * c.pitch + x;
    real eps = strain_at(x, y);
    real L = add(laplacian_along_x(x, y, eps, c.width, STENCIL, EDGES),
                 laplacian_along_y(x, y, eps, c.height, STENCIL, EDGES));
    curvature[i] = flush(curvature_of(rest_curvature[i], L, c.bend));
    deformation[i] = flush(deformation_of(surface[i], eps, c.thickness));
}
