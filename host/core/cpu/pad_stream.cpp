// SPDX-License-Identifier: MIT
#include "host/core/cpu/stream.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/cpu/pad_cells.hpp"

#include <atomic>
#include <functional>

namespace dermis::cpu {

using model::StreamedSkin;

namespace {

// A batch of pads, or a single skin with short rows or few sites. Each thread takes whole pads.
class PadStream : public model::Stream {
  public:
    PadStream(const StreamedSkin& s, int threads, const simd::Isa& isa)
        : pool_(threads), pads_(s, threads, isa), frame_(s.skin.cells()), counts_(model::response_counts(s)),
          tables_(s, pads_.elements()), pad_(size_t(s.pads)) {
        for (std::vector<float>& p : pressure_) p = simd::map_of(pad_.size() * pads_.pitch(), 0.0f);
        for (size_t r = 0; r < RESPONSE_MAPS; ++r) response_[r] = simd::map_of(pad_.size() * counts_[r], 0.0f);
    }

    bool take(const model::PadList& pads, const float* pressures, bool by_number) override {
        std::atomic<bool> finite = true;
        run(pads, [&](int, size_t first, size_t last) {
            for (size_t i = first; i < last;) {
                const size_t place = by_number ? size_t(pads[i]) : i;
                i += take_some(pads, i, last, pressures + place * frame_, finite);
            }
        });
        return finite;
    }

    bool rests(int pad) const override { return pad_[size_t(pad)].rests; }

    bool take_cells(const model::PadList& pads, const float* pressures, const std::vector<size_t>& cells,
                    size_t frame) override {
        if (!lists()) return Stream::take_cells(pads, pressures, cells, frame);
        std::atomic<bool> finite = true;
        run(pads, [&](int, size_t first, size_t last) {
            for (size_t i = first; i < last; ++i) {
                const float* own = pressures + i * cells.size();
                if (!model::all_finite(own, cells.size())) finite = false;
                take_listed(pads[i], [&own](size_t) { return *own++; });
            }
        });
        return finite;
    }

    const double* prepare(const model::PadList& pads, const model::StepLengths& dt) override {
        const DefaultFloats guard;
        return tables_.fill(pads, dt);
    }

    void press(const model::PadList& pads, const model::StepLengths&, bool answers) override {
        const DefaultFloats guard;
        run(pads, [&](int thread, size_t first, size_t last) {
            for (size_t i = first; i < last; i += press_some(pads, i, last, thread, answers)) {
            }
        });
    }

    const float* response(Quantity q) override { return response_[size_t(q) - QUANTITY_SA1].data(); }

    void reset(const model::PadList& pads) override {
        for (size_t i = 0; i < pads.count; ++i) {
            const size_t pad = size_t(pads[i]);
            pad_[pad] = {};
            pads_.rest(pads[i]);
            for (auto* p : {&pressure_[0], &pressure_[1]}) clear(*p, pad, pads_.pitch());
            for (size_t r = 0; r < RESPONSE_MAPS; ++r) clear(response_[r], pad, counts_[r]);
        }
    }

    void save(const model::PadList& pads, const model::StateMemory<char>& to) override {
        run(pads, [&](int, size_t first, size_t last) {
            for (size_t i = first; i < last; ++i) transfer(pads[i], to.strains_of(i), to.pressure_of(i));
        });
    }

    void load(const model::PadList& pads, const model::StateMemory<const char>& from) override {
        run(pads, [&](int, size_t first, size_t last) {
            for (size_t i = first; i < last; ++i) {
                pad_[size_t(pads[i])].rests = pad_[size_t(pads[i])].stays_at_rest = false;
                transfer(pads[i], from.strains_of(i), from.pressure_of(i));
            }
        });
    }

    void read(const model::PadList& pads, const std::vector<model::HeldCell>& cells, size_t planes,
              float* to) override {
        const size_t of_pad = cells.size() * (planes + 1);
        run(pads, [&](int, size_t first, size_t last) {
            for (size_t i = first; i < last; ++i)
                pads_.read(pads[i], cells, planes, pressure_of(pads[i], pad_[size_t(pads[i])].from), to + i * of_pad);
        });
    }

    void set_elements(const model::PadList& pads, const std::vector<model::Element>& elements) override {
        tables_.set_elements(pads, elements);
    }

  private:
    struct Pad {
        int from = 0;              // the side of the pressure that the next press starts from
        bool rests = true;         // nothing has ever pressed it
        bool stays_at_rest = true; // it rests, and the pressure that was taken last does not press it either
    };
    struct alignas(64) Part {
        std::atomic<size_t> next; // the first place of this part of a list that no thread has taken
    };

    // Calls some(thread, first, last) for shares of the list, places first .. last - 1, on some thread. A thread begins
    // with a part of the list that is the same in every call, as its cache may hold these pads, then helps the others.
    template <class Some> void run(const model::PadList& pads, Some some) {
        const size_t threads = parts_.size(), share = std::max<size_t>(pads_.together(), 4);
        if (threads == 1) return some(0, 0, pads.count); // parts that nobody else takes cost a tenth of a small press
        for (size_t p = 0; p < threads; ++p) parts_[p].next = pads.count * p / threads;
        const auto work = [&](int thread) {
            for (size_t k = 0; k < threads; ++k) {
                const size_t p = (size_t(thread) + k) % threads, last = pads.count * (p + 1) / threads;
                for (size_t i; (i = parts_[p].next.fetch_add(share)) < last;)
                    some(thread, i, std::min(i + share, last));
            }
        };
        pool_.each(std::ref(work), false); // a reference: nothing is allocated
    }

