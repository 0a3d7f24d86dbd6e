// SPDX-License-Identifier: MIT
#include "host/model/sites.hpp"

#include "host/loops/pool.hpp"

#include <algorithm>
#include <unordered_map>

namespace dermis::model {
namespace {

using f64::Axis;

// The cells that the stencil of a place reads, along each axis: far_low, low, high, far_high.
struct Neighbours {
    Axis x, y;
    size_t along_x[4], along_y[4];
};

Neighbours neighbours_of(const plan::Plan& plan, Cell c) {
    const size_t width = size_t(plan.constants.width);
    Neighbours n;
    n.x = f64::axis(c.x, plan.constants.width, plan.stencil, plan.edges);
    n.y = f64::axis(c.y, plan.constants.height, plan.stencil, plan.edges);
    const int xs[] = {n.x.far_low, n.x.low, n.x.high, n.x.far_high};
    const int ys[] = {n.y.far_low, n.y.low, n.y.high, n.y.far_high};
    for (int i = 0; i < 4; ++i) {
        n.along_x[i] = size_t(c.y) * width + size_t(xs[i]);
        n.along_y[i] = size_t(ys[i]) * width + size_t(c.x);
    }
    if (plan.stencil == STENCIL_FIVE_POINT) // looks no further
        for (size_t* along : {n.along_x, n.along_y}) along[0] = along[1], along[3] = along[2];
    return n;
}

// Cells that are never pressed stay at rest: they are one cell, behind the others.
bool ever_pressed(const plan::Plan& plan, size_t cell) {
    if (!plan.framed) return plan.maps.pressure[cell] != 0;
    const int x = int(cell % size_t(plan.constants.width)), y = int(cell / size_t(plan.constants.width));
    const plan::Pressed& box = plan.pressed;
    return y >= box.first_row && y < box.last_row && x >= box.first_tile * TILE_CELLS && x < box.last_tile * TILE_CELLS;
}

class Sites : public plan::Marcher {
  public:
    Sites(const plan::Plan& plan, const SiteCells& cells, int threads, Sink sink)
        : plan_(plan), sink_(std::move(sink)), pool_(loops::useful_threads(8 * cells.cells.size(), threads)),
          cells_(cells.cells), material_(cells.material), places_of_(cells.places.size()) {
        const size_t width = size_t(plan.constants.width), sites = plan.scene.sites.size();
        // the plan's own places, not some that are looked at beforehand
        const bool typed = plan.model == Model::sites && cells.places.size() == plan.places.size();
        for (size_t i = 0; i < cells.places.size(); ++i) {
            const Cell c = cells.places[i];
            const size_t cell = size_t(c.y) * width + size_t(c.x);
            if (!ever_pressed(plan, cell)) continue; // all that it has is 0
            Place p{neighbours_of(plan, c), rank(cell), i, -1,
                    plan::laplacian_at(plan.maps.surface, c, plan.scene.grid, plan.stencil, plan.edges)};
            for (auto& along : {&p.looks.along_x, &p.looks.along_y})
                for (size_t& at : *along) at = rank(at);
            if (typed && i >= places_of_ - sites) p.type = int(plan.scene.sites[i - (places_of_ - sites)].type);
            places_.push_back(p);
        }
        std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) { return a.cell < b.cell; });
        state_.resize(cells_.size() + 1);
        shown_.resize(cells_.size() + 1);
        for (size_t cell : cells_) {
            from_.push_back(0);
            to_.push_back(plan.framed ? 0 : plan.maps.pressure[cell]);
        }
        sample_.probes.assign(places_of_ * REDUCED_MAPS, 0);
    }

    void frame(const std::vector<double>& pressure) override {
        from_.swap(to_);
        for (size_t i = 0; i < cells_.size(); ++i) to_[i] = pressure[cells_[i]];
    }

    void press(const plan::Step& step) override {
        const auto c = plan::constants_of<f64::Constants>(plan_, step);
        if (step.rows != from_rows_) {
            from_rows_ = step.rows;
            rows_.clear();
            for (const f64::Row& k : *step.rows) rows_.push_back(f64::rows_of(k));
        }
        pool_.rows(int(cells_.size()), [&](int first, int last) {
            for (size_t i = size_t(first); i < size_t(last); ++i) {
                const f64::Load load = load_of(i, c);
                const f64::Rows& k = rows_[size_t(material_[i])];
                shown_[i].eps = f64::added(state_[i].eps, f64::strain_step(state_[i].eps, load, k));
                shown_[i].sum = f64::added(state_[i].sum, f64::sum_step(state_[i].eps, state_[i].sum, load, k));
            }
        });
        if (step.trace >= 0) {
            pool_.rows(int(places_.size()), [&](int first, int last) {
                for (int i = first; i < last; ++i) respond(places_[size_t(i)], c);
            });
            sink_(step, sample_);
        }
        if (step.keep) state_.swap(shown_);
    }

