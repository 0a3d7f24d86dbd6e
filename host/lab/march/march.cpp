// SPDX-License-Identifier: MIT
#include "host/lab/march/march.hpp"

#include "host/lab/march/capabilities.hpp"
#include "host/lab/march/self_test.hpp"

#ifdef DERMIS_VULKAN
#include "host/core/embedding/backend.hpp"
#endif

#include <deque>

namespace dermis {
namespace plan {
namespace {

// Those of a step of a schedule.
class CoefficientsOfStep : public StepCoefficients {
  public:
    CoefficientsOfStep(const Step& step, const PreparedSkin& skin) : step_(step), skin_(skin) {}
    void fill(std::vector<f32::Coefficients>& table) const override { fill_in<f32>(table); }
    void fill(std::vector<f64::Coefficients>& table) const override { fill_in<f64>(table); }
    void fill_row(const int* material, int cells, f32::Coefficients* row) const override {
        fill_row_in<f32>(material, cells, row);
    }
    void fill_row(const int* material, int cells, f64::Coefficients* row) const override {
        fill_row_in<f64>(material, cells, row);
    }

  private:
    template <class K> void fill_in(std::vector<typename K::Coefficients>& table) const {
        plan::fill_table<K>(step_, skin_.materials, skin_.chain, skin_.rule, table);
    }
    template <class K> void fill_row_in(const int* material, int cells, typename K::Coefficients* row) const {
        plan::fill_row<K>(step_, skin_.materials, skin_.chain, skin_.rule, material, cells, row);
    }

    const Step step_;
    const PreparedSkin& skin_;
};

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
        if (!coefficients_ || !step.same_coefficients(coefficients_of_)) {
            coefficients_ = std::make_shared<CoefficientsOfStep>(step, skin_);
            coefficients_of_ = step;
        }
        if (waiting_ == slots_.size()) slots_.emplace_back();
        Slot& slot = slots_[waiting_++];
        slot.step = step;
        if (march_->press({.coefficients = coefficients_,
                           .start = step.constant_start(),
                           .rise = step.constant_rise(),
                           .jump = step.jump,
                           .keep = step.keep,
                           .respond = step.respond(),
                           .sample = sampled(step) ? &slot.sample : nullptr}))
            finish();
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
        const std::vector<const void*> views = march_->maps(what);
        finish();
        maps.resize(what.size());
        for (size_t i = 0; i < what.size(); ++i)
            if (precision_ == Precision::f64) copy(static_cast<const double*>(views[i]), maps[i]);
            else copy(static_cast<const float*>(views[i]), maps[i]);
    }

    std::vector<const float*> view(const std::vector<Quantity>& what) override {
        if (precision_ == Precision::f64) return Stepper::view(what);
        std::vector<const float*> views;
        for (const void* map : march_->maps(what)) views.push_back(static_cast<const float*>(map));
        finish();
        return views;
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

    template <class T> void copy(const T* from, std::vector<double>& to) const {
        to.clear();
        for (int y = 0; y < skin_.height(); ++y, from += skin_.pitch) to.insert(to.end(), from, from + skin_.width());
    }

    const PreparedSkin& skin_;
    const Precision precision_;
    const bool holds_rate_; // the state holds the rate of a spring
    const int counts_;      // the bits of sums whose change could change what is asked for
    Sink sink_;
    std::deque<Slot> slots_; // of steps that wait, in order, and of the last ones that were taken
    std::unique_ptr<March> march_;
    std::shared_ptr<const StepCoefficients> coefficients_; // of the last step
    Step coefficients_of_;                                 // what they were made for
    size_t waiting_ = 0;
    size_t last_ = 0;     // slot of the last step that was taken
    bool steady_ = false; // the last step changed nothing that is asked for
    long long left_out_ = 0;
};

} // namespace

Capabilities capabilities_of(const Backend& backend) {
    Capabilities c;
    c.name = backend.name();
    c.threads = backend.threads();
#ifdef DERMIS_VULKAN
    if (const auto* vulkan = dynamic_cast<const vulkan::VulkanBackend*>(&backend)) {
        c.double_buffered = true;
        // Measured on lavapipe; for a GPU estimated from its memory bandwidth.
        c.cell_step = vulkan->context()->physical().info.kind == "software" ? 28e-9 : 3e-10;
        c.dispatch = 5e-6;
        return c;
    }
#endif
    c.f64 = true;
    c.cell_step = 1.8e-9 / c.threads; // measured on two cores of a server
    return c;
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
                         .keeps_maps = schedule.keeps_maps,
                         .derives = schedule.derives};
    return std::make_unique<MarchStepper>(backend.march(plan), skin, variant, precision, std::move(sink));
}

} // namespace plan

namespace {

void need_exact(Device::Impl& d, const plan::Variant& v) {
    using Tested = Device::Impl::Tested;
    const bool plain =
        v.stencil == STENCIL_FIVE_POINT && v.edges == EDGES_MIRROR && !v.compensated && !v.materials && !v.framed;
    const Tested needed = plain ? Tested::plain_march : Tested::every_march;
    if (d.tested < needed) d.info.exact &= self_test(*d.backend, !plain).exact();
    d.tested = std::max(d.tested, needed);
    d.need_exact();
}

} // namespace

std::unique_ptr<plan::Stepper> march(const Device& device, const plan::PreparedSkin& skin,
                                     const plan::Schedule& schedule, Precision precision, plan::Stepper::Sink sink) {
    need_exact(device.impl(), variant_of(skin, schedule, precision));
    return plan::march(*device.impl().backend, skin, schedule, precision, std::move(sink));
}

} // namespace dermis
