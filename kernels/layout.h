// SPDX-License-Identifier: MIT
// The interface of host and kernels: parameter blocks, sizes, and the numbers of bindings and specialization constants.

// Maps are row-major, index = y*pitch + x; pitch is the width rounded up to PITCH_CELLS, a cache line of floats, or in a
// batch of pads, whose rows may be short, to PRESS_CELLS.
#define PITCH_CELLS 16
// What an invocation computes, and the size of a workgroup. press: PRESS_CELLS cells, PRESS_X x PRESS_Y; for pads a
// workgroup has as many whole pads, or whole rows of one, as fit; of sites SITES_X entries of their list. reduce: one
// tile of TILE_CELLS columns, REDUCE_ROWS rows.
#define PRESS_CELLS 4
#define PRESS_X 32
#define PRESS_Y 4
#define SITES_X 64
#define TILE_CELLS 64
#define REDUCE_ROWS 16

#define STENCIL_FIVE_POINT 0
#define STENCIL_FOURTH_ORDER 1
#define STENCIL_PUBLISHED 2
#define EDGES_MIRROR 0
#define EDGES_PERIODIC 1
#define EDGES_PUBLISHED 2

// The quantities that are reduced, in this order everywhere; all but the strain are responses. The signals of FA1 and
// of the quantities after it are known only during a step: the state does not hold them.
#define QUANTITY_STRAIN 0
#define QUANTITY_SA1 1
#define QUANTITY_SA2 2
#define QUANTITY_FA1 3
#define QUANTITY_FA2 4
#define RESPONSE_MAPS QUANTITY_FA2 // their number is the last one's
#define REDUCED_MAPS (1 + RESPONSE_MAPS)
#define STEP_SIGNALS (1 + RESPONSE_MAPS - QUANTITY_FA1)
// The bit of a response in VARIANT_RESPONSES.
#define RESPONSE_BIT(quantity) (1 << ((quantity)-1))

// Specialization constants of press.
#define VARIANT_STENCIL 0
#define VARIANT_EDGES 1
#define VARIANT_COMPENSATED 2 // 1: the state carries the rounding errors of its sums
#define VARIANT_MATERIALS 3   // 1: each cell has an index into a table of coefficients
#define VARIANT_FRAMES 4      // 1: the pressure runs linearly from one map to another
#define VARIANT_RESPONSES 5   // the responses asked for, a bit each
#define VARIANT_ELEMENTS 6    // elements in series whose strain the state carries
#define VARIANT_SPRING 7      // 1: one more element, a spring, whose strain the state does not carry
#define VARIANT_STRAIN 8      // 1: the state holds the cell's strain too, the sum over elements and spring
#define VARIANT_PADS 9        // 1: invocations along z take the pads of a list; 2: each pad has coefficients of its own
#define VARIANT_GROUP_X 10    // size of a workgroup of press
#define VARIANT_GROUP_Y 11
#define VARIANT_GROUP_Z 12
#define VARIANT_HOLD 13 // 1: the pressure bends from frame to frame, and the table has two Coefficients for each element
#define VARIANT_CONSTANTS 14

#define PRESS_PRESSURE_FROM 0
#define PRESS_PRESSURE_TO 1
#define PRESS_REST_CURVATURE 2
#define PRESS_STATE_FROM 3
#define PRESS_STATE_TO 4
#define PRESS_RESPONSE(quantity) (PRESS_STATE_TO + (quantity))
#define PRESS_COEFFICIENTS (PRESS_RESPONSE(RESPONSE_MAPS) + 1)
#define PRESS_MATERIAL (PRESS_RESPONSE(RESPONSE_MAPS) + 2)
#define PRESS_INVALID (PRESS_RESPONSE(RESPONSE_MAPS) + 3)
#define PRESS_BINDINGS (PRESS_RESPONSE(RESPONSE_MAPS) + 4)
// Of sites, in place of fields: their list, and all of their responses.
#define PRESS_SITES PRESS_RESPONSE(QUANTITY_SA1)
#define PRESS_SITES_RESPONSE PRESS_RESPONSE(QUANTITY_SA2)

// A state interleaves its planes row by row, so that any window of rows is one range of memory. Its planes are the cell's
// strain, where VARIANT_STRAIN asks for it; then the strain of each element and, if compensated, the rounding error of
// that sum; where SA2 is asked for, the same follow for the integral of the cell's strain; then, where `rate` says so, the
// rate of a spring (kernels/step.h: spring_rate); last, where VARIANT_HOLD asks for it, the pressure of the frame before
// the one that the next step starts from.
#define STATE_SUM(s, compensated, strain) ((strain) + (s) * (1 + (compensated)))
#define STATE_RATE(elements, compensated, strain, integral) STATE_SUM((elements) + (integral), compensated, strain)
#define STATE_PREVIOUS(elements, compensated, strain, integral, rate) \
    (STATE_RATE(elements, compensated, strain, integral) + (rate))
