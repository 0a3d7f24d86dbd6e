// SPDX-License-Identifier: MIT
// The march of a skin whose receptors lie at depths: a backend marches the signals of the surface. At the end of a step
// that is sampled or read they are spread on the host, and answer.
#include "host/core/cpu/spreading.hpp"
#include "host/lab/march/march.hpp"

namespace dermis::model {
namespace {

template <class K> class DeepMarch : public March {
  public:
    using real = typename K::real;

    DeepMarch(Backend& backend, const MarchPlan& plan, const HalfSpaces& spaces)
        : points_(plan.points), surface_(signals_of(plan.skin)), signals_(march(backend, {.skin = surface_,
                                                                                          .variant = plan.variant,
                                                                                          .precision = plan.precision,
                                                                                          .pressed = plan.pressed,
                                                                                          .pressure = plan.pressure,
                                                                                          .points = plan.points,
                                                                                          .keeps_maps = true})),
          spreading_(plan.skin, classes_of(plan, spaces), pitch(), 1, true, backend.threads(), simd::best()),
          rest_(pitch()), tiles_(size_t(surface_.height()) * size_t(surface_.tiles)) {
        for (const auto& c : spreading_.classes()) {
            read_.push_back(Quantity(c.quantity));
            to_.push_back(maps_.emplace_back(surface_.padded_cells()).data());
        }
        read_.push_back(Quantity::strain);
    }

    void frame(const std::vector<double>& pressure) override { signals_->frame(pressure); }

    bool press(const Step& step, Sample* sample) override {
        spread_ = false;
        const bool none_waits = signals_->press(step, sample);
        if (!sample) return none_waits;
        spread(); // the sample then has strains and signals
        for (size_t i = 0; i < to_.size(); ++i) take(size_t(read_[i]), to_[i], *sample);
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

    size_t pitch() const { return size_t(surface_.pitch); }

    // Spreads the signals at the end of the last step, unless they are.
    void spread() {
        if (std::exchange(spread_, true)) return;
        std::vector<const real*> from;
        for (const void* map : signals_->maps(read_)) from.push_back(static_cast<const real*>(map));
        strain_ = from.back();
        spreading_.spread({}, from.data(), to_.data(), strain_);
    }

    // Takes total and points of a response. The total is that of the loop which answers rows: where the skin is flat
    // and nothing gains, this leaves responses as they are.
    void take(size_t q, const real* map, Sample& sample) {
        simd::RespondArguments<K> r{};
        r.last = surface_.width();
        r.strain = simd::neighbours<real>(0, r.last, surface_.height(), surface_.stencil, surface_.edges,
                                          [this](int) { return rest_.data(); });
        r.rest_curvature = rest_.data();
        std::ranges::fill(r.signal, rest_.data());
        for (size_t y = 0; y < size_t(surface_.height()); ++y) {
            r.signal[q - QUANTITY_SA1] = map + y * pitch();
            r.tiles[q] = tiles_.data() + y * size_t(surface_.tiles);
            simd::best().of<K>().respond(r, constants_of<K>(surface_, surface_.whole()));
        }
        sample.totals[q] = total_of<K>(tiles_.data(), tiles_.size(), surface_.cells());
        for (size_t i = 0; i < points_.size(); ++i)
            sample.points[q * points_.size() + i] = double(map[size_t(points_[i].y) * pitch() + size_t(points_[i].x)]);
    }

    const std::vector<Cell>& points_;
    const PreparedSkin surface_; // of the signals
    std::unique_ptr<March> signals_;
    cpu::Spreading<K> spreading_;
    const std::vector<real> rest_;           // a row of a flat skin at rest
    std::vector<typename K::Summary> tiles_; // of one response
    std::vector<Quantity> read_;             // each class, then the strain
    std::vector<std::vector<real>> maps_;    // responses of each class, rows a pitch apart
    std::vector<real*> to_;                  // where they begin
    const real* strain_ = nullptr;           // after spread(), until the next step
    bool spread_ = false;                    // the maps are those of the last step
};

} // namespace

std::unique_ptr<March> deep_march(Backend& backend, const MarchPlan& plan, const HalfSpaces& spaces) {
    if (plan.precision == Precision::f64) return std::make_unique<DeepMarch<f64>>(backend, plan, spaces);
    return std::make_unique<DeepMarch<f32>>(backend, plan, spaces);
}

} // namespace dermis::model
