// SPDX-License-Identifier: MIT
#include "host/core/model/streamed_skin.hpp"

#include "host/core/base/finite.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/description/description.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/model/site_cells.hpp"

#include <algorithm>
#include <bit>

namespace dermis::model {
namespace {

// Rounds coefficients to K. Returns false if one of them is beyond it.
template <class K> bool round_to(const f64::Coefficients& k, typename K::Coefficients& to) {
    to = rounded<K>(k);
    bool all = true;
#define CHECK_FINITE(name) all = all && finite(double(to.name));
    COEFFICIENTS(CHECK_FINITE)
#undef CHECK_FINITE
    return all;
}

constexpr size_t field_alignment = 64; // floats: 256 bytes, the greatest offset alignment that Vulkan allows

void need_float(const char* parameter, double v) {
    scene::need(finite(double(float(v))), parameter, v, "up to 3.4e38 for a skin in float");
}

// Checks the elements of a skin with these responses. `chain.length` consecutive elements belong to one cell.
void check_elements(const std::vector<Element>& elements, const Chain& chain, const Wanted& wanted) {
    for (size_t i = 0; i < elements.size(); ++i) {
        if (is_elastic(elements[i]) && i % chain.length < chain.elements() && wanted[QUANTITY_FA2])
            scene::refuse("material.viscosity", "0", "> 0 for FA2 of frames; with viscosity 0 do without fa2");
        need_float("material.modulus", stiffness(elements[i]));
    }
}

// Every constant must be finite in float: a product with infinity could be NaN, and appear as a wrong 0.
void check_float(const PreparedSkin& skin) {
    const f64::Constants& c = skin.constants;
    scene::need(finite(double(float(c.bend))), "grid.spacing", skin.spacing(),
                "material.thickness/spacing^2 up to 3.4e38 for a skin in float");
    need_float("material.curvature_length", c.curvature_length);
    for (double gain : {c.gain_plus, c.gain_minus}) need_float("receptors.fa2_gains", gain);
    for (const Site& site : skin.description.sites) // rest curvature of fields is checked where it is padded
        need_float("surface.relief", rest_curvature_at(skin, site.cell));
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
    if (!d.sites.empty()) asked.clear();
    for (const Site& site : d.sites) asked.push_back(site.type);
    return asked;
}

void check_pads(const SkinDescription& description, const SkinOptions& options) {
    constexpr int most = 1048576;
    scene::need(options.count >= 1 && options.count <= most, "count", options.count, "1..1048576 pads");
    const double cells = double(description.grid.width) * description.grid.height * options.count;
    scene::need(cells <= 2147483647, "count", options.count, "count*width*height up to 2147483647");
    if (!options.materials.empty() && options.materials.size() != size_t(options.count))
        scene::refuse("materials", std::to_string(options.materials.size()) + " materials",
                      "none, or one for each of count = " + std::to_string(options.count) + " pads");
}

// Gives a skin that is pressed by depth a spring of 1 Pa in place of its material: under a strain as its pressure, the
// strain is that pressure. A spring alone has no state for FA2; behind an element that never moves it has.
void press_by_depth(SkinDescription& s, const SkinOptions& options, const std::vector<Quantity>& asked) {
    scene::need(float(*s.material.thickness) > 0, "material.thickness", *s.material.thickness, "above 0 in float");
    if (scene::has_depth(s.receptors))
        scene::refuse("receptors.depth", "(given)", "none with control = depth, where no pressure is known");
    if (!options.materials.empty())
        scene::refuse("materials", "(given)", "none with control = depth, where the strain follows from the depth");
    if (s.receptors.fa2 == Fa2::point && std::ranges::count(asked, Quantity::fa2))
        scene::refuse("receptors.fa2", "\"point\"", "\"step-mean\" with control = depth");
    scene::drop_maps(s.material);
    std::vector<KelvinVoigt> chain = {{.modulus = 1, .viscosity = 0}};
    if (std::ranges::count(asked, Quantity::fa2)) chain.push_back({.modulus = 1, .viscosity = HUGE_VAL});
    scene::take_chain(s.material, chain);
}

// Sets what spreads each class that answers or has fibres, once for each depth.
void take_depths(StreamedSkin& s) {
    SkinDescription& d = s.skin.description;
    std::vector<std::pair<Depth, std::shared_ptr<const Spread>>> known;
    for (const scene::ReceptorClass& c : scene::receptor_classes) {
        const std::optional<double> depth = d.receptors.depth.*c.depth;
        const bool fires = std::ranges::any_of(s.afferents, [&](const Afferents& a) { return a.type == c.type; });
        if (!depth || !(s.wanted[size_t(c.type)] || fires)) continue;
        const Depth in_cells{*depth / s.skin.spacing(), d.receptors.kernel.*c.kernel, d.receptors.poisson.value_or(0)};
        if (!(in_cells.depth >= least_depth && in_cells.depth <= most_depth))
            scene::refuse("receptors.depth." + std::string(name(c.type)), shortest(*depth),
                          "0, or " + shortest(least_depth * s.skin.spacing()) + " .. " +
                              shortest(most_depth * s.skin.spacing()) +
                              ", a millionth and a million times grid.spacing");
        auto one = std::ranges::find_if(known, [&](const auto& k) { return k.first == in_cells; });
        if (one == known.end())
            one = known.insert(
                one, {in_cells, std::make_shared<const Spread>(spread_of(in_cells, s.skin.width(), s.skin.height()))});
        s.spread[size_t(c.type)] = one->second;
    }
}

// Refuses endings in cells that no site reads, where a state holds no others.
void need_held(const StreamedSkin& s, const std::vector<Afferents>& asked) {
    const char* others = "in a skin with sites but without receptors.depth";
    std::vector<size_t> held;
    for (const Site& site : s.skin.description.sites) held.push_back(s.skin.number_of(site.cell));
    std::ranges::sort(held);
    for (size_t i = 0; i < s.afferents.size() && !held.empty(); ++i) {
        const std::string at = "afferents[" + std::to_string(i) + "]";
        if (asked[i].radius) scene::refuse(at + ".radius", shortest(*asked[i].radius), std::string("none ") + others);
        for (size_t n = 0; n < s.afferents[i].cells.size(); ++n)
            if (!std::ranges::binary_search(held, s.skin.number_of(s.afferents[i].cells[n])))
                scene::refuse(at + ".cells[" + std::to_string(n) + "]", scene::text_of(s.afferents[i].cells[n]),
                              std::string("cells of sites ") + others);
    }
}

// Sets whether SA1 and fibres follow the stress. Refuses this where no cell, or no single material, comes to rest.
void take_followed(StreamedSkin& s, const SkinOptions& options) {
    const Receptors& r = s.skin.description.receptors;
    const std::vector<Element> chain = scene::chain_of(s.skin.description.material);
    const bool rests = s.skin.uniform() && options.control == Control::pressure &&
                       std::ranges::none_of(chain, [](const Element& e) { return scene::is_viscous(e); });
    const auto need_rest = [rests](const std::string& key) {
        if (!rests)
            scene::refuse(key, "\"stress\"",
                          "\"strain\", unless the skin is pressed by pressure and has one material that comes to rest");
    };
    if (s.wanted[QUANTITY_SA2] && r.follow.sa2 == Signal::stress)
        scene::refuse("receptors.follow.sa2", "\"stress\"",
                      "\"strain\" in a skin pressed frame by frame: only scenes integrate the stress");
    s.follows = s.wanted[QUANTITY_SA1] && r.follow.sa1 == Signal::stress;
    if (s.follows) need_rest("receptors.follow.sa1");
    for (size_t i = 0; i < s.afferents.size(); ++i) {
        Afferents& a = s.afferents[i];
        if (!scene::follows_stress(r, a)) continue;
        need_rest(a.follow == Signal::stress ? "afferents[" + std::to_string(i) + "].follow"
                                             : std::string("receptors.follow.") + name(a.type));
        a.follow = Signal::stress;
    }
}

} // namespace

Variant StreamedSkin::variant() const {
    return {.stencil = skin.stencil,
            .edges = skin.edges,
            .compensated = precision == Precision::f32_compensated,
            .materials = !skin.uniform(),
            .framed = true,
            .parabolic = hold == Hold::parabolic,
            .chain = skin.chain,
            .pads = pads > 1 ? Variant::Pads::own : Variant::Pads::none,
            .spreads = deep(),
            .sites = !skin.description.sites.empty(),
            .wanted = wanted};
}

PreparedSkin signals_of(PreparedSkin skin) {
    f64::Constants& c = skin.constants;
    c.bend = c.curvature_length = 0, c.gain_plus = 1, c.gain_minus = -1;
    return skin;
}

StreamedSkin signals_of(const StreamedSkin& s) {
    StreamedSkin signals = s;
    signals.skin = signals_of(std::move(signals.skin));
    signals.wanted[QUANTITY_SA1] |= s.skin.constants.curvature_length != 0; // the strain, from which the gain follows
    signals.spread = {}, signals.follows = false, signals.picked.clear();
    return signals;
}

StreamedSkin streamed_skin(const SkinDescription& description, const SkinOptions& options, int threads) {
    const std::vector<Quantity> asked = asked_responses(description, options);
    if (options.precision == Precision::f64)
        scene::refuse("precision", "\"f64\"", "f32, f32-compensated: a skin pressed frame by frame is in float");
    check_pads(description, options);
    StreamedSkin s;
    SkinDescription own = description;
    if (!options.materials.empty()) scene::take_elements(own.material, options.materials.front());
    SkinDescription validated = scene::validate_skin(own, asked);
    if (options.control == Control::depth) press_by_depth(validated, options, asked);
    for (Quantity q : asked) s.wanted[size_t(q)] = true;
    s.skin = prepare_skin(validated, threads, options.count > 1 ? PRESS_CELLS : PITCH_CELLS);
    const bool grows = s.wanted[QUANTITY_SA2] && !validated.receptors.sa2_adaptation;
    s.precision = options.precision.value_or(grows ? Precision::f32_compensated : Precision::f32);
    check_elements(s.skin.materials, s.skin.chain, s.wanted);
    check_float(s.skin);
    s.afferents = scene::validated_afferents(validated, options.afferents);
    take_followed(s, options);
    take_depths(s);
    if (s.by_signals()) s.picked = std::exchange(s.skin.description.sites, {});
    else need_held(s, options.afferents);
    s.hold = options.hold;
    s.pads = options.count;
    for (size_t i = 0; i < options.materials.size(); ++i) {
        const std::vector<Element> own = elements_of_pad(validated, options.materials[i], s.skin.chain, s.wanted,
                                                         "materials[" + std::to_string(i) + "]");
        s.elements_of_pad.insert(s.elements_of_pad.end(), own.begin(), own.end());
    }
    return s;
}

std::vector<double> moduli_at_rest(const StreamedSkin& s) {
    std::vector<double> moduli;
    for (int pad = 0; pad < s.pads; ++pad) moduli.push_back(scene::modulus_at_rest(elements_of(s, pad)));
    return moduli;
}

void need_new_material(bool uniform, bool own, size_t listed, size_t all) {
    if (!uniform) scene::refuse("material", "(numbers)", "none: the skin has a material of maps, which stays as it is");
    if (!own && listed != all)
        scene::refuse("pads", std::to_string(listed) + " of " + std::to_string(all),
                      "all, where pads have no materials of their own");
}

std::vector<Element> elements_of_pad(const SkinDescription& validated, const Material& material, const Chain& chain,
                                     const Wanted& wanted, const std::string& parameter) {
    SkinDescription d; // what a material is checked against, without the maps
    d.grid = validated.grid;
    d.receptors = validated.receptors;
    if (!scene::is_uniform(material)) scene::refuse(parameter, "(a map)", "numbers");
    std::vector<Quantity> asked;
    for (size_t q = 0; q < wanted.size(); ++q)
        if (wanted[q]) asked.push_back(Quantity(q));
    try {
        scene::check_material(d, material, asked);
        const scene::Series series = scene::series_at(material, 0);
        if (series.length != chain.length || series.ends_in_spring != chain.spring)
            scene::refuse("material.elements",
                          std::to_string(series.length - series.ends_in_spring) + " and " +
                              (series.ends_in_spring ? "a" : "no") + " spring",
                          std::to_string(chain.elements()) + " and " + (chain.spring ? "a" : "no") +
                              " spring, as the skin has");
        const std::vector<Element> elements = scene::chain_of(material), own = scene::chain_of(validated.material);
        if (!std::ranges::equal(elements, own, {}, scene::is_viscous, scene::is_viscous))
            scene::refuse("material.elements", "(another dashpot)",
                          "a dashpot, which has no modulus, in the same places as in the skin");
        check_elements(elements, chain, wanted);
        return elements;
    } catch (const Error& error) {
        throw Error(error.code(), parameter, parameter + ": " + error.what());
    }
}

ResponseLayout response_layout_of(const StreamedSkin& s) {
    ResponseLayout layout;
    const std::vector<Site>& sites = s.sites();
    const std::array<size_t, RESPONSE_MAPS> counts = response_counts(s);
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
        ResponseLayout::Range& range = layout.of[size_t(q)];
        range.first = layout.all;
        if (!s.wanted[size_t(q)]) continue;
        if (sites.empty()) {
            range.count = s.skin.padded_cells() * size_t(s.pads);
            layout.all += (range.count + field_alignment - 1) / field_alignment * field_alignment;
        } else {
            range.count = counts[size_t(q - QUANTITY_SA1)] * size_t(s.pads);
            layout.all += range.count;
        }
    }
    std::array<size_t, REDUCED_MAPS> next{};
    for (const Site& site : sites)
        layout.site.push_back(layout.of[size_t(site.type)].first + next[size_t(site.type)]++);
    return layout;
}

