// SPDX-License-Identifier: MIT
#include "host/cpu/stepper.hpp"

#include "host/cpu/cells.hpp"
#include "host/plan/float_environment.hpp"

namespace dermis::cpu {
namespace {

template <class K> class March : public plan::Stepper {
  public:
    using real = typename K::real;

    March(const plan::PreparedSkin& skin, const plan::Schedule& schedule, const plan::Variant& variant, int threads,
          const simd::Isa& isa, Sink sink)
        : skin_(skin), schedule_(schedule), sink_(std::move(sink)), isa_(isa),
          cells_(skin, variant, schedule.pressed, threads, isa), rest_(plan::padded_rest_curvature<real>(skin)) {
        if (schedule.framed) pressure_[0] = pressure_[1] = std::vector<real>(skin.padded_cells());
        else pressure_[0] = plan::padded<real>(schedule.pressure, skin, "load.intensity");
        for (int q = 0; q < REDUCED_MAPS; ++q) {
            if (!schedule.wanted[size_t(q)]) continue;
            tiles_[size_t(q)].assign(size_t(skin.height()) * size_t(skin.tiles), typename K::Summary{});
            if (q != QUANTITY_STRAIN && schedule.keeps_maps) make_response(q);
        }
    }

    void frame(const std::vector<double>& pressure) override {
        std::swap(pressure_[0], pressure_[1]);
        pressure_[1] = plan::padded<real>(pressure, skin_, "load.intensity");
    }

    void press(const plan::Step& step) override {
        const DefaultFloats guard;
        const bool sampled = step.trace >= 0 || step.impulse >= 0;
        if (steady_ && repeats(step)) { // pressed once more, everything stays as it is
            ++left_out_;
            if (sampled) hand_over(step);
            return;
        }
        if (!skin_.uniform() && step.coefficients != table_of_) {
            table_of_ = step.coefficients;
            table_.clear();
            for (const f64::Coefficients& k : *table_of_) table_.push_back(plan::rounded<K>(k));
        }
        const auto constants = plan::constants_of<K>(skin_, schedule_.pressed, step);
        typename Cells<K>::Press p{.constants = constants,
                                   .table = table_.data(),
                                   .pressure = pressure_[0].data(),
                                   .pressure_to = schedule_.framed ? pressure_[1].data() : nullptr,
                                   .rest_curvature = rest_.data(),
                                   .keep = step.keep};
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            if (sampled && schedule_.wanted[q]) p.tiles[q] = tiles_[q].data();
            if (q != QUANTITY_STRAIN) p.response[q - QUANTITY_SA1] = response(q).data();
        }
        const int changed = cells_.press(p);
        if (sampled) hand_over(step);
        const int counts = simd::strain_changed | (schedule_.wanted[QUANTITY_SA2] ? simd::integral_changed : 0);
        steady_ = step.keep && sampled && step.jump == 0 && (changed & counts) == 0;
        last_ = step;
    }

    void finish() override {}
    long long left_out() const override { return left_out_; }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
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
            const DefaultFloats guard;
            std::vector<const float*> maps;
            for (Quantity q : what) maps.push_back(q < Quantity::curvature ? plane(size_t(q)) : derived_map(q));
            return maps;
        }
    }

  private:
    size_t row(int y) const { return size_t(y) * size_t(skin_.pitch); }
    Plane<real>& response(size_t q) { return response_[q - QUANTITY_SA1]; }
    const real* plane(size_t q) { return q == QUANTITY_STRAIN ? cells_.strain() : response(q).data(); }

    // Cells that are pressed begin as NaN: to be written before they are read.
    void make_response(int q) {
        Plane<real>& map = response(size_t(q));
        map = Plane<real>(skin_.padded_cells(), response_place + q - QUANTITY_SA1);
        const plan::PressedBox& box = schedule_.pressed;
        for (int y = box.first_row; y < box.last_row; ++y)
            std::fill(map.row(y, skin_.pitch) + box.first_column(),
                      map.row(y, skin_.pitch) + box.last_column(skin_.width()), std::numeric_limits<real>::quiet_NaN());
    }

    bool repeats(const plan::Step& step) const {
        return step.keep && step.jump == 0 && step.coefficients == last_.coefficients && step.start == last_.start &&
               step.rise == last_.rise && step.frame == last_.frame;
    }

    void hand_over(const plan::Step& step) {
        plan::Sample sample{};
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            const bool wanted = schedule_.wanted[q];
            if (wanted) sample.totals[q] = plan::total_of(tiles_[q].data(), tiles_[q].size(), skin_.cells());
            for (const Cell& p : schedule_.points)
                sample.points.push_back(wanted ? double(plane(q)[row(p.y) + size_t(p.x)]) : 0);
        }
        sink_(step, sample);
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
    Cells<K> cells_;
    std::vector<real> pressure_[2]; // with frames: from and to
    std::vector<real> rest_;        // L(S)
    std::array<Plane<real>, RESPONSE_MAPS> response_;
    std::array<std::vector<real>, 2> derived_; // deformation and curvature, where they are viewed
    plan::SharedCoefficients table_of_;        // what table_ was made from
    std::vector<typename K::Coefficients> table_;
    std::array<std::vector<typename K::Summary>, REDUCED_MAPS> tiles_;
    plan::Step last_;     // the last one that was pressed
    bool steady_ = false; // it changed nothing that is asked for
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
