// SPDX-License-Identifier: MIT
// dermis: pressure on skin in, mechanoreceptor responses out. This header is the manual.
//
//     eta*eps' + E*eps = sigma      strain eps in each cell under pressure sigma (Kelvin-Voigt, no lateral coupling)
//     C = L(S) - h*L(eps)           curvature of the deformed surface S - h*eps; L is the Laplacian; C < 0 on crests
//     SA1 = eps*(1 + l*C)           Merkel          SA2 = integral of eps*(1 + l*C)   Ruffini
//     FA1 = eps'*(1 + l*C)          Meissner        FA2 = eps''*(1 + l*C)             Pacinian
//
//     dermis::Result r = dermis::run(dermis::Scene::from_file("scene.toml"));
//
// Maps are row-major, row 0 first: index = y*width + x. The centre of cell [x, y] lies (x + 0.5)*spacing along a row
// and (y + 0.5)*spacing across the rows from the outer corner of cell [0, 0]; seen from outside the skin the rows
// follow one another a quarter turn counter-clockwise from the direction along a row. Pressure pushes where it is
// positive; a negative one is suction, which lifts the skin, and strain and responses change their sign with it. Every
// output at a time t is the left limit at t, and 0 at t = 0 until the load has acted. Functions throw dermis::Error,
// and check their input before they write anything.
#pragma once

#include <dermis/export.hpp>
#include <dermis/version.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace dermis {

class DERMIS_API Error : public std::runtime_error {
  public:
    enum class Code {
        bad_input, // a parameter is not allowed; the message names it, its value and the allowed range
        no_device, // there is no such device, or none that can compute; the message says what is missing
        device,    // a device failed while working; the message names the call (see Device)
        io,        // a file could not be written
        no_memory  // memory could not be allocated; the message says what for and how much, unless none is left for it
    };
    Error(Code code, std::string parameter, const std::string& message)
        : std::runtime_error(one_line(message)), code_(code), parameter_(std::move(parameter)) {}
    Code code() const noexcept { return code_; }
    // Dotted name of the parameter at fault, as in a scene file ("time.step"); empty if there is none.
    const std::string& parameter() const noexcept { return parameter_; }

  private:
    // A message may quote a file or a key, with its line breaks and other control characters.
    static std::string one_line(std::string message) {
        for (char& c : message)
            if (static_cast<unsigned char>(c) < 32) c = ' ';
        return message;
    }
    Code code_;
    std::string parameter_;
};

// deformation: S - h*eps. indentation: h*eps, of a Skin alone.
enum class Quantity { strain, sa1, sa2, fa1, fa2, curvature, deformation, indentation };
DERMIS_API const char* name(Quantity) noexcept;

// exact: the closed-form solution of each step, at any step length. euler .. sdirk2: one-step baselines for comparison,
// which hold the load over a step and are constants of the same kernel. published: forward Euler with the published
// study's stencil, edges, SA2 as a running sum and FA2 as a central difference.
enum class Method { exact, euler, rk2, rk4, backward_euler, crank_nicolson, sdirk2, published };
DERMIS_API const char* name(Method) noexcept;

// The models by which a result is computed. Any two that can serve a scene agree on it.
//   moments   all means, extremes and probes from three means and a hull   exact for one retardation time under map x
//   maps      the same, and fields in one pass each                        envelope, and linear fa2_gains; in double
//   sites     receptors with their stencil's cells alone, no traces        any material and load; in double
//   march     every cell, from output to output                            any
enum class Model { moments, maps, sites, march };
DERMIS_API const char* name(Model) noexcept;

// f32_compensated carries the rounding error of each sum, for long runs and small steps. f64 runs on the CPU only.
enum class Precision { f32, f32_compensated, f64 };
DERMIS_API const char* name(Precision) noexcept;

enum class Stencil { five_point, fourth_order, published };
enum class Edges { mirror, periodic, published }; // mirror is half-sample: cell -1 is cell 0, cell -2 is cell 1
enum class Fa2 { point, step_mean };

struct Cell {
    int x = 0, y = 0;
};

// One number per cell, width*height, row 0 first. Copies share the numbers, so a scene is cheap to copy.
class Map {
  public:
    Map() = default;
    Map(std::vector<double> values) : values_(std::make_shared<std::vector<double>>(std::move(values))) {}
    Map(std::initializer_list<double> values) : Map(std::vector<double>(values)) {}