std::array<size_t, RESPONSE_MAPS> response_counts(const StreamedSkin& s) {
    std::array<size_t, RESPONSE_MAPS> counts{};
    const std::vector<Site>& sites = s.sites();
    for (size_t r = 0; r < RESPONSE_MAPS; ++r)
        if (sites.empty() && s.wanted[QUANTITY_SA1 + r]) counts[r] = s.skin.cells();
    for (const Site& site : sites) ++counts[size_t(site.type) - QUANTITY_SA1];
    return counts;
}

StateLayout state_layout_of(const StreamedSkin& s) {
    return {.cells = s.skin.description.sites.empty() ? s.skin.cells() : site_cells_of(s.skin).cells.size(),
            .planes = size_t(s.variant().state().planes()),
            .pressure = s.skin.cells()};
}

bool copy_rows(const PressureCopy& copy, int first, int last) {
    uint32_t joined = 0; // no early exit, so that the loop vectorises
    for (size_t y = size_t(first); y < size_t(last); ++y) {
        const float* from = copy.from + y * copy.stride;
        float* to = copy.to + y * copy.pitch;
        for (size_t x = 0; x < copy.width; ++x) {
            joined |= not_finite(std::bit_cast<uint32_t>(from[x]));
            to[x] = from[x];
        }
    }
    return !any_not_finite(joined);
}

