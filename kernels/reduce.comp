#version 450
// SPDX-License-Identifier: MIT
// Sum, least and greatest of strain, SA1, SA2, FA1, FA2 over each tile of each row (see reduce.h).
// One group per tile (x), row (y) and quantity (z); summaries[slot][quantity][row][tile].
#extension GL_GOOGLE_include_directive : require
#include "prelude.h"
#include "layout.h"
#include "reduce.h"

layout(local_size_x = REDUCE_THREADS) in;
layout(push_constant) uniform Push { Constants c; };
layout(std430, binding = 0) readonly restrict buffer Strain { float strain[]; };
layout(std430, binding = 1) readonly restrict buffer Sa1 { float sa1[]; };
layout(std430, binding = 2) readonly restrict buffer Sa2 { float sa2[]; };
layout(std430, binding = 3) readonly restrict buffer Fa1 { float fa1[]; };
layout(std430, binding = 4) readonly restrict buffer Fa2 { float fa2[]; };
layout(std430, binding = REDUCE_SUMMARIES) writeonly restrict buffer Summaries { Summary summaries[]; };

shared Summary tile[REDUCE_THREADS];

real value_at(int i) {
    switch (gl_WorkGroupID.z) {
    case 0: return strain[i];
    case 1: return sa1[i];
    case 2: return sa2[i];
    case 3: return fa1[i];
    default: return fa2[i];
    }
}

// Beyond the row's end: adds nothing, and repeats the tile's first value for least and greatest.
Summary padded(int x, int row, int first) {
    Summary s = summary_of(value_at(row + (x < c.width ? x : first)));
    if (x >= c.width) s.sum = real(0.0);
    return s;
}

void main() {
    int thread = int(gl_LocalInvocationID.x);
    int y = int(gl_WorkGroupID.y);
    int first = int(gl_WorkGroupID.x) * TILE_CELLS;
    int row = y * c.pitch;
    tile[thread] = join(padded(first + thread, row, first), padded(first + thread + REDUCE_THREADS, row, first));
    for (int reach = REDUCE_THREADS / 2; reach > 0; reach /= 2) {
        barrier();
        if (thread < reach) tile[thread] = join(tile[thread], tile[thread + reach]);
    }
    if (thread == 0) {
        int tiles = int(gl_NumWorkGroups.x);
        int quantity = c.slot * REDUCE_QUANTITIES + int(gl_WorkGroupID.z);
        summaries[(quantity * c.height + y) * tiles + int(gl_WorkGroupID.x)] = tile[0];
    }
}
