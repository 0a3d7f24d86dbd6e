// SPDX-License-Identifier: MIT
// A scene: a skin, the load on it over time, and what is asked for.
#pragma once

#include <dermis/afferents.hpp>

namespace dermis {

// exact: the closed-form solution of each step, at any step length. euler .. sdirk2: other one-step methods, to compare
// with; they hold the load over a step and give the same kernels other constants. published: forward Euler with the
// published study's stencil, edges, SA2 as a running sum and FA2 as a central difference.
enum class Method { exact, euler, rk2, rk4, backward_euler, crank_nicolson, sdirk2, published };
DERMIS_API const char* name(Method) noexcept;

// The published study's stencil, of second order, and its edges, which need that stencil and 2 x 2 cells. Not beside
// Surface::curvature. With Method::published they are the defaults.
inline constexpr Stencil published_stencil{2};
inline constexpr Edges published_edges{2};

// The models by which a result is computed. Any two that can serve a scene agree on it.
//   moments   means, extremes and probes, from three means and a convex hull; no fields
//   maps      the same, and each field in one pass
//   sites     sites alone, from the cells that their stencils read; no traces, no fields
//   march     every cell, from output to output
// All but march compute in double. moments and maps need a load that is a map times an envelope, or a sum of such
// products; gains k and -k of FA2; and a uniform material, or cells with one retardation time, or without extremes with
// up to eight.
enum class Model { moments, maps, sites, march };
DERMIS_API const char* name(Model) noexcept;

// The load over time: the pressure is map*intensity*g(t), and 0 before t = 0.
//   step   1 from start on                                       ramp   0 at start to 1 at start + rise, then 1
//   sine   mean + amplitude*sin(2 pi frequency t + phase)        pulse  1 for length from start, start + period ..
//   table  linear between (times, values), 0 before the first, the last held; a time given twice is a jump
// A step from t = 0 on and a sine may have a window, by which they are multiplied.
struct Envelope {
    // 0 until start, up to 1 within rise, 1 until `until`, and down to 0 within fall.
    struct Window {
        double start = 0, rise = 0;  // s, >= 0; a rise of 0 is a jump
        std::optional<double> until; // s, > start + rise; empty: the window does not fall
        double fall = 0;             // s, >= 0; 0 without `until`
    };
    enum class Kind { step, ramp, sine, pulse, table } kind = Kind::step;
    double start = 0;                  // s, >= 0
    double rise = 1;                   // s, > 0
    double frequency = 1, phase = 0;   // Hz, > 0; rad
    double mean = 0, amplitude = 1;    // finite
    double length = 0.5, period = 1;   // s, > 0; period > length; at most 1e6 pulses within Time::duration
    std::vector<double> times, values; // s, ascending, >= 0, each at most twice; finite; equally many, of a table >= 1
    std::optional<Window> window;      // of a step with start 0, and of a sine
};

// Waves that move over the skin and multiply a pressure, by 1 + sum over n = 1, 2 .. of
// amplitudes[n-1]*cos(n*2 pi*(s - velocity*t)/wavelength + phases[n-1]). s is the distance along `direction` from the
// centre of cell [0, 0].
struct Grating {
    double wavelength = 1;                // m, without Grid::spacing cells; > 0
    double direction = 0;                 // rad, from the x axis towards the y axis; finite
    double velocity = 0;                  // m/s along the direction, or cells/s; finite
    std::vector<double> amplitudes = {1}; // of the harmonics, 1 to 16, finite; none shorter than two cells
    std::vector<double> phases;           // rad, finite; none, or one for each amplitude
};

// Numbers that multiply the pressure of a load, and slide over the skin.
struct Texture {
    Map map;                   // width*height finite numbers; it repeats itself on all sides
    int width = 0, height = 0; // of the map, 1..16384
    // m from number to number, without Grid::spacing cells; > 0; default the grid's. The centre of the first number
    // lies over the centre of cell [0, 0] at t = 0.
    std::optional<double> spacing;
    std::array<double, 2> velocity = {0, 0}; // m/s along x and y, or cells/s; finite
};

// A recording of a sensor array: frames with a number for each taxel in place of one for each cell. The pressure of a
// taxel is (number - offset)*unit. Times its area it is the force that is spread over the cells, by a B-spline of one
// spacing (nearest), two (linear) or four (cubic); what would lie beyond the grid is reflected at its border. All
// taxels lie on the grid.
struct Taxels {
    enum class Spread { nearest, linear, cubic } spread = Spread::linear;
    double spacing = 0;                    // m from taxel to taxel, without Grid::spacing cells; > 0
    std::array<double, 2> origin = {0, 0}; // m along x and y: where the outer corner of the first taxel lies
    // Taxels in a row and in a column, 1..16384, both or neither: Load::path is then a CSV file, with a line for each
    // frame, row by row, and maybe a first line of names. It has `skip` other columns, 0..16384, before the taxels.
    std::optional<int> columns, rows;
    int skip = 0;
    std::optional<double>
        unit; // Pa, or m of depth, of 1 in the file; required; finite, not 0; Load::intensity is then 1
    // The number of a taxel at rest, finite; or, if the recording begins at rest, each taxel's in the first frame. One
    // of them is required unless the first frame is 0 everywhere.
    std::optional<double> offset;
    bool first_at_rest = false;
};

// circular: 1 - r/radius, at least 0, at r cells from the center. linear: 1 - |y - center.y|/radius, at least 0. point:
// an impulse of sum 1 smoothed by a Gaussian of radius/4.
// punch: a flat punch, round or elliptic. ball: a ball while it sinks. Both are pressed to a depth (see control).
// sequence: frames of a continuous pressure, in place of map and envelope. Frame 0 acts on a skin at rest at t = 0, the
// pressure runs linearly to frame 1, from there on as `hold` says, and the last frame is held. FA2 is then the mean
// over a step unless Receptors::fa2 says otherwise.
struct Load {
    enum class Kind { circular, point, linear, map, sequence, punch, ball } kind = Kind::circular;
    std::optional<Cell> center; // inside the grid; default width/2, height/2; not of a map or a sequence
    // Cells, 1..65536; default min(width, height)/4, at least 1; not of a map, a sequence or a ball.
    std::optional<int> radius;
    double intensity = 1; // Pa, or m of depth, any finite number; multiplies maps and frames too
    Map map;              // Kind::map: width*height finite numbers
    Envelope envelope;
    // Kind::sequence: a .npy file of shape (frames, height, width), with taxels (frames, rows, columns), which is read
    // frame by frame.
    std::string path;
    std::optional<double> interval; // Kind::sequence: s between frames, > 0; at most 1e8 frames within the duration
    Hold hold = Hold::linear;       // Kind::sequence and texture: how the pressure runs from frame to frame
    // A texture that slides over the skin: the map's pressure in each cell, times the texture's number over its centre,
    // by cubic splines. The pressure is then computed at each Time::step, and runs linearly between; FA2 is the mean
    // over a step unless Receptors::fa2 says otherwise. Only with the default envelope, and not of a sequence.
    std::optional<Texture> texture;
    // crests: the pressure acts on the crests of the surface alone, in proportion to how far they rise above the height
    // that contact_share of the cells exceed. The mean pressure over contact_length, from crest to crest, does not
    // change. Nor does the force: of the map, of each frame of a sequence, or of the map that a texture multiplies.
    // Pressures must then be >= 0.
    enum class Contact { even, crests } contact = Contact::even;
    double contact_share = 0.5;           // share of the cells that are crests, > 0, at most 1
    std::optional<double> contact_length; // m, > 0, without spacing cells; default the surface's ridge period
    // What intensity and envelope give. depth: how deep a punch (Sneddon 1965) or a ball (Lee and Radok 1960) is
    // pressed into a half-space; its pressure then relaxes as the material does, and strain is that of a surface under
    // this pressure, cell by cell. The pressure of a ball is computed at each Time::step and runs linearly between; its
    // depth must not fall. Kind::punch and ball need depth.
    // With every other kind each cell is pressed to a depth of its own, whatever the depths of its neighbours. The
    // strain is then depth/thickness, and 0 where a depth would pull. Depths need Grid::spacing, a uniform material and
    // Hold::linear.
    using Control = dermis::Control;
    Control control = Control::pressure;
    std::optional<int> radius_y;       // Kind::punch: cells along y, >= 1, where radius is along x; default: as radius
    std::optional<double> ball_radius; // Kind::ball: m, > 0, at least the greatest depth
    std::optional<Taxels> taxels;      // Kind::sequence: what the numbers of the frames belong to; default: the cells
    // Multiplies the map. Only with a step from t = 0 on, which may have a window, and not of a sequence, a texture or
    // a depth.
    std::optional<Grating> grating;
};

// Outputs are at 0, step, 2 step ..; there are ceil(duration/step - 1e-9) of them, at most 1e8.
struct Time {
    double step = 0.01;   // s, > 0
    double duration = 10; // s, >= step
};

struct FieldRequest {
    double at = 0;              // s, 0..duration; with another method than exact the time of an output
    std::vector<Quantity> what; // strain, sa1, sa2, fa1, fa2, curvature, deformation; each once at a time
};

struct Output {
    // strain, sa1, sa2, fa1, fa2, each once; may be empty.
    std::vector<Quantity> traces = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    std::vector<Cell> probes; // inside the grid
    std::vector<FieldRequest> fields;
    bool extremes = true; // min and max of each trace; without them Model::moments takes half the time
};

struct Scene : SkinDescription {
    // Default: the first of sites, moments, maps and march that serves the scene and keeps the tolerance; march if a
    // Vulkan device, Precision::f32 or a check is asked for.
    std::optional<Model> model;
    // Default: of march f32_compensated down to a tolerance of 1e-6 and f64 below, of other models f64.
    // RunOptions::precision overrides it.
    std::optional<Precision> precision;
    // The greatest error that is allowed, > 0, for each output that is asked for: the greatest |X - X_exact| over all
    // numbers of the output, divided by the greatest |X_exact| over all cells and over all times of outputs and fields.
    // The sites of one class are an output of their own; its cells are the cells of these sites. FA2 is measured before
    // fa2_gains, times the greater |gain|. X_exact is computed on the grid, maps and load as given, without any error
    // in time or arithmetic, except that a breakpoint, frame or field within 4 ulp of an output's time is taken at that
    // time. An output that is nowhere above 2^-64 in float, or 2^-340 in double, counts as 0. A tolerance that is given
    // binds: a run that cannot promise it throws Error::bad_input, which names the error that can be reached. Not
    // given: 1e-4, by which dermis chooses what is left to it; no run is refused for this.
    std::optional<double> tolerance;
    Method method = Method::exact;
    bool allow_unstable = false; // run an explicit method beyond its stability limit
    Load load;
    Time time;
    Output output;
    // Up to 63 loads whose pressures are added to the pressure of `load`. With more_loads, or with a grating that
    // moves, a scene must have a uniform material, Method::exact, gains k and -k of FA2, the default of
    // Receptors::follow, no Model::march, and no load by frames or of a depth. All loads together are at most 64
    // products of a map and an envelope; a moving grating of n amplitudes counts 1 + 2*n.
    std::vector<Load> more_loads;
    // Nerve fibres of the skin, numbered from 0 on through all entries; with Method::exact. Their cells need not be
    // sites' cells. They answer to what acts at the depth of their class, before the gain (1 + l*C), whatever the
    // model of the run; a class that Receptors::follow gives the stress has it here too.
    std::vector<Afferents> afferents;

