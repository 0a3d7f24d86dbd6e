// SPDX-License-Identifier: MIT
// The CPU path, in the `real` of the namespace that includes this.

#include "host/cpu/cells.inl"

class March : public plan::Stepper {
  public:
    March(const plan::Plan& plan, int threads, const simd::Isa& isa, Sink sink)
        : plan_(plan), sink_(std::move(sink)), isa_(isa), cells_(plan, threads, isa),
          rest_(plan::padded<real>(plan.maps.rest_curvature, plan, "surface.relief")) {
        const size_t cells = size_t(plan.pitch) * plan.constants.height;
        if (plan.framed) pressure_[0] = pressure_[1] = std::vector<real>(cells);
        else pressure_[0] = plan::padded<real>(plan.maps.pressure, plan, "load.intensity");
        const plan::Pressed& box = plan.pressed;
        for (int q = 0; q < REDUCED_MAPS; ++q) {
            if (!plan.wanted[q]) continue;
            tiles_[q].assign(size_t(plan.constants.height) * plan.tiles, Summary{});
            if (q == 0 || !plan.keeps_maps) continue;
            response_[q - 1] = Plane(cells, 11 + q);
            for (int y = box.first_row; y < box.last_row; ++y) // to be written before it is read
                std::fill(response_[q - 1].row(y, plan.pitch) + first_column(),
                          response_[q - 1].row(y, plan.pitch) + last_column(), std::numeric_limits<real>::quiet_NaN());
        }
    }

    void frame(const std::vector<double>& pressure) override {
        std::swap(pressure_[0], pressure_[1]);
        pressure_[1] = plan::padded<real>(pressure, plan_, "load.intensity");
    }

    void press(const plan::Step& step) override {
        const DefaultFloats guard;
        const bool sampled = step.trace >= 0 || step.impulse >= 0;
        const bool again = step.keep && step.jump == 0 && step.rows == last_.rows && step.start == last_.start &&
                           step.rise == last_.rise && step.frame == last_.frame;
        if (steady_ && again) { // pressed once more, everything stays as it is
            ++left_out_;
            if (sampled) hand_over(step);
            return;
        }
        const Constants c = plan::constants_of<Constants>(plan_, step);
        if (!plan_.material.empty() && step.rows != rows_) {
            rows_ = step.rows;
            table_.clear();
            for (const f64::Coefficients& k : *rows_) table_.push_back(plan::rounded<Coefficients>(k));
        }
        Cells::Outputs handed{};
        for (int q = 0; q < REDUCED_MAPS; ++q) {
            if (sampled && plan_.wanted[q]) handed.tiles[q] = tiles_[q].data();
            if (q > 0) handed.response[q - 1] = response_[q - 1].data();
        }
        const int changed =
            cells_.press(c, table_.data(), pressure_[0].data(), plan_.framed ? pressure_[1].data() : nullptr, rest_.data(),
                     step.keep, handed);
        if (sampled) hand_over(step);
        const int counts = plan_.wanted[int(Quantity::sa2)] ? 3 : 1;
        steady_ = step.keep && sampled && step.jump == 0 && (changed & counts) == 0;
        last_ = step;
    }

    void finish() override {}
    long long left_out() const override { return left_out_; }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        const DefaultFloats guard;
        const Constants c = plan::constants_of<Constants>(plan_, {});
        maps.resize(what.size());
        std::vector<real> derived(size_t(c.width));
        for (size_t i = 0; i < what.size(); ++i) {
            maps[i].clear();
            for (int y = 0; y < c.height; ++y) {
                const real* values = derived.data();
                if (what[i] < Quantity::curvature) values = plane(int(what[i])) + row(y);
                else derive(what[i], y, c, derived.data());
                maps[i].insert(maps[i].end(), values, values + c.width);
            }
        }
    }

  private:
    size_t row(int y) const { return size_t(y) * plan_.pitch; }
    int first_column() const { return plan_.pressed.first_tile * TILE_CELLS; }
    int last_column() const { return std::min(plan_.pressed.last_tile * TILE_CELLS, plan_.constants.width); }

    const real* plane(int quantity) const { return quantity == 0 ? cells_.strain() : response_[quantity - 1].data(); }

    void hand_over(const plan::Step& step) {
        const size_t cells = plan_.maps.pressure.size();
        plan::Sample sample{};
        for (int q = 0; q < REDUCED_MAPS; ++q) {
            if (plan_.wanted[q]) sample.totals[q] = plan::total_of(tiles_[q].data(), tiles_[q].size(), cells);
            for (const Cell& p : plan_.places)
                sample.probes.push_back(plan_.wanted[q] ? double(plane(q)[row(p.y) + p.x]) : 0);
        }
        sink_(step, sample);
    }

    void derive(Quantity q, int y, const Constants& c, real* out) const {
        const real* eps = cells_.strain();
        if (q == Quantity::deformation) {
            const double* surface = plan_.maps.surface.data() + size_t(y) * c.width;
            for (int x = 0; x < c.width; ++x)
                out[x] = flush(deformation_of(real(surface[x]), eps[row(y) + x], c.thickness));
            return;
        }
        isa_.of<real>().laplacian(
            simd::lines<real>(y, c.width, c.height, plan_.stencil, plan_.edges, [&](int i) { return eps + row(i); }),
            0, c.width, out);
        for (int x = 0; x < c.width; ++x) out[x] = flush(curvature_of(rest_[row(y) + x], out[x], c.bend));
    }

    const plan::Plan& plan_;
    Sink sink_;
    const simd::Isa& isa_;
    Cells cells_;
    std::vector<real> pressure_[2]; // framed: from and to
    std::vector<real> rest_;
    Plane response_[4];
    std::shared_ptr<const std::vector<f64::Coefficients>> rows_; // what table_ was made from
    std::vector<Coefficients> table_;
    std::vector<Summary> tiles_[REDUCED_MAPS];
    plan::Step last_;     // the last one that was pressed
    bool steady_ = false; // it changed nothing that is asked for
    long long left_out_ = 0;
};
