// SPDX-License-Identifier: MIT
#include "host/lab/march/march.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/cpu/cells.hpp"
#include "host/core/model/laplacian.hpp"

#include <deque>

namespace dermis::cpu {
namespace {

template <class K> class March : public plan::Stepper {
  public:
    using real = typename K::real;

    March(const plan::PreparedSkin& skin, const plan::Schedule& schedule, const plan::Variant& variant, int threads,
          const simd::Isa& isa, Sink sink)
        : skin_(skin), schedule_(schedule), sink_(std::move(sink)), isa_(isa), holds_rate_(variant.state().rate),
          cells_(skin, variant, schedule.pressed, threads, isa, schedule.points),
          rest_(plan::padded_rest_curvature<real>(skin)) {
        if (schedule.framed) pressure(0) = pressure(1) = std::vector<real>(skin.padded_cells());
        else pressure(0) = plan::padded<real>(schedule.pressure, skin, "load.intensity");
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
            if (schedule.wanted[size_t(q)] && schedule.keeps_maps) make_response(q);
    }

    void frame(const std::vector<double>& map) override {
        ++to_;
        if (waiting_ > 0 && slots_[0].from + frames_kept <= to_) take_batch(); // the frame's memory is used again
        pressure(to_) = plan::padded<real>(map, skin_, "load.intensity", std::move(pressure(to_)));
    }

    void press(const plan::Step& step) override {
        if (steady_ && repeats(step, slots_[last_].step)) { // pressed once more, everything stays as it is
            ++left_out_;
            if (sampled(step)) hand_over(step, slots_[last_]);
            return;
        }
        steady_ = false;
        if (waiting_ == slots_.size()) slots_.emplace_back();
        slots_[waiting_].from = to_ - 1;
        slots_[waiting_++].step = step;
        if (waiting_ == plan::steps_of_batch || step.field >= 0) take_batch();
    }

    void finish() override { take_batch(); }
    long long left_out() const override { return left_out_; }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        take_batch();
        const DefaultFloats guard;
        maps.resize(what.size());
        std::vector<real> derived(size_t(skin_.width()));
        for (size_t i = 0; i < what.size(); ++i) {
            maps[i].clear();
            for (int y = 0; y < skin_.height(); ++y) {
                const real* values = derived.data();
                if (what[i] < Quantity::curvature) values = plane(size_t(what[i])) + row(y);
                else derive(what[i], y, derived.data());
                maps[i].insert(maps[i].end(), values, values + skin_.width());
            }
        }
    }

    std::vector<const float*> view(const std::vector<Quantity>& what) override {
        if constexpr (!std::is_same_v<real, float>) return Stepper::view(what);
        else {
            take_batch();
            const DefaultFloats guard;
            std::vector<const float*> maps;
            for (Quantity q : what) maps.push_back(q < Quantity::curvature ? plane(size_t(q)) : derived_map(q));
            return maps;
        }
    }

  private:
    // A step of a batch, with its coefficients and its sample.
    struct Slot {
        plan::Step step;
        size_t from; // the frame that the pressure runs from
        typename K::Constants constants;
        std::vector<typename K::Coefficients> table;                  // of the materials, where there are several
        plan::Step table_of;                                          // what it was made from
        std::function<void(int, typename K::Coefficients*)> fill_row; // where there is no table
        std::array<std::vector<typename K::Summary>, REDUCED_MAPS> tiles;
        plan::Sample sample;
    };

    static bool sampled(const plan::Step& step) { return step.trace >= 0 || step.impulse >= 0; }

    // Takes the steps that wait.
    void take_batch() {
        if (waiting_ == 0) return;
        const DefaultFloats guard;
        const auto each_slot = [&](auto f) {
            cells_.pool().share(int(waiting_), [&](int first, int last) {
                for (int i = first; i < last; ++i) f(slots_[size_t(i)]);
            });
        };
        each_slot([this](Slot& slot) { make_coefficients(slot); });
        std::vector<typename Cells<K>::Press> batch;
        for (size_t i = 0; i < waiting_; ++i) batch.push_back(prepared(slots_[i], i + 1 == waiting_));
        std::array<int, plan::steps_of_batch> changed;
        cells_.press(batch, changed);
        each_slot([this](Slot& slot) { total(slot); });
        for (size_t i = 0; i < waiting_; ++i)
            if (sampled(slots_[i].step)) hand_over(slots_[i].step, slots_[i]);
        last_ = waiting_ - 1;
        waiting_ = 0;
        const plan::Step& step = slots_[last_].step;
        const int counts = simd::strain_changed | (schedule_.wanted[QUANTITY_SA2] ? simd::integral_changed : 0);
        const bool again = last_ > 0 && repeats(step, slots_[last_ - 1].step); // the spring's rate is that of the load
        steady_ =
            step.keep && sampled(step) && step.jump == 0 && (changed[last_] & counts) == 0 && (again || !holds_rate_);
    }

    void make_coefficients(Slot& slot) const {
        if (skin_.differs_everywhere()) {
            slot.fill_row = [this, &slot](int y, typename K::Coefficients* of_row) {
                plan::fill_row<K>(slot.step, skin_.materials, skin_.chain, skin_.rule,
                                  skin_.material_of.data() + row(y), skin_.width(), of_row);
            };
        } else if ((skin_.tabled() || slot.step.bent) && !slot.step.same_coefficients(slot.table_of)) {
            slot.table_of = slot.step;
            plan::fill_table<K>(slot.step, skin_.materials, skin_.chain, skin_.rule, slot.table);
        }
    }

