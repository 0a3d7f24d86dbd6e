// SPDX-License-Identifier: MIT
// A call, and a way to press a skin by it. A suite compares ways: each has to give the same bits.
#pragma once

#include "dermis/touch.hpp"
#include "host/core/press/device.hpp"
#include "host/doors/c/handles.hpp"
#include "tests/drawn_skin.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <functional>
#include <utility>

namespace test {

// A call of all ways, with the numbers that it hands over.
struct Call {
    enum Kind { press, frames, cells, touch, own, reset, keep, carry, material, refused, kinds };
    Kind kind = press;
    std::vector<int> pads;                 // in the order given
    bool all = true;                       // the list names every pad, and is not handed over
    size_t count = 1;                      // of frames
    std::vector<double> dt;                // s: one, or one for each pad
    std::vector<float> pressure, traction; // frame by frame, and axis by axis, each pad by pad
    bool sheared = false;                  // there are tractions
    std::vector<float> of_cells;           // the pressures of the cells that the skin reads
    const dermis_touch* contacts = nullptr;
    Quantity source = Quantity::strain;         // of `own`: the response that presses
    std::optional<Quantity> source_of_traction; // of `own`, where a response is the traction
    std::vector<int> to;                        // of `carry`: the pads that are loaded
    Material given;                             // of `material`
    int variant = 0;                            // of `keep`
};

// Which doors a way goes through; all of them closed is the plain way.
struct Doors {
    bool frames = false, cells = false, touch = false, own = false, keep = false;
    bool in_c = false; // all that the C interface has
};

// Some pads of a call, that one call of a skin presses.
struct Part {
    dermis_skin& handle;
    Skin& skin;
    Pads pads;
    const dermis_pads* in_c; // the same for the C interface
    size_t first, count;     // places in the call's list
};

inline void need(dermis_status status) { CHECK_MESSAGE(status == DERMIS_OK, dermis_last_error()); }

class Way {
  public:
    Way(std::string name, const Device& device, const DrawnSkin& drawn, bool alone, Doors doors)
        : name_(std::move(name)), device_(device), drawn_(drawn), alone_(alone), doors_(doors),
          fresh_(size_t(drawn.options.count), true) {
        for (int i = 0; i < (alone ? drawn.options.count : 1); ++i) skins_.push_back({made(i)});
    }

    const std::string& name() const { return name_; }
    int count() const { return int(fresh_.size()); }
    bool has_fields() const { return drawn_.skin.sites.empty(); }
    const Skin& skin() const { return skins_[0].skin; }
    // Whether a pad's responses are those of its last press: a state that was loaded brings none.
    bool fresh(int pad) const { return fresh_[size_t(pad)]; }
    bool fresh() const { return std::ranges::all_of(fresh_, std::identity()); }

    // A response of all pads. of_sites: the numbers of these cells alone, which a skin without sites has.
    std::vector<float> response(Quantity q, const std::vector<Site>& of_sites = {}) const {
        std::vector<float> all;
        for (const dermis_skin& s : skins_) {
            Skin::Response r = s.skin.response(q);
            if (doors_.in_c) need(dermis_skin_get_response(&s, int(q), &r.data, &r.size));
            all.insert(all.end(), r.begin(), r.end());
        }
        if (of_sites.empty() || !drawn_.skin.sites.empty()) return all;
        std::vector<float> some;
        for (size_t pad = 0; pad < fresh_.size(); ++pad)
            for (const Site& site : of_sites)
                if (site.type == q || q == Quantity::strain)
                    some.push_back(
                        all[pad * drawn_.cells() + size_t(site.cell.y * drawn_.skin.grid.width + site.cell.x)]);
        return some;
    }
    Bytes state(int pad) const { return alone_ ? saved(skins_[size_t(pad)].skin) : saved(skin(), Pads(&pad, 1)); }
    double greatest_strain(int pad) const {
        return (alone_ ? skins_[size_t(pad)].skin.report() : skin().report(pad)).strain.value;
    }