    const std::vector<double>& values() const { return *values_; }
    operator const std::vector<double>&() const { return values(); }
    bool empty() const { return values().empty(); }
    size_t size() const { return values().size(); }
    const double* data() const { return values().data(); }
    double operator[](size_t i) const { return values()[i]; }
    auto begin() const { return values().begin(); }
    auto end() const { return values().end(); }
    // The numbers to change; other copies of the map keep theirs.
    std::vector<double>& edit() {
        if (values_.use_count() > 1) values_ = std::make_shared<std::vector<double>>(values());
        return *values_;
    }

  private:
    std::shared_ptr<std::vector<double>> values_ = std::make_shared<std::vector<double>>();
};

// width, height: cells, 1..16384. spacing: metres between cells, > 0. Without spacing a scene is dimensionless:
// spacing, relief, thickness and curvature_length are then 1, and the material is by default the published study's;
// with it relief, thickness, curvature_length and a material are required.
struct Grid {
    int width = 150, height = 150;
    std::optional<double> spacing;
};

// flat: 0.5. wave: sin(2 pi ridges (x/width + 0.3 sin(y/30))) + noise. spiral: sin(ridges r/width + angle) + noise.
// wave and spiral are scaled to 0..1; then everything is multiplied by relief.
struct Surface {
    enum class Kind { flat, wave, spiral, map } kind = Kind::flat;
    std::optional<double> ridges;       // wave 15, spiral 25; any finite number
    std::optional<double> noise;        // amplitude of Perlin noise relative to the ridge; wave 2, spiral 0.5; >= 0
    std::optional<double> noise_length; // cells; wave 50, spiral 40; > 0
    std::optional<double> relief;       // m per unit of height; > 0
    Map map;                            // Kind::map: width*height finite heights
    std::optional<double> ridge_period; // m from crest to crest, > 0; in place of ridges, with Grid::spacing alone
};

// A spring beside a dashpot: modulus*strain + viscosity*rate = pressure. Pa and Pa s, >= 0, not both 0: viscosity 0 is
// a spring, modulus 0 a dashpot.
struct KelvinVoigt {
    double modulus = 0, viscosity = 0;
    Map modulus_map, viscosity_map; // values of each cell in place of the numbers, width*height. Empty: the number
};

struct Material {
    std::optional<double> modulus;          // E, Pa, >= 0; modulus and viscosity not both 0; without spacing 1.54
    std::optional<double> viscosity;        // eta, Pa s, >= 0; without spacing 1
    std::optional<double> thickness;        // h, m, >= 0: h*eps is the indentation
    std::optional<double> curvature_length; // l, m, any finite number: a gain
    // Values of each cell in place of the numbers, width*height, same ranges. Empty: the number everywhere.
    Map modulus_map, viscosity_map;
    // 1 to 8 elements in series in place of modulus and viscosity: their strains add up. With them a spring (Pa, > 0)
    // and a dashpot (Pa s, > 0) in the same series, the same in every cell. None of them stands beside modulus or
    // viscosity.
    std::vector<KelvinVoigt> elements;
    std::optional<double> spring, dashpot;
};

// The load over time: the pressure is map*intensity*g(t), and 0 before t = 0.
//   step   1 from start on                                       ramp   0 at start to 1 at start + rise, then 1
//   sine   mean + amplitude*sin(2 pi frequency t + phase)        pulse  1 for length from start, start + period ..
//   table  linear between (times, values), 0 before the first, the last held; a time given twice is a jump
struct Envelope {
    enum class Kind { step, ramp, sine, pulse, table } kind = Kind::step;
    double start = 0;                  // s, >= 0
    double rise = 1;                   // s, > 0
    double frequency = 1, phase = 0;   // Hz, > 0; rad
    double mean = 0, amplitude = 1;    // finite
    double length = 0.5, period = 1;   // s, > 0; period > length
    std::vector<double> times, values; // s, ascending, >= 0; finite
};

// circular: 1 - r/radius. linear: 1 - |y - center.y|/radius. point: a unit impulse smoothed by a Gaussian of radius/4.
// sequence: frames of a continuous pressure, linear from one to the next, in place of map and envelope. Frame 0 acts on
// a skin at rest at t = 0, the last is held. FA2 is then the mean over a step unless Receptors::fa2 says otherwise.
struct Load {
    enum class Kind { circular, point, linear, map, sequence } kind = Kind::circular;
    std::optional<Cell> center; // default width/2, height/2; inside the grid
    std::optional<int> radius;  // cells, >= 1; default min(width, height)/4, at least 1
    double intensity = 1;       // Pa, any finite number; multiplies maps too
    Map map;                    // Kind::map: width*height finite pressures
    Envelope envelope;
    std::string path;               // Kind::sequence: a .npy file of shape (frames, height, width), read frame by frame
    std::optional<double> interval; // Kind::sequence: s between frames, > 0
};