    // The number of pads of a list, from place i on, that stand side by side, start from the same side and are not at
    // rest.
    size_t alike(const model::PadList& pads, size_t i, size_t last, bool Pad::*at_rest) const {
        const int first = pads[i], side = pad_[size_t(first)].from;
        size_t n = 1;
        while (i + n < last && size_t(pads[i + n]) == size_t(first) + n) {
            const Pad& p = pad_[size_t(first) + n];
            if (p.from != side || p.*at_rest) break;
            ++n;
        }
        return n;
    }

    bool lists() const { return !pads_.read_cells().empty(); }
    float* pressure_of(int pad, int side) { return pressure_[side].data() + size_t(pad) * pads_.pitch(); }

    // Calls f(number of the cell in a frame, its pressure) for each cell of a pad that is stepped.
    template <class F> void each_listed(float* pressure, F f) {
        for (const size_t cell : pads_.read_cells()) f(cell, *pressure++);
    }

    // Copies the state of a pad to the caller's memory or, where Byte is const, from there.
    template <class Byte> void transfer(int pad, Byte* strains, Byte* pressure) {
        pads_.transfer(pad, strains);
        float* const own = pressure_of(pad, pad_[size_t(pad)].from);
        each_listed(own, [&](size_t cell, float& p) {
            Byte* at = pressure + cell * sizeof p;
            model::copy_state(at, &p, 1);
        });
        if (!lists()) model::copy_state(pressure, own, frame_);
    }

    // Takes the pressures of pads of a list, from place i on. Returns how many.
    size_t take_some(const model::PadList& pads, size_t i, size_t last, const float* pressure,
                     std::atomic<bool>& finite) {
        const int pad = pads[i];
        Pad& p = pad_[size_t(pad)];
        if (lists()) {
            if (!model::all_finite(pressure, frame_)) finite = false;
            take_listed(pad, [pressure](size_t cell) { return pressure[cell]; });
            return 1;
        }
        p.stays_at_rest = p.rests && model::all_bits_zero(pressure, frame_);
        if (p.stays_at_rest) return 1;
        const size_t n = alike(pads, i, last, &Pad::rests);
        if (!model::copy_rows({.from = pressure,
                               .stride = frame_,
                               .width = frame_,
                               .to = pressure_of(pad, 1 - p.from),
                               .pitch = pads_.pitch()},
                              0, int(n)))
            finite = false;
        return n;
    }

    // Takes the pressures of the cells of a pad that are stepped, where these are not all. of(cell): of a cell of a
    // frame, asked for once and in ascending order.
    template <class Of> void take_listed(int pad, Of of) {
        Pad& p = pad_[size_t(pad)];
        float* const to = pressure_of(pad, 1 - p.from);
        each_listed(to, [&](size_t cell, float& number) { number = of(cell); });
        p.stays_at_rest = p.rests && model::all_bits_zero(to, pads_.read_cells().size());
    }

    // Presses pads of a list, from place i on. Returns how many.
    size_t press_some(const model::PadList& pads, size_t i, size_t last, int thread, bool answers) {
        const int pad = pads[i];
        Pad& p = pad_[size_t(pad)];
        if (p.stays_at_rest) return 1;
        const size_t n =
            tables_.shared() ? alike(pads, i, std::min(last, i + pads_.together()), &Pad::stays_at_rest) : 1;
        PadCells::Press press{.first = pad,
                              .count = int(n),
                              .from = pressure_of(pad, p.from),
                              .to = pressure_of(pad, 1 - p.from),
                              .table = tables_.of(pad),
                              .response = {},
                              .answers = answers};
        for (size_t r = 0; r < RESPONSE_MAPS; ++r)
            press.response[r] = counts_[r] ? response_[r].data() + size_t(pad) * counts_[r] : nullptr;
        pads_.press(thread, press);
        std::fill_n(&p, n, Pad{.from = 1 - p.from, .rests = false, .stays_at_rest = false});
        return n;
    }

    static void clear(std::vector<float>& map, size_t pad, size_t count) {
        std::fill_n(map.begin() + long(pad * count), count, 0.0f);
    }

    simd::Pool pool_;
    std::vector<Part> parts_{size_t(pool_.threads())}; // one for each thread
    PadCells pads_;
    const size_t frame_; // cells of a frame
    const std::array<size_t, RESPONSE_MAPS> counts_;
    model::StepTables tables_;
    std::vector<Pad> pad_;
    std::vector<float> pressure_[2]; // of the cells that are stepped
    std::array<std::vector<float>, RESPONSE_MAPS> response_;
};

} // namespace

std::unique_ptr<model::Stream> pad_stream(const StreamedSkin& skin, int threads, const simd::Isa& isa) {
    return std::make_unique<PadStream>(skin, threads, isa);
}

} // namespace dermis::cpu
