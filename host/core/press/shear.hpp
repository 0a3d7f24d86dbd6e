// SPDX-License-Identifier: MIT
// The shear of a skin that is pressed frame by frame: tractions along x and y strain the skin's material, whose shear
// modulus is a third of its modulus, because its volume stays the same. The pads of a stream of their own: first the
// shear along x of each pad, then along y.
#pragma once

#include "host/core/model/felt.hpp"
#include "host/core/model/stream.hpp"

namespace dermis {

// The options by which the pressure is pressed: without SA2, where it answers to the stretch. Throws Error::bad_input
// where it cannot.
SkinOptions without_stretch(SkinOptions);

class Shear {
  public:
    // Throws Error::bad_input where SkinOptions::shear is asked of a skin that has none.
    Shear(const plan::StreamedSkin&, const SkinOptions&, plan::Backend&);

    bool any() const { return stream_ != nullptr; }
    // What Stream::take() does with the tractions of pads along x, then along y.
    bool take(const plan::PadList&, const float* tractions, bool by_number = false);
    // What Stream::press() does, after take() of the same pads.
    const double* press(const plan::PadList&, const plan::StepLengths&);
    // The shear strain along x of all pads, then along y, read from their states; the same memory.
    const float* strain();
    // Writes stretch_x, stretch_y or stretch_xy of all pads.
    void read_stretch(Quantity, std::vector<float>& out);
    // SA2 of all pads after each pad's last press, where it answers to the stretch; else null.
    const float* sa2() const { return sa2_.empty() ? nullptr : sa2_.data(); }

    void reset(const plan::PadList&);
    // Gives pads other elements in series, those of the pressure.
    void set_elements(const plan::PadList&, std::vector<plan::Element>);
    // Of a pad: the states of both axes; behind those of all pads, of each pad SA2 and its stretch.
    size_t state_bytes() const { return any() ? 2 * state_of_axis() + state_of_sa2() : 0; }
    void save(const plan::PadList&, char* states);
    void load(const plan::PadList&, const char* states);

  private:
    plan::PadList both(const plan::PadList&);
    void take_spring(const plan::PadList&, const std::vector<plan::Element>&);
    size_t state_of_axis() const { return (layout_.cells * layout_.planes + layout_.pressure) * sizeof(float); }
    size_t state_of_sa2() const { return sa2_.empty() ? 0 : 2 * width_ * height_ * sizeof(float); }
    template <class Byte> plan::StateMemory<Byte> memory(Byte* states) const;
    template <class Copy> void copy_sa2(const plan::PadList&, Copy);
    plan::ShearMaps maps(size_t pad);
    void step_sa2(const plan::PadList&, const plan::StepLengths&);

    size_t pads_ = 0, width_ = 0, height_ = 0;
    int edges_ = 0;
    float slope_ = 0; // thickness over twice the spacing
    plan::StateLayout layout_;
    std::unique_ptr<plan::Stream> stream_; // null: no shear
    bool answers_ = true;                  // whether presses answer: a device keeps back those that do not
    std::optional<plan::Felt> felt_;
    std::vector<double> springs_;                     // the modulus of each pad's spring in series, Pa; 0: none
    bool is_read_ = false;                            // whether the strains are those of the states
    std::vector<float> strains_, planes_, pressures_; // of all pads, once they are asked for
    std::vector<int> both_;                           // a list of pads along x, then along y
    std::vector<double> steps_, before_;              // of each pad along both axes, s
    plan::StretchWeights sa2_weights_{};
    double adaptation_ = 0;                     // s, of SA2; 0: none
    std::vector<float> sa2_, stretch_, newest_; // of all pads, where SA2 answers to the stretch; of one pad
};

} // namespace dermis