// Outputs are at 0, step, 2 step ..; there are ceil(duration/step - 1e-9) of them.
struct Time {
    double step = 0.01;   // s, > 0
    double duration = 10; // s, >= step
};

struct Receptors {
    std::optional<double> sa2_adaptation; // s, > 0: tau_a*y' = -y + tau_a*eps, bounded; not given: plain integral
    // Default point: the density of eps'' (jumps are in Result::impulses). step_mean, the default of a sequence and
    // where a cell has a spring (an element of viscosity 0): mean of eps'' over the step, jumps included.
    std::optional<Fa2> fa2;
    std::array<double, 2> fa2_gains = {1, -1}; // k+, k-: k+*max(a, 0) + k-*max(-a, 0) of a = eps''(1 + l*C)
};

// A receptor on one cell. Its response is the value of its class's field in that cell.
struct Site {
    Quantity type = Quantity::sa1; // sa1, sa2, fa1 or fa2
    Cell cell;                     // inside the grid
};

// Receptors per cm2. Default: the human fingertip, after Johansson and Vallbo (1979); see host/lab/scenes/fingertip.md.
struct Density {
    double sa1 = 70, sa2 = 10, fa1 = 140, fa2 = 25; // >= 0
};
// Draws round(density*area) receptors of each class, class by class, each from all cells with equal probability. A seed
// gives the same sites on every machine. Grid::spacing is required. Throws Error::bad_input.
DERMIS_API std::vector<Site> population(const Grid&, const Density& = {}, unsigned long long seed = 1);

struct FieldRequest {
    double at = 0; // s, 0..duration
    std::vector<Quantity> what;
};

struct Output {
    std::vector<Quantity> traces = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    std::vector<Cell> probes; // inside the grid
    std::vector<FieldRequest> fields;
    bool extremes = true; // min and max of each trace; without them Model::moments takes half the time
};

struct SkinDescription {
    Grid grid;
    Surface surface;
    Material material;
    std::optional<Stencil> stencil; // default five_point, with Method::published published
    std::optional<Edges> edges;     // default mirror, with Method::published published
    Receptors receptors;
    std::vector<Site> sites;
};

struct Scene : SkinDescription {
    // Default: the cheapest that serves the scene; march if a Vulkan device, Precision::f32 or a check is asked for.
    std::optional<Model> model;
    // Default: chosen with the model. RunOptions::precision overrides it.
    std::optional<Precision> precision;
    // The greatest |X - X_exact| over all numbers of an output, divided by the greatest |X_exact| over all cells and
    // over all times of rows and of fields, of each output that is asked for; > 0. A class of sites is an output of its
    // own, whose cells are those of its sites. FA2 is measured before fa2_gains, times the greater |gain|. X_exact has
    // no error in time or arithmetic on the grid, maps and load as given, but for breakpoints, frames and fields within
    // 4 ulp of a row's time, which are at that time. An output that is nowhere above 2^-64 in float, or 2^-340 in
    // double, counts as 0. If given, the tolerance always binds: a run that cannot promise it is refused, naming what
    // can be had. Default: 1e-4, for a free choice.
    std::optional<double> tolerance;
    Method method = Method::exact;
    bool allow_unstable = false; // run an explicit method beyond its stability limit
    Load load;
    Time time;
    Output output;

    // Reads a TOML file (host/lab/scenes/README.md lists the keys); paths in it are relative to it. Each of `overrides`
    // is "key=value" and replaces a key. The file is a regular file of at most 64 MiB. Throws Error::bad_input with
    // file, line, key, value and allowed range.
    DERMIS_API static Scene from_file(const std::string& path, const std::vector<std::string>& overrides = {});
    // Reads the same from a text of at most 64 MiB. Paths in it are relative to `folder`, which is by default the
    // working directory. Errors say "scene" in place of a file.
    DERMIS_API static Scene from_string(const std::string& text, const std::vector<std::string>& overrides = {},
                                        const std::string& folder = {});
};

// A human fingertip to begin with: 1 cm2 of ridged skin in metres, of a material with three decades of relaxation
// times. Each number stands with its source in host/lab/scenes/fingertip.md, and each can be changed. The load is left
// to the caller; receptors are population(scene.grid).
DERMIS_API Scene fingertip();

struct DeviceInfo {
    std::string name;   // "cpu", or what the driver calls the device
    std::string kind;   // "cpu path", "discrete GPU", "integrated GPU", "virtual GPU", "software", "other"
    std::string driver; // name and version; empty for the CPU path
    bool vulkan = false;
    bool exact = true;   // a self-test gave the bits of the CPU path
    std::string refused; // the reason why the device cannot be used; empty if it can
};

