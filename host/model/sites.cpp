// SPDX-License-Identifier: MIT
#include "host/model/sites.hpp"

#include "host/loops/pool.hpp"

#include <algorithm>
#include <unordered_map>

namespace dermis {

namespace f64 {
#include "host/model/site_loop.inl"
}

namespace model {
namespace {

// Along each axis: far_low, low, high, far_high; the nearest stencil looks no further than low and high.
struct Neighbours {
    size_t x[4], y[4]; // y*width + x
};

Neighbours neighbours_of(const plan::Plan& plan, Cell c) {
    const size_t width = size_t(plan.constants.width);
    const f64::Axis x = f64::axis(c.x, plan.constants.width, plan.stencil, plan.edges);
    const f64::Axis y = f64::axis(c.y, plan.constants.height, plan.stencil, plan.edges);
    const int xs[] = {x.far_low, x.low, x.high, x.far_high}, ys[] = {y.far_low, y.low, y.high, y.far_high};
    Neighbours n;
    for (int i = 0; i < 4; ++i) {
        n.x[i] = size_t(c.y) * width + size_t(xs[i]);
        n.y[i] = size_t(ys[i]) * width + size_t(c.x);
    }
    if (plan.stencil == STENCIL_FIVE_POINT)
        for (size_t* along : {n.x, n.y}) along[0] = along[1], along[3] = along[2];
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
          loop_(plan, cells.material), cells_(cells.cells), places_of_(cells.places.size()) {
        const size_t sites = plan.scene.sites.size();
        // the plan's own places, not some that are looked at beforehand
        const bool typed = plan.model == Model::sites && cells.places.size() == plan.places.size();
        for (size_t i = 0; i < cells.places.size(); ++i) {
            const Cell c = cells.places[i];
            if (!ever_pressed(plan, size_t(c.y) * size_t(plan.constants.width) + size_t(c.x)))
                continue; // all that it has is 0
            Place p{loop_.place(cells, c), i, -1};
            if (typed && i >= places_of_ - sites) p.type = int(plan.scene.sites[i - (places_of_ - sites)].type);
            places_.push_back(p);
        }
        std::sort(places_.begin(), places_.end(),
                  [](const Place& a, const Place& b) { return a.at.looks.here < b.at.looks.here; });
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
            loop_.advance(c, rows_.data(), plan_.framed ? from_.data() : to_.data(), to_.data(), size_t(first),
                          size_t(last));
        });
        if (step.trace >= 0) {
            pool_.rows(int(places_.size()), [&](int first, int last) {
                for (int i = first; i < last; ++i) respond(places_[size_t(i)], c);
            });
            sink_(step, sample_);
        }
        if (step.keep) loop_.keep();
    }

    void finish() override {}
    void read(const std::vector<Quantity>&, std::vector<std::vector<double>>&) override {} // plan::why_not: no fields

  private:
    struct Place {
        f64::SiteLoop::Place at;
        size_t column; // of a sample
        int type;      // of a site, whose class alone is asked for; -1: every quantity
    };

    void respond(const Place& p, const f64::Constants& c) {
        for (int q = 0; q < REDUCED_MAPS; ++q)
            if (p.type < 0 || p.type == q)
                sample_.probes[size_t(q) * places_of_ + p.column] = loop_.value(
                    p.at, Quantity(q), c, rows_.data(), plan_.framed ? from_.data() : to_.data(), to_.data());
    }

    const plan::Plan& plan_;
    Sink sink_;
    loops::Pool pool_;
    f64::SiteLoop loop_;
    const std::vector<size_t>& cells_;
    size_t places_of_;              // all of them
    std::vector<Place> places_;     // those that are ever pressed
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
        for (const auto& along : {n.x, n.y})
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

Looks looks_of(const plan::Plan& plan, const SiteCells& cells, Cell c) {
    const auto rank = [&](size_t cell) {
        const auto at = std::lower_bound(cells.cells.begin(), cells.cells.end(), cell);
        return size_t((at != cells.cells.end() && *at == cell ? at : cells.cells.end()) - cells.cells.begin());
    };
    const Neighbours n = neighbours_of(plan, c);
    Looks looks{rank(size_t(c.y) * size_t(plan.constants.width) + size_t(c.x)), {}, {}};
    for (int i = 0; i < 4; ++i) {
        looks.x[i] = rank(n.x[i]);
        looks.y[i] = rank(n.y[i]);
    }
    return looks;
}

std::unique_ptr<plan::Marcher> sites(const plan::Plan& plan, const SiteCells& cells, int threads,
                                     plan::Marcher::Sink sink) {
    return std::make_unique<Sites>(plan, cells, threads, std::move(sink));
}

} // namespace model
} // namespace dermis
