// SPDX-License-Identifier: MIT
// The description of a skin, and what responds in it.
//
//     eta*eps' + E*eps = sigma      strain eps in each cell under pressure sigma (Kelvin-Voigt, no lateral coupling)
//     C = L(S) - h*L(eps)           curvature of the deformed surface S - h*eps; L is the Laplacian; C < 0 on crests
//     SA1 = eps*(1 + l*C)           Merkel          SA2 = integral of eps*(1 + l*C)   Ruffini
//     FA1 = eps'*(1 + l*C)          Meissner        FA2 = eps''*(1 + l*C)             Pacinian
//
// Maps are row-major, row 0 first: cell [x, y] has the index y*width + x. Its centre lies at (x + 0.5)*spacing along x
// and (y + 0.5)*spacing along y, measured from the outer corner of cell [0, 0]. Seen from outside the skin, the y axis
// points a quarter turn counter-clockwise from the x axis. Positive pressure pushes into the skin; negative pressure is
// suction: it lifts the skin, and strain and responses change sign with it. Every output at a time t is the limit from
// the left: a jump of the load at t is not in it yet, and at t = 0 the load has not acted. Functions throw
// dermis::Error, and check their input before they write anything.
#pragma once

#include <dermis/export.hpp>

#include <array>
#include <cmath>
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
        no_device, // no device can be used: no loader, no driver, or a device that is refused; the message says why
        device,    // a device failed while working; the message names the call (see Device)
        io,        // a file could not be written
        no_memory  // memory could not be allocated; the message says for what and how much, if there is memory for it
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

// deformation: S - h*eps. Only a Skin gives indentation, h*eps, and, where it has shear, the shear strains along x and
// y and the three components of the strain of its surface. Units: SA2 in s, FA1 in 1/s, FA2 in 1/s^2, curvature in 1/m,
// deformation and indentation in m; the others are strains. Without Grid::spacing lengths are in cells.
enum class Quantity {
    strain,
    sa1,
    sa2,
    fa1,
    fa2,
    curvature,
    deformation,
    indentation,
    shear_x,
    shear_y,
    stretch_x,
    stretch_y,
    stretch_xy
};
DERMIS_API const char* name(Quantity) noexcept;

// f32_compensated adds the rounding error of each sum to the next one (Kahan), for long runs and small steps. f64 runs
// on the CPU only.
enum class Precision { f32, f32_compensated, f64 };
DERMIS_API const char* name(Precision) noexcept;

// The stencil of the Laplacian: of second and of fourth order.
enum class Stencil { five_point, fourth_order };
// The cell beyond an edge. mirror: cell -1 is cell 0, cell -2 is cell 1. periodic: cell -1 is the last cell.
enum class Edges { mirror, periodic };
enum class Fa2 { point, step_mean }; // see Receptors::fa2

// How a pressure that is known by frames runs over the step from one frame to the next. linear: along a line.
// parabolic: along the parabola through these two frames and the frame before them. For smooth loads a parabola is at
// least four times as accurate; after a jump it is less so, and overshoots by an eighth of the jump. The first step
// from rest, or after a pause, is linear.
enum class Hold { linear, parabolic };

// What a press prescribes: a pressure, or a depth (strain = depth/thickness, whatever the material).
enum class Control { pressure, depth };

struct Cell {
    int x = 0, y = 0;
    bool operator==(const Cell& other) const { return x == other.x && y == other.y; }
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
    std::optional<double> ridges; // default 15 for a wave, 25 for a spiral; any finite number
    std::optional<double> noise;  // amplitude of Perlin noise relative to the ridge, >= 0; default 2, of a spiral 0.5
    std::optional<double> noise_length; // cells, > 0; default 50, of a spiral 40
    std::optional<double> relief;       // m per unit of height; > 0
    Map map;                            // Kind::map: width*height finite heights
    // Kind::map: the curvature L of these heights in each cell, in heights per m^2, where it is known better than by
    // the stencil, from a finer grid; finite. Empty: by the stencil.
    Map curvature;
    // m from crest to crest, > 0, only with Grid::spacing. Of a wave or spiral it stands in place of `ridges`; of a map
    // it only says what the ridges of its heights are.
    std::optional<double> ridge_period;
};

