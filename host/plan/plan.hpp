// SPDX-License-Identifier: MIT
// A scene made ready to march: maps in double, constants, and the steps from output to output.
#pragma once

#include "dermis/dermis.hpp"
#include "host/plan/coefficients.hpp"
#include "host/scene/scene.hpp"
#include "host/scene/waveform.hpp"

namespace dermis::plan {

// LaneCoefficients and tiles of columns outside which no cell is ever pressed: all that such cells have is +0.
struct Pressed {
    int first_row, last_row, first_tile, last_tile; // the last is one behind
};

struct Plan {
    Scene scene; // validated, every default filled in
    SceneMaps maps;
    int pitch = 0, tiles = 0;   // cells, tiles per row
    int stencil = 0, edges = 0; // names in kernels/layout.h
    Model model = Model::march;
    Precision precision = Precision::f32;
    double predicted_error = std::nan("");
    bool compensated = false;               // f32 with what each sum has lost carried along
    f64::Constants constants{};             // what does not change from step to step
    std::vector<Medium> media;              // each material once
    std::vector<int> material;              // which of them a cell is, pitch*height; empty where there is one
    bool framed = false;                    // pressure runs from frame to frame: those handed to Stepper::frame
    std::vector<double> frame_peaks;        // of a sequence: greatest |pressure| of each frame
    std::shared_ptr<scene::NpyFile> frames; // the scene's, null without
    Pressed pressed{};
    std::vector<Cell> places;                // whose values are wanted: Output::probes, then sites
    long long outputs = 0;                   // rows of the traces
    std::array<bool, REDUCED_MAPS> wanted{}; // strain, SA1, SA2, FA1, FA2: of which anything is asked
    bool keeps_maps = false;                 // maps of responses are read, not their totals alone
    bool derives = false;                    // curvature or deformation is read
    std::vector<double> field_times;         // sorted, each once; within 1e-6 of a step from an output: that output's
};

// All but model and precision, and the rest curvature. frames: pressed by those that are handed over, not by its load.
Plan prepare(const Scene&, bool frames = false);
void complete(Plan&);                    // which Model::sites does without. Throw Error::bad_input.
Plan make_plan(const Scene&, Precision); // for a march of which every map is read
// Another modulus and viscosity, one number each, for the same skin. Throws Error::bad_input.
void set_material(Plan&, const Material&);

// Why a model cannot serve the scene; empty where it can.
std::string why_not(const Plan&, Model);
std::string why_not_separable(const Plan&); // into a map and scalars of time

// L of a map of width*height, 1/m^2 of its unit; stencil and edges as in kernels/layout.h.
std::vector<double> laplacian(const std::vector<double>& map, const Grid&, int stencil, int edges);
double laplacian_at(const std::vector<double>& map, Cell, const Grid&, int stencil, int edges);
// Columns first .. last - 1 of row y.
void laplacian_row(const std::vector<double>& map, int y, int first, int last, const Grid&, int stencil, int edges,
                   double* L);

// |C5 - C4| of the skin under the strain shape*scale: what the five-point stencil is off by, and in how many cells it
// exceeds |C|/2, which no refinement mends: a kink.
struct StencilEstimate {
    double greatest = 0, curvature = 0; // |C5 - C4|; |C| by the plan's own stencil, at rest or under the strain
    long long kinks = 0;
};
StencilEstimate stencil_estimate(const Plan&, const std::vector<double>& shape, double scale);

// One press of every cell, from the last kept state to `time`. `keep`: the new state replaces the old one; otherwise
// the step only looks (a field between outputs, an impulse). trace, impulse, field: what its end belongs to, or -1.
struct Step {
    std::shared_ptr<const std::vector<f64::Coefficients>> rows; // of Plan::media; the same pointer as before: the same rows
    double start = 0, rise = 0, jump = 0;              // see Constants in kernels/layout.h
    long long frame = -1;                              // of a sequence: pressure runs from this frame to the next
    double time = 0;
    bool keep = true;
    long long trace = -1;
    int impulse = -1, field = -1;
    bool respond() const { return trace >= 0 || impulse >= 0 || field >= 0; }
};

// What a timeline needs of a plan, for these materials and this method.
Plan timing(const Plan&, std::vector<Medium>, Method);

// Hands over the frames of a sequence as steps come to need them.
class FrameFeed {
  public:
    explicit FrameFeed(const Plan& plan) : plan_(plan) {}
    void before(const Step&, const std::function<void(const std::vector<double>&)>& give);

  private:
    const Plan& plan_;
    long long given_ = 0;
    std::vector<double> frame_;
};

// The steps of a plan, in order.
class Timeline {
  public:
    explicit Timeline(const Plan&);
    bool next(Step&);

  private:
    using LaneCoefficients = std::vector<f64::Coefficients>;
    using SharedRows = std::shared_ptr<const LaneCoefficients>;
    double output_time(long long n) const;
    double frame_time(long long k) const;
    long long frame_at(double t) const;
    bool regular(double from, double to) const;
    SharedRows rows_over(double from, double to) const;
    Step exact_step(double from, double to) const;
    Step framed_step(double from, double to) const;
    Step held_step(long long n);
    void look(Step step, int impulse, int field, double jump);
    void fill();
    void fill_frames(double from, double to);

    const Plan& plan_;
    SharedRows regular_; // of a whole step
    scene::Waveform load_;
    std::vector<Step> pending_; // of the output under way, last first
    long long output_ = 0;      // next row of the traces
    size_t field_ = 0, knot_ = 0;
    int impulses_ = 0;
    double rate_before_ = 0, rate_ = 0, strain_ = 0; // published: d[n-1], d[n], eps[n] under unit pressure
};

// A row in the precision of a backend.
template <class Coefficients> Coefficients rounded(const f64::Coefficients& k) {
    const auto r = [](double x) { return static_cast<decltype(Coefficients::E)>(x); };
    return {r(k.E), r(k.b), r(k.f), r(k.i0), r(k.i1), r(k.i2), r(k.leak), r(k.v0), r(k.v1), r(k.a0), r(k.a1), r(k.a2)};
}

// Constants of one step in the precision of a backend.
template <class Constants> Constants constants_of(const Plan& plan, const Step& step) {
    const auto r = [](double x) { return static_cast<decltype(Constants::bend)>(x); };
    const f64::Constants& p = plan.constants;
    Constants c{};
    if (step.rows) c.row = rounded<decltype(c.row)>(step.rows->front());
    c.start = r(step.start);
    c.rise = r(step.rise);
    c.jump = r(step.jump);
    c.bend = r(p.bend);
    c.curvature_length = r(p.curvature_length);
    c.gain_plus = r(p.gain_plus);
    c.gain_minus = r(p.gain_minus);
    c.thickness = r(p.thickness);
    c.width = p.width;
    c.height = p.height;
    c.pitch = p.pitch;
    c.first_column = plan.pressed.first_tile * TILE_CELLS;
    c.first_row = plan.pressed.first_row;
    c.respond = step.respond();
    return c;
}

} // namespace dermis::plan
