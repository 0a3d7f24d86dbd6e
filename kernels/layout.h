// SPDX-License-Identifier: MIT
// What host and kernels agree on: the parameter block, binding numbers, sizes, names of variants.

// Maps are row-major, index = y*pitch + x; pitch is the width rounded up to PITCH_CELLS: a cache line of floats.
#define PITCH_CELLS 16
// `press` runs PRESS_CELLS cells per invocation in groups of PRESS_X x PRESS_Y; `fields` one in groups of FIELDS_X x 1;
// `reduce` one tile of TILE_CELLS columns per invocation in groups of REDUCE_ROWS rows.
#define PRESS_CELLS 4
#define PRESS_X 64
#define PRESS_Y 1
#define FIELDS_X 64
#define TILE_CELLS 64
#define REDUCE_ROWS 16

#define STENCIL_FIVE_POINT 0
#define STENCIL_FOURTH_ORDER 1
#define STENCIL_PUBLISHED 2
#define EDGES_MIRROR 0
#define EDGES_PERIODIC 1
#define EDGES_PUBLISHED 2

#define PRESS_PRESSURE_FROM 0
#define PRESS_PRESSURE_TO 1
#define PRESS_REST_CURVATURE 2
#define PRESS_STATE_FROM 3
#define PRESS_STATE_TO 4
#define PRESS_SA1 5
#define PRESS_SA2 6
#define PRESS_FA1 7
#define PRESS_FA2 8
#define PRESS_ROWS 9
#define PRESS_MATERIAL 10
#define PRESS_BINDINGS 11
// A state is this many maps, one behind the other: strain, its integral, and if compensated what each has lost.
#define STATE_SUM 1
#define STATE_STRAIN_LOST 2
#define STATE_SUM_LOST 3

#define FIELDS_SURFACE 0
#define FIELDS_REST_CURVATURE 1
#define FIELDS_STRAIN 2
#define FIELDS_CURVATURE 3
#define FIELDS_DEFORMATION 4
#define FIELDS_BINDINGS 5

#define REDUCE_MAP 0
#define REDUCE_PROBES 1
#define REDUCE_SUMMARIES 2
#define REDUCE_BINDINGS 3
// what is reduced: strain, SA1, SA2, FA1, FA2, in this order everywhere
#define REDUCED_MAPS 5

// Coefficients of one step of one material, made on the host in double (host/plan/coefficients). With
//   r = s0 - E*eps            s0 the pressure after the jump sj at the step's start, s0 + ds the pressure at its end
//   eps += b*r + f*ds         strain
//   I   += i0*eps + i1*s0 + i2*ds - leak*I      its integral, or with leak > 0 its adapting integral
//   eps'  = v0*r + v1*ds              at the end of the step, from the left
//   eps'' = a0*r + a1*ds + a2*sj
struct Row {
    scalar E, b, f;
    scalar i0, i1, i2, leak;
    scalar v0, v1;
    scalar a0, a1, a2;
};

struct Constants {
    Row row;                      // of a uniform material; otherwise a table holds rows, and each cell has an index into it
    scalar start, rise, jump;     // pressure = start*p after a jump of jump*p, then rising by rise*p; or between frames
                                  // p and q: start of the way from p to q, then rise of it, after a jump of jump*p
    scalar bend;                  // thickness / spacing^2: turns the stencil's sum over eps into curvature
    scalar curvature_length;      // l in 1 + l*C
    scalar gain_plus, gain_minus; // FA2 = gain_plus*max(a, 0) + gain_minus*max(-a, 0)
    scalar thickness;             // h in D = S - h*eps
    int width, height, pitch;   // cells
    int first_column, first_row; // where the invocations begin: cells before are never pressed, so all they have is +0
    int respond;                 // 0: advance the state alone
};

struct ReduceConstants {
    int width, height, pitch, tiles; // cells; tiles of a row
    int first_tile, first_row, rows; // which of them
    int probes;                      // cells whose value is wanted too
    int slot;                        // where in the ring of results all this goes
};
