// SPDX-License-Identifier: MIT
// dermis::Skin: frames in, responses out, on the CPU or on a device.
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/base/watch.hpp"
#include "host/core/contact/touch.hpp"
#include "host/core/press/device.hpp"
#include "host/core/press/report.hpp"
#include "host/core/press/saved_state.hpp"
#include "host/core/press/shear.hpp"
#include "host/core/press/source.hpp"
#include "host/core/press/spiking.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dermis {

struct Skin::Impl {
    // Copies the numbers that it needs, so that the maps of the prepared skin are freed once the stages have read them.
    Impl(const model::StreamedSkin& skin, const SkinOptions& options, model::Backend& backend, std::string words)
        : count(size_t(skin.pads)), uniform(skin.skin.uniform()), wanted(skin.wanted), chain(skin.skin.chain),
          source(skin, options), shear(skin, options, backend), cells(skin, backend), spiking(skin, backend, cells),
          last_steps(skin), saved_state(skin, last_steps, spiking, shear), needs(std::move(words)),
          threads(backend.threads()), tau(tau_range(skin.skin.materials)), description(skin.skin.description),
          materials(options.materials), pressed(count), progress(options.progress) {
        listed.reserve(count);
        if (spiking.any() || shear.any()) cells.stream().reserve_states();
        if (description.surface.kind == Surface::Kind::map) {
            gain_at_rest = gain_of(skin.skin);
            if (cells.read().empty()) rest_curvature = rest_curvature_of(skin.skin);
        }
        if (!description.surface.curvature.empty()) description.surface.ridge_period.reset(); // see cells_per_ridge()
        description.surface.map = description.surface.curvature = {};
        scene::drop_maps(description.material);
        description.sites.clear();
    }

    // Adds to the report what the curvature under a strain of every cell does: the gain, and the responses that change
    // sign.
    void bend(Report& report, const model::PreparedSkin& skin, size_t pad, const std::vector<double>& strain) {
        const f64::Constants& c = skin.constants;
        const Grid unit = model::without_spacing(skin.description.grid);
        const std::vector<double> L = model::laplacian(strain, unit, skin.stencil, skin.edges);
        model::Wanted changed{};
        const size_t width = size_t(skin.width());
        std::vector<double> rest(width);
        for (size_t y = 0, i = 0; y < size_t(skin.height()); ++y) {
            model::rest_curvature_row(skin, int(y), 0, int(width), rest.data());
            for (size_t x = 0; x < width; ++x, ++i) {
                const double bent = c.curvature_length * f64::curvature_of(rest[x], L[i], c.bend);
                report.gain.value = std::max(report.gain.value, std::abs(bent));
                if (1 + bent >= 0) continue;
                for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
                    if (wanted[q]) changed[q] |= cells.stream().response(Quantity(q))[pad * cells.count() + i] != 0;
            }
        }
        for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
            if (changed[q]) report.sign_changed.push_back(Quantity(q));
    }

    static std::vector<float> rest_curvature_of(const model::PreparedSkin& skin) {
        std::vector<float> rest;
        std::vector<double> row(size_t(skin.width()));
        for (int y = 0; y < skin.height(); ++y) {
            model::rest_curvature_row(skin, y, 0, skin.width(), row.data());
            for (double C : row) rest.push_back(float(C));
        }
        return rest;
    }

    static double gain_of(const model::PreparedSkin& skin) {
        return std::abs(skin.constants.curvature_length) * greatest_rest_curvature(skin);
    }

