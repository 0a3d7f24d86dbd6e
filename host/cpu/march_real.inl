// SPDX-License-Identifier: MIT
// The CPU path, in the `real` of the namespace that includes this. Two passes a step: state, then responses.

#include "host/plan/laplacian.inl"

class March : public plan::Marcher {
  public:
    March(const plan::Plan& plan, int threads, Sink sink)
        : plan_(plan), sink_(std::move(sink)), pool_(threads),
          pressure_{plan.framed ? std::vector<real>(size_t(plan.pitch) * plan.constants.height)
                                : plan::padded<real>(plan.maps.pressure, plan, "load.intensity")},
          rest_(plan::padded<real>(plan.maps.rest_curvature, plan, "surface.relief")),
          surface_(plan::padded<real>(plan.maps.surface, plan, "surface.relief")),
          tiles_(size_t(REDUCED_MAPS) * plan.constants.height * plan.tiles) {
        const size_t cells = pressure_[0].size();
        if (plan.framed) pressure_[1].assign(cells, real(0));
        for (auto& state : {&strain_[0], &strain_[1], &sum_[0], &sum_[1]}) state->assign(cells, real(0));
        if (plan.compensated)
            for (auto& lost : {&strain_lost_[0], &strain_lost_[1], &sum_lost_[0], &sum_lost_[1]})
                lost->assign(cells, real(0));
        const plan::Pressed& box = plan.pressed;
        for (auto& r : response_) {
            r.assign(cells, real(0));
            for (int y = box.first_row; y < box.last_row; ++y) // to be written before it is read
                std::fill(r.begin() + row(y) + first_column(), r.begin() + row(y) + last_column(),
                          std::numeric_limits<real>::quiet_NaN());
        }
    }

    void frame(const std::vector<double>& pressure) override {
        std::swap(pressure_[0], pressure_[1]);
        pressure_[1] = plan::padded<real>(pressure, plan_, "load.intensity");
    }

    void press(const plan::Step& step) override {
        const DefaultFloats guard;
        const Constants c = plan::constants_of<Constants>(plan_, step);
        if (!plan_.material.empty() && step.rows != rows_) {
            rows_ = step.rows;
            table_.clear();
            for (const f64::Row& k : *rows_) table_.push_back(plan::rounded<Row>(k));
        }
        const plan::Pressed& box = plan_.pressed;
        const int rows = box.last_row - box.first_row;
        pool_.rows(rows, [&](int first, int last) {
            for (int y = first; y < last; ++y) advance(box.first_row + y, c);
        });
        shown_ = 1 - from_;
        if (c.respond) {
            pool_.rows(rows, [&](int first, int last) {
                for (int y = box.first_row + first; y < box.first_row + last; ++y)
                    for (int t = box.first_tile; t < box.last_tile; ++t) {
                        const int x = t * TILE_CELLS, count = std::min(TILE_CELLS, c.width - x);
                        respond(y, x, x + count, c);
                        for (int q = 0; q < REDUCED_MAPS; ++q)
                            tiles_[(size_t(q) * c.height + y) * plan_.tiles + t] =
                                summarize(plane(q) + row(y) + x, count);
                    }
            });
            hand_over(step);
        }
        if (step.keep) from_ = shown_;
    }

