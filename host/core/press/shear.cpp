// SPDX-License-Identifier: MIT
#include "host/core/press/shear.hpp"

#include "host/core/base/refusal.hpp"
#include "host/core/description/element.hpp"
#include "host/core/model/felt.hpp"

namespace dermis {
namespace {

std::vector<plan::Element> sheared(std::vector<plan::Element> chain) {
    for (plan::Element& e : chain) e.modulus /= 3, e.viscosity /= 3; // retardation times stay
    return chain;
}

// The material of a pad's shear. Without a curvature length SA1 is the shear strain.
Material sheared(const Material& m) {
    Material own;
    scene::take_chain(own, scene::listed(sheared(scene::chain_of(m))));
    return own;
}

// A flat skin without sites whose SA1 is the shear strain, with twice as many pads. It is one in metres, because a skin
// without metres has a curvature length.
plan::StreamedSkin skin_of(const plan::StreamedSkin& skin, const SkinOptions& options, int threads) {
    const SkinDescription& own = skin.skin.description;
    SkinDescription d;
    d.grid = {own.grid.width, own.grid.height, 1};
    d.surface.kind = Surface::Kind::flat;
    d.surface.relief = 1;
    d.material = sheared(own.material);
    d.material.thickness = 1, d.material.curvature_length = 0;
    d.stencil = own.stencil, d.edges = own.edges;
    SkinOptions both;
    both.responses = {Quantity::sa1};
    both.precision = skin.precision;
    both.count = 2 * options.count;
    both.hold = options.hold;
    for (int axis = 0; axis < 2; ++axis)
        for (const Material& m : options.materials) both.materials.push_back(sheared(m));
    return plan::streamed_skin(d, both, threads);
}

void check(const plan::StreamedSkin& skin, const SkinOptions& options) {
    const auto need = [](bool ok, const char* allowed) {
        if (!ok) scene::refuse("shear", "true", allowed);
    };
    need(skin.skin.description.sites.empty(), "false in a skin with sites");
    need(options.control == Control::pressure, "false with control = depth");
    need(scene::is_uniform(skin.skin.description.material), "false in a skin whose material has maps");
    need(skin.skin.edges != EDGES_PUBLISHED, "false with curvature.edges = published");
    need(options.count <= 524288, "false with more than 524288 pads");
}

} // namespace

Shear::Shear(const plan::StreamedSkin& skin, const SkinOptions& options, plan::Backend& backend) {
    if (!options.shear) return;
    check(skin, options);
    const plan::StreamedSkin own = skin_of(skin, options, backend.threads());
    pads_ = size_t(options.count);
    width_ = size_t(skin.skin.width()), height_ = size_t(skin.skin.height());
    edges_ = skin.skin.edges;
    slope_ = float(skin.skin.constants.thickness / (2 * skin.skin.spacing()));
    layout_ = state_layout_of(own);
    stream_ = backend.stream(own);
    both_.reserve(2 * pads_);
    steps_.resize(2 * pads_);
    before_.resize(2 * pads_);
}

// The same pads along x, then along y. It is valid until the next call.
plan::PadList Shear::both(const plan::PadList& pads) {
    both_.clear();
    for (size_t axis = 0; axis < 2; ++axis)
        for (size_t i = 0; i < pads.count; ++i) both_.push_back(int(axis * pads_) + pads[i]);
    return {.ids = both_.data(), .count = both_.size()};
}

bool Shear::take(const plan::PadList& pads, const float* tractions, bool by_number) {
    return stream_->take(both(pads), tractions, by_number);
}

const double* Shear::press(const plan::PadList& pads, const plan::StepLengths& dt) {
    for (size_t i = 0; dt.each && i < 2 * pads.count; ++i) steps_[i] = dt[i % pads.count];
    for (size_t i = 0; i < pads.count; ++i) {
        const auto pad = size_t(pads[i]);
        before_[pad] = before_[pads_ + pad] = dt.before[pad];
    }
    const plan::StepLengths own{
        .dt = dt.each ? steps_.data() : dt.dt, .each = dt.each, .before = before_.data(), .bent = dt.bent};
    const double* refused = stream_->press(both(pads), own);
    return refused && dt.each ? &dt[size_t(refused - steps_.data()) % pads.count] : refused;
}

void Shear::read_stretch(Quantity q, std::vector<float>& out) {
    const size_t cells = width_ * height_;
    out.resize(pads_ * cells);
    for (size_t pad = 0; pad < pads_; ++pad)
        plan::stretch_of(q,
                         {.along_x = strain() + pad * cells,
                          .along_y = strain() + (pads_ + pad) * cells,
                          .width = int(width_),
                          .height = int(height_),
                          .edges = edges_,
                          .slope = slope_},
                         out.data() + pad * cells);
}

void Shear::reset(const plan::PadList& pads) {
    if (any()) stream_->reset(both(pads));
}

void Shear::set_elements(const plan::PadList& pads, std::vector<plan::Element> elements) {
    if (any()) stream_->set_elements(both(pads), sheared(std::move(elements)));
}

template <class Byte> plan::StateMemory<Byte> Shear::memory(Byte* states) const {
    return {.strains = states,
            .pressure = states + layout_.cells * layout_.planes * sizeof(float),
            .strains_step = state_of_axis(),
            .pressure_step = state_of_axis()};
}

void Shear::save(const plan::PadList& pads, char* states) { stream_->save(both(pads), memory(states)); }

void Shear::load(const plan::PadList& pads, const char* states) { stream_->load(both(pads), memory(states)); }

} // namespace dermis