    // Reads a TOML file (host/lab/scenes/README.md lists the keys). Relative paths in it start from its folder. Each of
    // `overrides` is "key=value" and replaces a key. The file is a regular file of at most 64 MiB. Throws
    // Error::bad_input with file, line, key, value and allowed range.
    DERMIS_API static Scene from_file(const std::string& path, const std::vector<std::string>& overrides = {});
    // Reads the same from a text of at most 64 MiB. Paths in it are relative to `folder`, which is by default the
    // working directory. Errors say "scene" in place of a file.
    DERMIS_API static Scene from_string(const std::string& text, const std::vector<std::string>& overrides = {},
                                        const std::string& folder = {});
};

// What slides over the skin, along x and y. `repeat` of a grating along an axis is infinite on the other one.
struct MovingPattern {
    std::array<double, 2> velocity, repeat; // m/s, and m after which it repeats itself; without Grid::spacing cells
};
// Returns the texture or grating that moves; nothing if none of the loads has one, or several have.
DERMIS_API std::optional<MovingPattern> moving_pattern(const Scene&);

// The generalized Maxwell model, which papers call a Prony series: the stress per strain after a step of strain,
//
//     E(t) = equilibrium + sum moduli_k*e^(-t/times_k)
//
// A chain of elements describes the same material; its retardation times viscosity_k/modulus_k are longer.
struct Relaxation {
    std::vector<double> moduli, times; // Pa, s; > 0; equally many, 0..7; moduli of equal times are added up
    double equilibrium = 0;            // Pa, >= 0; > 0 if there are no times
};
// Returns the chain with this relaxation: a spring, then elements by ascending retardation time, then, if the
// equilibrium is 0, a dashpot. The numbers are exact up to a few roundings of the last digit. Throws Error::bad_input.
DERMIS_API std::vector<KelvinVoigt> chain_of(const Relaxation&);
// Returns the relaxation of a chain of 1 to 8 elements, times ascending. Throws Error::bad_input, also for a chain
// without a spring: a step of strain takes an infinite stress.
DERMIS_API Relaxation relaxation_of(const std::vector<KelvinVoigt>&);

} // namespace dermis
