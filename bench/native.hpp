// SPDX-License-Identifier: MIT
// The native peer: the same work as the library's, with any order of operations and fused multiply-add.
#pragma once

#include "bench/frames.hpp"
#include "bench/native_loops.hpp"

#include <cmath>
#include <memory>

namespace bench {

// The greatest error that a peer may have, by the greatest value.
constexpr double peer_error = 8e-7;

namespace native {

// phi1(z) = (1 - e^-z)/z, phi2 = (1 - phi1)/z and phi3 = (1/2 - phi2)/z weigh the pressure; z = dt*E/eta > 0.
template <class Real = double> ExactStep<Real> exact_step(double modulus, double viscosity, double dt) {
    const double z = dt * modulus / viscosity, q = dt / viscosity, decay = std::exp(-z);
    const double phi1 = -std::expm1(-z) / z, phi2 = (1 - phi1) / z, phi3 = (0.5 - phi2) / z;
    return {.E = Real(modulus),
            .b = Real(q * phi1),
            .f = Real(q * phi2),
            .i0 = Real(dt * phi1),
            .i1 = Real(dt * q * phi2),
            .i2 = Real(dt * q * phi3),
            .v0 = Real(decay / viscosity),
            .v1 = Real(phi1 / viscosity),
            .a0 = Real(-modulus / viscosity * decay / viscosity),
            .a1 = Real(decay / viscosity / dt)};
}

} // namespace native

// The greatest error of each response after `presses` presses from rest, by its greatest value, against the same model
// in double. responses: SA1, SA2, FA1, FA2, pitch*height each.
std::array<double, 4> errors_of_frames(const FrameScene&, int presses, int threads,
                                       const std::array<const float*, 4>& responses);

// One press of one skin: in one fused loop, which steps a row and answers the one above it, with responses written past
// the caches or through them; or in two passes over whole maps.
class NativeFrames {
  public:
    enum class Way { past_caches, plain_stores, two_passes };
    NativeFrames(const FrameScene&, int threads, Way);
    void press(int frames);
    std::array<const float*, 4> responses() const;

  private:
    const FrameScene& scene_;
    dermis::simd::Pool pool_;
    Floats rest_, strain_, integral_;
    std::array<Floats, 4> responses_;
    std::vector<Floats> rows_; // four of each thread, or the maps of rate and acceleration
    const Way way_;
    native::Frame frame_{};
    size_t frames_ = 0;
};

// Means and extremes of strain, SA1, SA2, FA1 and FA2 over all cells at each step of a march under map times envelope.
// No cell needs its neighbours' past, so that a tile with a halo of one cell takes all steps while it is in the cache.
class NativeMarch {
  public:
    struct Skin {
        int n; // cells a side, a multiple of the tile's
        std::vector<float> pressure, rest;
        std::vector<int> material;                              // of each cell; empty if there is one
        std::vector<native::ExactStep<float>> step_of_material; // at most native::most_materials
    };
    NativeMarch(Skin, int threads);
    std::vector<native::Statistics> run(const std::vector<native::Envelope>&);

  private:
    static constexpr size_t height = 32, width = 256, pitch = width + 2 * native::lanes;
    static constexpr size_t with_halo = (height + 2) * pitch, inside = height * width;
    struct alignas(64) TileMemory {
        float strain[with_halo], pressure[with_halo];
        int material[with_halo];
        float integral[inside], rest[inside], rate[width], acceleration[width];
        native::Tile tile();
    };
    void load(TileMemory&, size_t top, size_t left) const;

    const Skin skin_;
    dermis::simd::Pool pool_;
    std::vector<std::unique_ptr<TileMemory>> tiles_; // one of each thread
};

} // namespace bench
