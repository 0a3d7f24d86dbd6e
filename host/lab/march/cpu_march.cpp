// SPDX-License-Identifier: MIT
// The march of a run on the CPU path, in K = f32 or f64.
#include "host/core/base/float_environment.hpp"
#include "host/core/cpu/cells.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/lab/march/march.hpp"

namespace dermis::cpu {
namespace {

template <class K> class BandMarch : public model::March {
  public:
    using real = typename K::real;

    BandMarch(const model::MarchPlan& plan, int threads, const simd::Isa& isa)
        : plan_(plan), skin_(plan.skin), isa_(isa), constants_(model::constants_of<K>(skin_, plan.pressed)),
          cells_(skin_, plan.variant, plan.pressed, threads, isa, plan.points),
          rest_(model::padded_rest_curvature<real>(skin_)) {
        if (plan.variant.framed) pressure(0) = pressure(1) = std::vector<real>(skin_.padded_cells());
        else pressure(0) = model::padded<real>(plan.pressure, skin_, "load.intensity");
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
            if (plan.variant.wanted[size_t(q)] && plan.keeps_maps) make_response(q);
        batch_.reserve(slots_.size());
    }

    void frame(const std::vector<double>& map) override {
        ++to_;
        if (waiting_ > 0 && slots_[0].from + frames_kept <= to_) settle(); // the frame's memory is used again
        pressure(to_) = model::padded<real>(map, skin_, "load.intensity", std::move(pressure(to_)));
    }

    bool press(const model::Step& step, model::Sample* sample) override {
        slots_[waiting_].from = to_ - 1;
        slots_[waiting_].sample = sample;
        slots_[waiting_++].step = &step;
        if (waiting_ < slots_.size()) return false;
        settle();
        return true;
    }

    int settle() override {
        const size_t count = std::exchange(waiting_, 0);
        if (count == 0) return changed_;
        const DefaultFloats guard;
        const auto each_slot = [&](auto f) {
            cells_.pool().share(int(count), [&](int first, int last) {
                for (int i = first; i < last; ++i) f(slots_[size_t(i)]);
            });
        };
        each_slot([this](Slot& slot) { make_coefficients(slot); });
        batch_.clear(); // a call that ran out of memory has left some
        for (size_t i = 0; i < count; ++i) batch_.push_back(prepared(slots_[i], i + 1 == count));
        std::array<int, model::steps_of_batch> changed;
        cells_.press(batch_, changed);
        each_slot([this](Slot& slot) { total(slot); });
        return changed_ = changed[count - 1];
    }

    std::vector<const void*> maps(const std::vector<Quantity>& what) override {
        settle();
        std::vector<const void*> maps;
        for (Quantity q : what) maps.push_back(q == Quantity::strain ? cells_.strain() : response(size_t(q)).data());
        return maps;
    }

  private:
    // A step of a batch, with its coefficients.
    struct Slot {
        const model::Step* step;
        model::Sample* sample;
        size_t from; // the frame that the pressure runs from
        typename K::Constants constants;
        std::vector<typename K::Coefficients> table;                  // of the materials
        model::Step table_of;                                         // what it was made for
        std::function<void(int, typename K::Coefficients*)> fill_row; // where there is no table
        std::array<std::vector<typename K::Summary>, REDUCED_MAPS> tiles;
    };

    void make_coefficients(Slot& slot) const {
        if (skin_.differs_everywhere()) {
            slot.fill_row = [this, &slot](int y, typename K::Coefficients* of_row) {
                model::fill_row<K>(*slot.step, skin_.materials, skin_.chain, skin_.rule,
                                   skin_.material_of.data() + row(y), skin_.width(), of_row);
            };
        } else if (!slot.step->same_coefficients(slot.table_of)) {
            slot.table_of = *slot.step;
            model::fill_table<K>(*slot.step, skin_.materials, skin_.chain, skin_.rule, slot.table);
        }
    }

    CellsPress<K> prepared(Slot& slot, bool last) {
        const model::Step& step = *slot.step;
        slot.constants = model::constants_of<K>(constants_, skin_.tabled() ? nullptr : slot.table.data(), step);
        CellsPress<K> p{.constants = slot.constants,
                        .table = slot.table.data(),
                        .fill_row = skin_.differs_everywhere() ? &slot.fill_row : nullptr,
                        .pressure = pressure(slot.from).data(),
                        .pressure_to = plan_.variant.framed ? pressure(slot.from + 1).data() : nullptr,
                        .rest_curvature = rest_.data(),
                        .keep = step.keep,
                        .response_pitch = size_t(skin_.pitch)};
        for (size_t i = 0; last && i < RESPONSE_MAPS; ++i) p.response[i] = response_[i].data();
        if (!slot.sample) return p;
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            if (!plan_.variant.wanted[q]) continue;
            slot.tiles[q].resize(size_t(skin_.height()) * size_t(skin_.tiles));
            p.tiles[q] = slot.tiles[q].data();
        }
        slot.sample->points.assign(REDUCED_MAPS * plan_.points.size(), 0);
        p.points = slot.sample->points.data();
        return p;
    }

    void total(Slot& slot) const {
        for (size_t q = 0; slot.sample && q < REDUCED_MAPS; ++q)
            if (plan_.variant.wanted[q])
                slot.sample->totals[q] =
                    model::total_of<K>(slot.tiles[q].data(), slot.tiles[q].size(), skin_.cells(), isa_);
    }

    std::vector<real>& pressure(size_t frame) { return pressure_[frame % frames_kept]; }
    size_t row(int y) const { return size_t(y) * size_t(skin_.pitch); }
    Plane<real>& response(size_t q) { return response_[q - QUANTITY_SA1]; }

    // Cells that are pressed begin as NaN, so that one which is read before it is written shows.
    void make_response(int q) {
        Plane<real>& map = response(size_t(q));
        map = Plane<real>(skin_.padded_cells(), response_place(skin_.chain) + q - QUANTITY_SA1);
        const model::PressedBox& box = plan_.pressed;
        for (int y = box.first_row; y < box.last_row; ++y)
            std::fill(map.row(y, skin_.pitch) + box.first_column(),
                      map.row(y, skin_.pitch) + box.last_column(skin_.width()), std::numeric_limits<real>::quiet_NaN());
    }

    static constexpr size_t frames_kept = model::steps_of_batch + 1;
    const model::MarchPlan plan_;
    const model::PreparedSkin& skin_;
    const simd::Isa& isa_;
    const typename K::Constants constants_; // of every step
    Cells<K> cells_;
    std::array<std::vector<real>, frames_kept> pressure_; // of the last frames; without frames the first alone
    size_t to_ = 1;                                       // the frame given last; frames 0 and 1 are the skin at rest
    std::vector<real> rest_;                              // L(S)
    std::array<Plane<real>, RESPONSE_MAPS> response_;
    std::array<Slot, model::steps_of_batch> slots_; // of steps that wait, in order
    std::vector<CellsPress<K>> batch_;
    size_t waiting_ = 0; // steps that wait to be taken in one batch
    int changed_ = ~0;   // the bits of the last step
};

} // namespace

std::unique_ptr<model::March> march(const model::MarchPlan& plan, int threads, const simd::Isa& isa) {
    const DefaultFloats guard; // threads inherit it
    threads = simd::useful_threads(plan.skin.cells(), threads);
    if (plan.precision == Precision::f64) return std::make_unique<BandMarch<f64>>(plan, threads, isa);
    return std::make_unique<BandMarch<f32>>(plan, threads, isa);
}

} // namespace dermis::cpu