    // Returns the spikes of the call, as press_frames() of a batch gives them.
    std::vector<Spike> take(const Call& call) {
        std::vector<Spike> spikes;
        switch (call.kind) {
        case Call::reset: reset(call); break;
        case Call::keep:
            if (doors_.keep) keep(call);
            return {}; // responses come with the next press
        case Call::carry: carry(call); return {};
        case Call::material: set_material(call); return {};
        case Call::refused: refuse(call); return {};
        default:
            if (by_touch(call)) {
                if (doors_.in_c) need(dermis_skin_press_touch(&skins_[0], call.contacts, call.dt[0]));
                else skins_[0].skin.press(call.contacts->touch, call.dt[0]);
                append(spikes, skins_[0], 0, 0);
            } else each_part(call, [&](const Part& p) { press(call, p, spikes); });
            std::ranges::stable_sort(spikes, {}, &Spike::frame);
        }
        for (int pad : call.pads) fresh_[size_t(pad)] = true;
        return spikes;
    }

  private:
    Skin made(int pad) const {
        SkinOptions own = drawn_.options;
        if (alone_) own.count = 1;
        if (alone_ && !own.materials.empty()) own.materials = {own.materials[size_t(pad)]};
        return Skin(device_, drawn_.skin, own);
    }

    bool by_touch(const Call& call) const { return call.kind == Call::touch && doors_.touch && !alone_; }

    template <class F> void each_part(const Call& call, F f) {
        const auto part = [&](int skin, const Pads& pads, const dermis_pads* in_c, size_t first, size_t count) {
            dermis_skin& handle = skins_[size_t(skin)];
            f(Part{handle, handle.skin, pads, in_c, first, count});
        };
        const dermis_pads list{call.pads.data(), call.pads.size()};
        if (!alone_)
            return part(0, call.all ? Pads() : Pads(call.pads), call.all ? nullptr : &list, 0, call.pads.size());
        for (size_t i = 0; i < call.pads.size(); ++i) part(call.pads[i], Pads(), nullptr, i, 1);
    }

    // A part's numbers, one pad after another, of each of some groups: frames, or axes.
    static std::vector<float> share(const std::vector<float>& all, size_t groups, const Call& call, const Part& p) {
        const size_t pads = call.pads.size(), cells = pads ? all.size() / groups / pads : 0;
        std::vector<float> own;
        for (size_t g = 0; g < groups; ++g) {
            const auto first = all.begin() + std::ptrdiff_t((g * pads + p.first) * cells);
            own.insert(own.end(), first, first + std::ptrdiff_t(p.count * cells));
        }
        return own;
    }

    // These numbers, or the memory of the response that holds them already.
    const float* source(const Call& call, const Part& p, std::optional<Quantity> q,
                        const std::vector<float>& numbers) const {
        static const float none = 0; // for the numbers of no pad
        const bool there = q && call.kind == Call::own && doors_.own && fresh() && (!alone_ || count() == 1);
        return numbers.empty() ? &none : there ? p.skin.response(*q).data : numbers.data();
    }

    void press(const Call& call, const Part& p, std::vector<Spike>& spikes) {
        const std::vector<float> numbers = share(call.pressure, call.count, call, p),
                                 tractions = share(call.traction, 2, call, p);
        const size_t each = numbers.size() / call.count;
        const float* const from = source(call, p, call.source, numbers);
        const int pad = alone_ ? call.pads[p.first] : 0;
        const bool c = doors_.in_c;
        const double dt = call.dt[0];
        if (call.kind == Call::cells && doors_.cells) {
            const std::vector<float> cells = share(call.of_cells, 1, call, p);
            if (c) need(dermis_skin_press_cells(&p.handle, cells.data(), cells.size(), dt, p.in_c));
            else p.skin.press_cells(cells.data(), cells.size(), dt, p.pads);
        } else if (call.sheared) {
            const float* const along = source(call, p, call.source_of_traction, tractions);
            if (c) need(dermis_skin_press_tractions(&p.handle, from, along, each, dt, p.in_c));
            else p.skin.press(from, along, each, dt, p.pads);
        } else if (call.dt.size() > 1) {
            const double* const steps = &call.dt[p.first];
            if (c) need(dermis_skin_press(&p.handle, from, each, steps, p.count, p.in_c));
            else p.skin.press(from, each, steps, p.count, p.pads);
        } else if (doors_.frames && (call.kind == Call::frames || call.kind == Call::own)) {
            if (c) need(dermis_skin_press_frames(&p.handle, from, call.count, each, dt, p.in_c));
            else p.skin.press_frames(from, call.count, each, dt, p.pads);
        } else {
            for (size_t f = 0; f < call.count; ++f) {
                const float* const one = (f ? numbers.data() : from) + f * each;
                if (c) need(dermis_skin_press(&p.handle, one, each, &dt, 1, p.in_c));
                else p.skin.press(one, each, dt, p.pads);
                if (f + 1 < call.count) append(spikes, p.handle, pad, int(f));
            }
            return append(spikes, p.handle, pad, int(call.count) - 1);
        }
        append(spikes, p.handle, pad, 0);
    }