// A spring beside a dashpot: modulus*strain + viscosity*rate = pressure. Pa and Pa s, >= 0, not both 0: viscosity 0 is
// a spring, modulus 0 a dashpot.
struct KelvinVoigt {
    double modulus = 0, viscosity = 0;
    Map modulus_map, viscosity_map; // one value per cell, width*height; empty: the number holds in every cell
};

struct Material {
    std::optional<double> modulus;          // E, Pa, >= 0; modulus and viscosity not both 0; without spacing 1.54
    std::optional<double> viscosity;        // eta, Pa s, >= 0; without spacing 1
    std::optional<double> thickness;        // h, m, >= 0: h*eps is the indentation
    std::optional<double> curvature_length; // l, m, any finite number: a gain
    // One value per cell, width*height, in the same ranges. Empty: the number holds in every cell.
    Map modulus_map, viscosity_map;
    // 1 to 8 elements in series, in place of modulus and viscosity; their strains add up. A spring (Pa, > 0) and a
    // dashpot (Pa s, > 0) can be added to the series; both are the same in every cell. None of the three can be given
    // together with modulus or viscosity.
    std::vector<KelvinVoigt> elements;
    std::optional<double> spring, dashpot;
};

// A depth for each class of receptors, m; not given: none.
struct Depths {
    std::optional<double> sa1, sa2, fa1, fa2;
};

// What the receptors of a class answer to: the strain, or the stress. The stress is divided by the modulus at which the
// material comes to rest.
enum class Signal { strain, stress };
// By class. FA1 and FA2 follow the strain.
struct Follow {
    Signal sa1 = Signal::strain, sa2 = Signal::strain;
};

// What acts at a depth: the vertical stress; the vertical strain times the modulus; or the vertical displacement times
// the modulus over z*(1 + nu)*(3 - 2*nu)/3, z the depth and nu Poisson's ratio, a length that makes it the stress
// straight below a point force. Stress falls with the fifth power of the distance, displacement with the first: FA2
// afferents answer to contacts centimetres away, which displacement alone reaches. Strain and displacement need a depth
// > 0.
enum class DepthKernel { stress, strain, displacement };
// By class.
struct DepthKernels {
    DepthKernels(DepthKernel all = DepthKernel::stress) : sa1(all), sa2(all), fa1(all), fa2(all) {}
    DepthKernel sa1, sa2, fa1, fa2;
};

struct Receptors {
    std::optional<double> sa2_adaptation; // s, > 0: tau_a*y' = -y + tau_a*eps, bounded; not given: plain integral
    // point: eps'' at the step's end; jumps of the rate are listed in Result::impulses. step_mean: the mean of eps''
    // over the step, jumps included. Default: point, but step_mean for a sequence of frames, for a Skin, and where a
    // cell has a spring (an element of viscosity 0).
    std::optional<Fa2> fa2;
    // k+, k-, finite: FA2 is k+*max(a, 0) + k-*max(-a, 0) of a = eps''*(1 + l*C).
    std::array<double, 2> fa2_gains = {1, -1};
    // m below the surface, >= 0: where the receptors of a class lie. The skin is then a flat, uniform half-space, which
    // the pressures of all cells load and nothing loads beyond the grid. The class responds to the strain that the
    // stress at its depth causes. C remains the curvature of the surface. Not given, or 0: a receptor responds to the
    // strain of its own cell. Needs Grid::spacing and, in each pad, a uniform material; refuses Edges::periodic and, in
    // a Skin, SkinOptions::control = depth and depths below a millionth or above a million times the spacing.
    Depths depth;
    DepthKernels kernel;           // what acts at that depth; if classes differ, those without a depth have the stress
    std::optional<double> poisson; // Poisson's ratio, 0..0.5, of strain, displacement, a punch and a ball; default 0.4
    // Under a pressure that is held the strain creeps; under a depth that is held the stress relaxes, and receptors
    // that follow it adapt. In a scene it needs a uniform material with a spring and no dashpot in series, and a load
    // that is a map times an envelope or, where sites alone are asked for, frames of depths or a ball. In a Skin it
    // needs a uniform material without a dashpot in series and a press by pressure, which is then the stress; SA2
    // refuses it there, and a SkinProgram refuses it.
    Follow follow;
};

