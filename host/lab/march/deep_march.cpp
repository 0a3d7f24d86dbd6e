// SPDX-License-Identifier: MIT
#include "host/lab/march/deep_march.hpp"

#include "host/core/cpu/spreading.hpp"

namespace dermis::model {
namespace {

template <class K> class DeepMarch : public March {
  public:
    using real = typename K::real;

    DeepMarch(Backend& backend, const MarchPlan& plan, const HalfSpaces& half_space)
        : points_(plan.points), surface_(signals_of(plan.skin)), signals_(backend.march({.skin = surface_,
                                                                                         .variant = plan.variant,
                                                                                         .precision = plan.precision,
                                                                                         .pressed = plan.pressed,
                                                                                         .pressure = plan.pressure,
                                                                                         .points = plan.points,
                                                                                         .keeps_maps = true})),
          spreading_(plan.skin, classes_of(plan, half_space), size_t(surface_.pitch), 1, true, backend.threads(),
                     simd::best()),
          rest_(size_t(surface_.pitch)) {
        for (const auto& c : spreading_.classes()) {
            read_.push_back(Quantity(c.quantity));
            to_.push_back(maps_.emplace_back(surface_.padded_cells()).data());
            tiles_.emplace_back(size_t(surface_.height()) * size_t(surface_.tiles));
        }
        read_.push_back(Quantity::strain);
    }

    void frame(const std::vector<double>& pressure) override { signals_->frame(pressure); }

    bool press(const MarchStep& step) override {
        spread_ = false;
        const bool none_waits = signals_->press(step);
        if (!step.sample) return none_waits;
        spread(); // the sample then has strains and signals
        take_totals(*step.sample);
        for (size_t i = 0; i < to_.size(); ++i)
            for (size_t p = 0; p < points_.size(); ++p)
                step.sample->points[size_t(read_[i]) * points_.size() + p] = double(to_[i][number_of(points_[p])]);
        return true;
    }

    int settle() override { return signals_->settle(); }

    std::vector<const void*> maps(const std::vector<Quantity>& what) override {
        spread();
        std::vector<const void*> maps;
        for (Quantity q : what)
            maps.push_back(q == Quantity::strain ? strain_ : to_[size_t(std::ranges::find(read_, q) - read_.begin())]);
        return maps;
    }

    long long dispatches() const override { return signals_->dispatches(); }

  private:
    static std::vector<typename cpu::Spreading<K>::Class> classes_of(const MarchPlan& plan, const HalfSpaces& spaces) {
        std::vector<typename cpu::Spreading<K>::Class> classes;
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
            if (plan.variant.wanted[size_t(q)])
                classes.push_back({q, spaces[size_t(q)] ? spaces[size_t(q)]->spread() : nullptr});
        return classes;
    }

    size_t number_of(Cell c) const { return size_t(c.y) * size_t(surface_.pitch) + size_t(c.x); }

    // Spreads the signals at the end of the last step, unless they are.
    void spread() {
        if (std::exchange(spread_, true)) return;
        const std::vector<const void*> views = signals_->maps(read_);
        std::vector<const real*> from;
        for (const void* view : views) from.push_back(static_cast<const real*>(view));
        strain_ = from.back();
        spreading_.spread({}, from.data(), to_.data(), from.back());
    }

    // By the loop that answers rows: where the skin is flat and nothing gains, it leaves responses as they are.
    void take_totals(Sample& sample) {
        const simd::Loops<K>& loops = simd::best().of<K>();
        const auto constants = constants_of<K>(surface_, surface_.whole());
        simd::RespondArguments<K> r{};
        r.last = surface_.width();
        r.strain = simd::neighbours<real>(0, r.last, surface_.height(), surface_.stencil, surface_.edges,
                                          [this](int) { return rest_.data(); });
        r.rest_curvature = rest_.data();
        std::ranges::fill(r.signal, rest_.data());
        for (int y = 0; y < surface_.height(); ++y) {
            for (size_t i = 0; i < to_.size(); ++i) {
                r.signal[size_t(read_[i]) - QUANTITY_SA1] = to_[i] + number_of({0, y});
                r.tiles[size_t(read_[i])] = tiles_[i].data() + size_t(y) * size_t(surface_.tiles);
            }
            loops.respond(r, constants);
        }
        for (size_t i = 0; i < to_.size(); ++i)
            sample.totals[size_t(read_[i])] = total_of<K>(tiles_[i].data(), tiles_[i].size(), surface_.cells());
    }

    const std::vector<Cell>& points_;
    const PreparedSkin surface_; // of the signals
    std::unique_ptr<March> signals_;
    cpu::Spreading<K> spreading_;
    const std::vector<real> rest_;                        // a row of a flat skin at rest
    std::vector<Quantity> read_;                          // each class, then the strain
    std::vector<std::vector<real>> maps_;                 // responses of each class, rows a pitch apart
    std::vector<real*> to_;                               // where they begin
    std::vector<std::vector<typename K::Summary>> tiles_; // of each class
    const real* strain_ = nullptr;                        // after spread(), until the next step
    bool spread_ = false;                                 // the maps are those of the last step
};

} // namespace

std::unique_ptr<March> deep_march(Backend& backend, const MarchPlan& plan, const HalfSpaces& half_space) {
    if (plan.precision == Precision::f64) return std::make_unique<DeepMarch<f64>>(backend, plan, half_space);
    return std::make_unique<DeepMarch<f32>>(backend, plan, half_space);
}

} // namespace dermis::model