// A Vulkan device is lost once work submitted to it fails. Every later use of it, by copies and skins too, throws
// Error::device naming the call that failed, and what the driver may still use is left to it. Device::open() makes
// another one. A wait for submitted work, of a second or less on most devices, lasts until the driver ends it: no time
// of a clock tells a device that hangs from one that is slow or stopped.
// A process that is forked uses neither its parent's Vulkan devices nor its CPU devices' threads: a press or a run
// there throws Error::device and never waits, and destructors leave both alone. What it opens and makes itself works.
class DERMIS_API Device {
  public:
    // threads: 0 = one per core that the process may use, by its affinity and its control groups; 1 = only the calling
    // thread.
    static Device cpu(int threads = 0);
    // which: "auto", a hardware GPU if there is one, else the CPU path (info().refused then says in one line why no
    // Vulkan device is used); "cpu"; "vulkan", the best Vulkan device, software included; a number, an index of list();
    // anything else, a part of a Vulkan device's name. Throws Error::no_device. A device whose bits differ from the CPU
    // path's in a self-test is refused unless asked for by number or name. Opening tests the plain kernels; the first
    // run that needs another stencil, edge rule, frames or materials tests those, and refuses it if they differ.
    static Device open(const std::string& which);
    // Lists every Vulkan device, usable or not. Throws Error::no_device if there is no loader or no driver.
    static std::vector<DeviceInfo> list();

    const DeviceInfo& info() const noexcept;

    struct DERMIS_HIDDEN Impl;
    explicit Device(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
    Impl& impl() const noexcept { return *impl_; }

  private:
    std::shared_ptr<Impl> impl_;
};

// One quantity over time, over all cells and in each probe. Means are summed in twice the digits of the run. min and
// max are empty without Output::extremes.
struct Trace {
    Quantity quantity = Quantity::strain;
    std::vector<double> mean, min, max;
    std::vector<std::vector<double>> probes; // [probe][time]
};

// The weight of an impulse per cell: a jump of the load at `time` puts one into FA2, or at viscosity 0 into FA1.
// Method::exact lists it if that response is asked for, with the curvature at its instant and after fa2_gains.
struct Impulse {
    double time = 0;
    Quantity quantity = Quantity::fa2;
    double mean = 0, min = 0, max = 0; // min and max are NaN without Output::extremes
    std::vector<double> probes;
};

struct Field {
    double at = 0;
    Quantity quantity = Quantity::strain;
    std::vector<double> values; // width*height
};

struct Result {
    std::vector<double> time; // s
    std::vector<Trace> traces;
    std::vector<double> responses; // [time][site of the scene]
    std::vector<Impulse> impulses; // empty with Model::sites, which computes no other cells
    std::vector<Field> fields;
    DeviceInfo device; // the CPU path for all models but march
    Model model = Model::march;
    Precision precision = Precision::f32;
    long long steps = 0;             // steps of the whole skin
    long long left_out = 0;          // steps among them that were skipped: the skin was steady, no output could change
    long long dispatches = 0;        // GPU kernels dispatched
    double seconds = 0;              // time of stepping, without set-up; with RunOptions::check also of the comparison
    double tau_min = 0, tau_max = 0; // s: range of viscosity/modulus of the materials; infinite if a modulus is 0
    double predicted_error = std::nan(""); // Candidate::error of this run; NaN if the choice was free and needed none
    // Where Scene::tolerance is given: the greatest error in some 4 to 32 cells or sites that are computed once more in
    // long double, relative as predicted_error is. Above predicted_error something is wrong: a driver, a compiler, or
    // dermis. NaN otherwise, with Method::published, and where a baseline takes frames.
    double measured_error = std::nan("");
    std::vector<KelvinVoigt> reduced;  // Candidate::reduced of this run
    double cells_per_ridge = HUGE_VAL; // wavelength of wave and spiral, else infinite; below 8 curvature is coarse
    // The next five describe the whole skin. With Model::sites, which computes no other cells, they are not known: NaN
    // or -1.
    double stencil_estimate = std::nan("");   // 1/m: greatest |C5 - C4| at the end, the error of a five-point curvature
    double greatest_curvature = std::nan(""); // 1/m: greatest |C|, at rest, at the end and at the greatest strain
    double greatest_gain = std::nan("");      // greatest |l*C|, at the same times; above 1 responses change sign
    long long kinks = -1;                     // cells where |C5 - C4| exceeds |C|/2: curvature does not converge there
    long long pressed_cells = -1;             // cells that the load's map presses; -1 of a sequence
    // Counted with RunOptions::check. Any NaN counts as equal to any other, whatever its sign and payload.
    long long cells_compared = 0, cells_different = 0;