    const size_t count; // of pads
    const bool uniform; // a pad's cells have the same elements
    const model::Wanted wanted;
    const model::Chain chain;
    Source source;
    Shear shear;
    PressedCells cells;
    Spiking spiking;
    LastSteps last_steps;
    Stage* const stages[4] = {&shear, &cells, &spiking, &last_steps}; // in the order of a press
    const SavedState saved_state;
    const std::string needs; // words for the message if memory runs out
    const int threads;
    const scene::TauRange tau;          // of all cells, where they differ
    SkinDescription description;        // without maps and sites
    std::vector<Material> materials;    // of each pad, where each has its own
    std::optional<double> gain_at_rest; // of a surface that is a map, which is not kept
    std::vector<float> rest_curvature;  // width*height, once it is needed; kept of a surface that is a map
    std::vector<char> before;           // the state before a press that progress may end
    std::vector<uint64_t> pressed;      // of each pad: the number of the last list that names it
    uint64_t lists = 0;
    std::vector<int> listed;               // the pads of a call: those of its list, or that a Touch moves
    std::vector<double> steps_of_pads;     // of a press with a step for each pad, s
    const scene::Watch::Progress progress; // SkinOptions::progress
    bool pressing = false;

    // A press, in which each look() calls progress.
    struct Press {
        explicit Press(Impl& s) : skin(s), watch(s.progress, {}) { skin.pressing = true; }
        ~Press() { skin.pressing = false; }
        Impl& skin;
        const scene::Watch watch;
    };

    // Throws Error::bad_input if a number is no pad's or occurs twice, or where progress calls in a press.
    model::PadList list_of(const Pads& pads) {
        if (pressing) scene::refuse("skin", "(in a press, which calls progress)", "another skin");
        if (pads.all) return {.count = count};
        ++lists;
        listed.clear();
        for (size_t i = 0; i < pads.count; ++i) {
            const int pad = pads.numbers[i]; // once: another thread may change it
            if (pad < 0 || size_t(pad) >= count || pressed[size_t(pad)] == lists)
                scene::refuse("pads", std::to_string(pad) + " at position " + std::to_string(i),
                              "0.." + std::to_string(count - 1) + ", each at most once");
            pressed[size_t(pad)] = lists;
            listed.push_back(pad);
        }
        return {.ids = listed.data(), .count = pads.count};
    }

    model::StepLengths steps(const double* dt, bool each = false) { return last_steps.of(dt, each); }
    void press(const float* pressure, size_t numbers, const model::StepLengths& dt, const model::PadList& pads,
               const float* traction = nullptr) {
        need_shear(traction);
        source.need(numbers, dt, pads, cells.count());
        source.take(cells, pads, pressure, numbers);
        if (traction && !shear.take(pads, traction)) source.refuse("traction", traction, pads, 2);
        const Press pressed(*this);
        step(pads, dt);
    }

    // Throws Error::bad_input where a press has tractions and the skin no shear, or the other way round.
    void need_shear(bool given) const {
        if (given != shear.any())
            scene::refuse("traction", given ? "(given)" : "(not given)",
                          given ? "none: the skin was made without shear" : "tractions: the skin was made with shear");
    }

    // Throws Error::bad_input for a Touch of other pads.
    void need_touch(const contact::Touch::Impl& touch) const {
        if (source.depths())
            scene::refuse("touch", "pressures", "none with control = depth, where a press takes depths");
        const contact::Pad& pad = touch.shape;
        const auto shape = [](size_t pads, size_t w, size_t h) {
            return std::to_string(pads) + " pads of " + std::to_string(w) + " x " + std::to_string(h) + " cells";
        };
        const size_t width = size_t(description.grid.width), height = size_t(description.grid.height);
        if (size_t(touch.count) != count || size_t(pad.width) != width || size_t(pad.height) != height)
            scene::refuse("touch", shape(size_t(touch.count), size_t(pad.width), size_t(pad.height)),
                          shape(count, width, height));
        need_shear(!touch.traction.empty());
        const std::optional<double> spacing = description.grid.spacing;
        if (spacing && std::abs(*spacing - pad.spacing) > 1e-6 * pad.spacing)
            scene::refuse("touch.spacing", shortest(pad.spacing), shortest(*spacing) + " m, as the skin has it");
    }

