// SPDX-License-Identifier: MIT
// The shear of a skin that is pressed frame by frame. Tractions along x and y strain the skin's material. Its shear
// modulus is a third of its modulus, because its volume stays the same. A stream of its own computes the shear: its
// first pads are the skin's pads along x, the others are the skin's pads along y.
#pragma once

#include "host/core/base/float_environment.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/description/element.hpp"
#include "host/core/press/pressed_cells.hpp"

#include <cmath>

namespace dermis {

// Returns the options of the stream that the pressure presses. They have no SA2 where SA2 answers to the stretch.
// Throws Error::bad_input where SA2 cannot answer to it.
inline SkinOptions without_stretch(SkinOptions options) {
    if (!options.sa2_stretch) return options;
    if (!options.shear) scene::refuse("sa2_stretch", "(given)", "none without shear");
    const auto [x, y] = *options.sa2_stretch;
    for (const double n : {x, y}) scene::need_finite("sa2_stretch", n);
    if (std::erase(options.responses, Quantity::sa2) == 0)
        scene::refuse("sa2_stretch", "(given)", "none where sa2 is not among the responses");
    if (options.responses.empty()) options.responses = {Quantity::sa1};
    return options;
}

class Shear : public Stage {
  public:
    // Throws Error::bad_input where SkinOptions::shear is asked of a skin that has none.
    Shear(const model::StreamedSkin& skin, const SkinOptions& options, model::Backend& backend) {
        if (!options.shear) return;
        check(skin, options);
        const model::StreamedSkin own = skin_of(skin, options, backend.threads());
        pads_ = size_t(options.count);
        width_ = size_t(skin.skin.width()), height_ = size_t(skin.skin.height());
        edges_ = skin.skin.edges;
        slope_ = float(skin.skin.constants.thickness / (2 * skin.skin.spacing()));
        layout_ = state_layout_of(own);
        cells_.emplace(own, backend);
        cells_->stream().reserve_states();
        answers_ = backend.threads() == 0; // a device keeps presses back that need not answer
        both_.reserve(2 * pads_);
        steps_.resize(2 * pads_);
        before_.resize(2 * pads_);
        if (!options.sa2_stretch) return;
        auto [x, y] = *options.sa2_stretch;
        const double longer = std::max(std::abs(x), std::abs(y));
        for (double* d : {&x, &y}) *d = std::scalbn(*d, longer > 0 ? -std::ilogb(longer) : 0); // squares are finite
        const double square = x * x + y * y;
        sa2_weights_ = square == 0 ? model::StretchWeights{1, 1, 0}
                                   : model::StretchWeights{float(x * x / square), float(y * y / square),
                                                           float(2 * x * y / square)};
        adaptation_ = skin.skin.description.receptors.sa2_adaptation.value_or(0);
        for (std::vector<float>* map : {&sa2_, &stretch_}) map->resize(pads_ * width_ * height_);
        if (adaptation_ == 0) carried_.resize(sa2_.size());
        newest_.resize(width_ * height_);
        (void)strain(); // makes room
    }

    bool any() const { return cells_.has_value(); }
    // Copies the next tractions of pads, along x and then along y, as Stream::take() copies pressures.
    bool take(const model::PadList& pads, const float* tractions, bool by_number = false) {
        return cells_->stream().take(both(pads), tractions, by_number);
    }
    bool rests(int pad) const override { return !any() || (cells_->rests(pad) && cells_->rests(int(pads_) + pad)); }
    void prepare(const model::PadList& pads, const model::StepLengths& dt, size_t) override {
        if (any()) cells_->prepare(both(pads), both(pads, dt), 1);
    }
    void press(const model::PadList& pads, const model::StepLengths& dt, size_t, bool) override {
        if (!any()) return;
        is_read_ = false;
        // Strains are read from the states: nothing is to be answered, which takes a third of the time.
        cells_->press(both(pads), both(pads, dt), 0, answers_);
        if (!sa2_.empty()) step_sa2(pads, dt);
    }
    // shear_x, shear_y, stretch_x, stretch_y or stretch_xy of all pads, read from their states, or SA2 after each pad's
    // last press, if it answers to the stretch; the same memory. Nothing for another quantity.
    std::optional<Skin::Response> response(Quantity q) {
        const size_t all = pads_ * width_ * height_;
        if (q == Quantity::sa2 && !sa2_.empty()) return Skin::Response{sa2_.data(), all};
        if (!any() || q < Quantity::shear_x) return {};
        if (q <= Quantity::shear_y) return Skin::Response{strain() + (q == Quantity::shear_y ? all : 0), all};
        const DefaultFloats guard;
        std::vector<float>& out = told_[size_t(q) - size_t(Quantity::stretch_x)];
        const model::StretchWeights weights{.x = float(q == Quantity::stretch_x),
                                            .y = float(q == Quantity::stretch_y),
                                            .xy = float(q == Quantity::stretch_xy)};
        out.resize(all);
        for (size_t pad = 0; pad < pads_; ++pad)
            model::stretch_of(weights, maps(pad), out.data() + pad * width_ * height_);
        return Skin::Response{out.data(), all};
    }