// A place where the response of one class of receptors is read: the value of the class's field in a cell.
struct Site {
    Quantity type = Quantity::sa1; // sa1, sa2, fa1 or fa2
    Cell cell;                     // inside the grid
};

// Sites per cm2. Default: the human fingertip, after Johansson and Vallbo (1979): host/core/description/fingertip.md.
struct Density {
    double sa1 = 70, sa2 = 10, fa1 = 140, fa2 = 25; // >= 0; at most 1e8 sites of a class
};
// Draws round(density*area) sites of each class, class by class, each from all cells with equal probability. A seed
// gives the same sites on every machine. Grid::spacing is required. Throws Error::bad_input.
DERMIS_API std::vector<Site> population(const Grid&, const Density& = {}, unsigned long long seed = 1);

struct SkinDescription {
    Grid grid;
    Surface surface;
    Material material;
    std::optional<Stencil> stencil; // default five_point
    std::optional<Edges> edges;     // default mirror
    Receptors receptors;
    std::vector<Site> sites;
};

// A human fingertip to begin with: 1 cm2 of ridged skin in metres, of a material with three decades of relaxation
// times. Each number stands with its source in host/core/description/fingertip.md, and each can be changed. Sites
// are population(fingertip().grid); a scene of it is Scene{fingertip()}, whose load is left to the caller.
DERMIS_API SkinDescription fingertip();
// Receptors::depth of a fingertip: SA1 0.3 mm, FA1 0.5 mm and FA2 2 mm, at which its afferents were fitted with the
// default kernel and Poisson's ratio, and SA2 1.1 mm. Sources: as above.
DERMIS_API Depths fingertip_depths();

// A figure that shows whether the numbers of a skin are plausible, and the range in which they are.
struct Figure {
    double value = std::nan(""); // NaN: not known
    double least = 0, greatest = HUGE_VAL;
    bool outside() const { return value < least || value > greatest; } // false where the value is not known
};

// Whether the numbers of a skin are plausible. In a scene without Grid::spacing strains and times have no range.
struct Report {
    Figure strain;      // greatest |eps|, indentation over thickness, in the traces' extremes or a Skin's state; 0..1
    Figure indentation; // m: thickness*strain; 0..thickness; NaN without Grid::spacing
    Figure gain;        // greatest |l*C|; 0..1, above which responses can change sign
    Figure cells_per_ridge; // infinite without a ridge period, or with Surface::curvature; >= 8
    // s, 1e-4..20, ascending, equal times once: of each element in series; where cells differ, the least and the
    // greatest of all cells. Springs and dashpots have none.
    std::vector<Figure> retardation_times;
    // The responses that have the wrong sign in some cell, because 1 + l*C is negative there. A Result shows this only
    // by the extremes of its traces; values below 1e-4 of the response's greatest value do not count.
    std::vector<Quantity> sign_changed;
    // Hz: what frames lose. A line between frames that are dt seconds apart keeps sinc(f*dt)^2 of a vibration of
    // frequency f, with sinc(x) = sin(pi*x)/(pi*x). This is the frequency at which a tenth is lost, 0.178/dt; at 0.5/dt
    // it is six tenths, and above that the vibration appears at another frequency. Known where the load is a sequence,
    // and of a Skin after a step longer than 0 under linear hold.
    Figure vibration;
    // The share of the load that is finer than receptors lie deep: what cells are pressed more than the mean over the
    // square around them, which goes on as far to all sides as the deepest class lies deep (without depths a
    // fingertip's, 2 mm), within the grid. 0: an even load; close to 1: points. 0..1; without depths 0..0.1, above
    // which they matter. Of a Skin's last press, or a sequence's frame of the greatest pressure. NaN without
    // Grid::spacing or load, and where a Skin holds the cells of its sites alone.
    Figure fine_load;
};
} // namespace dermis