    DERMIS_API const Trace& trace(Quantity) const; // throws Error::bad_input if it was not asked for
};

// A figure by which a user judges whether numbers can mean skin, and the range in which they can.
struct Figure {
    double value = std::nan(""); // NaN: not known
    double least = 0, greatest = HUGE_VAL;
    bool outside() const { return value < least || value > greatest; } // false where the value is not known
};

// What the numbers of a skin mean. In a scene without Grid::spacing strains and times have no range.
struct Report {
    Figure strain;      // greatest |eps| of the traces' extremes or of a Skin's state: indentation over thickness; 0..1
    Figure indentation; // m: thickness*strain; 0..thickness
    Figure gain;        // greatest |l*C|; 0..1, above which responses can change sign
    Figure cells_per_ridge; // infinite where the surface has no ridges of its own; from 8 on
    // s, 1e-4..20: of elements in series each, else the least and the greatest of all cells. Springs and dashpots have
    // none.
    std::vector<Figure> retardation_times;
    // The responses that have in some cell another sign than what they answer to, because 1 + l*C is negative there; as
    // far as extremes of the traces show it, beyond 1e-4 of the response's greatest value.
    std::vector<Quantity> sign_changed;
};
// scene: the one that was run. What a result does not know, as strain without its trace, is NaN.
DERMIS_API Report report(const Scene&, const Result&);

struct RunOptions {
    std::optional<Precision> precision; // overrides the scene's
    // Marches in f32 on the other backend too and compares the bits of every cell of every output: a Vulkan device with
    // the CPU path, the CPU path with the best Vulkan device.
    bool check = false;
    // Whether runs of several materials over the same maps each describe the skin at their own end, at the cost of a
    // pass over all cells; otherwise the figures from Result::stencil_estimate on are those of the first material.
    bool describe_each = false;
    // Called some times a second on the thread that called, while the run is prepared and planned too, with the
    // fraction done, 0..1. What it throws ends the run. It may press skins and run scenes on any device, this one too.
    std::function<void(double)> progress;
};

// The maps that a scene is made of: the surface S, its curvature L(S) and the pressure, width*height each.
struct SceneMaps {
    Map surface, rest_curvature, pressure;
};
DERMIS_API SceneMaps maps(const Scene&);

// A model, precision and device that could serve a scene, and what that would cost.
struct Candidate {
    Model model = Model::march;
    Precision precision = Precision::f32;
    std::string device;
    long long steps = 0, dispatches = 0;
    double bytes = 0;   // greatest memory in use
    double traffic = 0; // bytes moved
    double flops = 0;
    double seconds = 0;          // an estimate from a table of rates, to choose by: no promise
    double error = std::nan(""); // upper bound of the error that Scene::tolerance limits; NaN: not needed to choose
    std::string refused;         // the reason why it is not chosen; empty if it is
    // Elements in series, springs and dashpots among them, that stand for the material's where `error` allows it.
    // Empty: the material's own.
    std::vector<KelvinVoigt> reduced;
};

struct Explanation {
    std::vector<Candidate> candidates; // cheapest first
    size_t chosen = 0;
    double stencil_estimate = 0;   // 1/m: greatest |C5 - C4| at rest; no part of the errors here
    double greatest_curvature = 0; // 1/m: greatest |C| at rest, the scale of the estimate
    // s: where materials differ, and yet the strain is the sum of a few maps, each times a function of time: the
    // retardation times of these; infinite where the modulus is 0.
    std::vector<double> retardation_times;
    double tolerance = 0;
    bool binding = false; // the tolerance is the scene's
};

// Says how run() would compute the scene, like a database's EXPLAIN. Nothing is run.
DERMIS_API Explanation explain(const Scene&, const Device& = Device::cpu(), const RunOptions& = {});

// Runs the scene, on the CPU path unless a device is given. Opening a GPU takes a loader, a driver and a self-test:
// open one once, by Device::open("auto"), and pass it to each run.
DERMIS_API Result run(const Scene&, const Device& = Device::cpu(), const RunOptions& = {});
// Runs the scene with each of these materials in place of its own. All models but march read the maps once (see
// RunOptions::describe_each).
DERMIS_API std::vector<Result> run(const Scene&, const std::vector<Material>&, const Device& = Device::cpu(),
                                   const RunOptions& = {});

} // namespace dermis

#include <dermis/skin.hpp>