#define STATE_PLANES(elements, compensated, strain, integral, rate, previous) \
    (STATE_PREVIOUS(elements, compensated, strain, integral, rate) + (previous))
// Windows of rows begin at a multiple of WINDOW_ROWS, where each map has an offset that every device can bind.
#define WINDOW_ROWS 4

#define REDUCE_MAP 0
#define REDUCE_PROBES 1
#define REDUCE_SUMMARIES 2
#define REDUCE_BINDINGS 3

// Coefficients of one step of one element, computed on the host in double (host/core/model/coefficients). With
//   r = s0 - E*eps            s0 the pressure after the jump sj at the step's start, s0 + ds the pressure at its end
//   eps += b*r + f*ds         strain
//   I   += i0*eps + i1*s0 + i2*ds - leak*I      its integral, or with leak > 0 its adapting integral
//   eps'  = v0*r + v1*ds              at the end of the step, from the left
//   eps'' = a0*r + a1*ds + a2*sj
// Elements in series stand one after another, a spring last. Strain, integral, rate and acceleration are sums over the
// elements. What the load adds to integral, rate and acceleration of all elements is added up on the host, in i1, i2,
// v1, a1 and a2 of the first element; b and f stay with each element. With frames, a spring's rate at the step's end is
// v0*rate + v1*ds, and its eps'' is a1 times the change of that rate.
// Under parabolic hold each element has a second Coefficients, of which only f, i2, v1 and a1 are used: they multiply
// what the pressure changed by over the step before, and add to f*ds, i2*ds, v1*ds and a1*ds.
#define COEFFICIENTS(each) \
    each(E) each(b) each(f) each(i0) each(i1) each(i2) each(leak) each(v0) each(v1) each(a0) each(a1) each(a2)
#define SCALAR_MEMBER(name) scalar name;
struct Coefficients {
    COEFFICIENTS(SCALAR_MEMBER)
};

struct Constants {
    Coefficients coefficients;    // where all cells have the same single element; otherwise a table holds them
    scalar start, rise, jump;     // Pressure over the step, after a jump of jump*p at its start. Map and envelope: from
                                  // start*p, rising linearly by rise*p. Frames p, q: from p + start*(q - p), rising by
                                  // rise*(q - p).
    scalar bend;                  // thickness / spacing^2: turns the stencil's sum over eps into curvature
    scalar curvature_length;      // l in 1 + l*C
    scalar gain_plus, gain_minus; // FA2 = gain_plus*max(a, 0) + gain_minus*max(-a, 0)
    scalar thickness;             // h in D = S - h*eps
    int width, height, pitch;     // cells
    int first_column, first_row;  // first cell of the dispatch; earlier ones are never pressed: their values are +0
    int base_row;                 // the first row that is bound
    int respond;                  // 0: only advance the state
};

// An entry of the list of pads, which stands before the table of coefficients: the pad's number, and the index of its
// first coefficients, counted in Coefficients from the beginning of the list. For press the list ends with a workgroup.
struct PadEntry {
    int pad; // -1: none
    int table;
};

// An entry of the list of a press at sites: PRESS_CELLS cells of a row of which sites need some, and one site among them.
struct SiteEntry {
    int x, y;     // the first of the cells; x = the width: none
    int needed;   // a bit for each cell that a site's stencil reads; 0: an earlier entry has the same cells
    int lane;     // the site's place among the cells
    int quantity; // the site's response; 0: there is no site
    int response; // index of its float in the response of pad 0
    int of_class; // sites of its class in a pad: floats from pad to pad
};

#define SPREAD_FINE 0   // as it went down
#define SPREAD_COARSE 1 // of halve: what is made; of spread: as it has come up
#define SPREAD_GAIN 2   // of all cells, like level 0
#define SPREAD_TO 3     // the level as it comes up, or the response
#define SPREAD_WEIGHTS 4
#define SPREAD_PADS 5
#define SPREAD_BINDINGS 6
// Maps of nodes have so many zeros on each side, behind the next multiple of 4 nodes along a row.
#define SPREAD_MARGIN 8
// Specialization constants of halve and spread.
#define SPREAD_RADIUS 0  // of the level's stencil; -1: it has none
#define SPREAD_COARSER 1 // 1: there is a coarser level
#define SPREAD_ANSWERS 2 // 1: level 0 answers: what is written is a response
#define SPREAD_OF_PADS 3 // as VARIANT_PADS
#define SPREAD_GROUP_X 4 // size of a workgroup
#define SPREAD_GROUP_Y 5
#define SPREAD_GROUP_Z 6
#define SPREAD_CONSTANTS 7

