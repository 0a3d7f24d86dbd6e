// SPDX-License-Identifier: MIT
// The loops of the model over the cells of a row, compiled once for each instruction set of the processor family. The
// text is the same, and so are the bits.
#pragma once

#include "host/core/simd/model.hpp"

#include <cstddef>
#include <vector>

namespace dermis::simd {

// Row y of a map and the rows that a stencil reads beside it, each from column 0 on, and the published stencil's
// weights across them.
template <class real> struct RowNeighbours {
    const real *far_low, *low, *here, *high, *far_high;
    real w_low, w_high, w;
    int width, stencil, edges; // stencil and edges: numbers of kernels/layout.h
};

// row(i) is where row i of the map begins. The five-point stencil has no far rows: the near ones are repeated.
template <class real, class RowOf>
RowNeighbours<real> neighbours(int y, int width, int height, int stencil, int edges, RowOf row) {
    const f64::Axis a = f64::axis(y, height, stencil, edges);
    const bool far = f64::reach(stencil) > 1;
    return {.far_low = row(far ? a.far_low : a.low),
            .low = row(a.low),
            .here = row(y),
            .high = row(a.high),
            .far_high = row(far ? a.far_high : a.high),
            .w_low = real(a.w_low),
            .w_high = real(a.w_high),
            .w = real(a.w),
            .width = width,
            .stencil = stencil,
            .edges = edges};
}

// The sums of a state: the strains of elements in series, and the integral of the cell's strain.
enum StateSum { sum_strain, sum_integral, state_sums };

// One row of a state: for each sum the values, and what they have lost to rounding, null unless sums are compensated.
template <class real> struct StateRow {
    real* value[state_sums]; // of the integral null where the state has none
    real* lost[state_sums];
    size_t element; // the distance from an element's strains to the next element's strains
    real* strain;   // the cells' strain; of a single element its values
    real* rate;     // of a spring, between frames for FA2; otherwise null
    real* previous; // the pressure of the frame before, under parabolic hold; otherwise null
};

constexpr int most_in_series = 10; // elements of a cell, spring and dashpot included

// How the pressure runs over a step: a map under an envelope, or from frame to frame, linearly or along a parabola.
enum class Hold { held, linear, parabolic };
constexpr int entries_of(Hold hold) { return hold == Hold::parabolic ? 2 : 1; } // Coefficients of each element

// Arguments of a step of `count` cells of a row. The new state may overwrite the old one. pressure_to is null without
// frames, and material is null for a uniform material. table is then read only if there are several elements, or under
// parabolic hold, where it has two Coefficients for each element.
template <class K> struct AdvanceArguments {
    using real = typename K::real;
    int count;
    int elements;                       // elements in series, each with a strain in the state
    bool spring;                        // one more element, a spring, without a strain in the state
    const real *pressure, *pressure_to; // between frames the pressure runs from the first to the second
    const int* material;
    const int* line_material; // for each PITCH_CELLS cells their material, or -1 if they have several; null: all -1
    const typename K::Coefficients* table;
    StateRow<real> from, to;
    real* signal[STEP_SIGNALS]; // the signals that the state does not hold, at the step's end; null: not asked for
};
// Bits that an advance returns: the sum changed in some cell.
constexpr int strain_changed = 1 << sum_strain, integral_changed = 1 << sum_integral;

// Arguments of the responses of columns first .. last - 1, where first is a multiple of TILE_CELLS. All rows begin at
// column 0.
template <class K> struct RespondArguments {
    using real = typename K::real;
    int first, last;
    RowNeighbours<real> strain;        // at the step's end
    const real* signal[RESPONSE_MAPS]; // the signal of each response
    const real* rest_curvature;
    real* response[RESPONSE_MAPS]; // null: not stored
    bool streams; // responses are not read again soon: they go past the caches, where cache lines can be filled
    typename K::Summary* tiles[REDUCED_MAPS]; // null: not asked for
};

// Arguments of Loops::step_rows, which steps `rows` consecutive rows and after each step answers a row above the
// stepped one, whose stencil may read the new strain. `advance` and `respond` are the arguments of the first pair of
// rows; the distances lead to the next pair.
template <class K> struct RowSteps {
    using real = typename K::real;
    AdvanceArguments<K> advance;
    RespondArguments<K> respond;
    int rows = 1;
    size_t pitch = 0, response_pitch = 0, tiles = 0; // cells of a map, cells of a response, and tiles from row to row
    int stepped = 0, behind = 0;        // the first row that is stepped, and how far behind it rows are answered
    real* signal[STEP_SIGNALS][3] = {}; // the signals of row y, in [y % 3], from column 0 on
    real* strain[5] = {};               // the strain of row y, in [y % 5]; null where the state holds the strain
};

// Arguments of Isa::respond_pads. A pad is a small grid; its rows stand one after another without a gap, `cells`
// numbers in all. A cell has eight neighbours: the far low, low, high and far high one along its row, then across rows.
// Each is as far away as the stencil says, unless it would be beyond an edge of the grid: if bit 2*n + i of a cell's
// number in `edge` is set, its neighbour n is edge_distance[n][i] cells away. All pads share `edge`, the weights and
// the rest curvature.
struct PadResponses {
    int pads, cells, width, stencil;
    bool mirrored; // with the five-point stencil, a neighbour beyond an edge is the cell itself
    int edge_distance[8][2];
    const int* edge;        // of each cell
    const float* weight[6]; // of the published stencil: w_low, w_high and w along a row, then across rows
    const float* rest_curvature;
    size_t pitch;                       // from pad to pad of the next two
    const float* strain;                // at the step's end; whatever stands beside it may be read and is not used
    const float* signal[RESPONSE_MAPS]; // the signal of each response
    float* response[RESPONSE_MAPS];     // `cells` from pad to pad; null: not asked for
};

// The half-plane to the right of the line through the point (b, a) in direction (along_b, along_a), line included.
struct HalfPlane {
    double b, a, along_b, along_a;
};

constexpr int polygon_edges = 8;

// Sums in two parts (kernels/reduce.h), one for each column.
struct LongSums {
    double *sum, *rest;
};

// Sums over the rows of each column of p, a and b (see host/lab/reduced/moments.hpp), and the range of p.
struct ColumnSums {
    LongSums p, a, b;
    double *least, *greatest;
};

// The most tiles that a call joins by the tree of kernels/reduce.h, and the result.
constexpr int tiles_joined = 64;
template <class K> struct JoinedTiles {
    typename K::LongSum sum;
    typename K::real low, high;
};

// Arguments of a press of fibres first .. last - 1 of one kind. Both are multiples of a cache line of numbers, at whose
// beginnings planes and inputs start.
template <class K> struct FibreArguments {
    using real = typename K::real;
    const typename K::FibreConstants* constants;
    int first, last;
    int part, end;                  // the substeps of the press that are taken: from `part` on, before `end`
    int endings, of_pad;            // of each fibre; numbers from an ending of a fibre to its next
    real* state;                    // FIBRE_PLANES planes
    size_t plane;                   // numbers from plane to plane
    const real* input;              // of each ending at the end of the press
    typename K::FibreEntry* spikes; // room for one in each of these substeps of each ending
};

// Rows of nodes (kernels/spread.h). `beside` numbers belong to a node, of pads whose nodes stand side by side: 1, or
// Loops::beside. Rows of levels have zeros around them: 16 nodes, or 8 of pads side by side.

// Arguments of a row of a coarser level.
template <class K> struct HalveRow {
    using real = typename K::real;
    const real* row[7]; // of the finer level, from its first node on; zeros for a row that it does not have
    int low, high;      // its first and last node
    int coarse_low, count;
    int beside;
    real *column, *even, *odd; // room of the caller's: zeros in front of it, and two rows more behind it
    real* to;
};

constexpr int most_radius = 7;
// Arguments of a row that comes up: stencil, coarser level, answer.
template <class K> struct SpreadRow {
    using real = typename K::real;
    int count; // nodes
    int beside;
    int radius;                                               // of the stencil; -1: there is none
    const real* weight;                                       // (radius + 1)^2
    const real* here;                                         // the level's own row as it went down
    const real *low[most_radius + 1], *high[most_radius + 1]; // [b]: b rows before and behind it
    real* fold[most_radius + 1];                              // room of the caller's
    const real* wide[4]; // rows of the coarser level from widen_row(), from the first node on; null: there is none
    bool odd;            // the row lies between wide[1] and wide[2]
    int quantity;        // its number in kernels/layout.h, if the row answers; 0: it is stored as it is
    const real* gain;    // null: 1
    real* to;
};

template <class K> struct Loops {
    using real = typename K::real;
    void (*laplacian)(const RowNeighbours<real>&, int first, int last, real* L);
    int (*advance)(const AdvanceArguments<K>&, const typename K::Constants&);
    void (*respond)(const RespondArguments<K>&, const typename K::Constants&);
    // Joins 1 to tiles_joined tiles.
    void (*join_tiles)(const typename K::Summary* tiles, int count, JoinedTiles<K>&);
    // Does advance() of each row, then respond() in the same columns of the row above. Both are one loop in f32, where
    // the pressure comes in frames and no sums are asked for. Skins of several materials are an exception if their
    // cells are chains or their hold is parabolic. The one loop may read each row up to its pitch, writes rows of
    // states and signals up to their pitch, and returns all bits.
    int (*step_rows)(const RowSteps<K>&, const typename K::Constants&);
    // Presses fibres. Returns the number of spikes, which come in the order of their fibres, then of time.
    int (*press_fibres)(const FibreArguments<K>&);
    int beside; // pads that stand side by side
    void (*halve_row)(const HalveRow<K>&);
    // Writes 2*pairs nodes between and at the nodes of a row, from node 0 of `from` on.
    void (*widen_row)(const real* from, int pairs, int beside, real* to);
    void (*spread_row)(const SpreadRow<K>&, const typename K::Constants&);
    // Writes gain_at() of a row of cells; the rest curvature is the same for all pads.
    void (*gain_row)(const RowNeighbours<real>& strain, int beside, const real* rest_curvature,
                     const typename K::Constants&, real* gain);
    // Copy maps of `beside` pads, `count` numbers each, to where they stand side by side, and back.
    void (*to_beside)(const real* const* pads, int count, real* to);
    void (*from_beside)(const real* from, int count, real* const* pads);
};

// One instruction set.
struct Isa {
    const char* name;
    bool (*supported)(); // true if this processor supports it
    Loops<f32> in_f32;
    Loops<f64> in_f64;
    void (*respond_pads)(const PadResponses&, const f32::Constants&);
    // Computes a = p*(1 + length*rest) and b = p*(length*(bend*L)) of `width` cells and adds them to the sums.
    void (*moments)(const double* p, const double* rest, const double* L, int width, double length, double bend,
                    double* a, double* b, const ColumnSums& sums);
    // Adds only to the sums of p, a and b, with the same bits as moments.
    void (*means)(const double* p, const double* rest, const double* L, int width, double length, double bend,
                  const ColumnSums& sums);
    // distance[x] = greatest signed distance of the point (b[x], a[x]) to the polygon_edges edges, each distance times
    // its edge's length; positive: outside the polygon. Returns whether some point is outside.
    bool (*outside)(const double* a, const double* b, int width, const HalfPlane* edges, double* distance);
    // Updates the column maxima of |five - fourth|, |five| and max(|own|, |rest|). Returns whether some cell is a kink:
    // |five - fourth| > |five|/2.
    bool (*compare)(const double* five, const double* fourth, const double* own, const double* rest, int width,
                    double* differ, double* bent, double* curved);
    void (*fence_streams)(); // makes responses that the loops have streamed past the caches visible to other threads

    template <class K> const Loops<K>& of() const {
        if constexpr (std::is_same_v<K, f32>) return in_f32;
        else return in_f64;
    }
};

extern const Isa plain;
#ifdef DERMIS_X86_64
extern const Isa avx2, avx512;
#endif

const std::vector<const Isa*>& isas(); // the instruction sets that this processor supports, the best first, plain last
inline const Isa& best() { return *isas().front(); }

} // namespace dermis::simd
