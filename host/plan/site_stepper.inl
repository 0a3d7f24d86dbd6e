// SPDX-License-Identifier: MIT
// The cells that some places look at, one step at a time, in the `real` of the namespace that includes this. Cells go by
// their rank among plan::SiteCells; one more, behind them, stays at rest.

class SiteStepper {
  public:
    struct Place {
        plan::StencilCells looks;
        Axis x, y;
        real rest_curvature;
    };

    SiteStepper(const plan::Plan& plan, const std::vector<int>& material)
        : plan_(plan), material_(material), state_(material.size() + 1), shown_(material.size() + 1) {}

    Place place(const plan::SiteCells& cells, Cell c) const {
        return {plan::stencil_cells_of(plan_, cells, c), axis(c.x, plan_.constants.width, plan_.stencil, plan_.edges),
                axis(c.y, plan_.constants.height, plan_.stencil, plan_.edges),
                real(plan::laplacian_at(plan_.maps.surface, c, plan_.scene.grid, plan_.stencil, plan_.edges))};
    }

    // Steps cells first .. last - 1. k: by material; p: pressure, with frames what it was before q.
    void advance(const Constants& c, const LaneCoefficients* k, const real* p, const real* q, size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const Load load = load_at(i, c, p, q);
            const State& s = state_[i];
            const LaneCoefficients& row = k[material_[i]];
            const real step = strain_step(s.eps, load, row), gained = sum_step(s.eps, s.sum, load, row);
            State& to = shown_[i];
            if (plan_.compensated) {
                const Compensated eps = added_compensated(s.eps, s.eps_lost, step),
                                  sum = added_compensated(s.sum, s.sum_lost, gained);
                to = {eps.value, sum.value, eps.lost, sum.lost};
            } else {
                to.eps = added(s.eps, step);
                to.sum = added(s.sum, gained);
            }
        }
    }

    // What a place has after advance().
    real value(const Place& place, Quantity q, const Constants& c, const LaneCoefficients* k, const real* p, const real* p_to) const {
        const size_t here = place.looks.here;
        const LaneCoefficients& row = k[material_[here]];
        const real after = shown_[here].eps;
        if (q == Quantity::strain) return after;
        const real L = add(along(place.looks.x, after, place.x), along(place.looks.y, after, place.y));
        const real C = curvature_of(place.rest_curvature, L, c.bend);
        const scalar l = c.curvature_length;
        const Load load = load_at(here, c, p, p_to);
        switch (q) {
        case Quantity::sa1: return response(after, C, l);
        case Quantity::sa2: return response(shown_[here].sum, C, l);
        case Quantity::fa1: return response(rate_after(state_[here].eps, load, row), C, l);
        default:
            return rectified(response(acceleration_after(state_[here].eps, load, row), C, l), c.gain_plus, c.gain_minus);
        }
    }

    void keep() { state_.swap(shown_); }
    void reset() { std::fill(state_.begin(), state_.end(), State{}); }

  private:
    struct State {
        real eps = 0, sum = 0, eps_lost = 0, sum_lost = 0;
    };

    Load load_at(size_t i, const Constants& c, const real* p, const real* q) const {
        return plan_.framed ? load_between(p[i], q[i], c) : load_of(p[i], c);
    }

    real along(const size_t (&cells)[4], real centre, const Axis& axis) const {
        const auto eps = [&](int i) { return shown_[cells[i]].eps; };
        if (plan_.stencil == STENCIL_FIVE_POINT) return second_difference(eps(1), centre, eps(2));
        if (plan_.stencil == STENCIL_FOURTH_ORDER) return fourth_order(eps(0), eps(1), centre, eps(2), eps(3));
        return published_difference(eps(0), eps(1), eps(2), eps(3), axis);
    }

    const plan::Plan& plan_;
    const std::vector<int>& material_;
    std::vector<State> state_, shown_;
};
