// SPDX-License-Identifier: MIT
// From a description to checked numbers and maps.
#pragma once

#include "dermis/dermis.hpp"

#include <fstream>

namespace dermis::scene {

// Checks every parameter and fills every default in; throws Error::bad_input.
Scene validated(const Scene&);

// Of a scene in which all else is validated. Throws Error::bad_input.
void check_material(const Scene&);

bool wants(const Scene&, Quantity); // in a trace, a field or a site

long long outputs(const Time&); // rows of the traces

// Of cell i.
inline double modulus_at(const Material& m, size_t i) { return m.modulus_map.empty() ? m.modulus : m.modulus_map[i]; }
inline double viscosity_at(const Material& m, size_t i) {
    return m.viscosity_map.empty() ? m.viscosity : m.viscosity_map[i];
}

// width*height, from a validated scene
Map surface_map(const Scene&);
Map pressure_map(const Scene&);

// time.step goes this many times into load.interval; 0: not a whole number of times.
long long steps_per_frame(const Scene&);

// Maps in a .npy file of float32 or float64, little-endian, C order.
class NpyFile {
  public:
    // Of shape (height, width), or if `sequence` (any, height, width). Throws Error::bad_input naming `parameter`.
    NpyFile(const std::string& path, int width, int height, bool sequence, const std::string& parameter);
    long long maps() const { return maps_; }
    // width*height finite numbers, row 0 first. Throws Error::bad_input naming the cell of one that is not.
    void read(long long map, std::vector<double>& values);

  private:
    Error error(const std::string& what) const;

    std::string path_, parameter_, allowed_;
    int width_;
    size_t cells_;
    bool sequence_, f8_ = false;
    long long maps_ = 1;
    std::ifstream in_;
    std::streamoff first_ = 0; // byte of the first map
    std::vector<float> raw_;
};

// A list of receptors: type,x,y. Throws Error::bad_input.
std::vector<Site> read_sites(const std::string& path);

std::vector<double> read_npy(const std::string& path, int width, int height, const std::string& parameter);

} // namespace dermis::scene
