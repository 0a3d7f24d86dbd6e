// SPDX-License-Identifier: MIT
// The outputs of a scene from its definition alone: closed forms in time, maps in long double.
#pragma once

#include "dermis/dermis.hpp"

namespace oracle {

using dermis::Quantity;
using Numbers = std::vector<long double>;

// A scene of maps and its pressures in memory. Surface and load are of Kind::map, or the load is a sequence of
// `frames`, which are also in the scene's file.
struct Case {
    dermis::Scene scene;
    std::vector<std::vector<double>> frames;
};

inline size_t cells_of(const dermis::Scene& s) { return size_t(s.grid.width) * size_t(s.grid.height); }

struct ExactTrace {
    Numbers mean, min, max;
    std::vector<Numbers> probes; // [probe][time]
};

struct ExactField {
    double at;
    Quantity quantity;
    Numbers values;
};

struct ExactImpulse {
    long double time;
    Quantity quantity;
    Numbers values; // of each cell
};

struct Exact {
    std::vector<ExactTrace> traces; // as the scene asks for them
    Numbers responses;              // of the sites: [time][site]
    std::vector<ExactField> fields;
    std::vector<ExactImpulse> impulses;
    // The greatest |X| over cells, or sites of the class, and over the times of rows and of fields: of FA2 before
    // fa2_gains, of curvature and deformation where a field asks for one of them.
    std::array<long double, 7> largest{}, largest_at_sites{};
};

// more_bits: beside those that the cancellation takes.
Exact exact(const Case&, long more_bits = 320);

// The greatest |X - X_exact| over all numbers of an output, over the greatest |X_exact| as above: what Scene::tolerance
// limits, for the output where it is greatest.
struct Distance {
    double value = 0;
    Quantity quantity = Quantity::strain;
    const char* where = "";
    size_t row = 0;
};
Distance distance(const Exact&, const dermis::Scene&, const dermis::Result&);

// What pressure 1 on a square cell of side h causes at a depth z below a point at (x, y) from its centre, by a sum over
// point forces (Boussinesq), as DepthKernel says. nu: Poisson's ratio.
// Exact to some 1e-17 where h is a few times z at most.
long double below_cell(long double x, long double y, long double h, long double z, dermis::DepthKernel, long double nu);

// The curvature of a map by its definition, per cell^2.
class Curvature {
  public:
    explicit Curvature(const dermis::SkinDescription&);
    template <class T> std::vector<T> laplacian(const std::vector<T>& map) const; // T: long double or Wide

  private:
    using Weights = std::vector<std::vector<std::pair<int, long double>>>; // of the differences, for each place
    static Weights along(int n, dermis::Stencil, dermis::Edges);
    int width_, height_;
    Weights x_, y_;
};

} // namespace oracle