    void finish() override {}
    void read(const std::vector<Quantity>&, std::vector<std::vector<double>>&) override {} // plan::why_not: no fields

  private:
    struct State {
        double eps = 0, sum = 0;
    };
    struct Place {
        Neighbours looks;
        size_t cell, column; // of a sample
        int type;            // of a site, whose class alone is asked for; -1: every quantity
        double rest_curvature;
    };

    size_t rank(size_t cell) const {
        const auto at = std::lower_bound(cells_.begin(), cells_.end(), cell);
        return size_t((at != cells_.end() && *at == cell ? at : cells_.end()) - cells_.begin());
    }

    f64::Load load_of(size_t i, const f64::Constants& c) const {
        return plan_.framed ? f64::load_between(from_[i], to_[i], c) : f64::load_of(to_[i], c);
    }

    double along(const size_t (&cells)[4], double centre, const Axis& axis) const {
        const auto eps = [&](int i) { return shown_[cells[i]].eps; };
        if (plan_.stencil == STENCIL_FIVE_POINT) return f64::second_difference(eps(1), centre, eps(2));
        if (plan_.stencil == STENCIL_FOURTH_ORDER) return f64::fourth_order(eps(0), eps(1), centre, eps(2), eps(3));
        return f64::published_difference(eps(0), eps(1), eps(2), eps(3), axis);
    }

    void respond(const Place& p, const f64::Constants& c) {
        const f64::Rows& k = rows_[size_t(material_[p.cell])];
        const double eps = state_[p.cell].eps, after = shown_[p.cell].eps;
        const double L = f64::add(along(p.looks.along_x, after, p.looks.x), along(p.looks.along_y, after, p.looks.y));
        const double C = f64::curvature_of(p.rest_curvature, L, c.bend), l = c.curvature_length;
        const f64::Load load = load_of(p.cell, c);
        const auto value = [&](int q) {
            switch (Quantity(q)) {
            case Quantity::strain: return after;
            case Quantity::sa1: return f64::response(after, C, l);
            case Quantity::sa2: return f64::response(shown_[p.cell].sum, C, l);
            case Quantity::fa1: return f64::response(f64::rate_after(eps, load, k), C, l);
            default:
                return f64::rectified(f64::response(f64::acceleration_after(eps, load, k), C, l), c.gain_plus,
                                      c.gain_minus);
            }
        };
        for (int q = 0; q < REDUCED_MAPS; ++q)
            if (p.type < 0 || p.type == q) sample_.probes[size_t(q) * places_of_ + p.column] = value(q);
    }

    const plan::Plan& plan_;
    Sink sink_;
    loops::Pool pool_;
    std::vector<size_t> cells_; // ascending; all else here is by rank in it
    std::vector<int> material_;
    size_t places_of_;          // all of them
    std::vector<Place> places_; // those that are ever pressed
    std::vector<State> state_, shown_;
    std::vector<double> from_, to_; // pressure
    std::vector<f64::Rows> rows_;
    std::shared_ptr<const std::vector<f64::Row>> from_rows_;
    plan::Sample sample_{};
};

} // namespace

SiteCells::SiteCells(const plan::Plan& plan, const std::vector<Cell>& at) : places(at) {
    const size_t width = size_t(plan.constants.width);
    for (const Cell& c : places) {
        const Neighbours n = neighbours_of(plan, c);
        const size_t cell = size_t(c.y) * width + size_t(c.x);
        if (!ever_pressed(plan, cell)) continue;
        cells.push_back(cell);
        for (const auto& along : {n.along_x, n.along_y})
            for (int i = 0; i < 4; ++i)
                if (ever_pressed(plan, along[i])) cells.push_back(along[i]);
    }
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    std::unordered_map<int, int> known;
    for (size_t cell : cells) {
        const int kind = plan.material.empty() ? 0 : plan.material[cell / width * plan.pitch + cell % width];
        const auto [rank, fresh] = known.try_emplace(kind, int(media.size()));
        if (fresh) media.push_back(plan.media[size_t(kind)]);
        material.push_back(rank->second);
    }
    if (media.empty()) media.push_back(plan.media.front()); // a timeline has at least one
}

std::unique_ptr<plan::Marcher> sites(const plan::Plan& plan, const SiteCells& cells, int threads,
                                     plan::Marcher::Sink sink) {
    return std::make_unique<Sites>(plan, cells, threads, std::move(sink));
}

} // namespace dermis::model
