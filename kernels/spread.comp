#version 450
// SPDX-License-Identifier: MIT
// Four nodes of a level that comes up: its stencil and the coarser level (see spread.h); at level 0, the responses of four
// cells: X*(1 + l*C) of the signal X at their depth.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require // maps.glsl
#define real vec4
#include "prelude.h"
#include "layout.h"
#include "step.h"
#include "responses.h"
#include "spread.h"
#include "maps.glsl"
#include "nodes.glsl"

layout(constant_id = SPREAD_RADIUS) const int RADIUS = -1;
layout(constant_id = SPREAD_COARSER) const int COARSER = 0;
layout(constant_id = SPREAD_ANSWERS) const int ANSWERS = 0;
layout(std430, binding = SPREAD_WEIGHTS) readonly restrict buffer Weights { float weights[]; };
MAP(SPREAD_COARSE, Coarse, coarse);
MAP(SPREAD_GAIN, Gain, gain);
layout(std430, binding = SPREAD_TO) writeonly restrict buffer To { vec4 to[]; };

// Nodes x + shift .. x + shift + 3 of w, which are nodes x - 8 .. x + 11.
vec4 shifted(vec4 w[5], int shift) {
    int i = (shift + 8) >> 2;
    int by = (shift + 8) & 3;
    if (by == 0) return w[i];
    if (by == 1) return vec4(w[i].yzw, w[i + 1].x);
    if (by == 2) return vec4(w[i].zw, w[i + 1].xy);
    return vec4(w[i].w, w[i + 1].xyz);
}

vec4 stencil(int x, int y) {
    vec4 sum = vec4(0.0);
    for (int b = 0; b <= RADIUS; ++b) {
        vec4 v[5]; // both rows b away, added
        for (int i = 0; i < 5; ++i) {
            if (RADIUS <= 4 && (i == 0 || i == 4)) continue;
            v[i] = fine_at(x + 4 * i - 8, y - b);
            if (b > 0) v[i] = together(v[i], fine_at(x + 4 * i - 8, y + b));
        }
        int w = c.weights + b * (RADIUS + 1);
        vec4 row = weighted(vec4(weights[w]), v[2]);
        for (int a = 1; a <= RADIUS; ++a)
            row = together(row, weighted(vec4(weights[w + a]), together(shifted(v, -a), shifted(v, a))));
        sum = b > 0 ? together(sum, row) : row;
    }
    return sum;
}

// The coarser level's row y at nodes x .. x + 3, where x is a multiple of 4.
vec4 along(int x, int y) {
    int k = (x >> 1) - 1; // the first of the coarse nodes n[0] .. n[4]
    vec4 p = FOUR(coarse, place(COARSE, k & ~3, y)), q = FOUR(coarse, place(COARSE, (k & ~3) + 4, y));
    vec4 n = (k & 3) == 3 ? vec4(p.w, q.xyz) : vec4(p.yzw, q.x);
    float last = (k & 3) == 3 ? q.w : q.y;
    vec4 b = n.xxyy, d = n.yyzz, e = n.zzww, f = vec4(n.ww, vec2(last));
    return mix(at_node(b, d, e), between_nodes(b, d, e, f), bvec4(false, true, false, true));
}

vec4 coarser(int x, int y) {
    int q = y >> 1;
    vec4 b = along(x, q - 1), d = along(x, q), e = along(x, q + 1);
    return (y & 1) == 0 ? at_node(b, d, e) : between_nodes(b, d, e, along(x, q + 2));
}

void main() {
    ivec2 node = own_nodes();
    if (!has_nodes(node)) return;
    vec4 sum = RADIUS >= 0 ? stencil(node.x, node.y) : vec4(0.0);
    if (COARSER != 0) sum = RADIUS >= 0 ? together(sum, coarser(node.x, node.y)) : coarser(node.x, node.y);
    if (RADIUS < 0 && COARSER == 0) sum = fine_at(node.x, node.y); // receptors at the surface
    if (ANSWERS == 0) {
        to[place(FINE, node.x, node.y)] = of_level(sum, node.x);
        return;
    }
    Constants k;
    k.gain_plus = c.gain_plus;
    k.gain_minus = c.gain_minus;
    to[((pad * c.height + node.y) * c.pitch + node.x) >> 2] =
        answer(c.quantity, sum, FOUR(gain, place(FINE, node.x, node.y)), k);
}