    // Presses the pads that a Touch moves; fibres step in all pads.
    void press(const contact::Touch::Impl& touch, const model::StepLengths& dt) {
        const model::PadList all = list_of({});
        source.need(count * cells.count(), dt, all, cells.count());
        listed.clear();
        for (int pad = 0; size_t(pad) < count; ++pad)
            if (spiking.any() || touch.pressed[size_t(pad)].height > 0 ||
                !std::ranges::all_of(stages, [pad](Stage* s) { return s->rests(pad); }))
                listed.push_back(pad);
        const model::PadList pads{.ids = listed.data(), .count = listed.size()};
        (void)cells.stream().take(pads, touch.pressure.data(), true); // true: a Touch has finite pressures
        if (shear.any()) (void)shear.take(pads, touch.traction.data(), true);
        const Press pressed(*this);
        step(pads, dt);
        last_steps.press(all, dt);
    }

    // Does all of so many presses that can fail, before a state changes. Throws Error::bad_input for a step that no
    // press takes.
    void prepare(const model::PadList& pads, const model::StepLengths& dt, size_t presses = 1) {
        for (Stage* s : stages) s->prepare(pads, dt, presses);
        if (progress && spiking.in_blocks()) before.resize(saved_state.bytes(pads.count));
    }

    // Steps pads to the pressures that they have taken, and their fibres. frame: counts the call's. last: also
    // responses. If progress ends the press, the pads keep the state before it.
    void step(const model::PadList& pads, const model::StepLengths& dt, size_t frame = 0, bool last = true) {
        prepare(pads, dt);
        const bool may_end = progress && spiking.in_blocks();
        StateParts<char> undo{};
        if (may_end) save(pads, undo = saved_state.write(before.data(), before.size(), pads.count));
        try {
            for (Stage* s : stages) s->press(pads, dt, frame, last);
        } catch (...) {
            if (may_end) load(pads, undo);
            throw;
        }
    }

    void save(const model::PadList& list, const StateParts<char>& to) {
        cells.save_cells(list, to.cells);
        if (to.steps) last_steps.save(list, to.steps);
        if (to.fibres) spiking.save(list, to.fibres);
        if (to.shear) shear.save(list, to.shear);
    }

    void load(const model::PadList& list, const StateParts<const char>& from) {
        cells.stream().load(list, from.cells);
        if (from.steps) last_steps.load(list, from.steps);
        if (from.fibres) spiking.load(list, from.fibres);
        if (from.shear) shear.load(list, from.shear);
    }

    // Presses a copy of the frames, one after another where the stream does not take them together.
    void press_frames(const model::PadList& pads, const float* frames, size_t n, size_t numbers,
                      const model::StepLengths& dt) {
        if (numbers == 0) return step(pads, dt); // of no pad
        const Press pressed(*this);
        const float* at = source.copied(cells, pads, frames, n, numbers);
        prepare(pads, dt, n);
        constexpr size_t most_numbers = 1 << 26, most_frames = 1024; // about 100 ms
        const bool fires = spiking.any(),
                   joined = !fires && cells.stream().joins_frames(); // fibres read the state after each step
        const size_t together = fires ? 1 : progress ? std::clamp(most_numbers / numbers, size_t(1), most_frames) : n;
        for (size_t i = 0, end; i < n; i = end) {
            end = std::min(i + together, n);
            if (i > 0) scene::reach(double(i) / double(n), true);
            if (joined) {
                cells.prepare(pads, dt, 1); // it refuses nothing: the steps behind the first one were checked with it
                cells.stream().press_frames(pads, at, end - i, numbers, dt);
                last_steps.press(pads, dt);
                at += (end - i) * numbers;
            }
            for (size_t k = joined ? end : i; k < end; ++k, at += numbers) {
                cells.stream().take(pads, at);
                step(pads, dt, k, fires || k + 1 == end);
            }
        }
    }

    // Reads strain, indentation or curvature of all pads from their states.
    const std::vector<float>& told(Quantity q) {
        const DefaultFloats guard;
        if (q == Quantity::curvature && cells.read().empty() && rest_curvature.empty())
            rest_curvature = rest_curvature_of(model::prepare_skin(description, threads));
        return cells.told(q, rest_curvature.data());
    }

    const Material& material_of(int pad) const {
        return materials.empty() ? description.material : materials[size_t(pad)];
    }
};

