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
                for (int y = first; y < last; ++y) {
                    respond(y, c);
                    summarize(y, c);
                }
            });
            hand_over(step);
        }
        if (step.keep) from_ = shown_;
    }

    void finish() override {}

    std::vector<std::vector<double>> read(const std::vector<Quantity>& what) override {
        const DefaultFloats guard;
        const Constants c = plan::constants_of<Constants>(plan_, {});
        std::vector<std::vector<double>> maps;
        for (Quantity q : what) {
            std::vector<double>& map = maps.emplace_back();
            map.reserve(size_t(c.width) * c.height);
            for (int y = 0; y < c.height; ++y)
                for (int x = 0; x < c.width; ++x) map.push_back(double(value(q, x, y, c)));
        }
        return maps;
    }

  private:
    size_t row(int y) const { return size_t(y) * plan_.pitch; }

    void advance(int y, const Constants& c) {
        const real* __restrict p = pressure_.data() + row(y);
        const real* __restrict eps = strain_[from_].data() + row(y);
        const real* __restrict sum = sum_[from_].data() + row(y);
        real* __restrict eps_to = strain_[1 - from_].data() + row(y);
        real* __restrict sum_to = sum_[1 - from_].data() + row(y);
        for (int x = 0; x < c.width; ++x) {
            const Load load = load_of(p[x], c);
            eps_to[x] = strain_after(eps[x], load, c.row);
            sum_to[x] = sum_after(eps[x], sum[x], load, c.row);
        }
    }

    // Responses in columns first..last of a row, with the Laplacian that `laplacian(x)` gives.
    template <class Laplacian> void respond(int y, int first, int last, const Constants& c, Laplacian&& laplacian) {
        const real* __restrict p = pressure_.data() + row(y);
        const real* __restrict rest = rest_.data() + row(y);
        const real* __restrict eps = strain_[from_].data() + row(y);
        const real* __restrict after = strain_[1 - from_].data() + row(y);
        const real* __restrict sum = sum_[1 - from_].data() + row(y);
        real* __restrict sa1 = response_[0].data() + row(y);
        real* __restrict sa2 = response_[1].data() + row(y);
        real* __restrict fa1 = response_[2].data() + row(y);
        real* __restrict fa2 = response_[3].data() + row(y);
        for (int x = first; x < last; ++x) {
            const Load load = load_of(p[x], c);
            const real C = curvature_of(rest[x], laplacian(x), c.bend), l = c.curvature_length;
            sa1[x] = response(after[x], C, l);
            sa2[x] = response(sum[x], C, l);
            fa1[x] = response(rate_after(eps[x], load, c.row), C, l);
            fa2[x] = rectified(response(acceleration_after(eps[x], load, c.row), C, l), c.gain_plus, c.gain_minus);
        }
    }

    real laplacian_at(int x, int y, const Constants& c) const {
        Stored stored{strain_[shown_].data(), plan_.pitch};
        const real centre = stored.strain_at(x, y);
        return add(stored.laplacian_along_x(x, y, centre, c.width, plan_.stencil, plan_.edges),
                   stored.laplacian_along_y(x, y, centre, c.height, plan_.stencil, plan_.edges));
    }

    void respond(int y, const Constants& c) {
        const auto anywhere = [&](int x) { return laplacian_at(x, y, c); };
        if (plan_.stencil != STENCIL_FIVE_POINT || c.width < 3) return respond(y, 0, c.width, c, anywhere);
        const real* after = strain_[shown_].data();
        const real* here = after + row(y);
        const real* low = after + row(wrapped(y - 1, c.height, plan_.edges));
        const real* high = after + row(wrapped(y + 1, c.height, plan_.edges));
        respond(y, 0, 1, c, anywhere);
        respond(y, 1, c.width - 1, c, [=](int x) {
            return add(second_difference(here[x - 1], here[x], here[x + 1]), second_difference(low[x], here[x], high[x]));
        });
        respond(y, c.width - 1, c.width, c, anywhere);
    }

    const real* plane(int quantity) const {
        return quantity == 0 ? strain_[shown_].data() : response_[quantity - 1].data();
    }

    void summarize(int y, const Constants& c) {
        real sum[TILE_CELLS], low[TILE_CELLS], high[TILE_CELLS]; // Summary by parts, for the compiler's vectors
        for (int q = 0; q < REDUCED_MAPS; ++q)
            for (int t = 0; t < plan_.tiles; ++t) {
                const real* values = plane(q) + row(y) + size_t(t) * TILE_CELLS;
                const int count = std::min(TILE_CELLS, c.width - t * TILE_CELLS);
                for (int i = 0; i < count; ++i) sum[i] = low[i] = high[i] = values[i];
                for (int i = count; i < TILE_CELLS; ++i) {
                    sum[i] = real(0);
                    low[i] = high[i] = values[0];
                }
                for (int reach = TILE_CELLS / 2; reach > 0; reach /= 2)
                    for (int i = 0; i < reach; ++i) {
                        const Summary joined = join({sum[i], low[i], high[i]}, {sum[i + reach], low[i + reach], high[i + reach]});
                        sum[i] = joined.sum;
                        low[i] = joined.low;
                        high[i] = joined.high;
                    }
                tiles_[(size_t(q) * c.height + y) * plan_.tiles + t] = {sum[0], low[0], high[0]};
            }
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

    real value(Quantity q, int x, int y, const Constants& c) const {
        const size_t i = row(y) + x;
        if (q == Quantity::curvature) return flush(curvature_of(rest_[i], laplacian_at(x, y, c), c.bend));
        if (q == Quantity::deformation) return flush(deformation_of(surface_[i], strain_[shown_][i], c.thickness));
        return plane(int(q))[i];
    }

    const plan::Plan& plan_;
    Sink sink_;
    Pool pool_;
    std::vector<real> pressure_, rest_, surface_, strain_[2], sum_[2], response_[4];
    std::vector<Summary> tiles_;
    int from_ = 0, shown_ = 0; // which state is kept, which one the last press made
};
