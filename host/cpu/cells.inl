// SPDX-License-Identifier: MIT
// The state of every cell and one pass over it per step, in the `real` of the namespace that includes this. LaneCoefficients are
// stepped in place; responses follow as far behind as the stencil reaches, while the rows are still in a cache. What a
// band of rows needs of the new strain elsewhere it makes for itself before any band begins.

// Values that begin at a cache line, and so do their rows. Planes that are walked side by side have different `place`s:
// all beginning at the same bits of an address they would fight for the same lines of a cache.
class Plane {
  public:
    Plane() = default;
    Plane(size_t cells, int place) : shift_(size_t(place) * 5 * size_t(line) / sizeof(real)) {
        const size_t all = cells + shift_;
        values_.reset(static_cast<real*>(::operator new(all * sizeof(real), line)));
        simd::prefer_large_pages(values_.get(), all * sizeof(real));
        std::fill_n(values_.get(), all, real(0));
    }
    real* data() const { return values_ ? values_.get() + shift_ : nullptr; }
    real* row(int y, int pitch) const { return values_ ? data() + size_t(y) * pitch : nullptr; }

  private:
    static constexpr std::align_val_t line{64};
    struct Free {
        void operator()(real* p) const { ::operator delete(p, line); }
    };
    std::unique_ptr<real[], Free> values_;
    size_t shift_ = 0;
};

class Cells {
  public:
    // What one press hands out; null: not wanted. Maps of pitch*height, summaries of tiles*height.
    struct Outputs {
        real* response[4];
        Summary* tiles[REDUCED_MAPS];
    };

    Cells(const plan::Plan& plan, int threads, const simd::Isa& isa)
        : plan_(plan), pool_(threads), isa_(isa), loops_(isa.of<real>()), barrier_(pool_.bands()),
          kept_(state_of(plan)), bands_(size_t(pool_.bands())) {
        for (Band& band : bands_) {
            int place = 4;
            for (Plane& row : band.outside) row = Plane(size_t(plan.pitch), 0);
            for (Plane& row : band.unused) row = Plane(size_t(plan.pitch), 0);
            for (auto* ring : {&band.rate, &band.acceleration})
                for (Plane& row : *ring) row = Plane(size_t(plan.pitch), ++place);
        }
    }

    // Pressure runs from p to q, or is p where q is null. keep: the state moves on; else it is looked ahead of. Returns
    // which of strain (1) and integral (2) are not what they were in some cell.
    int press(const Constants& c, const Coefficients* table, const real* p, const real* q, const real* rest, bool keep,
               const Outputs& handed) {
        if (!keep && !scratch_.strain.data()) scratch_ = state_of(plan_);
        shown_ = keep ? &kept_ : &scratch_;
        const Press press{c, table, p, q, rest, handed};
        pool_.each([&](int band) { stream(press, band); });
        int changed = 0;
        for (const Band& band : bands_) changed |= band.changed;
        return changed;
    }

    const real* strain() const { return shown_->strain.data(); }

    void rest() {
        const size_t cells = size_t(plan_.pitch) * plan_.constants.height;
        for (const Plane* map : {&kept_.strain, &kept_.sum, &kept_.strain_lost, &kept_.sum_lost})
            if (map->data()) std::fill_n(map->data(), cells, real(0));
    }

  private:
    struct State {
        Plane strain, sum, strain_lost, sum_lost; // what sums have lost: only compensated
    };
    // Of one thread: new strain of rows outside its band, and what belongs to a step but not to the state.
    struct Band {
        std::array<Plane, 8> outside;
        std::array<int, 8> row{};
        int count = 0, changed = 0;
        std::array<Plane, 3> rate, acceleration;
        std::array<Plane, 5> unused;
    };
    struct Press {
        const Constants& c;
        const Coefficients* table;
        const real *p, *q, *rest;
        const Outputs& handed;
    };

    static State state_of(const plan::Plan& plan) {
        const size_t cells = size_t(plan.pitch) * plan.constants.height;
        State s{Plane(cells, 0), Plane(cells, 1), {}, {}};
        if (plan.compensated) s.strain_lost = Plane(cells, 2), s.sum_lost = Plane(cells, 3);
        return s;
    }

    int first_column() const { return plan_.pressed.first_tile * TILE_CELLS; }
    int last_column() const { return std::min(plan_.pressed.last_tile * TILE_CELLS, plan_.constants.width); }