Skin::Skin(const Device& device, const SkinDescription& description, const SkinOptions& options) {
    const auto words = [&] { return scene::needs_of(description, options); };
    scene::guarded(words, [&] {
        const DefaultFloats guard;
        Device::Impl& d = device.impl();
        const auto skin = model::streamed_skin(description, without_stretch(options), d.backend->threads());
        impl_ = std::make_unique<Impl>(skin, options, *d.backend, words());
        if (!d.backend->exact(skin)) d.info.exact = false; // written on Vulkan alone, where one thread uses the device
        d.need_exact();
    });
}

Skin::~Skin() = default;
Skin::Skin(Skin&&) noexcept = default;
Skin& Skin::operator=(Skin&&) noexcept = default;

int Skin::count() const { return int(impl_->count); }

void Skin::press(const float* pressure, size_t cells, double dt, const Pads& pads) {
    scene::guarded(impl_->needs, [&] { impl_->press(pressure, cells, impl_->steps(&dt), impl_->list_of(pads)); });
}

void Skin::press(const float* pressure, size_t cells, const double* dt, size_t steps, const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        const model::PadList list = impl_->list_of(pads);
        if (steps != list.count)
            scene::refuse("dt", std::to_string(steps) + " steps", std::to_string(list.count) + ", one for each pad");
        impl_->steps_of_pads.reserve(impl_->count);
        impl_->steps_of_pads.assign(dt, dt + steps);
        impl_->press(pressure, cells, impl_->steps(impl_->steps_of_pads.data(), true), list);
    });
}

void Skin::press(const float* pressure, const float* traction, size_t cells, double dt, const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        if (!traction) scene::refuse("traction", "(null)", "a pointer");
        impl_->press(pressure, cells, impl_->steps(&dt), impl_->list_of(pads), traction);
    });
}

void Skin::press(const contact::Touch& touch, double dt) {
    scene::guarded(impl_->needs, [&] {
        impl_->need_touch(touch.impl());
        impl_->press(touch.impl(), impl_->steps(&dt));
    });
}

Skin::Response Skin::response(Quantity q) const {
    return scene::guarded(impl_->needs, [&]() -> Skin::Response {
        Impl& s = *impl_;
        if (q == Quantity::strain || q == Quantity::indentation || q == Quantity::curvature) {
            const std::vector<float>& all = s.told(q);
            return {all.data(), all.size()};
        }
        if (const auto response = s.shear.response(q)) return *response;
        if (const auto response = s.cells.response(q)) return *response;
        scene::refuse("response", std::string("\"") + name(q) + "\"",
                      std::string(s.cells.fields() ? "the responses that the skin was made with"
                                                   : "the classes of the description's sites") +
                          ", strain, indentation, curvature" +
                          (s.shear.any() ? ", shear_x, shear_y, stretch_x, stretch_y, stretch_xy" : ""));
    });
}

void Skin::press_frames(const float* frames, size_t count, size_t numbers, double dt, const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        Impl& s = *impl_;
        const model::PadList list = s.list_of(pads);
        const model::StepLengths steps = s.steps(&dt);
        s.source.need(numbers, steps, list, s.cells.count());
        s.need_shear(false);
        scene::need(count > 0, "count", count, "at least 1 frame");
        s.press_frames(list, frames, count, numbers, steps);
    });
}

std::vector<int> Skin::cells() const {
    return scene::guarded(impl_->needs, [&]() -> std::vector<int> {
        const PressedCells& c = impl_->cells;
        std::vector<int> all(c.read().begin(), c.read().end());
        if (!all.empty()) return all;
        all.resize(c.count());
        std::iota(all.begin(), all.end(), 0);
        return all;
    });
}

void Skin::press_cells(const float* pressure, size_t numbers, double dt, const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        Impl& s = *impl_;
        const model::PadList list = s.list_of(pads);
        const model::StepLengths steps = s.steps(&dt);
        if (s.cells.read().empty()) return s.press(pressure, numbers, steps, list);
        s.source.need(numbers, steps, list, s.cells.read().size());
        s.source.take_read(s.cells, list, pressure, numbers);
        const Impl::Press pressed(s);
        s.step(list, steps);
    });
}

