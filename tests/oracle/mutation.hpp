// SPDX-License-Identifier: MIT
// Changes of a scene: random ones, for a search that keeps those which make it worse, and ones that make it simpler.
#pragma once

#include "tests/oracle/draw.hpp"
#include "tests/oracle/exact.hpp"

namespace oracle {

class Mutation : private Draw {
  public:
    explicit Mutation(unsigned seed) : Draw(seed) {}
    // Changes a thing or a few. The scene may be one that is not allowed afterwards.
    void change(Case&);

  private:
    void change_one(Case&);
    double changed(double);
    double beside_row(const dermis::Scene&);
    void change_number(dermis::Scene&);
    void change_map(Case&);
    void change_size(Case&);
    void change_units(dermis::Scene&);
    void change_envelope(dermis::Scene&);
    void change_time(dermis::Scene&);
    void change_frames(Case&);
    void change_material(dermis::Scene&);
    void change_output(dermis::Scene&);
    void change_receptors(dermis::Scene&);
    std::vector<dermis::Quantity> some();

    static constexpr int most_rows = 60;
};

// Cuts every map to its first columns and rows, and leaves out the cells beyond.
void crop(Case&, int width, int height);
// Scenes that each have less of something.
std::vector<Case> simpler(const Case&);

} // namespace oracle
