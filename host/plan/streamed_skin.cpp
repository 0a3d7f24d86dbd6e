// SPDX-License-Identifier: MIT
#include "host/plan/streamed_skin.hpp"

#include "host/plan/laplacian.hpp"
#include "host/plan/site_cells.hpp"
#include "host/scene/refusal.hpp"

#include <algorithm>
#include <bit>

namespace dermis::plan {
namespace {

constexpr size_t field_alignment = 64; // floats: 256 bytes, the greatest offset alignment that Vulkan allows

// Every constant must be finite in float: a product with infinity could be NaN, and appear as a wrong 0.
void check_float(const PreparedSkin& skin) {
    const auto need = [](const char* parameter, double v) {
        scene::need(scene::finite(double(float(v))), parameter, v, "up to 3.4e38 for a skin in float");
    };
    for (const Element& m : skin.materials) need("material.modulus", stiffness(m));
    const f64::Constants& c = skin.constants;
    scene::need(scene::finite(double(float(c.bend))), "grid.spacing", skin.spacing(),
                "material.thickness/spacing^2 up to 3.4e38 for a skin in float");
    need("material.curvature_length", c.curvature_length);
    for (double gain : {c.gain_plus, c.gain_minus}) need("receptors.fa2_gains", gain);
    for (const Site& site : skin.description.sites) // rest curvature of fields is checked where it is padded
        need("surface.relief", rest_curvature_at(skin, site.cell));
}

std::vector<Quantity> asked_responses(const SkinDescription& d, const SkinOptions& options) {
    std::vector<Quantity> asked;
    for (Quantity q : options.responses) {
        if (!scene::is_receptor_class(q) || std::count(asked.begin(), asked.end(), q))
            scene::refuse("responses", std::string("\"") + name(q) + "\"",
                          scene::receptor_class_names() + ", each at most once");
        asked.push_back(q);
    }
    if (options.responses.empty() && d.sites.empty())
        scene::refuse("responses", "(none)",
                      "some of " + scene::receptor_class_names() + ", or sites in the description");
    if (d.sites.empty()) return asked;
    asked.clear();
    for (const Site& site : d.sites) asked.push_back(site.type);
    return asked;
}

} // namespace

Variant StreamedSkin::variant() const {
    return {.stencil = skin.stencil,
            .edges = skin.edges,
            .compensated = precision == Precision::f32_compensated,
            .materials = !skin.uniform(),
            .framed = true,
            .chain = skin.chain,
            .wanted = wanted};
}

StreamedSkin streamed_skin(const SkinDescription& description, const SkinOptions& options, int threads) {
    const std::vector<Quantity> asked = asked_responses(description, options);
    if (options.precision == Precision::f64)
        scene::refuse("precision", "\"f64\"", "f32, f32-compensated: a skin pressed frame by frame is in float");
    StreamedSkin s;
    const SkinDescription validated = scene::validate_skin(description, asked);
    for (Quantity q : asked) s.wanted[size_t(q)] = true;
    s.skin = prepare_skin(validated, threads);
    const bool grows = s.wanted[QUANTITY_SA2] && !validated.receptors.sa2_adaptation;
    s.precision = options.precision.value_or(grows ? Precision::f32_compensated : Precision::f32);
    const Chain& chain = s.skin.chain;
    for (size_t i = 0; i < s.skin.materials.size(); ++i)
        if (is_elastic(s.skin.materials[i]) && i % chain.length < chain.elements() && s.wanted[QUANTITY_FA2])
            scene::refuse("material.viscosity", "0", "> 0 for FA2 of frames; with viscosity 0 do without fa2");
    check_float(s.skin);
    return s;
}

ResponseLayout response_layout_of(const StreamedSkin& s) {
    ResponseLayout layout;
    const std::vector<Site>& sites = s.skin.description.sites;
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
        ResponseLayout::Range& range = layout.of[size_t(q)];
        range.first = layout.all;
        if (!s.wanted[size_t(q)]) continue;
        if (sites.empty()) {
            range.count = s.skin.padded_cells();
            layout.all += (range.count + field_alignment - 1) / field_alignment * field_alignment;
        } else {
            range.count = size_t(std::count_if(sites.begin(), sites.end(), [q](auto& t) { return int(t.type) == q; }));
            layout.all += range.count;
        }
    }
    std::array<size_t, REDUCED_MAPS> next{};
    for (const Site& site : sites)
        layout.site.push_back(layout.of[size_t(site.type)].first + next[size_t(site.type)]++);
    return layout;
}

StateLayout state_layout_of(const StreamedSkin& s) {
    const Variant v = s.variant();
    const size_t sums = v.chain.elements() + (s.wanted[QUANTITY_SA2] ? 1 : 0);
    std::vector<Cell> at;
    for (const Site& site : s.skin.description.sites) at.push_back(site.cell);
    return {.cells = at.empty() ? s.skin.cells() : SiteCells(s.skin, {s.skin.whole()}, at).cells.size(),
            .planes = sums * (v.compensated ? 2 : 1) + v.carries_rate(),
            .pressure = s.skin.cells()};
}

bool copy_rows(const PressureCopy& copy, int first, int last) {
    bool all = true; // no early exit, so that the loop vectorises
    for (size_t y = size_t(first); y < size_t(last); ++y) {
        const float* from = copy.from + y * copy.stride;
        float* to = copy.to + y * copy.pitch;
        for (size_t x = 0; x < copy.width; ++x) {
            all &= (std::bit_cast<uint32_t>(from[x]) & 0x7f800000u) != 0x7f800000u;
            to[x] = from[x];
        }
    }
    return all;
}

bool fill_table(const std::vector<Element>& materials, const Chain& chain, const ResponseRule& rule, double dt,
                f32::Coefficients* table) {
    if (!scene::finite(double(float(dt)))) return false;
    std::array<f64::Coefficients, scene::most_in_series> k;
    for (size_t i = 0; i < materials.size(); i += chain.length) {
        for (size_t e = 0; e < chain.length; ++e) k[e] = exact_coefficients(materials[i + e], rule, dt);
        join_loads<f64>(k.data(), chain.length, chain.spring, dt);
        for (size_t e = 0; e < chain.length; ++e)
            if (!round_to_float(k[e], table[i + e])) return false;
    }
    return true;
}

f32::Constants frame_constants(const PreparedSkin& skin, const f32::Coefficients& coefficients) {
    f32::Constants c = constants_of<f32>(skin, skin.whole());
    c.coefficients = coefficients;
    c.rise = 1;
    c.respond = 1;
    return c;
}

} // namespace dermis::plan
