// SPDX-License-Identifier: MIT
// The products of a map and an envelope of which a load is the sum: one, but for several loads and moving gratings.
#include "host/lab/scenes/scene.hpp"

#include <cmath>
#include <numbers>

namespace dermis {

std::optional<MovingPattern> moving_pattern(const Scene& s) {
    const double cell = s.grid.spacing.value_or(1);
    std::vector<Load> loads = s.more_loads;
    loads.push_back(s.load);
    std::vector<MovingPattern> moving;
    for (const Load& l : loads)
        if (l.texture) {
            const double spacing = l.texture->spacing.value_or(cell);
            moving.push_back({l.texture->velocity, {l.texture->width * spacing, l.texture->height * spacing}});
        } else if (l.grating) {
            const Grating& g = *l.grating;
            const auto rounded = [](double x) { return std::abs(x) < 1e-12 ? 0 : x; }; // that of 90 degrees is not 0
            const double x = rounded(std::cos(g.direction)), y = rounded(std::sin(g.direction));
            moving.push_back(
                {{g.velocity * x, g.velocity * y}, {g.wavelength / std::abs(x), g.wavelength / std::abs(y)}});
        }
    std::erase_if(moving, [](const MovingPattern& m) { return m.velocity == std::array{0.0, 0.0}; });
    return moving.size() == 1 ? std::optional(moving[0]) : std::nullopt;
}

namespace scene {
namespace {

// The angle of a grating's first harmonic, at t = 0, in the centre of cell [x, y].
double angle_at(const Grating& g, double spacing, size_t x, size_t y) {
    const double along = double(x) * std::cos(g.direction) + double(y) * std::sin(g.direction);
    return 2 * std::numbers::pi * along * (spacing / g.wavelength);
}

double phase_of(const Grating& g, size_t harmonic) { return g.phases.empty() ? 0 : g.phases[harmonic]; }

// The shape of a load times of(angle) in each cell.
template <class Of> Map shape_times(const Scene& s, Of of) {
    Map map = shape_of(s);
    const double spacing = s.grid.spacing.value_or(1);
    const size_t width = size_t(s.grid.width);
    std::vector<double>& values = map.edit();
    for (size_t i = 0; i < values.size(); ++i)
        if (values[i] != 0) values[i] *= of(angle_at(*s.load.grating, spacing, i % width, i / width));
    return map;
}

// The same load under another map and envelope.
Load with(const Load& load, Map map, const Envelope& envelope) {
    Load product = load;
    product.kind = Load::Kind::map;
    product.map = std::move(map);
    product.envelope = envelope;
    product.grating.reset();
    return product;
}

// The map, then for each harmonic a*cos(n*(K*s - w*t) + phase), which is a*cos(n*K*s + phase)*cos(n*w*t) +
// a*sin(n*K*s + phase)*sin(n*w*t).
void add_moving(const Scene& s, std::vector<Load>& products) {
    const Grating& g = *s.load.grating;
    products.push_back(with(s.load, shape_of(s), s.load.envelope));
    for (size_t i = 0; i < g.amplitudes.size(); ++i) {
        const double n = double(i + 1), a = g.amplitudes[i], phase = phase_of(g, i);
        Envelope wave{.kind = Envelope::Kind::sine};
        wave.frequency = n * std::abs(g.velocity) / g.wavelength;
        wave.window = s.load.envelope.window;
        const double sign = g.velocity < 0 ? -1 : 1;
        wave.phase = std::numbers::pi / 2;
        products.push_back(
            with(s.load, shape_times(s, [&](double angle) { return a * std::cos(n * angle + phase); }), wave));
        wave.phase = 0;
        products.push_back(
            with(s.load, shape_times(s, [&](double angle) { return sign * a * std::sin(n * angle + phase); }), wave));
    }
}

} // namespace

bool is_sum(const Scene& s) { return !s.more_loads.empty() || (s.load.grating && s.load.grating->velocity != 0); }

Map grating_at_rest(const Scene& s) {
    const Grating& g = *s.load.grating;
    return shape_times(s, [&](double angle) {
        double sum = 1;
        for (size_t i = 0; i < g.amplitudes.size(); ++i)
            sum += g.amplitudes[i] * std::cos(double(i + 1) * angle + phase_of(g, i));
        return sum;
    });
}

std::vector<Load> products_of(const Scene& scene) {
    std::vector<Load> products;
    Scene one = scene;
    one.more_loads.clear();
    for (size_t i = 0; i <= scene.more_loads.size(); ++i) {
        if (i > 0) one.load = scene.more_loads[i - 1];
        if (!one.load.grating) products.push_back(one.load);
        else if (one.load.grating->velocity != 0) add_moving(one, products);
        else products.push_back(with(one.load, grating_at_rest(one), one.load.envelope));
    }
    return products;
}

} // namespace scene
} // namespace dermis
