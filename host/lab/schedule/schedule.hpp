// SPDX-License-Identifier: MIT
// The load and the output times of a run.
#pragma once

#include "host/core/model/site_cells.hpp"
#include "host/lab/scenes/instant.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/schedule/half_space.hpp"

#include <memory>

namespace dermis::model {

struct Schedule {
    Method method = Method::exact;
    bool allow_unstable = false;
    Load load; // validated
    Time time;
    Output output;
    Map pressure;               // Pa, width*height; of a sequence the greatest |pressure| of each cell over all frames
    double unit = 1;            // Pa: the maps are in this unit, a power of two (in_units)
    double quantum = 0x1p-1074; // Pa: the rounding of a pressure below 2^-1022; in_parts() divides it
    // Above the receptors of each class that is wanted; null: they answer to their cell alone. Classes of equal depth
    // share one.
    HalfSpaces half_space;
    std::array<Map, REDUCED_MAPS> stress; // Pa, below each half-space, width*height; empty without, and if framed
    // A stress that classes follow, over the modulus at which it comes to rest: the sum of elements of modulus 1 under
    // the load, each times its share. Empty where none is followed.
    std::vector<Element> modes;
    std::vector<double> shares;
    std::array<bool, REDUCED_MAPS> follows{}; // whether a quantity follows the stress
    Map crests;                               // scene::crest_factors; empty: the contact is even
    bool framed = false;                      // the pressure runs between the frames given to Stepper::frame
    std::shared_ptr<scene::Frames> sequence;  // null if the load is not known by frames
    std::vector<double> frame_peaks;          // greatest |pressure| of each frame of a sequence, Pa
    std::vector<double> frame_changes;        // greatest |change| of a cell's pressure from each frame to the next, Pa
    size_t changed_most = 0;                  // the cell of the greatest of these changes
    double fine_load = 0;                     // Report::fine_load
    // The greatest |Laplacian| of a frame, per cell^2, over the frame's peak. Strains are no rougher: they are sums of
    // frames, each times a number >= 0. Known where receptors lie at depths and the pressure runs along lines.
    std::optional<double> frame_roughness;
    PressedBox pressed;
    long long outputs = 0;                   // number of output times
    long long every = 1;                     // Time::step's from output to output, a power of two
    std::vector<scene::Instant> field_times; // ascending, unique; at an output's time if only rounding is between
    std::vector<Cell> points;                // cells whose values are read: Output::probes, then the skin's sites
    Wanted wanted{};
    // Where the load is a sum of products: each of the others as if it were alone. The first has what belongs to the
    // run, such as points. All take the same steps, because each takes the impulses of all; its own jump may be 0.
    std::vector<Schedule> others;
    std::vector<scene::Instant> jumps; // times at which some product jumps, ascending; empty without others
    bool keeps_maps = false;           // maps of responses are read, not only their totals
    bool derives = false;              // curvature or deformation is read
    bool parabolic() const { return load.hold == Hold::parabolic; } // the pressure runs along parabolas between frames
    double between_outputs() const { return time.step * double(every); } // s
    // The map to which a quantity answers.
    const Map& map_of(size_t q) const { return stress[q].empty() ? pressure : stress[q]; }
    size_t products() const { return 1 + others.size(); }
    const Schedule& product(size_t i) const { return i == 0 ? *this : others[i - 1]; }
    // Whether a quantity is the sum of modes in a cell of its own, which under frames is no map times a function.
    bool sums_modes(size_t q) const { return framed && q < follows.size() && follows[q]; }
    // Whether some quantity answers to the pressure on all cells.
    bool spreads() const {
        return std::ranges::any_of(half_space, [](const auto& space) { return space != nullptr; });
    }
};

// Sets Schedule::modes, shares and follows. Throws Error::bad_input where the material has no stress that is followed.
void take_follow(Schedule&, const Scene&);

// A validated scene prepared to run.
struct PreparedRun {
    PreparedSkin skin;
    Schedule schedule;
};
// check: every map of every output is to be compared with another backend's map. threads: they make the skin's maps, as
// for Device::cpu.
PreparedRun prepare_run(const scene::ValidatedScene&, bool check = false, int threads = 0);
// Validates the scene, once. Throws Error::bad_input.
PreparedRun prepare_run(const Scene&, bool check = false, int threads = 0);

// The same schedule with only every 2^n-th output, at most `most` of them. For the exact method: under an envelope it
// needs no other outputs.
Schedule with_fewer_outputs(const Schedule&, long long most);

PressedCells pressed_cells(const Schedule&);

Variant variant_of(const PreparedSkin&, const Schedule&, Precision);

// The run with one element for each part of the skin, and with the pressure over each cell's resistance. Its strain is
// the same. A run whose skin is uniform stays as it is.
PreparedRun in_parts(PreparedRun);

// The elements that a timeline makes coefficients for: the materials, then the modes of a stress.
std::vector<Element> elements_of(const PreparedSkin&, const Schedule&);

// Pa: a power of two in which the products of a map of extreme magnitudes stay in range; 1 for all other maps.
double unit_of(const std::vector<double>& map);
// The run with its map in that unit, for models that compute products.
PreparedRun in_units(PreparedRun);

// The reason why a model cannot serve; empty if it can.
std::string why_not(const PreparedSkin&, const Schedule&, Model);
// The reason why the strain is not, in each of a few parts of the skin, a map times a function of time; empty if it is.
std::string why_not_separable(const PreparedSkin&, const Schedule&);

} // namespace dermis::model
