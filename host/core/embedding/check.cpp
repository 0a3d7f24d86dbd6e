// SPDX-License-Identifier: MIT
#include "host/core/embedding/check.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/cpu/stream.hpp"
#include "host/core/model/laplacian.hpp"

#include <cstring>

namespace dermis {
namespace {

constexpr int sample_width = 67, sample_height = 13;

std::vector<double> noise(uint32_t random) {
    std::vector<double> map;
    for (int i = 0; i < sample_width * sample_height; ++i) {
        random = random * 1664525u + 1013904223u;
        map.push_back((double(random >> 8) / (1 << 24) - 0.25) * (i % 7 ? 1 : 1e-18));
    }
    return map;
}

} // namespace

Map sample_pressure() { return noise(99); }

SkinDescription sample_skin(Stencil stencil, Edges edges, bool materials, const model::Chain& chain) {
    SkinDescription d;
    d.grid = {sample_width, sample_height, {}};
    d.stencil = stencil;
    d.edges = edges;
    d.receptors = {0.5, Fa2::step_mean, {0.75, -0.375}};
    d.surface.kind = Surface::Kind::map;
    d.surface.map = noise(12345);
    Map moduli;
    if (materials) {
        moduli = noise(54321);
        for (double& E : moduli.edit()) E += 1.5;
    }
    if (chain.length == 1) {
        d.material.modulus = 2.5;
        d.material.viscosity = 0.75;
        d.material.modulus_map = moduli;
        return d;
    }
    for (size_t i = 100; i < moduli.size(); ++i)
        moduli.edit()[i] = moduli[i % 100]; // few enough for one update of a table
    constexpr size_t most = 8;              // elements of a material; a ninth one of a chain is its dashpot
    for (size_t e = 0; e < std::min(chain.elements(), most); ++e)
        d.material.elements.push_back({2.5 / double(1 + e), 0.75 * double(1 + 3 * e), e == 0 ? moduli : Map()});
    if (chain.elements() > most) d.material.dashpot = 20;
    if (chain.spring) d.material.spring = 8;
    return d;
}

SampleStream::SampleStream(const Options& v) {
    SkinDescription d = sample_skin(v.stencil, v.edges, v.materials, v.chain);
    if (!v.gains) d.receptors.fa2_gains = {1, -1};
    if (v.depth.sa1 || v.depth.sa2 || v.depth.fa1 || v.depth.fa2) {
        d.grid.spacing = 1; // m, as it counts without
        for (auto* one : {&d.surface.relief, &d.material.thickness, &d.material.curvature_length}) *one = 1; // likewise
        d.receptors.depth = v.depth;
        d.receptors.kernel = v.kernel;
    }
    SkinOptions options;
    options.precision = v.precision;
    options.responses.clear();
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
        if (v.wanted[size_t(q)]) options.responses.push_back(Quantity(q));
    for (int i = 0; v.sites && i < 100; ++i)
        d.sites.push_back({options.responses[size_t(i) % options.responses.size()],
                           {i * 31 % d.grid.width, i * i * 7 % d.grid.height}});
    options.count = v.pads ? 2 : 1;
    options.hold = v.hold;
    streamed_ = model::streamed_skin(d, options);
    layout_ = response_layout_of(streamed_);
}

static Depths in_cells(const model::StreamedSkin& s) {
    Depths depth;
    for (const scene::ReceptorClass& c : scene::receptor_classes)
        if (const auto& given = s.skin.description.receptors.depth.*c.depth) depth.*c.depth = *given / s.skin.spacing();
    return depth;
}

SampleStream::SampleStream(const model::StreamedSkin& like)
    : SampleStream({.stencil = *like.skin.description.stencil,
                    .edges = *like.skin.description.edges,
                    .precision = like.precision,
                    .materials = !like.skin.uniform(),
                    .sites = !like.sites().empty(),
                    .pads = like.pads > 1,
                    .hold = like.hold,
                    .chain = like.skin.chain,
                    .wanted = like.wanted,
                    .depth = in_cells(like),
                    .kernel = like.skin.description.receptors.kernel}) {}

std::vector<std::vector<float>> SampleStream::pressures() const {
    std::vector<std::vector<float>> all = {std::vector<float>(streamed_.skin.padded_cells() * size_t(streamed_.pads))};
    for (int i = 1; i <= presses; ++i) {
        std::vector<float>& pads = all.emplace_back();
        for (int pad = 0; pad < streamed_.pads; ++pad) {
            const Map& map = (i + pad) % 2 ? sample_pressure() : streamed_.skin.description.surface.map;
            const std::vector<float> own = model::padded<float>(map, streamed_.skin, "");
            pads.insert(pads.end(), own.begin(), own.end());
        }
    }
    return all;
}

std::array<size_t, 2> SampleStream::read_cells() const {
    const auto at = [&](Cell c) { return size_t(c.y) * size_t(streamed_.skin.pitch) + size_t(c.x); };
    const std::vector<Site>& sites = streamed_.sites();
    if (sites.empty()) return {at({3, 2}), at({66, 12})};
    return {at(sites[0].cell), at(sites[1].cell)};
}

std::vector<std::vector<float>> SampleStream::expected(const std::vector<std::vector<float>>& pressures) const {
    return pressed(*cpu::stream(streamed_, 1, simd::plain), pressures);
}

std::vector<std::vector<float>> SampleStream::pressed(model::Stream& stream,
                                                      const std::vector<std::vector<float>>& pressures) const {
    const size_t width = size_t(streamed_.skin.width()), pitch = size_t(streamed_.skin.pitch),
                 row = streamed_.sites().empty() ? width : 0; // of responses
    const model::PadList pads{.count = size_t(streamed_.pads)};
    std::vector<std::vector<float>> all;
    std::vector<double> before(pads.count);
    for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) // asked for first, so that a device ends each press with them
        if (streamed_.wanted[q]) (void)stream.response(Quantity(q));
    for (int i = 0; i < presses; ++i) {
        const std::vector<float>& pressure = pressures[size_t(i) + 1];
        std::vector<float> frame; // without the cells beyond the width
        for (size_t at = 0; at < pressure.size(); at += pitch)
            frame.insert(frame.end(), pressure.data() + at, pressure.data() + at + width);
        const model::StepLengths steps = this->steps(i, before.data());
        (void)stream.take(pads, frame.data());
        (void)stream.prepare(pads, steps); // null: a sample's coefficients fit float
        stream.press(pads, steps);
        steps.taken(pads);
        std::vector<float>& out = all.emplace_back(layout_.all);
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
            const model::ResponseLayout::Range& r = layout_.of[size_t(q)];
            for (size_t k = 0; k < r.count; k += row ? pitch : r.count)
                std::copy_n(stream.response(Quantity(q)) + (row ? k / pitch * row : k), row ? row : r.count,
                            out.data() + r.first + k);
        }
    }
    return all;
}

bool SampleStream::same(const float* a, const float* b) const {
    const bool fields = streamed_.sites().empty();
    const size_t pitch = size_t(streamed_.skin.pitch), width = size_t(streamed_.skin.width());
    for (const model::ResponseLayout::Range& r : layout_.of)
        for (size_t k = 0; k < r.count; ++k) {
            if (fields && k % pitch >= width) continue;
            if (std::memcmp(a + r.first + k, b + r.first + k, sizeof(float)) != 0) return false;
        }
    return true;
}

bool presses_exactly(model::Backend& backend, const model::StreamedSkin& like) {
    const DefaultFloats guard;
    const SampleStream sample(like);
    const auto pressures = sample.pressures(), found = sample.pressed(*backend.stream(sample.skin()), pressures),
               expected = sample.expected(pressures);
    bool exact = true;
    for (size_t i = 0; i < found.size(); ++i) exact &= sample.same(found[i].data(), expected[i].data());
    return exact;
}

} // namespace dermis
