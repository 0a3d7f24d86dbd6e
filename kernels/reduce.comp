#version 450
// SPDX-License-Identifier: MIT
// Sum, minimum and maximum of a map over each tile of each row (see reduce.h): summaries[slot][row][tile], and at the end
// of each slot the values of the probes. An invocation takes one tile (x: row, y: tile), four cells at a time and without
// shared memory: on a software driver barriers and single loads are slow.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require // maps.glsl
#define real vec4
#include "prelude.h"
#include "layout.h"
#include "reduce.h"
#include "maps.glsl"

layout(local_size_x = REDUCE_ROWS) in;
layout(push_constant) uniform Push { ReduceConstants c; };
MAP(REDUCE_MAP, Map, map); // stride/4 vec4s per bound row
layout(std430, binding = REDUCE_PROBES) readonly restrict buffer Probes { int probes[]; }; // cells, y*pitch + x
struct TileSummary {
    float sum, low, high;
};
layout(std430, binding = REDUCE_SUMMARIES) writeonly restrict buffer Summaries { TileSummary summaries[]; };

// Cells x .. x + 3 of the row that begins at the vec4 `start`. Cells beyond the row's end add 0 to the sum, and count
// as `first` for minimum and maximum.
Summary cells(int x, int start, float first) {
    vec4 v = FOUR(map, start + min(x, c.pitch - 4) / 4);
    bvec4 outside = greaterThanEqual(ivec4(x, x + 1, x + 2, x + 3), ivec4(c.width));
    Summary s = summary_of(mix(v, vec4(first), outside));
    s.sum = mix(v, vec4(0.0), outside);
    return s;
}

// Cells x .. x + 3 joined with the cells 8, 16 .. 56 columns further on.
Summary eighths(int x, int start, float first) {
    Summary a = join(join(cells(x, start, first), cells(x + 32, start, first)),
                     join(cells(x + 16, start, first), cells(x + 48, start, first)));
    Summary b = join(join(cells(x + 8, start, first), cells(x + 40, start, first)),
                     join(cells(x + 24, start, first), cells(x + 56, start, first)));
    return join(a, b);
}

// Each lane joined with the one `reach` further on; the lanes below `reach` hold the results.
Summary folded(Summary s, int reach) {
    Summary t;
    t.sum = reach == 2 ? s.sum.zwxy : s.sum.yxwz;
    t.low = reach == 2 ? s.low.zwxy : s.low.yxwz;
    t.high = reach == 2 ? s.high.zwxy : s.high.yxwz;
    return join(s, t);
}

void main() {
    int y = int(gl_GlobalInvocationID.x);
    int tile = int(gl_WorkGroupID.y) + c.first_tile;
    if (y >= c.rows + c.probes || (y >= c.rows && tile > c.first_tile)) return;
    int i = c.slot * (c.height * c.tiles + c.probes);
    Summary s;
    if (y < c.rows) {
        y += c.first_row;
        i += y * c.tiles + tile;
        int x = tile * TILE_CELLS;
        int start = (y - c.base_row) * (c.stride / 4);
        float first = FOUR(map, start + x / 4).x;
        s = folded(folded(join(eighths(x, start, first), eighths(x + 4, start, first)), 2), 1);
    } else {
        i += c.height * c.tiles + (y - c.rows);
        int cell = probes[y - c.rows];
        int row = cell / c.pitch;
        if (row < c.first_row || row >= c.first_row + c.rows) return; // in another row window, or 0 for ever
        int at = (row - c.base_row) * c.stride + cell % c.pitch;
        s = summary_of(vec4(ONE(map, at)));
    }
    summaries[i].sum = s.sum.x;
    summaries[i].low = s.low.x;
    summaries[i].high = s.high.x;
}
