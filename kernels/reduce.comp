#version 450
// SPDX-License-Identifier: MIT
// Sum, least and greatest of a map over each tile of each row (see reduce.h): summaries[slot][row][tile], and behind them in
// each slot the value of each probe's cell. One invocation per tile (x: row, y: tile), four cells
// at a time, no shared memory: on a software driver barriers and single loads are slow.
#extension GL_GOOGLE_include_directive : require
#define real vec4
#include "prelude.h"
#include "layout.h"
#include "reduce.h"

layout(local_size_x = REDUCE_ROWS) in;
layout(push_constant) uniform Push { ReduceConstants c; };
layout(std430, binding = REDUCE_MAP) readonly restrict buffer Map { vec4 map[]; }; // stride/4 times the rows bound
layout(std430, binding = REDUCE_PROBES) readonly restrict buffer Probes { int probes[]; }; // cells, y*pitch + x
struct TileSummary {
    float sum, low, high;
};
layout(std430, binding = REDUCE_SUMMARIES) writeonly restrict buffer Summaries { TileSummary summaries[]; };

// Four cells from column x on. Beyond the row's end: adds nothing, and repeats `first` for least and greatest.
Summary cells(int x, int row, float first) {
    vec4 v = map[row + min(x, c.pitch - 4) / 4];
    bvec4 outside = greaterThanEqual(ivec4(x, x + 1, x + 2, x + 3), ivec4(c.width));
    Summary s = summary_of(mix(v, vec4(first), outside));
    s.sum = mix(v, vec4(0.0), outside);
    return s;
}

// Cells x .. x + 3 joined with those 8, 16 .. 56 further on.
Summary eighths(int x, int row, float first) {
    Summary a = join(join(cells(x, row, first), cells(x + 32, row, first)), join(cells(x + 16, row, first), cells(x + 48, row, first)));
    Summary b = join(join(cells(x + 8, row, first), cells(x + 40, row, first)), join(cells(x + 24, row, first), cells(x + 56, row, first)));
    return join(a, b);
}

// Each cell joined with the one `reach` lanes further on; lanes below reach hold the results.
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
        int row = (y - c.base_row) * (c.stride / 4);
        float first = map[row + x / 4].x;
        s = folded(folded(join(eighths(x, row, first), eighths(x + 4, row, first)), 2), 1);
    } else {
        i += c.height * c.tiles + (y - c.rows);
        int cell = probes[y - c.rows];
        int row = cell / c.pitch;
        if (row < c.first_row || row >= c.first_row + c.rows) return; // another band's, or never pressed: it stays 0
        int at = (row - c.base_row) * c.stride + cell % c.pitch;
        s = summary_of(vec4(map[at / 4][at % 4]));
    }
    summaries[i].sum = s.sum.x;
    summaries[i].low = s.low.x;
    summaries[i].high = s.high.x;
}
