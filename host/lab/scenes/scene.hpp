// SPDX-License-Identifier: MIT
// Scenes: read, checked, with their defaults, and the pressure made from them.
#pragma once

#include "dermis/scene.hpp"
#include "host/core/description/description.hpp"

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>

namespace dermis::scene {

// The frames of a continuous pressure.
class Frames {
  public:
    virtual ~Frames() = default;
    virtual long long maps() const = 0;
    // Writes width*height numbers, row 0 first.
    virtual void read(long long map, std::vector<double>& values) = 0;
};

struct NumberType;
// Reads maps from a .npy file of numbers, in the order of C or of Fortran: integers and floats of any size, of either
// byte order, and bool.
class NpyFile : public Frames {
  public:
    // The array's shape must be (height, width), or (any, height, width) if `sequence`; a width of 0 takes any two
    // numbers up to 16384. Throws Error::bad_input, naming `parameter`.
    NpyFile(const std::string& path, int width, int height, bool sequence, const std::string& parameter);
    long long maps() const override { return maps_; }
    int width() const { return width_; }
    int height() const { return int(cells_ / size_t(width_)); }
    // Throws Error::bad_input, naming the first cell that is not finite.
    void read(long long map, std::vector<double>& values) override;

  private:
    Error error(const std::string& what) const;
    std::string read_header();
    void read_bytes_of(long long map);