    void stream(const Press& press, int of) {
        const plan::Pressed& box = plan_.pressed;
        const long long rows = box.last_row - box.first_row, bands = pool_.bands();
        const int first = box.first_row + int(rows * of / bands), last = box.first_row + int(rows * (of + 1) / bands);
        const int reach = plan_.stencil == STENCIL_FIVE_POINT ? 1 : 2;
        const bool respond = press.c.respond != 0;
        Band& band = bands_[size_t(of)];
        band.changed = 0;
        if (respond) {
            band.count = 0;
            for (int y = first; y < last; ++y) {
                if (y == first + reach) y = std::max(y, last - reach);
                look_outside(press, band, y, first, last, reach);
            }
            if (bands > 1) barrier_.arrive_and_wait();
        }
        for (int y = first; y < last + reach; ++y) {
            const int ring = y % 3, behind = y - reach;
            if (y < last) band.changed |= advance(press, y, *shown_, band.rate[ring], band.acceleration[ring]);
            if (respond && behind >= first) respond_row(press, band, behind, first, last, reach);
        }
        isa_.fence_streams();
    }

    // Whether the array holds row i's new strain by the time that row y responds.
    bool ready(int i, int y, int first, int last, int reach) const {
        const plan::Pressed& box = plan_.pressed;
        const bool pressed = i >= box.first_row && i < box.last_row; // others rest for ever
        return !pressed || (i >= first && i < last && i <= y + reach);
    }

    void look_outside(const Press& press, Band& band, int y, int first, int last, int reach) {
        const f64::Axis a = f64::axis(y, plan_.constants.height, plan_.stencil, plan_.edges);
        for (int i : {a.far_low, a.low, a.high, a.far_high}) {
            const auto known = band.row.begin() + band.count;
            if (ready(i, y, first, last, reach) || std::find(band.row.begin(), known, i) != known) continue;
            band.row[size_t(band.count)] = i;
            advance_to(press, i, band.outside[size_t(band.count)].data(), band.unused[0].data(),
                       plan_.compensated ? band.unused[1].data() : nullptr,
                       plan_.compensated ? band.unused[2].data() : nullptr, band.unused[3].data(),
                       band.unused[4].data());
            ++band.count;
        }
    }

    int advance(const Press& press, int y, State& to, const Plane& rate, const Plane& acceleration) {
        const int pitch = plan_.pitch;
        return advance_to(press, y, to.strain.row(y, pitch), to.sum.row(y, pitch), to.strain_lost.row(y, pitch),
                   to.sum_lost.row(y, pitch), rate.data(), acceleration.data());
    }

    int advance_to(const Press& press, int y, real* eps, real* sum, real* eps_lost, real* sum_lost, real* rate,
                    real* acceleration) {
        const int at = first_column(), pitch = plan_.pitch;
        const size_t row = size_t(y) * pitch + at;
        const auto from = [&](real* map) { return map ? map + at : nullptr; };
        return loops_.advance({last_column() - at, press.p + row, press.q ? press.q + row : nullptr,
                        plan_.material.empty() ? nullptr : plan_.material.data() + row, press.table,
                        from(kept_.strain.row(y, pitch)), from(kept_.sum.row(y, pitch)),
                        from(kept_.strain_lost.row(y, pitch)), from(kept_.sum_lost.row(y, pitch)), from(eps), from(sum),
                        from(eps_lost), from(sum_lost), from(rate), from(acceleration)},
                       press.c);
    }

    void respond_row(const Press& press, const Band& band, int y, int first, int last, int reach) {
        const Constants& c = press.c;
        const int pitch = plan_.pitch;
        const size_t row = size_t(y) * pitch, tile = size_t(y) * plan_.tiles;
        const auto strain = [&](int i) -> const real* {
            if (ready(i, y, first, last, reach)) return shown_->strain.row(i, pitch);
            return band.outside[size_t(std::find(band.row.begin(), band.row.end(), i) - band.row.begin())].data();
        };
        simd::Respond<real> r{first_column(),
                               last_column(),
                               simd::lines<real>(y, c.width, c.height, plan_.stencil, plan_.edges, strain),
                               shown_->sum.row(y, pitch),
                               band.rate[size_t(y % 3)].data(),
                               band.acceleration[size_t(y % 3)].data(),
                               press.rest + row,
                               {},
                               {}};
        for (int q = 0; q < 4; ++q) r.response[q] = press.handed.response[q] ? press.handed.response[q] + row : nullptr;
        for (int q = 0; q < REDUCED_MAPS; ++q)
            r.tiles[q] = press.handed.tiles[q] ? press.handed.tiles[q] + tile : nullptr;
        loops_.respond(r, c);
    }

    const plan::Plan& plan_;
    Pool pool_;
    const simd::Isa& isa_;
    const simd::Loops<real>& loops_;
    std::barrier<> barrier_;
    State kept_, scratch_;    // ahead of it at a look
    State* shown_ = &kept_; // what the last press made
    std::vector<Band> bands_;
};
