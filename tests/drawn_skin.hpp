// SPDX-License-Identifier: MIT
// Skins drawn at random, with all that a description and its options can ask for. None of them is refused.
#pragma once

#include "dermis/dermis.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

namespace test {

using namespace dermis;

// The same numbers from a seed everywhere, which the standard's distributions do not promise.
struct Random {
    std::mt19937_64 bits;
    double unit() { return double(bits() >> 11) * 0x1p-53; }
    double within(double low, double high) { return low + (high - low) * unit(); }
    double decades(double low, double high) { return std::pow(10, within(low, high)); }
};

inline int whole(Random& r, int low, int high) { return low + int(r.bits() % uint64_t(high - low + 1)); }
inline bool chance(Random& r, double share) { return r.unit() < share; }

struct DrawnSkin {
    SkinDescription skin;
    SkinOptions options;

    size_t cells() const { return size_t(skin.grid.width) * size_t(skin.grid.height); }
    bool large() const { return cells() * size_t(options.count) > 16384; } // takes long
    bool has_maps() const { return !skin.material.elements[0].modulus_map.empty(); }
    // Whether set_material() may be called.
    bool takes_material() const { return !has_maps() && options.control == Control::pressure; }

    // The responses that the skin gives.
    std::vector<Quantity> responses() const {
        if (skin.sites.empty()) return options.responses;
        std::vector<Quantity> classes;
        for (const Site& site : skin.sites)
            if (!std::ranges::count(classes, site.type)) classes.push_back(site.type);
        return classes;
    }
    // The same skin, of which each cell gives the responses of the sites.
    DrawnSkin with_fields() const {
        DrawnSkin all = *this;
        all.options.responses = responses();
        all.skin.sites.clear();
        return all;
    }

