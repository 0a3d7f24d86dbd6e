// SPDX-License-Identifier: MIT
// A fingertip that a body presses: what the page in the browser shows, and what replays a recording of it. Both have
// the same bits.
#pragma once

#include <dermis/dermis.hpp>

#include <cstdint>
#include <vector>

namespace dermis::web {

// A ball; a flat, round punch; an edge: a round bar of `edge_length` that lies along x.
enum class Shape { ball, punch, edge };

// The settings that a user of the page chooses.
struct Settings {
    double ridge_period = 5e-4; // m; 0: no ridges
    double modulus = 5e4;       // Pa, of the skin at rest; all elements of the material are scaled with it
    Shape shape = Shape::ball;
    double radius = 5e-3;     // m, of the ball, of the punch or of the edge
    bool one_element = false; // a single element with a retardation time of 70 ms; otherwise the preset's four
};

// A skin of 12 mm x 16 mm. A step is one press: from step to step the pressure runs linearly. Responses are known at
// its end, spikes at their own times.
class Session {
  public:
    static constexpr int width = 240, height = 320; // cells
    static constexpr double spacing = 5e-5;         // m
    static constexpr double step_time = 1.0 / 60;   // s
    static constexpr double edge_length = 8e-3;     // m
    static constexpr size_t cells = size_t(width) * height;

    // Throws Error::bad_input.
    explicit Session(const Settings&);

    // Presses for one step. At its end the body is at (x, y), in m, and presses with `force`, in N. Throws
    // Error::bad_input and std::invalid_argument.
    void step(double x, double y, double force);

    // One number for each cell: strain or a response. The same memory after every step.
    const float* map(Quantity quantity) const { return skin_.response(quantity).data; }
    Skin::Spikes spikes() const { return skin_.spikes(); }
    // The endings of the afferents: those of sa1, then of fa1, then of fa2.
    const std::vector<Afferents>& afferents() const { return afferents_; }
    double pressed() const { return pressed_; } // m^2, of the cells that the body presses
    int steps() const { return steps_; }
    size_t all_spikes() const { return spikes_; } // since the beginning
    // FNV-1a of strain and responses after the last step, and of all spikes since the beginning.
    std::uint64_t hash() const;

  private:
    std::vector<Afferents> afferents_;
    Skin skin_;
    std::vector<float> depth_, pressure_;
    Settings settings_;
    double stiffness_; // Pa/m, of the skin at rest
    double pressed_ = 0;
    int steps_ = 0;
    size_t spikes_ = 0;
    std::uint64_t spikes_hash_;
};

} // namespace dermis::web
