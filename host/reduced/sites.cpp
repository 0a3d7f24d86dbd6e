// SPDX-License-Identifier: MIT
#include "host/reduced/sites.hpp"

#include "host/simd/pool.hpp"

#include <algorithm>
#include <unordered_map>

namespace dermis {

namespace f64 {
#include "host/plan/site_stepper.inl"
}

namespace reduced {
namespace {

class Sites : public plan::Stepper {
  public:
    Sites(const plan::Plan& plan, const plan::SiteCells& cells, int threads, Sink sink)
        : plan_(plan), sink_(std::move(sink)), pool_(simd::useful_threads(8 * cells.cells.size(), threads)),
          loop_(plan, cells.material), cells_(cells.cells), places_of_(cells.places.size()) {
        const size_t sites = plan.scene.sites.size();
        // the plan's own places, not some that are looked at beforehand
        const bool typed = plan.model == Model::sites && cells.places.size() == plan.places.size();
        for (size_t i = 0; i < cells.places.size(); ++i) {
            const Cell c = cells.places[i];
            if (!plan::ever_pressed(plan, size_t(c.y) * size_t(plan.constants.width) + size_t(c.x)))
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
            for (const f64::Coefficients& k : *step.rows) rows_.push_back(f64::lanes_of(k));
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
        f64::SiteStepper::Place at;
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
    simd::Pool pool_;
    f64::SiteStepper loop_;
    const std::vector<size_t>& cells_;
    size_t places_of_;              // all of them
    std::vector<Place> places_;     // those that are ever pressed
    std::vector<double> from_, to_; // pressure
    std::vector<f64::LaneCoefficients> rows_;
    std::shared_ptr<const std::vector<f64::Coefficients>> from_rows_;
    plan::Sample sample_{};
};

} // namespace

std::unique_ptr<plan::Stepper> sites(const plan::Plan& plan, const plan::SiteCells& cells, int threads,
                                     plan::Stepper::Sink sink) {
    return std::make_unique<Sites>(plan, cells, threads, std::move(sink));
}

} // namespace reduced
} // namespace dermis
