// SPDX-License-Identifier: MIT
// Random scenes of every kind that a tolerance has to be kept in; the same for the same seed.
#pragma once

#include "tests/oracle/draw.hpp"
#include "tests/oracle/exact.hpp"

#include <filesystem>

namespace oracle {

class Family : private Draw {
  public:
    // Sequences are written to a file of this process, which each next() replaces.
    explicit Family(unsigned seed);
    ~Family();
    Family(const Family&) = delete;

    Case next();
    // Few steps or one, with a field of curvature and deformation: most cells and sites are not pressed, a recording
    // begins at rest, a method is not the exact one, or the load is a sum.
    Case next_sparse();
    const char* kind() const { return kind_; } // of the last scene

  private:
    struct Size {
        int grid, outputs;
    };

    dermis::Scene scene();
    void take_grid(dermis::Scene&, Size);
    void take_surface(dermis::Scene&);
    void take_material(dermis::Scene&, double z);
    void take_material_maps(dermis::Scene&);
    void take_patch(dermis::Scene&);
    void take_surroundings(dermis::Scene&);
    void take_load(dermis::Scene&);
    void take_envelope(dermis::Scene&);
    void take_table(dermis::Scene&);
    void move_breakpoint(dermis::Scene&);
    void take_receptors(dermis::Scene&);
    void take_output(dermis::Scene&);
    void take_sites(dermis::Scene&);
    void take_late(dermis::Scene&);
    void take_depths(dermis::Scene&);
    void take_window(dermis::Scene&);
    void take_more_loads(Case&);
    void take_control(dermis::Scene&);
    void take_baseline(dermis::Scene&);
    bool may_be_chain(const dermis::Scene&) const;
    void take_chain(dermis::Scene&);
    void take_chain_maps(dermis::Scene&);
    void take_wide_chain(dermis::Scene&);
    void take_sites_on_chain(Case&);
    std::vector<std::vector<double>> frames(dermis::Scene&);

    std::filesystem::path path_;
    const char* kind_ = "";
};

// Whether a breakpoint, field or frame is so far from a row that rounding could decide if it is the row's: about 4 ulp.
bool undecided(const dermis::Scene&);

} // namespace oracle