    std::string path_, parameter_, allowed_;
    int width_;
    size_t cells_;
    bool sequence_;
    const NumberType* type_ = nullptr; // of the file's numbers
    bool swapped_ = false;             // whether its bytes are in the other order
    bool by_columns_ = false;          // whether the array is in the order of Fortran
    long long maps_ = 1;
    std::ifstream in_;
    std::streamoff first_ = 0; // offset of the first map in bytes
    std::string raw_;
};

// A map of any size, up to 16384 x 16384.
struct FileMap {
    Map values;
    int width = 0, height = 0;
    bool picture = false; // of a PNG: grey from 0 (black) to 1 (white)
};
// Reads a .npy file of numbers, or a PNG of 8 or 16 bits. Colours become grey. Row 0 of the map is the picture's top
// row. width, height: what the map must have; 0: any. Throws Error::bad_input, naming `parameter`.
FileMap read_map(const std::string& path, int width, int height, const std::string& parameter);

// A measured surface, read in the middle of each cell of a grid.
struct MeasuredSurface {
    Map heights, curvature; // as Surface::map and Surface::curvature
};
// Reads heights and curvature of a map in the cells of a grid, from cubic splines. The curvature is computed on the
// map, by the stencil of fourth order. spacing: m from number to number of the map; the corners of map and grid lie on
// each other. Throws Error::bad_input where the map does not cover the grid.
MeasuredSurface measured_surface(const FileMap&, double spacing, const Grid&);
// Returns the period of the ridges of a map, in units of the distance between two of its numbers. It is the period of
// the spectrum's strongest peak, in any direction. Returns nothing where no peak stands out, as on a rough surface.
std::optional<double> ridge_period_of(const FileMap&);

// The frames of a texture that slides over a validated scene, one at each output and one more. They are to be
// multiplied by Load::intensity.
std::shared_ptr<Frames> texture_frames(const Scene&);

// Opens a recording of taxels and returns its frames, as pressures of cells. Throws Error::bad_input.
std::shared_ptr<Frames> taxel_frames(const Scene&);

// Reads a list of receptors on a grid: a line of names, then for each receptor its type and its cell, x and y, or its
// place in m, x_m and y_m. If there are both, as in receptors.csv, the place counts if the grid has a spacing, else the
// cell. Throws Error::bad_input with the line.
std::vector<Site> read_sites(const std::string& path, const Grid&);

// A scene with the files that it was read from: the scene file, then its maps, frames and list of receptors.
struct SceneWithFiles {
    Scene scene;
    std::vector<std::string> files;
};
// Is Scene::from_file, and also returns the files.
SceneWithFiles read_scene(const std::string& path, const std::vector<std::string>& overrides);

// The text of a scene, the name that errors give it, and the folder that paths in it are relative to.
struct SceneText {
    std::string text, name;
    std::filesystem::path folder;
};
SceneText text_of_file(const std::string& path);
SceneText text_of_string(const std::string& text, const std::string& folder);
// Is called with a sentence for a word that a scene has and a later version will not read. By default it writes the
// sentence to the standard error, once in a process.
extern void (*old_word_found)(const char* sentence);
// Maps in memory, each under the name that a scene gives in place of a file.
using NamedMaps = std::map<std::string, FileMap>;
// Maps that have been read, by path.
using FileMaps = std::map<std::string, FileMap>;
// Returns the scene of a text, and the files that it names. read: maps that scenes share; null: this scene shares none.
// complete: adds what the caller has in memory, before the scene is checked; empty: nothing.
SceneWithFiles read_scene(const SceneText&, const std::vector<std::string>& overrides, const NamedMaps& = {},
                          FileMaps* read = nullptr, const std::function<void(Scene&)>& complete = {});
// A scene as a text, from which read_scene() reads an equal scene, and the maps that the text names.
struct WrittenScene {
    std::string text;
    NamedMaps maps; // each under a name that ends with .npy
};
// Throws Error::bad_input where a scene has what no text can say.
WrittenScene written(const Scene&);
// Returns the dotted name of every key that a scene file may have, as in "load.radius", except keys in lists.
std::vector<std::string> known_keys();

// A scene that has passed validate(): every parameter is in range, and every default is filled in, except the
// material's (element_at()).
struct ValidatedScene {
    Scene scene;
    std::shared_ptr<Frames> frames; // of a sequence, whose file is open, or of a texture; null with any other load
};

// Checks every parameter and fills in every default. Throws Error::bad_input.
ValidatedScene validate(const Scene&);
// Checks the method together with the material, stencil, edges, receptors and time step that it is used with, and fills
// in the defaults of stencil, edges and receptors.fa2. Grid, time and load have been checked before.
void check_method(Scene&);
// Checks the elements of another material for a scene that is validated. Throws Error::bad_input.
void check_material(const Scene& validated, const Material&);

// The functions below expect a validated scene.

// a*b; if rounding would lose it, the least double of its sign, because it is not 0.
inline double product(double a, double b) {
    return a * b != 0 || a == 0 || b == 0 ? a * b : std::copysign(0x1p-1074, (a < 0) == (b < 0) ? 1.0 : -1.0);
}

// Returns width*height pressures in Pa where the envelope is 1; the first of the frames, if there are any.
Map pressure_map(const ValidatedScene&);
// The same without frames, in units of Load::intensity.
Map shape_of(const Scene&);
// The products of a map and an envelope whose sum is the pressure, in units of their intensities. One for most scenes;
// none has a grating.
std::vector<Load> products_of(const Scene&);
bool is_sum(const Scene&); // whether there may be more than one
// The shape of a load with a grating, at t = 0.
Map grating_at_rest(const Scene&);
// Whether the load is known by frames.
inline bool is_framed(const Load& l) {
    return l.kind == Load::Kind::sequence || l.kind == Load::Kind::ball || l.texture;
}
// Whether the load is pressed into a half-space, to a depth.
inline bool is_indenter(const Load& l) { return l.kind == Load::Kind::punch || l.kind == Load::Kind::ball; }
// Whether the load is a depth of each cell, which knows no other cell.
inline bool presses_cells(const Load& l) { return l.control == Control::depth && !is_indenter(l); }

// The strains under a punch, and under a ball at each output and one more.
std::vector<double> punch_map(const Scene&);
std::shared_ptr<Frames> ball_frames(const Scene&);
// Turns depths of each cell, to be multiplied by Load::intensity, into strains: over the thickness, and 0 where they
// would pull.
void to_strain(const Scene&, std::vector<double>& depths);
std::shared_ptr<Frames> pressed_frames(const Scene&, std::shared_ptr<Frames> depths);

// Returns a line that a Gaussian of `sigma` cells has smoothed. The Gaussian is cut off at `reach` standard deviations,
// and the line reflected at both ends (d c b a | a b c d | d c b a).
std::vector<double> smoothed(const std::vector<double>& line, double sigma, double reach);

// Load::Contact::crests on some heights, width*height: the factor of each cell's pressure. Throws Error::bad_input
// where the heights have no crests.
Map crest_factors(const Scene&, const std::vector<double>& heights);
// Multiplies pressures by these factors. Their sum stays, but for a texture, of which only the map's sum does: the
// factors contain its scale. unit: of the pressures, Pa. Throws Error::bad_input, naming a cell that is pulled.
void press_crests(const Load&, const Map& factors, int width, double unit, std::vector<double>& pressure);

bool wants(const Scene&, Quantity); // whether a trace, a field or a site asks for it
long long outputs(const Time&);     // number of output times
// interval/step; 0 where it is not a whole number.
long long steps_per_frame(double interval, double step);

} // namespace dermis::scene
