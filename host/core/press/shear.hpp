// SPDX-License-Identifier: MIT
// The shear of a skin that is pressed frame by frame. Tractions along x and y strain the skin's material. Its shear
// modulus is a third of its modulus, because its volume stays the same. A stream of its own computes the shear: its
// first pads are the skin's pads along x, the others are the skin's pads along y.
#pragma once

#include "host/core/press/pressed_cells.hpp"

namespace dermis {

// Returns the options of the stream that the pressure presses. They have no SA2 where SA2 answers to the stretch.
// Throws Error::bad_input where SA2 cannot answer to it.
SkinOptions without_stretch(SkinOptions);

class Shear : public Stage {
  public:
    // Throws Error::bad_input where SkinOptions::shear is asked of a skin that has none.
    Shear(const model::StreamedSkin&, const SkinOptions&, model::Backend&);

    bool any() const { return cells_.has_value(); }
    // Copies the next tractions of pads, along x and then along y, as Stream::take() copies pressures.
    bool take(const model::PadList&, const float* tractions, bool by_number = false);
    bool rests(int pad) const override { return !any() || (cells_->rests(pad) && cells_->rests(int(pads_) + pad)); }
    void prepare(const model::PadList&, const model::StepLengths&, size_t presses) override;
    void press(const model::PadList&, const model::StepLengths&, size_t frame, bool last) override;
    // shear_x, shear_y, stretch_x, stretch_y or stretch_xy of all pads, read from their states, or SA2 after each pad's
    // last press, if it answers to the stretch; the same memory. Nothing for another quantity.
    std::optional<Skin::Response> response(Quantity);

    void reset(const model::PadList&) override;
    // elements: as the pressure strains them, not as the shear does.
    void set_elements(const model::PadList&, const std::vector<model::Element>&) override;
    // The bytes of a pad's state: of the shear along both axes, and of SA2 with its stretch. In memory the shear of all
    // pads comes first, then SA2 and the stretch of each pad.
    size_t state_bytes() const override { return any() ? 2 * state_of_axis() + state_of_sa2() : 0; }
    void save(const model::PadList&, char* states) override;
    void load(const model::PadList&, const char* states) override;

  private:
    model::PadList both(const model::PadList&);
    model::StepLengths both(const model::PadList&, const model::StepLengths&);
    const float* strain(); // along x of all pads, then along y
    size_t state_of_axis() const { return (layout_.cells * layout_.planes + layout_.pressure) * sizeof(float); }
    size_t state_of_sa2() const { return sa2_.empty() ? 0 : 2 * width_ * height_ * sizeof(float); }
    template <class Byte> model::StateMemory<Byte> memory(Byte* states) const;
    template <class Byte> void copy_sa2(const model::PadList&, Byte* states);
    model::ShearMaps maps(size_t pad);
    void step_sa2(const model::PadList&, const model::StepLengths&);

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
    std::array<std::vector<float>, 3> told_;    // the stretch's components, of all pads, once they are asked for
};

} // namespace dermis