    void reset(const model::PadList& pads) override {
        if (!any()) return;
        is_read_ = false;
        cells_->reset(both(pads));
        for (size_t i = 0; i < pads.count; ++i)
            for (std::vector<float>* map : {&sa2_, &stretch_, &carried_})
                if (!map->empty())
                    std::fill_n(map->begin() + long(size_t(pads[i]) * width_ * height_), width_ * height_, 0.0f);
    }
    // elements: as the pressure strains them, not as the shear does.
    void set_elements(const model::PadList& pads, const std::vector<model::Element>& elements) override {
        if (!any()) return;
        cells_->set_elements(both(pads), sheared(elements));
        is_read_ = false;
    }
    // The bytes of a pad's state: of the shear along both axes, and of SA2 with its stretch. In memory the shear of all
    // pads comes first, then SA2 and the stretch of each pad.
    size_t state_bytes() const override { return any() ? 2 * state_of_axis() + state_of_sa2() : 0; }
    void save(const model::PadList& pads, char* states) override {
        cells_->save_cells(both(pads), memory(states));
        copy_sa2(pads, states);
    }
    void load(const model::PadList& pads, const char* states) override {
        is_read_ = false;
        cells_->stream().load(both(pads), memory(states));
        copy_sa2(pads, states);
    }

  private:
    static std::vector<model::Element> sheared(std::vector<model::Element> chain) {
        for (model::Element& e : chain) e.modulus /= 3, e.viscosity /= 3; // retardation times stay
        return chain;
    }

    // The material of a pad's shear, whose elements stand in the order in which they strain the skin.
    static Material sheared(const Material& m) {
        Material own;
        std::vector<KelvinVoigt>& elements = own.elements = scene::listed(sheared(scene::chain_of(m)));
        if (elements.size() > 1 && elements.back().viscosity == 0)
            own.spring = elements.back().modulus, elements.pop_back();
        if (elements.size() > 1 && m.dashpot) own.dashpot = elements.back().viscosity, elements.pop_back();
        return own;
    }

    // Returns the skin whose strains are the shear strains: it is flat, and has two pads for each pad of the pressed
    // skin. Its rules for SA2 and FA2 are the pressed skin's. Its moduli and viscosities are a third of the pressed
    // skin's, so that a step that is too long for the pressed skin is too long for this one.
    static model::StreamedSkin skin_of(const model::StreamedSkin& skin, const SkinOptions& options, int threads) {
        const SkinDescription& own = skin.skin.description;
        SkinDescription d;
        d.grid = {own.grid.width, own.grid.height, 1};
        d.surface.kind = Surface::Kind::flat;
        d.surface.relief = 1;
        d.material = sheared(own.material);
        d.material.thickness = 1, d.material.curvature_length = 0;
        d.stencil = own.stencil, d.edges = own.edges;
        d.receptors.fa2 = own.receptors.fa2, d.receptors.sa2_adaptation = own.receptors.sa2_adaptation;
        SkinOptions both;
        both.responses = {Quantity::sa1};
        both.precision = skin.precision;
        both.count = 2 * options.count;
        both.hold = options.hold;
        for (int axis = 0; axis < 2; ++axis)
            for (const Material& m : options.materials) both.materials.push_back(sheared(m));
        return model::streamed_skin(d, both, threads);
    }

    static void check(const model::StreamedSkin& skin, const SkinOptions& options) {
        const auto need = [](bool ok, const char* allowed) {
            if (!ok) scene::refuse("shear", "true", allowed);
        };
        need(skin.sites().empty(), "false in a skin with sites");
        need(options.control == Control::pressure, "false with control = depth");
        need(scene::is_uniform(skin.skin.description.material), "false in a skin whose material has maps");
        need(skin.skin.edges != EDGES_PUBLISHED, "false with curvature.edges = published");
        need(options.count <= 524288, "false with more than 524288 pads");
        const Receptors& r = skin.skin.description.receptors;
        if (options.sa2_stretch && (r.depth.sa2 || r.follow.sa2 == Signal::stress))
            scene::refuse("sa2_stretch", "(given)",
                          "none with receptors.depth.sa2, or with receptors.follow.sa2 = stress");
    }