    typename Cells<K>::Press prepared(Slot& slot, bool last) {
        const plan::Step& step = slot.step;
        slot.constants = plan::constants_of<K>(skin_, schedule_.pressed, step);
        typename Cells<K>::Press p{.constants = slot.constants,
                                   .table = slot.table.data(),
                                   .fill_row = skin_.differs_everywhere() ? &slot.fill_row : nullptr,
                                   .pressure = pressure(slot.from).data(),
                                   .pressure_to = schedule_.framed ? pressure(slot.from + 1).data() : nullptr,
                                   .rest_curvature = rest_.data(),
                                   .keep = step.keep,
                                   .response_pitch = size_t(skin_.pitch)};
        for (size_t i = 0; last && i < RESPONSE_MAPS; ++i) p.response[i] = response_[i].data();
        if (!sampled(step)) return p;
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            if (!schedule_.wanted[q]) continue;
            slot.tiles[q].resize(size_t(skin_.height()) * size_t(skin_.tiles));
            p.tiles[q] = slot.tiles[q].data();
        }
        slot.sample.points.assign(REDUCED_MAPS * schedule_.points.size(), 0);
        p.points = slot.sample.points.data();
        return p;
    }

    void total(Slot& slot) const {
        for (size_t q = 0; sampled(slot.step) && q < REDUCED_MAPS; ++q)
            if (schedule_.wanted[q])
                slot.sample.totals[q] =
                    plan::total_of<K>(slot.tiles[q].data(), slot.tiles[q].size(), skin_.cells(), isa_);
    }

    void hand_over(const plan::Step& step, const Slot& slot) { sink_(step, slot.sample); }

    std::vector<real>& pressure(size_t frame) { return pressure_[frame % frames_kept]; }
    size_t row(int y) const { return size_t(y) * size_t(skin_.pitch); }
    Plane<real>& response(size_t q) { return response_[q - QUANTITY_SA1]; }
    const real* plane(size_t q) { return q == QUANTITY_STRAIN ? cells_.strain() : response(q).data(); }

    // Cells that are pressed begin as NaN, so that one which is read before it is written shows.
    void make_response(int q) {
        Plane<real>& map = response(size_t(q));
        map = Plane<real>(skin_.padded_cells(), response_place(skin_.chain) + q - QUANTITY_SA1);
        const plan::PressedBox& box = schedule_.pressed;
        for (int y = box.first_row; y < box.last_row; ++y)
            std::fill(map.row(y, skin_.pitch) + box.first_column(),
                      map.row(y, skin_.pitch) + box.last_column(skin_.width()), std::numeric_limits<real>::quiet_NaN());
    }

    static bool repeats(const plan::Step& step, const plan::Step& last) {
        return step.keep && step.jump == 0 && step.same_coefficients(last) && step.start == last.start &&
               step.rise == last.rise && step.frame == last.frame;
    }

    void derive(Quantity q, int y, real* out) const {
        const auto c = plan::constants_of<K>(skin_, schedule_.pressed);
        const real* eps = cells_.strain();
        if (q == Quantity::deformation) {
            std::vector<double> surface(size_t(c.width));
            plan::surface_row(skin_, y, surface.data());
            for (int x = 0; x < c.width; ++x)
                out[x] = K::flush(K::deformation_of(real(surface[size_t(x)]), eps[row(y) + size_t(x)], c.thickness));
            return;
        }
        const auto rows = simd::neighbours<real>(y, c.width, c.height, skin_.stencil, skin_.edges,
                                                 [&](int i) { return eps + row(i); });
        isa_.of<K>().laplacian(rows, 0, c.width, out);
        for (int x = 0; x < c.width; ++x) out[x] = K::flush(K::curvature_of(rest_[row(y) + size_t(x)], out[x], c.bend));
    }

    const real* derived_map(Quantity q) {
        std::vector<real>& map = derived_[q == Quantity::curvature];
        map.resize(skin_.padded_cells());
        for (int y = 0; y < skin_.height(); ++y) derive(q, y, map.data() + row(y));
        return map.data();
    }

    const plan::PreparedSkin& skin_;
    const plan::Schedule& schedule_;
    Sink sink_;
    const simd::Isa& isa_;
    const bool holds_rate_; // the state holds the rate of a spring
    Cells<K> cells_;
    static constexpr size_t frames_kept = plan::steps_of_batch + 1;
    std::array<std::vector<real>, frames_kept> pressure_; // of the last frames; without frames the first alone
    size_t to_ = 1;                                       // the frame given last; frames 0 and 1 are the skin at rest
    std::vector<real> rest_;                              // L(S)
    std::array<Plane<real>, RESPONSE_MAPS> response_;
    std::array<std::vector<real>, 2> derived_; // deformation and curvature, where they are viewed
    std::deque<Slot> slots_;                   // of steps that wait, in order, and of the last batch
    size_t waiting_ = 0;                       // steps that wait to be taken in one batch
    size_t last_ = 0;                          // slot of the last step that was taken
    bool steady_ = false;                      // the last step changed nothing that is asked for
    long long left_out_ = 0;
};

} // namespace

std::unique_ptr<plan::Stepper> stepper(const plan::PreparedSkin& skin, const plan::Schedule& schedule,
                                       Precision precision, int threads, plan::Stepper::Sink sink,
                                       const simd::Isa& isa) {
    const DefaultFloats guard; // threads inherit it
    const plan::Variant variant = variant_of(skin, schedule, precision);
    threads = simd::useful_threads(skin.cells(), threads);
    if (precision == Precision::f64)
        return std::make_unique<March<f64>>(skin, schedule, variant, threads, isa, std::move(sink));
    return std::make_unique<March<f32>>(skin, schedule, variant, threads, isa, std::move(sink));
}

} // namespace dermis::cpu
