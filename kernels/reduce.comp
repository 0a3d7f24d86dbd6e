#version 450
// SPDX-License-Identifier: MIT
// Sum, least and greatest of one map over each tile of each row (see reduce.h): summaries[slot][row][tile].
// One invocation per tile, no shared memory: software drivers run barriers as coroutines, 20 times slower.
#extension GL_GOOGLE_include_directive : require
#include "prelude.h"
#include "layout.h"
#include "reduce.h"

layout(local_size_x = REDUCE_ROWS) in;
layout(push_constant) uniform Push { Constants c; };
layout(std430, binding = REDUCE_MAP) readonly restrict buffer Map { float map[]; };
layout(std430, binding = REDUCE_SUMMARIES) writeonly restrict buffer Summaries { Summary summaries[]; };

// Beyond the row's end: adds nothing, and repeats the tile's first value for least and greatest.
Summary cell(int x, int first, int row) {
    Summary s = summary_of(map[row + (x < c.width ? x : first)]);
    if (x >= c.width) s.sum = real(0.0);
    return s;
}

// Cells x, x + 8 .. x + 56 of a tile.
Summary eighth(int x, int first, int row) {
    Summary a = join(join(cell(x, first, row), cell(x + 32, first, row)), join(cell(x + 16, first, row), cell(x + 48, first, row)));
    Summary b = join(join(cell(x + 8, first, row), cell(x + 40, first, row)), join(cell(x + 24, first, row), cell(x + 56, first, row)));
    return join(a, b);
}

void main() {
    int y = int(gl_GlobalInvocationID.x);
    int tile = int(gl_WorkGroupID.y);
    if (y >= c.height) return;
    int first = tile * TILE_CELLS;
    int row = y * c.pitch;
    Summary part[8];
    for (int i = 0; i < 8; ++i) part[i] = eighth(first + i, first, row);
    Summary even = join(join(part[0], part[4]), join(part[2], part[6]));
    Summary odd = join(join(part[1], part[5]), join(part[3], part[7]));
    int tiles = int(gl_NumWorkGroups.y);
    summaries[(c.slot * c.height + y) * tiles + tile] = join(even, odd);
}