bool all_finite(const float* numbers, size_t count) {
    uint32_t joined = 0;
    for (size_t i = 0; i < count; ++i) joined |= not_finite(std::bit_cast<uint32_t>(numbers[i]));
    return !any_not_finite(joined);
}

bool all_bits_zero(const float* numbers, size_t count) {
    uint32_t bits = 0;
    for (size_t i = 0; i < count; ++i) bits |= std::bit_cast<uint32_t>(numbers[i]);
    return bits == 0;
}

template <class K>
bool fill_table(std::span<const Element> materials, const Chain& chain, const ResponseRule& rule, const FrameStep& step,
                typename K::Coefficients* table) {
    const double dt = step.dt;
    if (!finite(double(typename K::real(dt)))) return false;
    // The frames after the first one of press_frames() have the step dt before them, and nothing refuses them any more.
    if (step.before && *step.before != dt && !fill_table<K>(materials, chain, rule, {dt, dt}, table)) return false;
    SeriesCoefficients k, past;
    for (size_t i = 0; i < materials.size(); i += chain.length) {
        const auto of = [&](size_t e) { return exact_coefficients(materials[i + e], rule, dt); };
        join_series(&materials[i], chain, rule, step, of, k, past);
        for (size_t e = 0; e < chain.length; ++e)
            if (!round_to<K>(k[e], *table++) || (step.before && !round_to<K>(past[e], *table++))) return false;
    }
    return true;
}
template bool fill_table<f32>(std::span<const Element>, const Chain&, const ResponseRule&, const FrameStep&,
                              f32::Coefficients*);