    // The material of the skin after pads have got this one.
    void give(const Material& material, const std::vector<int>& pads) {
        for (int pad : pads)
            if (!options.materials.empty()) options.materials[size_t(pad)] = material;
        if (!options.materials.empty()) return;
        skin.material.elements = material.elements;
        skin.material.spring = material.spring, skin.material.dashpot = material.dashpot;
    }
};

// Moduli and viscosities of a chain with as many elements, springs and dashpots.
inline Material like(Random& r, const Material& chain) {
    Material m;
    for (size_t i = 0; i < chain.elements.size(); ++i) {
        m.elements.emplace_back();
        m.elements.back().modulus = r.decades(3, 6), m.elements.back().viscosity = r.decades(1, 5);
    }
    if (chain.spring) m.spring = r.decades(3, 6);
    if (chain.dashpot) m.dashpot = r.decades(3, 6);
    return m;
}

// Small pads, some as wide as a register or a tile; widths from 96 on, which are pressed in rows; and skins large
// enough for two or three threads.
inline void draw_size(Random& r, DrawnSkin& drawn) {
    Grid& grid = drawn.skin.grid;
    grid.spacing = 5e-4;
    if (const int kind = whole(r, 0, 19); kind == 0) {
        drawn.options.count = whole(r, 0, 1) ? 1 : whole(r, 4, 6);
        const bool one = drawn.options.count == 1;
        grid.width = one ? whole(r, 24, 27) * 16 + whole(r, 0, 1) : 64, grid.height = one ? whole(r, 160, 250) : 65;
    } else if (kind <= 5) {
        grid.width = chance(r, 0.2) ? 150 : 96 + 16 * whole(r, 0, 3), grid.height = whole(r, 1, 24);
        drawn.options.count = chance(r, 0.7) ? 1 : 2;
    } else {
        grid.width = chance(r, 0.2) ? 16 * whole(r, 1, 6) : whole(r, 1, chance(r, 0.3) ? 95 : 24);
        grid.height = whole(r, 1, 20);
        drawn.options.count = chance(r, 0.25) ? 1 : whole(r, 2, 8);
        if (drawn.cells() <= 64 && drawn.options.count > 1) drawn.options.count *= 5; // many share a register
    }
}

inline void draw_surface(Random& r, DrawnSkin& drawn) {
    SkinDescription& d = drawn.skin;
    d.surface.kind = Surface::Kind(whole(r, 0, 3));
    d.surface.relief = r.decades(-6, -3);
    d.material.thickness = r.decades(-4, -2);
    d.material.curvature_length = chance(r, 0.1) ? 0 : (chance(r, 0.5) ? 1 : -1) * r.decades(-6, -2);
    if (chance(r, 0.5)) d.stencil = Stencil(whole(r, 0, 2));
    if (chance(r, 0.5)) d.edges = Edges(whole(r, 0, 1));
    if (d.stencil == published_stencil && d.grid.width > 1 && d.grid.height > 1 && chance(r, 0.5))
        d.edges = published_edges;
    if (d.surface.kind != Surface::Kind::map) return;
    std::vector<double> heights(drawn.cells()), curvature(drawn.cells());
    for (double& x : heights) x = r.unit();
    for (double& x : curvature) x = r.within(-1e5, 1e5);
    d.surface.map = heights;
    if (d.stencil != published_stencil && chance(r, 0.3)) d.surface.curvature = curvature;
}

inline void draw_material(Random& r, DrawnSkin& drawn) {
    Material& m = drawn.skin.material;
    Material chain;
    chain.elements.resize(size_t(whole(r, 1, chance(r, 0.15) ? 8 : 4)));
    if (chance(r, 0.25)) chain.spring = 1;
    if (chance(r, 0.15) && chain.elements.size() < 8) chain.dashpot = 1;
    chain = like(r, chain);
    m.elements = chain.elements, m.spring = chain.spring, m.dashpot = chain.dashpot;
    if (chance(r, 0.15)) {
        std::vector<double> moduli(drawn.cells()), few = {1e4, 2e4, 7e5};
        const bool classes = chance(r, 0.5);
        for (double& x : moduli) x = classes ? few[size_t(whole(r, 0, 2))] : r.decades(3, 6);
        m.elements[0].modulus_map = moduli;
    }
}

inline void draw_receptors(Random& r, DrawnSkin& drawn) {
    SkinDescription& d = drawn.skin;
    SkinOptions& o = drawn.options;
    if (chance(r, 0.4)) d.receptors.sa2_adaptation = r.decades(-3, 1);
    if (!d.material.spring && chance(r, 0.3)) d.receptors.fa2 = chance(r, 0.5) ? Fa2::point : Fa2::step_mean;
    if (chance(r, 0.3)) d.receptors.fa2_gains = {r.within(-2, 2), r.within(-2, 2)};
    for (int n = chance(r, 0.35) ? whole(r, 1, chance(r, 0.3) ? 200 : 12) * (drawn.large() ? 40 : 1) : 0; n > 0; --n)
        d.sites.push_back({Quantity(whole(r, 1, 4)), {whole(r, 0, d.grid.width - 1), whole(r, 0, d.grid.height - 1)}});
    o.responses.clear();
    for (int q = 1; q <= 4; ++q)
        if (chance(r, 0.6)) o.responses.push_back(Quantity(q));
    if (o.responses.empty()) o.responses = {Quantity(whole(r, 1, 4))};
}

inline void draw_options(Random& r, DrawnSkin& drawn) {
    const SkinDescription& d = drawn.skin;
    SkinOptions& o = drawn.options;
    if (chance(r, 0.4)) o.precision = chance(r, 0.5) ? Precision::f32 : Precision::f32_compensated;
    if (chance(r, 0.4)) o.hold = Hold::parabolic;
    if (chance(r, 0.12)) o.control = Control::depth, drawn.skin.receptors.fa2 = {};
    if (drawn.takes_material() && chance(r, 0.3))
        for (int i = 0; i < o.count; ++i) o.materials.push_back(like(r, d.material));
    o.shear = drawn.takes_material() && d.sites.empty() && d.edges != published_edges && chance(r, 0.4);
    if (o.shear && std::ranges::count(o.responses, Quantity::sa2) && chance(r, 0.4))
        o.sa2_stretch = chance(r, 0.5) ? std::array{0.0, 0.0} : std::array{r.within(0.1, 1), r.within(-1, 1)};
}

inline AfferentModel drawn_model(Random& r) {
    AfferentModel m;
    m.time_constants = {r.decades(-4, -1)};
    const bool pair = chance(r, 0.3);
    if (pair) m.frequency = r.decades(0, 3), m.quality = r.decades(-1, 1);
    else if (chance(r, 0.5)) m.time_constants.push_back(r.decades(-4, -1));
    m.value = r.within(-200, 200), m.rate = r.within(-1, 1) * r.decades(-3, 0);
    m.membrane_time = r.decades(-3, -1), m.refractory_time = r.decades(-3.3, -2), m.reset = r.within(-2, 0.9);
    m.gains[0] = {r.within(-3, 3), r.within(-3, 3)};
    if (pair || m.time_constants.size() > 1) m.gains[1] = {r.within(-0.1, 0.1), r.within(-0.1, 0.1)};
    m.after[0] = {r.within(-3, 1), r.decades(-3, -1)};
    return m;
}

inline void draw_fibres(Random& r, DrawnSkin& drawn) {
    const SkinDescription& d = drawn.skin;
    for (int entries = chance(r, 0.3) ? whole(r, 1, 2) : 0; entries > 0; --entries) {
        Afferents a;
        const Quantity types[] = {Quantity::sa1, Quantity::fa1, Quantity::fa2};
        a.type = types[whole(r, 0, 2)];
        if (chance(r, 0.5)) a.model = drawn_model(r);
        if (drawn.takes_material() && !d.material.dashpot && chance(r, 0.3)) a.follow = Signal::stress;
        a.endings = chance(r, 0.5) ? 1 : whole(r, 1, 5);
        for (int n = a.endings * whole(r, 1, chance(r, 0.2) ? 100 : 12); n > 0; --n)
            a.cells.push_back(d.sites.empty() ? Cell{whole(r, 0, d.grid.width - 1), whole(r, 0, d.grid.height - 1)}
                                              : d.sites[size_t(whole(r, 0, int(d.sites.size()) - 1))].cell);
        drawn.options.afferents.push_back(a);
    }
}

// Depths of receptors, and SA1 that follows the stress. A fit takes about 20 ms, for each skin that is made.
inline void draw_depths(Random& r, DrawnSkin& drawn) {
    SkinDescription& d = drawn.skin;
    if (!drawn.takes_material()) return;
    if (!d.material.dashpot && chance(r, 0.1)) d.receptors.follow.sa1 = Signal::stress;
    if (d.edges == Edges::periodic || !chance(r, 0.3)) return;
    if (chance(r, 0.5)) d.receptors.kernel = DepthKernel::strain;
    if (d.receptors.kernel.sa1 == DepthKernel::strain && chance(r, 0.5)) d.receptors.poisson = r.within(0, 0.5);
    if (d.receptors.poisson > 0.25) d.receptors.kernel.fa2 = DepthKernel::displacement;
    double two[2];
    for (double& z : two) z = *d.grid.spacing * r.decades(-1, 1.5);
    if (d.receptors.kernel.sa1 == DepthKernel::stress && chance(r, 0.1)) two[0] = 0;
    Depths& z = d.receptors.depth;
    for (std::optional<double>* depth : {&z.sa1, &z.sa2, &z.fa1, &z.fa2})
        if (chance(r, 0.5)) *depth = two[whole(r, 0, 1)];
    if (drawn.options.sa2_stretch) z.sa2.reset();
    DepthKernels& k = d.receptors.kernel; // a class without a depth has none
    for (auto [depth, kernel] : {std::pair{z.sa1, &k.sa1}, {z.sa2, &k.sa2}, {z.fa1, &k.fa1}, {z.fa2, &k.fa2}})
        if (!depth) *kernel = DepthKernel::stress;
}

inline DrawnSkin drawn_skin(Random& r) {
    DrawnSkin drawn;
    draw_size(r, drawn);
    draw_surface(r, drawn);
    draw_material(r, drawn);
    draw_receptors(r, drawn);
    draw_options(r, drawn);
    draw_fibres(r, drawn);
    draw_depths(r, drawn);
    return drawn;
}

inline std::string words_of(const DrawnSkin& drawn) {
    const SkinDescription& d = drawn.skin;
    const SkinOptions& o = drawn.options;
    std::string text = std::to_string(o.count) + " pads of " + std::to_string(d.grid.width) + " x " +
                       std::to_string(d.grid.height) + ", surface " + std::to_string(int(d.surface.kind)) + ", " +
                       std::to_string(d.material.elements.size()) + " elements";
    const auto add = [&](bool there, const std::string& words) {
        if (there) text += ", " + words;
    };
    add(bool(d.material.spring), "spring");
    add(bool(d.material.dashpot), "dashpot");
    add(drawn.has_maps(), "map of the modulus");
    add(!d.surface.curvature.empty(), "curvature given");
    add(bool(d.stencil), "stencil " + std::to_string(int(d.stencil.value_or(Stencil::five_point))));
    add(bool(d.edges), "edges " + std::to_string(int(d.edges.value_or(Edges::mirror))));
    add(!d.sites.empty(), std::to_string(d.sites.size()) + " sites");
    add(bool(d.receptors.sa2_adaptation), "adaptation");
    const Depths& z = d.receptors.depth;
    for (auto [depth, of] : {std::pair{z.sa1, "sa1"}, {z.sa2, "sa2"}, {z.fa1, "fa1"}, {z.fa2, "fa2"}})
        add(bool(depth), std::string(of) + " " + std::to_string(depth.value_or(0) / 5e-4) + " cells deep");
    add(d.receptors.kernel.sa1 == DepthKernel::strain, "strain at a depth");
    add(d.receptors.kernel.fa2 == DepthKernel::displacement, "displacement for fa2");
    add(d.receptors.follow.sa1 == Signal::stress, "sa1 of the stress");
    for (Quantity q : o.responses) add(d.sites.empty(), name(q));
    add(bool(o.precision), o.precision ? name(*o.precision) : "");
    add(o.hold == Hold::parabolic, "parabolic");
    add(o.control == Control::depth, "depths");
    add(!o.materials.empty(), "own materials");
    add(o.shear, "shear");
    add(bool(o.sa2_stretch), "sa2 of the stretch");
    for (const Afferents& a : o.afferents)
        add(true, std::to_string(a.cells.size()) + " endings of fibres" +
                      (a.follow == Signal::stress ? " that follow the stress" : ""));
    return text;
}

} // namespace test