    void finish() override {}

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        const DefaultFloats guard;
        const Constants c = plan::constants_of<Constants>(plan_, {});
        maps.resize(what.size());
        for (size_t i = 0; i < what.size(); ++i) {
            maps[i].clear();
            for (int y = 0; y < c.height; ++y)
                if (what[i] < Quantity::curvature)
                    maps[i].insert(maps[i].end(), plane(int(what[i])) + row(y), plane(int(what[i])) + row(y) + c.width);
                else
                    for (int x = 0; x < c.width; ++x) maps[i].push_back(double(derived(what[i], x, y, c)));
        }
    }

  private:
    size_t row(int y) const { return size_t(y) * plan_.pitch; }
    int first_column() const { return plan_.pressed.first_tile * TILE_CELLS; }
    int last_column() const { return std::min(plan_.pressed.last_tile * TILE_CELLS, plan_.constants.width); }

    // Cells of a row from `at` on: what their load and rows are made of.
    struct Cells {
        const real *p, *q;
        const int* material;
        const Row* table;
    };
    Cells cells(size_t at) const {
        return {pressure_[0].data() + at, plan_.framed ? pressure_[1].data() + at : nullptr,
                plan_.material.empty() ? nullptr : plan_.material.data() + at, table_.data()};
    }

    // Calls body(framed, materials, compensated), constants known to the compiler.
    template <class Body> void in_variant(Body&& body) const {
        const auto with = [&](auto framed, auto materials) {
            plan_.compensated ? body(framed, materials, std::true_type()) : body(framed, materials, std::false_type());
        };
        const auto under = [&](auto framed) {
            plan_.material.empty() ? with(framed, std::false_type()) : with(framed, std::true_type());
        };
        plan_.framed ? under(std::true_type()) : under(std::false_type());
    }

    void advance(int y, const Constants& c) {
        const size_t at = row(y) + first_column();
        const int to = 1 - from_, count = last_column() - first_column();
        in_variant([&](auto framed, auto materials, auto compensated) {
            const auto lost = [&](std::vector<real>& map) { return compensated ? map.data() + at : nullptr; };
            const Cells k = cells(at);
            advance_cells<framed, materials, compensated>(
                count, c, k.p, k.q, k.material, k.table, strain_[from_].data() + at, sum_[from_].data() + at,
                lost(strain_lost_[from_]), lost(sum_lost_[from_]), strain_[to].data() + at, sum_[to].data() + at,
                lost(strain_lost_[to]), lost(sum_lost_[to]));
        });
    }

    // Apart, so that the compiler believes that nothing overlaps; so is respond_cells.
    template <bool framed, bool materials, bool compensated>
    static void advance_cells(int count, const Constants c, const real* __restrict p, const real* __restrict q,
                              const int* __restrict material, const Row* __restrict table, const real* __restrict eps,
                              const real* __restrict sum, const real* __restrict eps_lost,
                              const real* __restrict sum_lost, real* __restrict eps_to, real* __restrict sum_to,
                              real* __restrict eps_lost_to, real* __restrict sum_lost_to) {
        const Rows uniform = rows_of(c.row);
        for (int i = 0; i < count; ++i) {
            const Load load = framed ? load_between(p[i], q[i], c) : load_of(p[i], c);
            const Rows k = materials ? rows_of(table[material[i]]) : uniform;
            const real step = strain_step(eps[i], load, k), gained = sum_step(eps[i], sum[i], load, k);
            if constexpr (compensated) {
                const Compensated strain = added_compensated(eps[i], eps_lost[i], step);
                const Compensated integral = added_compensated(sum[i], sum_lost[i], gained);
                eps_to[i] = strain.value;
                eps_lost_to[i] = strain.lost;
                sum_to[i] = integral.value;
                sum_lost_to[i] = integral.lost;
            } else {
                eps_to[i] = added(eps[i], step);
                sum_to[i] = added(sum[i], gained);
            }
        }
    }

    Stored strain() const {
        const f64::Constants& k = plan_.constants;
        return {strain_[shown_].data(), k.pitch, k.width, k.height, plan_.stencil, plan_.edges};
    }

    void respond(int y, int first, int last, const Constants& c) {
        const size_t at = row(y) + first;
        real L[TILE_CELLS];
        strain().laplacian(y, first, last, L);
        const Cells k = cells(at);
        in_variant([&](auto framed, auto materials, auto) {
            respond_cells<framed, materials>(last - first, c, k.p, k.q, k.material, k.table, rest_.data() + at, L,
                                             strain_[from_].data() + at, strain_[shown_].data() + at,
                                             sum_[shown_].data() + at, response_[0].data() + at,
                                             response_[1].data() + at, response_[2].data() + at,
                                             response_[3].data() + at);
        });
    }

    template <bool framed, bool materials>
    static void respond_cells(int count, const Constants c, const real* __restrict p, const real* __restrict q,
                              const int* __restrict material, const Row* __restrict table, const real* __restrict rest,
                              const real* __restrict L, const real* __restrict eps, const real* __restrict after,
                              const real* __restrict sum, real* __restrict sa1, real* __restrict sa2,
                              real* __restrict fa1, real* __restrict fa2) {
        const real l = c.curvature_length;
        const Rows uniform = rows_of(c.row);
        for (int i = 0; i < count; ++i) {
            const Load load = framed ? load_between(p[i], q[i], c) : load_of(p[i], c);
            const Rows k = materials ? rows_of(table[material[i]]) : uniform;
            const real C = curvature_of(rest[i], L[i], c.bend);
            sa1[i] = response(after[i], C, l);
            sa2[i] = response(sum[i], C, l);
            fa1[i] = response(rate_after(eps[i], load, k), C, l);
            fa2[i] = rectified(response(acceleration_after(eps[i], load, k), C, l), c.gain_plus, c.gain_minus);
        }
    }

    const real* plane(int quantity) const {
        return quantity == 0 ? strain_[shown_].data() : response_[quantity - 1].data();
    }

    // See kernels/reduce.h. Sum, least and greatest apart and lengths known, for the compiler's vectors.
    template <int reach> static void fold(real* __restrict sum, real* __restrict low, real* __restrict high) {
        for (int i = 0; i < reach; ++i) {
            const Summary joined = join({sum[i], low[i], high[i]}, {sum[i + reach], low[i + reach], high[i + reach]});
            sum[i] = joined.sum;
            low[i] = joined.low;
            high[i] = joined.high;
        }
        if constexpr (reach > 1) fold<reach / 2>(sum, low, high);
    }

    static Summary summarize(const real* values, int count) {
        real sum[TILE_CELLS], low[TILE_CELLS], high[TILE_CELLS];
        std::copy_n(values, count, sum);
        std::fill(sum + count, sum + TILE_CELLS, real(0));
        std::copy_n(values, count, low);
        std::fill(low + count, low + TILE_CELLS, values[0]);
        std::copy_n(low, TILE_CELLS, high);
        fold<TILE_CELLS / 2>(sum, low, high);
        return {sum[0], low[0], high[0]};
    }

    void hand_over(const plan::Step& step) {
        if (step.trace < 0 && step.impulse < 0) return;
        const size_t cells = plan_.maps.pressure.size(), tiles = size_t(plan_.constants.height) * plan_.tiles;
        plan::Sample sample;
        for (int q = 0; q < REDUCED_MAPS; ++q) {
            sample.totals[q] = plan::total_of(tiles_.data() + q * tiles, tiles, cells);
            for (const Cell& p : plan_.places) sample.probes.push_back(double(plane(q)[row(p.y) + p.x]));
        }
        sink_(step, sample);
    }

    real derived(Quantity q, int x, int y, const Constants& c) const {
        const size_t i = row(y) + x;
        if (q == Quantity::curvature) return flush(curvature_of(rest_[i], strain().laplacian_at(x, y), c.bend));
        return flush(deformation_of(surface_[i], strain_[shown_][i], c.thickness));
    }

    const plan::Plan& plan_;
    Sink sink_;
    Pool pool_;
    std::vector<real> pressure_[2]; // framed: from and to
    std::vector<real> rest_, surface_, strain_[2], sum_[2], response_[4];
    std::vector<real> strain_lost_[2], sum_lost_[2]; // compensated
    std::shared_ptr<const std::vector<f64::Row>> rows_; // what table_ was made from
    std::vector<Row> table_;
    std::vector<Summary> tiles_;
    int from_ = 0, shown_ = 0; // which state is kept, which one the last press made
};
