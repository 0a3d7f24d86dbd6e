// SPDX-License-Identifier: MIT
// The CPU path, in the `real` of the namespace that includes this. Two passes a step: state, then responses.

struct Stored {
    const real* strain;
    int pitch;
    real strain_at(int x, int y) const { return strain[size_t(y) * pitch + x]; }
#include "kernels/gather.h"
};

class March : public plan::Marcher {
  public:
    March(const plan::Plan& plan, int threads, Sink sink)
        : plan_(plan), sink_(std::move(sink)), pool_(threads),
          pressure_(plan::padded<real>(plan.maps.pressure, plan, "load.intensity")),
          rest_(plan::padded<real>(plan.maps.rest_curvature, plan, "surface.relief")),
          surface_(plan::padded<real>(plan.maps.surface, plan, "surface.relief")),
          tiles_(size_t(REDUCED_MAPS) * plan.constants.height * plan.tiles) {
        const size_t cells = pressure_.size();
        for (auto& state : {&strain_[0], &strain_[1], &sum_[0], &sum_[1]}) state->assign(cells, real(0));
        if (plan.compensated)
            for (auto& lost : {&strain_lost_[0], &strain_lost_[1], &sum_lost_[0], &sum_lost_[1]})
                lost->assign(cells, real(0));
        for (auto& r : response_) r.assign(cells, std::numeric_limits<real>::quiet_NaN()); // to be written, never read
    }

    void press(const plan::Step& step) override {
        const DefaultFloats guard;
        const Constants c = plan::constants_of<Constants>(plan_, step);
        pool_.rows(c.height, [&](int first, int last) {
            for (int y = first; y < last; ++y) advance(y, c);
        });
        shown_ = 1 - from_;
        if (c.respond) {
            pool_.rows(c.height, [&](int first, int last) {
                for (int y = first; y < last; ++y)
                    for (int t = 0; t < plan_.tiles; ++t) {
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

    void advance(int y, const Constants& c) {
        const size_t at = row(y);
        const int to = 1 - from_;
        if (plan_.compensated)
            advance_compensated(c.width, c, pressure_.data() + at, strain_[from_].data() + at, sum_[from_].data() + at,
                                strain_lost_[from_].data() + at, sum_lost_[from_].data() + at, strain_[to].data() + at,
                                sum_[to].data() + at, strain_lost_[to].data() + at, sum_lost_[to].data() + at);
        else
            advance_cells(c.width, c, pressure_.data() + at, strain_[from_].data() + at, sum_[from_].data() + at,
                          strain_[to].data() + at, sum_[to].data() + at);
    }

    // Apart, so that the compiler believes that nothing overlaps; so is respond_cells.
    static void advance_cells(int count, const Constants c, const real* __restrict p, const real* __restrict eps,
                              const real* __restrict sum, real* __restrict eps_to, real* __restrict sum_to) {
        for (int i = 0; i < count; ++i) {
            const Load load = load_of(p[i], c);
            eps_to[i] = added(eps[i], strain_step(eps[i], load, c.row));
            sum_to[i] = added(sum[i], sum_step(eps[i], sum[i], load, c.row));
        }
    }

    static void advance_compensated(int count, const Constants c, const real* __restrict p, const real* __restrict eps,
                                    const real* __restrict sum, const real* __restrict eps_lost,
                                    const real* __restrict sum_lost, real* __restrict eps_to, real* __restrict sum_to,
                                    real* __restrict eps_lost_to, real* __restrict sum_lost_to) {
        for (int i = 0; i < count; ++i) {
            const Load load = load_of(p[i], c);
            const Compensated strain = added_compensated(eps[i], eps_lost[i], strain_step(eps[i], load, c.row));
            const Compensated integral = added_compensated(sum[i], sum_lost[i], sum_step(eps[i], sum[i], load, c.row));
            eps_to[i] = strain.value;
            eps_lost_to[i] = strain.lost;
            sum_to[i] = integral.value;
            sum_lost_to[i] = integral.lost;
        }
    }

    // L(eps) in columns first..last of a row.
    void laplacian(int y, int first, int last, const Constants& c, real* __restrict L) const {
        const auto gather = [&](int x) { L[x - first] = laplacian_at(x, y, c); };
        if (plan_.stencil != STENCIL_FIVE_POINT || c.width < 3) {
            for (int x = first; x < last; ++x) gather(x);
            return;
        }
        const real* after = strain_[shown_].data();
        const real* __restrict here = after + row(y);
        const real* __restrict low = after + row(wrapped(y - 1, c.height, plan_.edges));
        const real* __restrict high = after + row(wrapped(y + 1, c.height, plan_.edges));
        const int begin = std::max(first, 1), end = std::min(last, c.width - 1);
        if (first < begin) gather(first);
        for (int x = begin; x < end; ++x)
            L[x - first] =
                add(second_difference(here[x - 1], here[x], here[x + 1]), second_difference(low[x], here[x], high[x]));
        if (end < last) gather(last - 1);
    }

    void respond(int y, int first, int last, const Constants& c) {
        const size_t at = row(y) + first;
        real L[TILE_CELLS];
        laplacian(y, first, last, c, L);
        respond_cells(last - first, c, pressure_.data() + at, rest_.data() + at, L, strain_[from_].data() + at,
                      strain_[shown_].data() + at, sum_[shown_].data() + at, response_[0].data() + at,
                      response_[1].data() + at, response_[2].data() + at, response_[3].data() + at);
    }

    static void respond_cells(int count, const Constants c, const real* __restrict p, const real* __restrict rest,
                              const real* __restrict L, const real* __restrict eps, const real* __restrict after,
                              const real* __restrict sum, real* __restrict sa1, real* __restrict sa2,
                              real* __restrict fa1, real* __restrict fa2) {
        const real l = c.curvature_length;
        for (int i = 0; i < count; ++i) {
            const Load load = load_of(p[i], c);
            const real C = curvature_of(rest[i], L[i], c.bend);
            sa1[i] = response(after[i], C, l);
            sa2[i] = response(sum[i], C, l);
            fa1[i] = response(rate_after(eps[i], load, c.row), C, l);
            fa2[i] = rectified(response(acceleration_after(eps[i], load, c.row), C, l), c.gain_plus, c.gain_minus);
        }
    }

    real laplacian_at(int x, int y, const Constants& c) const {
        Stored stored{strain_[shown_].data(), plan_.pitch};
        const real centre = stored.strain_at(x, y);
        return add(stored.laplacian_along_x(x, y, centre, c.width, plan_.stencil, plan_.edges),
                   stored.laplacian_along_y(x, y, centre, c.height, plan_.stencil, plan_.edges));
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
            for (const Cell& p : plan_.scene.output.probes) sample.probes.push_back(double(plane(q)[row(p.y) + p.x]));
        }
        sink_(step, sample);
    }

    real derived(Quantity q, int x, int y, const Constants& c) const {
        const size_t i = row(y) + x;
        if (q == Quantity::curvature) return flush(curvature_of(rest_[i], laplacian_at(x, y, c), c.bend));
        return flush(deformation_of(surface_[i], strain_[shown_][i], c.thickness));
    }

    const plan::Plan& plan_;
    Sink sink_;
    Pool pool_;
    std::vector<real> pressure_, rest_, surface_, strain_[2], sum_[2], response_[4];
    std::vector<real> strain_lost_[2], sum_lost_[2]; // compensated
    std::vector<Summary> tiles_;
    int from_ = 0, shown_ = 0; // which state is kept, which one the last press made
};
