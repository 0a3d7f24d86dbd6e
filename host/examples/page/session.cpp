// SPDX-License-Identifier: MIT
#include "host/examples/page/session.hpp"

#include <dermis/contact.hpp>

#include <algorithm>

namespace dermis::web {
namespace {

constexpr std::uint64_t fnv_start = 14695981039346656037u;

std::uint64_t fnv(const void* data, size_t bytes, std::uint64_t hash) {
    const auto* byte = static_cast<const unsigned char*>(data);
    for (size_t i = 0; i < bytes; ++i) hash = (hash ^ byte[i]) * 1099511628211u;
    return hash;
}

SkinDescription description(const Settings& s) {
    SkinDescription d = fingertip();
    d.grid = {Session::width, Session::height, Session::spacing};
    if (s.ridge_period > 0) d.surface.ridge_period = s.ridge_period;
    else d.surface = {.kind = Surface::Kind::flat, .relief = d.surface.relief};
    if (s.one_element) d.material.elements = {{.modulus = s.modulus, .viscosity = 0.07 * s.modulus}};
    double compliance = 0; // of the elements in series, at rest
    for (const KelvinVoigt& element : d.material.elements) compliance += 1 / element.modulus;
    for (KelvinVoigt& element : d.material.elements) {
        element.modulus *= compliance * s.modulus;
        element.viscosity *= compliance * s.modulus;
    }
    d.receptors.depth = fingertip_depths();
    d.receptors.sa2_adaptation = 2; // s: a plain integral would grow for ever
    return d;
}

// The afferents of a fingertip.
std::vector<Afferents> afferents_of(const Grid& grid) {
    std::vector<Afferents> all;
    for (const Quantity type : {Quantity::sa1, Quantity::fa1, Quantity::fa2}) {
        all.push_back({.type = type});
        for (const Site& site : population(grid))
            if (site.type == type) all.back().cells.push_back(site.cell);
    }
    return all;
}

// The body where it just touches the skin at (x, y).
contact::Body body_at(const Settings& s, double x, double y) {
    contact::Body body{.kind = contact::Body::Kind::sphere, .size = {s.radius}, .pose = {.position = {x, y, s.radius}}};
    if (s.shape == Shape::ball) return body;
    body.kind = contact::Body::Kind::cylinder;
    body.size[1] = Session::edge_length / 2;
    if (s.shape == Shape::punch) body.pose.position[2] = body.size[1]; // it stands
    else body.pose.rotation = {0, 0, 1, 0, 1, 0, -1, 0, 0};
    return body;
}

} // namespace

Session::Session(const Settings& settings)
    : afferents_(afferents_of({width, height, spacing})),
      skin_(Device::cpu(1), description(settings), {.precision = Precision::f32, .afferents = afferents_}),
      depth_(cells), pressure_(cells), settings_(settings),
      stiffness_(contact::skin_stiffness(description(settings).material)), spikes_hash_(fnv_start) {}

void Session::step(double x, double y, double force) {
    std::fill(pressure_.begin(), pressure_.end(), 0.0f);
    const contact::Pad pad{.width = width, .height = height, .spacing = spacing, .pressure = pressure_.data()};
    contact::fill_depths(pad, {}, body_at(settings_, x, y), depth_.data());
    const contact::DepthMap depths{.depth = depth_.data(), .force = force, .stiffness = stiffness_};
    pressed_ = contact::add_depths(pad, depths).cells * spacing * spacing;
    skin_.press(pressure_, step_time);
    ++steps_;
    spikes_ += skin_.spikes().size;
    for (const Spike& spike : skin_.spikes()) {
        spikes_hash_ = fnv(&spike.afferent, sizeof spike.afferent, spikes_hash_);
        spikes_hash_ = fnv(&spike.share, sizeof spike.share, spikes_hash_);
    }
}

std::uint64_t Session::hash() const {
    std::uint64_t hash = spikes_hash_;
    for (const Quantity q : {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2})
        hash = fnv(map(q), cells * sizeof(float), hash);
    return hash;
}

} // namespace dermis::web