template bool fill_table<f64>(std::span<const Element>, const Chain&, const ResponseRule&, const FrameStep&,
                              f64::Coefficients*);

StepTables::StepTables(const StreamedSkin& s, const std::vector<Element>& elements)
    : chain_(s.skin.chain), rule_(s.skin.rule), pads_(size_t(s.pads)), own_(!s.elements_of_pad.empty()), each_(own_),
      elements_(own_ ? s.elements_of_pad : elements) {
    elements_of_pad_ = own_ ? chain_.length : elements_.size();
    length_ = elements_of_pad_ * entries_of(s.hold);
    tables_.resize(length_ * (own_ ? pads_ : 1));
    filled_.assign(own_ ? pads_ : 1, {std::nan("")});
}

bool StepTables::fill_slot(size_t slot, const FrameStep& step) {
    if (step == filled_[slot]) return true;
    filled_[slot] = {std::nan("")}; // the table is of no step until it is filled
    const Element* elements = elements_.data() + (own_ ? slot * elements_of_pad_ : 0);
    if (!fill_table<f32>({elements, elements_of_pad_}, chain_, rule_, step, tables_.data() + slot * length_))
        return false;
    filled_[slot] = step;
    return true;
}

const double* StepTables::fill(const PadList& pads, const StepLengths& dt) {
    each_ = own_ || dt.each || !dt.alike(pads);
    if (!each_) return fill_slot(0, dt.of(pads, 0)) ? nullptr : &dt[0];
    if (filled_.size() < pads_) {
        tables_.resize(length_ * pads_);
        filled_.resize(pads_, {std::nan("")});
    }
    for (size_t i = 0; i < pads.count; ++i)
        if (!fill_slot(size_t(pads[i]), dt.of(pads, i))) return &dt[i];
    return nullptr;
}

void StepTables::set_elements(const PadList& pads, const std::vector<Element>& elements) {
    for (size_t i = 0; i < pads.count; ++i) {
        const size_t pad = own_ ? size_t(pads[i]) : 0;
        std::ranges::copy(elements, elements_.begin() + long(pad * elements_of_pad_));
        if (own_) filled_[pad] = {std::nan("")};
    }
    if (!own_) std::ranges::fill(filled_, FrameStep{std::nan("")});
}

f32::Constants frame_constants(const PreparedSkin& skin, const f32::Coefficients& coefficients) {
    f32::Constants c = constants_of<f32>(skin, skin.whole());
    c.coefficients = coefficients;
    c.rise = 1, c.respond = 1;
    return c;
}

} // namespace dermis::model
