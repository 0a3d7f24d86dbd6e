#version 450
// SPDX-License-Identifier: MIT
// Four nodes of a coarser level, of 13 x 7 finer ones (see spread.h).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require // maps.glsl
#define real vec4
#include "prelude.h"
#include "layout.h"
#include "spread.h"
#include "maps.glsl"
#include "nodes.glsl"

layout(std430, binding = SPREAD_COARSE) writeonly restrict buffer Coarse { vec4 coarse[]; };

vec4 column(int x, int y) {
    return halved(fine_at(x, y - 3), fine_at(x, y - 2), fine_at(x, y - 1), fine_at(x, y),
                  fine_at(x, y + 1), fine_at(x, y + 2), fine_at(x, y + 3));
}

void main() {
    ivec2 node = own_nodes();
    if (!has_nodes(node)) return;
    int x = 2 * node.x, y = 2 * node.y;
    vec4 p = column(x - 4, y), q = column(x, y), r = column(x + 4, y), s = column(x + 8, y);
    vec4 v = halved(vec4(p.yw, q.yw), vec4(p.z, q.xz, r.x), vec4(p.w, q.yw, r.y), vec4(q.xz, r.xz), vec4(q.yw, r.yw),
                    vec4(q.z, r.xz, s.x), vec4(q.w, r.yw, s.y));
    coarse[place(COARSE, node.x, node.y)] = of_level(v, node.x);
}