    void append(std::vector<Spike>& to, const dermis_skin& s, int pad, int frame) const {
        const Skin::Spikes fired = s.skin.spikes();
        const dermis_spike* in_c = nullptr;
        size_t count = fired.size;
        if (doors_.in_c) need(dermis_skin_get_spikes(&s, &in_c, &count));
        for (size_t i = 0; i < count; ++i) {
            const Spike one = in_c ? Spike{in_c[i].pad, in_c[i].afferent, in_c[i].frame, in_c[i].share} : fired[i];
            to.push_back({one.pad + pad, one.afferent, one.frame + frame, one.share});
        }
    }

    // The plain way takes new skins: a pad that is reset answers as a new one.
    void reset(const Call& call) {
        const bool plain = alone_ && device_.impl().backend->threads() == 1;
        for (int pad : plain ? call.pads : std::vector<int>()) skins_[size_t(pad)].skin = made(pad);
        if (plain) return;
        each_part(call, [&](const Part& p) {
            if (doors_.in_c) need(dermis_skin_reset(&p.handle, p.in_c));
            else p.skin.reset(p.pads);
        });
    }

    // Goes on from bytes: in another skin, after a reset, or after presses that are taken back.
    void keep(const Call& call) {
        for (size_t i = 0; i < skins_.size(); ++i) {
            Skin& skin = skins_[i].skin;
            Bytes state = saved(skin);
            if (doors_.in_c) {
                std::ranges::fill(state, 0xcd);
                need(dermis_skin_save(&skins_[i], state.data(), state.size(), nullptr));
            }
            if (call.variant == 0) skin = made(int(i));
            else if (call.variant == 1) skin.reset();
            else {
                const std::vector<float> other(size_t(skin.count()) * drawn_.cells(), 1e3f);
                const std::vector<float> along(2 * other.size(), -70.0f);
                if (drawn_.options.shear) skin.press(other.data(), along.data(), other.size(), 1e-3);
                else skin.press(other, 1e-3);
            }
            if (doors_.in_c) need(dermis_skin_load(&skins_[i], state.data(), state.size(), nullptr));
            else skin.load(state.data(), state.size());
        }
        fresh_.assign(fresh_.size(), false);
    }

    // States go from pads to other pads.
    void carry(const Call& call) {
        if (!alone_) {
            const Bytes state = saved(skin(), call.pads);
            skins_[0].skin.load(state.data(), state.size(), call.to);
            return;
        }
        std::vector<Bytes> states;
        for (int pad : call.pads) states.push_back(state(pad));
        for (size_t i = 0; i < call.to.size(); ++i)
            skins_[size_t(call.to[i])].skin.load(states[i].data(), states[i].size());
    }

    void set_material(const Call& call) {
        each_part(call, [&](const Part& p) { p.skin.set_material(call.given, p.pads); });
        drawn_.give(call.given, call.pads);
    }

    // A call that is refused, of a batch: each skin's state keeps every byte.
    void refuse(const Call& call) {
        if (alone_ && count() > 1) return;
        Skin& skin = skins_[0].skin;
        const Bytes before = saved(skin);
        const Pads pads = call.all ? Pads() : Pads(call.pads);
        const size_t each = call.pressure.size() / call.count;
        CHECK_THROWS_AS(
            [&] {
                if (call.sheared) return skin.press(call.pressure.data(), call.traction.data(), each, call.dt[0], pads);
                if (!call.of_cells.empty())
                    return skin.press_cells(call.of_cells.data(), call.of_cells.size(), call.dt[0], pads);
                if (call.count > 1) return skin.press_frames(call.pressure.data(), call.count, each, call.dt[0], pads);
                if (call.dt.size() > 1)
                    return skin.press(call.pressure.data(), each, call.dt.data(), call.dt.size(), pads);
                skin.press(call.pressure.data(), each, call.dt[0], pads);
            }(),
            Error);
        CHECK_MESSAGE(saved(skin) == before, name_, " has another state after a call that it refused");
    }

    std::string name_;
    Device device_;
    DrawnSkin drawn_;
    bool alone_;
    Doors doors_;
    std::vector<bool> fresh_;
    std::vector<dermis_skin> skins_;
};

} // namespace test