// A map of nodes: floats from row to row and from pad to pad.
struct NodeMap {
    int pitch, pad;
};
struct SpreadConstants {
    NodeMap fine, coarse;
    int x_low, x_high, y_low, y_high; // the nodes that are made
    int weights;                      // index of the level's first weight
    int quantity;                     // what answers
    int height, pitch;                // cells of responses
    scalar gain_plus, gain_minus;     // as in Constants
};

struct ReduceConstants {
    int width, height, pitch, tiles; // cells; tiles per row
    int stride;                      // cells from row to row: the pitch of a map, more in a state
    int first_tile, first_row, rows; // the part that is reduced
    int base_row;                    // the first row that is bound
    int probes;                      // number of cells whose values are copied out
    int slot;                        // index of the results in their ring
};

#define FIBRES_X 64
#define FIBRES_CONSTANTS 0
#define FIBRES_STATE 1
#define FIBRES_INPUT 2
#define FIBRES_SPIKES 3
#define FIBRES_BINDINGS 4
// Planes of the state of each ending: Fibre in kernels/afferent.h, and its input at the end of the last press.
#define FIBRE_Y0 0
#define FIBRE_Y1 1
#define FIBRE_Y2 2
#define FIBRE_MEMBRANE 3
#define FIBRE_REST 4
#define FIBRE_AFTER0 5
#define FIBRE_AFTER1 6
#define FIBRE_INPUT 7
#define FIBRE_PLANES 8
// Two more planes of dispatches that end between two endings of a substep: the share at which a fibre has fired first,
// and the ending that did.
#define FIBRE_FIRST 8
#define FIBRE_FIRES 9
#define FIBRE_DISPATCH_PLANES 10
// The most passes through all loops of an invocation; llvmpipe ends them in silence after twice as many. Other shaders
// loop over a cell's elements alone, at most 10.
#define FIBRE_PASSES 32768
#define FIBRE_OUTPUTS 3 // derivatives of the filter's output that drive the membrane: y, its first and its second
#define COURSE_DEGREE 10 // of the Taylor polynomials inside a substep
#define COURSE_DERIVATIVES (COURSE_DEGREE + FIBRE_OUTPUTS)

// Constants of one substep of fibres of one kind (kernels/afferent.h), computed on the host in double
// (host/core/model/fibres.cpp). y0, y1, y2 are the filter's output and its derivatives, in seconds, so that a state
// outlives a change of dt; in shares of a substep derivative j is yj times step^j. Matrices have rows of five: the factors
// of the drive w at the substep's start, of what the drive gains, and of y0, y1, y2.
struct FibreConstants {
    scalar filter_step[15];   // y0, y1, y2 at the end
    scalar membrane_step[15]; // what V gains by each of y0, y1, y2 with a gain of 1
    scalar start[15];         // derivatives 0, 1, 2 at the start by the filter's equation, in shares
    scalar highest[5];        // what the highest derivative of the state changes by in a substep, as at its start
    scalar back[3];           // derivative i = driven - back[2]*(i-1) - back[1]*(i-2) - back[0]*(i-3), in shares, with
    scalar driven[3];         // driven[0]*w + driven[1]*gained for i = 3, driven[2]*gained for i = 4, 0 beyond
    scalar gain[6];           // factor of y0 where it is positive, and where it is negative, then of y1 and of y2
    scalar per_scale[3];      // 1/step^j
    scalar per_factorial[COURSE_DEGREE + 1]; // 1/i!
    scalar per_next[COURSE_DEGREE];          // 1/(i + 1)
    scalar after_keep[2];     // of the currents after a spike over a substep
    scalar after_loss[2];     // substep over time
    scalar after_gain[2];     // what V gains by them
    scalar amplitude[2];
    scalar keep, loss;        // of V over a substep; substep over membrane time
    scalar value, rate;       // w = value*q + rate*(what q gains in a substep)
    scalar step, per_step;    // s, 1/s
    scalar per_substeps;
    scalar refractory;        // in substeps, at least 1
    scalar reset;
    int poles;                // of the filter
    int substeps;             // of a press
    int bisections;           // of the search for a spike within a substep
    int turn_bisections;      // of the search for a change of sign, whose place counts by its square
    int events;               // that are followed in a substep
    int outputs;              // a bit for each derivative that has gains
    int after;                // 1: a spike starts currents
};

// The fibres of one kind in neighbouring pads, of_pad of them in each, `pad` numbers apart in a plane from `first` on.
// The next endings of a pad's fibres follow of_pad numbers behind.
struct FibreDispatch {
    int from, to; // the fibres that are stepped, counted through all these pads
    int first, of_pad, pad;
    int endings; // of each fibre
    int plane; // numbers from plane to plane
    int kind;  // of the constants
    int begin, end; // substeps of single endings: number n is that of ending n % endings in substep n / endings
};
struct FibreEntry {
    int fibre; // index of its first ending in a plane
    scalar share;
};
