// SPDX-License-Identifier: MIT
#include "host/lab/march/march.hpp"

#include "host/core/cpu/backend.hpp"
#include "host/core/model/laplacian.hpp"

#include <deque>

namespace dermis {
namespace model {
namespace {

// Writes curvature or deformation under a strain whose rows are a pitch apart, in the arithmetic of a march.
template <class K>
void derive(const PreparedSkin& skin, Quantity q, const typename K::real* strain, std::vector<double>& to) {
    using real = typename K::real;
    const typename K::Constants c = constants_of<K>(skin, skin.whole());
    const auto row = [&](int y) { return strain + size_t(y) * size_t(c.pitch); };
    std::vector<double> rest(size_t(c.width)); // L(S)
    std::vector<real> L(rest.size());
    to.clear();
    to.reserve(skin.cells());
    for (int y = 0; y < c.height; ++y) {
        if (q == Quantity::deformation) {
            const double* heights = skin.heights.data() + skin.number_of({0, y});
            for (size_t x = 0; x < L.size(); ++x)
                to.push_back(K::flush(K::deformation_of(real(heights[x] * skin.relief), row(y)[x], c.thickness)));
            continue;
        }
        rest_curvature_row(skin, y, 0, c.width, rest.data());
        const auto rows = simd::neighbours<real>(y, c.width, c.height, skin.stencil, skin.edges, row);
        simd::best().of<K>().laplacian(rows, 0, c.width, L.data());
        for (size_t x = 0; x < L.size(); ++x) to.push_back(K::flush(K::curvature_of(real(rest[x]), L[x], c.bend)));
    }
}

class MarchStepper : public Stepper {
  public:
    MarchStepper(std::unique_ptr<March> march, const PreparedSkin& skin, const Variant& variant, Precision precision,
                 Sink sink)
        : skin_(skin), precision_(precision), holds_rate_(variant.state().rate),
          counts_(simd::strain_changed | (variant.wanted[QUANTITY_SA2] ? simd::integral_changed : 0)),
          sink_(std::move(sink)), march_(std::move(march)) {}

    void frame(const std::vector<double>& pressure) override { march_->frame(pressure); }

    void press(const Step& step) override {
        if (steady_ && repeats(step, slots_[last_].step)) { // pressed once more, everything stays as it is
            ++left_out_;
            if (sampled(step)) sink_(step, slots_[last_].sample);
            return;
        }
        steady_ = false;
        if (waiting_ == slots_.size()) slots_.emplace_back();
        Slot& slot = slots_[waiting_++];
        slot.step = step;
        if (march_->press(slot.step, sampled(step) ? &slot.sample : nullptr)) finish();
    }

    void finish() override {
        const int changed = march_->settle();
        if (waiting_ == 0) return;
        for (size_t i = 0; i < waiting_; ++i)
            if (sampled(slots_[i].step)) sink_(slots_[i].step, slots_[i].sample);
        last_ = waiting_ - 1;
        waiting_ = 0;
        const Step& step = slots_[last_].step;
        const bool again = last_ > 0 && repeats(step, slots_[last_ - 1].step); // the spring's rate is that of the load
        steady_ = step.keep && sampled(step) && step.jump == 0 && (changed & counts_) == 0 && (again || !holds_rate_);
    }

    long long left_out() const override { return left_out_; }
    long long dispatches() const override { return march_->dispatches(); }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        maps.resize(what.size());
        precision_ == Precision::f64 ? read_in<f64>(what, maps) : read_in<f32>(what, maps);
    }

  private:
    struct Slot {
        Step step;
        Sample sample;
    };

    static bool sampled(const Step& step) { return step.trace >= 0 || step.impulse >= 0; }
    static bool repeats(const Step& step, const Step& last) {
        return step.keep && step.jump == 0 && step.same_coefficients(last) && step.start == last.start &&
               step.rise == last.rise && step.frame == last.frame;
    }

    template <class K> void read_in(std::vector<Quantity> what, std::vector<std::vector<double>>& maps) {
        const std::vector<Quantity> asked = what;
        std::ranges::replace_if(
            what, [](Quantity q) { return q >= Quantity::curvature; }, Quantity::strain);
        const std::vector<const void*> views = march_->maps(what);
        finish();
        for (size_t i = 0; i < what.size(); ++i) {
            const auto* from = static_cast<const typename K::real*>(views[i]);
            if (asked[i] != what[i]) {
                derive<K>(skin_, asked[i], from, maps[i]);
                continue;
            }
            maps[i].clear();
            for (int y = 0; y < skin_.height(); ++y, from += skin_.pitch)
                maps[i].insert(maps[i].end(), from, from + skin_.width());
        }
    }

    const PreparedSkin& skin_;
    const Precision precision_;
    const bool holds_rate_; // the state holds the rate of a spring
    const int counts_;      // the bits of sums whose change could change what is asked for
    Sink sink_;
    std::deque<Slot> slots_; // of steps that wait, in order, and of the last ones that were taken
    std::unique_ptr<March> march_;
    size_t waiting_ = 0;
    size_t last_ = 0;     // slot of the last step that was taken
    bool steady_ = false; // the last step changed nothing that is asked for
    long long left_out_ = 0;
};

} // namespace

std::unique_ptr<March> march(Backend& backend, const MarchPlan& plan) {
    const auto* const cpu = dynamic_cast<const cpu::CpuBackend*>(&backend);
    return cpu ? cpu::march(plan, cpu->threads(), cpu->isa()) : vulkan::march(plan, backend);
}

std::unique_ptr<Stepper> march(Backend& backend, const PreparedSkin& skin, const Schedule& schedule,
                               Precision precision, Stepper::Sink sink) {
    const Variant variant = variant_of(skin, schedule, precision);
    const MarchPlan plan{.skin = skin,
                         .variant = variant,
                         .precision = precision,
                         .pressed = schedule.pressed,
                         .pressure = schedule.pressure,
                         .points = schedule.points,
                         .keeps_maps = schedule.keeps_maps};
    return std::make_unique<MarchStepper>(schedule.spreads() ? deep_march(backend, plan, schedule.half_space)
                                                             : march(backend, plan),
                                          skin, variant, precision, std::move(sink));
}

} // namespace model

std::unique_ptr<model::Stepper> march(const Device& device, const model::PreparedSkin& skin,
                                      const model::Schedule& schedule, Precision precision, model::Stepper::Sink sink) {
    Device::Impl& d = device.impl();
    if (d.info.vulkan) d.info.exact &= vulkan::exact(*d.backend, variant_of(skin, schedule, precision));
    d.need_exact();
    return model::march(*d.backend, skin, schedule, precision, std::move(sink));
}

} // namespace dermis