    // The same pads along x, then along y. It is valid until the next call.
    model::PadList both(const model::PadList& pads) {
        both_.clear();
        for (size_t axis = 0; axis < 2; ++axis)
            for (size_t i = 0; i < pads.count; ++i) both_.push_back(int(axis * pads_) + pads[i]);
        return {.ids = both_.data(), .count = both_.size()};
    }
    // The steps of both(pads). They are valid until the next call.
    model::StepLengths both(const model::PadList& pads, const model::StepLengths& dt) {
        for (size_t i = 0; dt.each && i < 2 * pads.count; ++i) steps_[i] = dt[i % pads.count];
        for (size_t i = 0; i < pads.count; ++i) {
            const auto pad = size_t(pads[i]);
            before_[pad] = before_[pads_ + pad] = dt.before[pad];
        }
        return {.dt = dt.each ? steps_.data() : dt.dt,
                .each = dt.each,
                .before = before_.data(),
                .parabolic = dt.parabolic};
    }
    // along x of all pads, then along y
    const float* strain() {
        const DefaultFloats guard;
        if (!is_read_) cells_->read({.count = 2 * pads_}, states_);
        is_read_ = true;
        return states_.strains.data();
    }
    size_t state_of_axis() const { return (layout_.cells * layout_.planes + layout_.pressure) * sizeof(float); }
    size_t state_of_sa2() const { return (sa2_.size() + stretch_.size() + carried_.size()) / pads_ * sizeof(float); }
    template <class Byte> model::StateMemory<Byte> memory(Byte* states) const {
        return {.strains = states,
                .pressure = states + layout_.cells * layout_.planes * sizeof(float),
                .strains_step = state_of_axis(),
                .pressure_step = state_of_axis()};
    }
    // Copies SA2 and the stretch of each of these pads to the caller's memory or, where Byte is const, from there.
    template <class Byte> void copy_sa2(const model::PadList& pads, Byte* states) {
        states += 2 * pads.count * state_of_axis();
        for (size_t i = 0; i < pads.count; ++i)
            for (std::vector<float>* map : {&sa2_, &stretch_, &carried_})
                if (!map->empty())
                    model::copy_state(states, map->data() + size_t(pads[i]) * width_ * height_, width_ * height_);
    }
    model::ShearMaps maps(size_t pad) {
        const float* const first = strain() + pad * width_ * height_;
        return {.along_x = first,
                .along_y = first + pads_ * width_ * height_,
                .width = int(width_),
                .height = int(height_),
                .edges = edges_,
                .slope = slope_};
    }
    // Steps y' = stretch - y/adaptation, with the stretch along a line over the step.
    void step_sa2(const model::PadList& pads, const model::StepLengths& dt) {
        const DefaultFloats guard;
        const size_t cells = width_ * height_;
        for (size_t i = 0; i < pads.count; ++i) {
            const double z = adaptation_ > 0 ? dt[i] / adaptation_ : 0;
            const double mean = z == 0 ? 1 : -std::expm1(-z) / z; // of exp(-z*t), t in 0..1
            const double late = z < 1e-3 ? 0.5 - z / 6 + z * z / 24 : (1 - mean) / z;
            const float kept = float(std::exp(-z)), before = float(dt[i] * (mean - late)), now = float(dt[i] * late);
            const size_t first = size_t(pads[i]) * cells;
            float *y = sa2_.data() + first, *last = stretch_.data() + first;
            float* const carried = carried_.empty() ? nullptr : carried_.data() + first;
            model::stretch_of(sa2_weights_, maps(size_t(pads[i])), newest_.data());
            for (size_t k = 0; k < cells; ++k) {
                const float step = before * last[k] + now * newest_[k], more = carried ? step - carried[k] : step,
                            sum = kept * y[k] + more;
                if (carried) carried[k] = (sum - y[k]) - more;
                y[k] = sum;
                last[k] = newest_[k];
            }
        }
    }

    size_t pads_ = 0, width_ = 0, height_ = 0;
    int edges_ = 0;
    float slope_ = 0; // thickness over twice the spacing
    model::StateLayout layout_;
    std::optional<PressedCells> cells_;  // empty: no shear
    bool answers_ = true;                // whether a press computes responses: without, a device would delay it
    bool is_read_ = false;               // whether `states_` belongs to the last press
    PressedCells::States states_;        // of all pads, once they are asked for
    std::vector<int> both_;              // a list of pads along x, then along y
    std::vector<double> steps_, before_; // of each pad along both axes, s
    model::StretchWeights sa2_weights_{};
    double adaptation_ = 0;                     // s, of SA2; 0: none
    std::vector<float> sa2_, stretch_, newest_; // of all pads, where SA2 answers to the stretch; of one pad
    std::vector<float> carried_;                // rounding errors of SA2, of all pads; empty with an adaptation
    std::array<std::vector<float>, 3> told_;    // the stretch's components, of all pads, once they are asked for
};

} // namespace dermis