Skin::Spikes Skin::spikes() const {
    const std::vector<Spike>& all = impl_->spiking.spikes();
    return {all.data(), all.size()};
}

void Skin::reset(const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        const model::PadList list = impl_->list_of(pads);
        for (Stage* s : impl_->stages) s->reset(list);
    });
}

size_t Skin::state_bytes(const Pads& pads) const {
    return scene::guarded(impl_->needs, [&] { return impl_->saved_state.bytes(impl_->list_of(pads).count); });
}

void Skin::save(void* state, size_t bytes, const Pads& pads) const {
    scene::guarded(impl_->needs, [&] {
        const model::PadList list = impl_->list_of(pads);
        impl_->save(list, impl_->saved_state.write(state, bytes, list.count));
    });
}

void Skin::load(const void* state, size_t bytes, const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        const model::PadList list = impl_->list_of(pads);
        const char* const given = static_cast<const char*>(state);
        const std::vector<char> own(given, given + (given ? bytes : 0)); // the caller's memory may change
        const auto from = impl_->saved_state.read(own.empty() ? given : own.data(), bytes, list.count);
        impl_->spiking.need_possible(from.fibres, list.count);
        impl_->last_steps.reset(list); // a state may have none
        impl_->load(list, from);
    });
}

void Skin::set_material(const Material& material, const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        const DefaultFloats guard;
        Impl& s = *impl_;
        const model::PadList list = s.list_of(pads);
        if (s.source.depths())
            scene::refuse("material", "(given)", "none with control = depth, where the strain follows from the depth");
        model::need_new_material(s.uniform, !s.materials.empty(), list.count, s.count);
        const std::vector<model::Element> elements =
            model::elements_of_pad(s.description, material, s.chain, s.wanted, "material");
        Material taken = s.description.material; // Copies come first: they allocate, and the rest does not.
        scene::take_elements(taken, material);
        std::vector<Material> copies(s.materials.empty() ? 0 : list.count, material);
        for (Stage* stage : s.stages) stage->set_elements(list, elements); // the first one alone allocates, first
        if (copies.empty()) s.description.material = std::move(taken);
        for (size_t i = 0; i < copies.size(); ++i) s.materials[size_t(list[i])] = std::move(copies[i]);
    });
}

Report Skin::report(int pad) const {
    return scene::guarded(impl_->needs, [&] {
        const DefaultFloats guard;
        Impl& s = *impl_;
        scene::need(pad >= 0 && size_t(pad) < s.count, "pad", pad, "0.." + std::to_string(s.count - 1));
        SkinDescription own = s.description;
        scene::take_elements(own.material, s.material_of(pad));
        std::optional<model::PreparedSkin> skin;
        if (!s.gain_at_rest) skin = model::prepare_skin(own, s.threads);
        std::vector<model::Element> elements;
        if (s.uniform) elements = scene::chain_of(own.material);
        Report report = report_of(own, s.uniform ? tau_range(elements) : s.tau, scene::cells_per_ridge(own),
                                  skin ? Impl::gain_of(*skin) : *s.gain_at_rest);
        if (const double dt = s.last_steps.frame_of(pad); dt > 0) report.vibration.value = vibration_between(dt);
        PressedCells::States state;
        s.cells.read({.ids = &pad, .count = 1}, state);
        const std::vector<float>&strain = state.strains, &pressure = state.pressures;
        if (s.cells.read().empty()) report.fine_load.value = fine_load_of(own, {pressure.begin(), pressure.end()});
        report.strain.value = 0;
        for (float eps : strain) report.strain.value = std::max(report.strain.value, double(std::abs(eps)));
        if (skin && s.cells.fields()) s.bend(report, *skin, size_t(pad), {strain.begin(), strain.end()});
        if (own.grid.spacing) report.indentation.value = report.strain.value * own.material.thickness.value_or(0);
        return report;
    });
}

} // namespace dermis
