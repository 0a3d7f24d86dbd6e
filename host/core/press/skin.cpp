// SPDX-License-Identifier: MIT
// dermis::Skin: frames in, responses out, on the CPU or on a device.
#include "host/core/base/finite.hpp"
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/base/watch.hpp"
#include "host/core/model/felt.hpp"
#include "host/core/press/device.hpp"
#include "host/core/press/report.hpp"
#include "host/core/press/saved_state.hpp"
#include "host/core/press/shear.hpp"
#include "host/core/press/spiking.hpp"
#include "host/core/press/touch.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace dermis {

struct Skin::Impl {
    // Copies the numbers that it needs, so that the maps of the prepared skin are freed once the stream has read them.
    Impl(const plan::StreamedSkin& skin, const SkinOptions& options, plan::Backend& backend)
        : width(size_t(skin.skin.width())), height(size_t(skin.skin.height())), count(size_t(skin.pads)),
          fields(skin.skin.description.sites.empty()), uniform(skin.skin.uniform()), wanted(skin.wanted),
          chain(skin.skin.chain), state_layout(state_layout_of(skin)), felt(skin), spiking(skin, backend),
          shear(skin, options, backend), saved_state(skin, spiking.state_bytes(), shear.state_bytes()),
          needs(scene::needs_of(skin.skin.description, options)), threads(backend.threads()),
          tau(tau_range(skin.skin.materials)), description(skin.skin.description), materials(options.materials),
          bent(skin.hold == Hold::parabolic), depth(options.control == Control::depth), last_steps(count),
          pressed(count), strains(depth ? count * cells() : 0), stream(backend.stream(skin)),
          progress(options.progress) {
        listed.reserve(count);
        if (spiking.any() || shear.any()) stream->reserve_states();
        for (const Site& site : description.sites) ++sites_of[size_t(site.type)];
        if (!fields) read = plan::SiteCells(skin.skin, {skin.skin.whole()}, plan::cells_of(description.sites)).cells;
        if (description.surface.kind == Surface::Kind::map) {
            gain_at_rest = gain_of(skin.skin);
            if (fields) rest_curvature = rest_curvature_of(skin.skin);
        }
        if (!description.surface.curvature.empty()) description.surface.ridge_period.reset(); // see cells_per_ridge()
        description.surface.map = description.surface.curvature = {};
        scene::drop_maps(description.material);
        description.sites.clear();
    }

    // Adds to the report what the curvature under a strain of every cell does: the gain, and the responses that change
    // sign.
    void bend(Report& report, const plan::PreparedSkin& skin, size_t pad, const std::vector<double>& strain) const {
        const f64::Constants& c = skin.constants;
        const Grid unit = plan::without_spacing(skin.description.grid);
        const std::vector<double> L = plan::laplacian(strain, unit, skin.stencil, skin.edges);
        plan::Wanted changed{};
        std::vector<double> rest(width);
        for (size_t y = 0, i = 0; y < height; ++y) {
            plan::rest_curvature_row(skin, int(y), 0, int(width), rest.data());
            for (size_t x = 0; x < width; ++x, ++i) {
                const double bent = c.curvature_length * f64::curvature_of(rest[x], L[i], c.bend);
                report.gain.value = std::max(report.gain.value, std::abs(bent));
                if (1 + bent >= 0) continue;
                for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
                    if (wanted[q]) changed[q] |= stream->response(Quantity(q))[pad * cells() + y * width + x] != 0;
            }
        }
        for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
            if (changed[q]) report.sign_changed.push_back(Quantity(q));
    }

    static std::vector<float> rest_curvature_of(const plan::PreparedSkin& skin) {
        std::vector<float> rest;
        std::vector<double> row(size_t(skin.width()));
        for (int y = 0; y < skin.height(); ++y) {
            plan::rest_curvature_row(skin, y, 0, skin.width(), row.data());
            for (double C : row) rest.push_back(float(C));
        }
        return rest;
    }

    static double gain_of(const plan::PreparedSkin& skin) {
        return std::abs(skin.constants.curvature_length) * greatest_rest_curvature(skin);
    }

    const size_t width, height, count; // count: of pads
    std::vector<size_t> read;          // the cells that sites read; empty without sites
    const bool fields, uniform;        // uniform: a pad's cells have the same elements
    const plan::Wanted wanted;
    const plan::Chain chain;
    const plan::StateLayout state_layout; // of one pad
    const plan::Felt felt;
    Spiking spiking;
    Shear shear;
    const SavedState saved_state;
    const std::string needs; // words for the message if memory runs out
    const int threads;
    const scene::TauRange tau;                   // of all cells, where they differ
    std::array<size_t, REDUCED_MAPS> sites_of{}; // of each class, in a pad
    SkinDescription description;                 // without maps and sites
    std::vector<Material> materials;             // of each pad, where each has its own
    std::optional<double> gain_at_rest;          // of a surface that is a map, which is not kept
    std::vector<float> rest_curvature;           // width*height, once it is needed; kept of a surface that is a map
    std::array<std::vector<float>, 3> told;      // strain, indentation and curvature, once they are asked for
    const bool bent;                             // under parabolic hold
    const bool depth;                            // presses take depths
    std::vector<float> taken;                    // copies of the frames of a call
    std::vector<char> before;                    // the state before a frame that progress may end
    std::vector<double> last_steps;              // of each pad, s; 0: none, or not known
    std::vector<uint64_t> pressed;               // of each pad: the number of the last list that names it
    uint64_t lists = 0;
    std::vector<float> strains;                // of a frame of depths
    std::array<std::vector<float>, 3> stretch; // its components, of all pads, once they are asked for
    std::vector<int> listed;                   // the pads of a call: those of its list, or that a Touch moves
    std::vector<double> steps_of_pads;         // of a press with a step for each pad, s
    std::unique_ptr<plan::Stream> stream;
    const scene::Watch::Progress progress; // SkinOptions::progress
    bool pressing = false;

    // A press, in which each look() calls progress.
    struct Press {
        explicit Press(Impl& s) : skin(s), watch(s.progress, {}) { skin.pressing = true; }
        ~Press() { skin.pressing = false; }
        Impl& skin;
        const scene::Watch watch;
    };
    size_t cells() const { return width * height; }
    plan::PadList list_of(const Pads&);
    // The steps of a press, with those before them.
    plan::StepLengths steps(const double* dt, bool each = false) {
        return {.dt = dt, .each = each, .before = last_steps.data(), .bent = bent};
    }
    // Throws Error::bad_input for a step, or a number of pressures, that no press takes.
    void need_press(size_t numbers, const plan::StepLengths&, const plan::PadList&, size_t cells_of_pad) const;
    void press(const float* pressure, size_t numbers, const plan::StepLengths&, const plan::PadList&,
               const float* traction = nullptr);
    void need_shear(bool given) const;
    void need_touch(const contact::Touch::Impl&) const;
    void press(const contact::Touch::Impl&, const plan::StepLengths&);
    void to_strains(const float* depths, size_t count, float* to) const;
    // Returns what the stream takes: the numbers, or the strains of depths.
    const float* to_take(const float* numbers, size_t count) {
        if (depth) to_strains(numbers, count, strains.data());
        return depth ? strains.data() : numbers;
    }
    bool prepare(const plan::PadList&, const plan::StepLengths&, size_t frames = 1);
    void step(const plan::PadList&, const plan::StepLengths&, size_t frame = 0, bool last = true);
    void save(const plan::PadList&, const plan::StateMemory<char>&);
    void load(const plan::PadList&, const plan::StateMemory<const char>&);
    void take_frames(const plan::PadList&, const float*, size_t count, size_t numbers);
    void press_frames(const plan::PadList&, const float*, size_t count, size_t numbers, const plan::StepLengths&);
    void clear_unread(char* pressure) const;
    std::vector<float> strain_of(int pad) const;
    const std::vector<float>& tell(Quantity);
    // cells: the cells whose pressures are given; empty where the pressures of all cells are given.
    [[noreturn]] void refuse_pressure(const float* pressure, const plan::PadList&, size_t frames = 1,
                                      const std::vector<size_t>& cells = {}, const char* argument = "pressure") const;
    const Material& material_of(int pad) const {
        return materials.empty() ? description.material : materials[size_t(pad)];
    }
};

// Throws Error::bad_input if a number is no pad's or occurs twice, or where progress calls in a press.
plan::PadList Skin::Impl::list_of(const Pads& pads) {
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

void Skin::Impl::need_press(size_t numbers, const plan::StepLengths& dt, const plan::PadList& pads,
                            size_t cells_of_pad) const {
    // Only on failure: need_not_negative() builds its message first, which allocates.
    for (size_t i = 0; i < (dt.each ? pads.count : 1); ++i)
        if (!finite(dt[i]) || dt[i] < 0) scene::need_not_negative("dt", dt[i]);
    if (numbers != pads.count * cells_of_pad)
        scene::refuse("pressure", std::to_string(numbers) + " cells",
                      (count > 1 ? std::to_string(pads.count) + " pads of " : "") +
                          (cells_of_pad == cells() ? "width*height = " + std::to_string(cells()) + ", row 0 first"
                                                   : std::to_string(cells_of_pad) + ", as cells() lists them"));
}

// Throws Error::bad_input where a press has tractions and the skin no shear, or the other way round.
void Skin::Impl::need_shear(bool given) const {
    if (given != shear.any())
        scene::refuse("traction", given ? "(given)" : "(not given)",
                      given ? "none: the skin was made without shear" : "tractions: the skin was made with shear");
}

void Skin::Impl::press(const float* pressure, size_t numbers, const plan::StepLengths& dt, const plan::PadList& pads,
                       const float* traction) {
    need_shear(traction);
    need_press(numbers, dt, pads, cells());
    if (!stream->take(pads, to_take(pressure, numbers))) refuse_pressure(pressure, pads);
    if (traction && !shear.take(pads, traction)) refuse_pressure(traction, pads, 2, {}, "traction");
    const Press pressed(*this);
    step(pads, dt);
}

// Throws Error::bad_input for a Touch of other pads.
void Skin::Impl::need_touch(const contact::Touch::Impl& touch) const {
    if (depth) scene::refuse("touch", "pressures", "none with control = depth, where a press takes depths");
    const contact::Pad& pad = touch.shape;
    const auto shape = [](size_t pads, size_t w, size_t h) {
        return std::to_string(pads) + " pads of " + std::to_string(w) + " x " + std::to_string(h) + " cells";
    };
    if (size_t(touch.count) != count || size_t(pad.width) != width || size_t(pad.height) != height)
        scene::refuse("touch", shape(size_t(touch.count), size_t(pad.width), size_t(pad.height)),
                      shape(count, width, height));
    need_shear(!touch.traction.empty());
    const std::optional<double> spacing = description.grid.spacing;
    if (spacing && std::abs(*spacing - pad.spacing) > 1e-6 * pad.spacing)
        scene::refuse("touch.spacing", shortest(pad.spacing), shortest(*spacing) + " m, as the skin has it");
}

// Presses the pads that a Touch moves; fibres step in all pads.
void Skin::Impl::press(const contact::Touch::Impl& touch, const plan::StepLengths& dt) {
    const plan::PadList all = list_of({});
    need_press(count * cells(), dt, all, cells());
    if (spiking.any()) listed.resize(count), std::iota(listed.begin(), listed.end(), 0);
    else {
        listed.clear();
        for (size_t pad = 0; pad < count; ++pad)
            if (touch.touches[pad] || !stream->rests(int(pad)) || !shear.rests(int(pad))) listed.push_back(int(pad));
    }
    const plan::PadList pads{.ids = listed.data(), .count = listed.size()};
    (void)stream->take(pads, touch.pressure.data(), true); // true: a Touch has finite pressures
    if (shear.any()) (void)shear.take(pads, touch.traction.data(), true);
    const Press pressed(*this);
    step(pads, dt);
    dt.taken(all);
}

// Does all of a press of so many frames that can fail, before a state changes. Returns whether progress may end a
// frame, because fibres take several blocks of substeps. Throws Error::bad_input for a step that no press takes.
bool Skin::Impl::prepare(const plan::PadList& pads, const plan::StepLengths& dt, size_t frames) {
    const double* refused_by_fibres = nullptr;
    const bool in_blocks = spiking.prepare(pads, dt, frames, &refused_by_fibres) && progress;
    if (refused_by_fibres)
        scene::refuse("dt", shortest(*refused_by_fibres),
                      "at most 65536 refractory times or shortest time constants of the nerve fibres, and coefficients "
                      "of their steps below 3.4e38");
    // Shear has the greater coefficients: it refuses each step that the pressure refuses.
    const double* refused = shear.prepare(pads, dt);
    if (!refused) refused = stream->prepare(pads, dt);
    if (refused)
        scene::refuse("dt", shortest(*refused), "seconds over which the coefficients of a step stay below 3.4e38");
    if (in_blocks) before.resize(saved_state.bytes(pads.count));
    return in_blocks;
}

// Steps pads to the pressures that they have taken, and their fibres. frame: counts the call's. last: also responses.
// If progress ends the press, the pads keep the state before it.
void Skin::Impl::step(const plan::PadList& pads, const plan::StepLengths& dt, size_t frame, bool last) {
    const bool in_blocks = prepare(pads, dt);
    plan::StateMemory<char> undo{};
    if (in_blocks) save(pads, undo = saved_state.write(before.data(), before.size(), pads.count));
    shear.press(pads, dt);
    stream->press(pads, dt, last);
    try {
        spiking.press(pads, dt, *stream, frame);
    } catch (...) {
        if (in_blocks) load(pads, undo);
        throw;
    }
    dt.taken(pads);
}

// Copies depths as strains. A depth that is not finite, or too great, becomes a strain that is not finite.
void Skin::Impl::to_strains(const float* depths, size_t n, float* to) const {
    const DefaultFloats guard;
    const float thickness = float(*description.material.thickness);
    for (size_t i = 0; i < n; ++i) {
        const float deep = depths[i]; // once: another thread may change it
        to[i] = deep < 0 && finite(double(deep)) ? 0.0f : deep / thickness;
    }
}

// Copies frames to `taken`, some at a time, as strains where they are depths.
void Skin::Impl::take_frames(const plan::PadList& pads, const float* frames, size_t n, size_t numbers) {
    scene::need(n <= taken.max_size() / numbers, "count", double(n), "as many frames as memory holds");
    const size_t all = n * numbers, most = std::max((size_t(1) << 20) / numbers, size_t(1)) * numbers; // about 1 ms
    if (taken.capacity() < all) {
        taken = {};
        taken.reserve(all);
        simd::prefer_large_pages(taken.data(), all * sizeof(float));
    }
    for (size_t i = 0; i < all; i += most) {
        if (i > 0) scene::look();
        const size_t some = std::min(most, all - i);
        taken.resize(std::max(taken.size(), i + some));
        float* to = taken.data() + i;
        if (depth) to_strains(frames + i, some, to);
        if (!(depth ? plan::all_finite(to, some) : stream->copy(frames + i, some, to)))
            refuse_pressure(frames, pads, n);
    }
}

// Presses a copy of the frames, one after another where the stream does not take them together.
void Skin::Impl::press_frames(const plan::PadList& pads, const float* frames, size_t n, size_t numbers,
                              const plan::StepLengths& dt) {
    if (numbers == 0) return step(pads, dt); // of no pad
    const Press pressed(*this);
    take_frames(pads, frames, n, numbers);
    prepare(pads, dt, n);
    constexpr size_t most_numbers = 1 << 26, most_frames = 1024; // about 100 ms
    const bool fires = spiking.any(),
               joined = !fires && stream->joins_frames(); // fibres read the state after each step
    const size_t together = fires ? 1 : progress ? std::clamp(most_numbers / numbers, size_t(1), most_frames) : n;
    for (size_t i = 0, end; i < n; i = end) {
        end = std::min(i + together, n);
        if (i > 0) scene::reach(double(i) / double(n), true);
        const float* at = taken.data() + i * numbers;
        if (joined) {
            (void)stream->prepare(pads, dt); // null: the steps behind the first one were checked with it
            stream->press_frames(pads, at, end - i, numbers, dt);
            dt.taken(pads);
        }
        for (size_t k = joined ? end : i; k < end; ++k, at += numbers) {
            stream->take(pads, at);
            step(pads, dt, k, fires || k + 1 == end);
        }
    }
}

// Copies the states of pads. Pressures of cells that no site reads become 0, so that equal skins have equal states,
// whatever pressed them.
void Skin::Impl::save(const plan::PadList& list, const plan::StateMemory<char>& to) {
    stream->save(list, to);
    for (size_t i = 0; !fields && i < list.count; ++i) clear_unread(to.pressure_of(i));
    for (size_t i = 0; to.steps && i < list.count; ++i)
        std::memcpy(to.steps + i * sizeof(double), &last_steps[size_t(list[i])], sizeof(double));
    for (size_t i = 0; to.fibres && i < list.count; ++i) spiking.save(list[i], to.fibres + i * spiking.state_bytes());
    if (to.shear) shear.save(list, to.shear);
}

void Skin::Impl::load(const plan::PadList& list, const plan::StateMemory<const char>& from) {
    stream->load(list, from);
    if (from.shear) shear.load(list, from.shear);
    for (size_t i = 0; i < list.count; ++i) {
        if (from.steps) std::memcpy(&last_steps[size_t(list[i])], from.steps + i * sizeof(double), sizeof(double));
        if (from.fibres) spiking.load(list[i], from.fibres + i * spiking.state_bytes());
    }
}

// Throws Error::bad_input naming the first cell that is not finite, or none if another thread has changed it since.
void Skin::Impl::refuse_pressure(const float* pressure, const plan::PadList& pads, size_t frames,
                                 const std::vector<size_t>& listed, const char* argument) const {
    const std::string of = argument == std::string_view("traction") ? " of axis " : " of frame ";
    const float thickness = depth ? float(*description.material.thickness) : 1.0f;
    for (size_t k = 0; k < frames * pads.count; ++k)
        for (size_t i = 0, n = listed.empty() ? cells() : listed.size(); i < n; ++i, ++pressure)
            if (!finite(double(*pressure / thickness)))
                scene::refuse(argument,
                              shortest(double(*pressure)) + " in cell " +
                                  scene::cell_text(listed.empty() ? i : listed[i], int(width)) +
                                  (count > 1 ? " of pad " + std::to_string(pads[k % pads.count]) : "") +
                                  (frames > 1 ? of + std::to_string(k / pads.count) : ""),
                              finite(double(*pressure)) ? "depths below 3.4e38 times the thickness" : "finite numbers");
    scene::refuse(argument, "(a number that was not finite)", "finite numbers");
}

// Sets the pressures of a state's cells that no site reads to 0.
void Skin::Impl::clear_unread(char* pressure) const {
    size_t next = 0;
    for (const size_t cell : read) {
        std::memset(pressure + next * sizeof(float), 0, (cell - next) * sizeof(float));
        next = cell + 1;
    }
    std::memset(pressure + next * sizeof(float), 0, (cells() - next) * sizeof(float));
}

// The strain of each cell that a pad's state holds.
std::vector<float> Skin::Impl::strain_of(int pad) const {
    std::vector<float> strains(state_layout.cells * state_layout.planes), pressure(state_layout.pressure);
    stream->save({.ids = &pad, .count = 1}, {.strains = reinterpret_cast<char*>(strains.data()),
                                             .pressure = reinterpret_cast<char*>(pressure.data())});
    std::vector<plan::Element> elements;
    if (uniform) elements = scene::chain_of(material_of(pad));
    return felt.strain(strains.data(), pressure.data(), elements);
}

// Reads strain, indentation or curvature of all pads from their states.
const std::vector<float>& Skin::Impl::tell(Quantity q) {
    if (q == Quantity::curvature && fields && rest_curvature.empty())
        rest_curvature = rest_curvature_of(plan::prepare_skin(description, threads));
    std::vector<float>& all = told[q == Quantity::strain ? 0 : q == Quantity::indentation ? 1 : 2];
    all.resize(count * felt.count());
    for (size_t pad = 0; pad < count; ++pad)
        felt.read(q, strain_of(int(pad)), rest_curvature.data(), all.data() + pad * felt.count());
    return all;
}

Skin::Skin(const Device& device, const SkinDescription& description, const SkinOptions& options) {
    const auto words = [&] { return scene::needs_of(description, options); };
    scene::guarded(words, [&] {
        const DefaultFloats guard;
        Device::Impl& d = device.impl();
        impl_ = std::make_unique<Impl>(plan::streamed_skin(description, without_stretch(options), d.backend->threads()),
                                       options, *d.backend);
        if (!impl_->stream->exact()) d.info.exact = false; // written on Vulkan alone, where one thread uses the device
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
        const plan::PadList list = impl_->list_of(pads);
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
            const DefaultFloats guard;
            const std::vector<float>& all = s.tell(q);
            return {all.data(), all.size()};
        }
        if (q == Quantity::sa2 && s.shear.sa2()) return {s.shear.sa2(), s.count * s.cells()};
        if (s.shear.any() && q >= Quantity::shear_x) {
            const size_t all = s.count * s.cells();
            if (q <= Quantity::shear_y) return {s.shear.strain() + (q == Quantity::shear_y ? all : 0), all};
            std::vector<float>& own = s.stretch[size_t(q) - size_t(Quantity::stretch_x)];
            s.shear.read_stretch(q, own);
            return {own.data(), all};
        }
        if (!scene::is_receptor_class(q) || !s.wanted[size_t(q)])
            scene::refuse("response", std::string("\"") + name(q) + "\"",
                          std::string(s.fields ? "the responses that the skin was made with"
                                               : "the classes of the description's sites") +
                              ", strain, indentation, curvature" +
                              (s.shear.any() ? ", shear_x, shear_y, stretch_x, stretch_y, stretch_xy" : ""));
        const float* data = s.stream->response(q); // throws if the device is lost
        return {data, s.count * (s.fields ? s.cells() : s.sites_of[size_t(q)])};
    });
}

void Skin::press_frames(const float* frames, size_t count, size_t numbers, double dt, const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        Impl& s = *impl_;
        const plan::PadList list = s.list_of(pads);
        const plan::StepLengths steps = s.steps(&dt);
        s.need_press(numbers, steps, list, s.cells());
        s.need_shear(false);
        scene::need(count > 0, "count", count, "at least 1 frame");
        s.press_frames(list, frames, count, numbers, steps);
    });
}

std::vector<int> Skin::cells() const {
    return scene::guarded(impl_->needs, [&]() -> std::vector<int> {
        std::vector<int> all(impl_->read.begin(), impl_->read.end());
        if (!impl_->fields) return all;
        all.resize(impl_->cells());
        std::iota(all.begin(), all.end(), 0);
        return all;
    });
}

void Skin::press_cells(const float* pressure, size_t numbers, double dt, const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        Impl& s = *impl_;
        const plan::PadList list = s.list_of(pads);
        const plan::StepLengths steps = s.steps(&dt);
        if (s.fields) return s.press(pressure, numbers, steps, list);
        s.need_press(numbers, steps, list, s.read.size());
        if (!s.stream->take_cells(list, s.to_take(pressure, numbers), s.read, s.cells()))
            s.refuse_pressure(pressure, list, 1, s.read);
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
        const plan::PadList list = impl_->list_of(pads);
        impl_->stream->reset(list);
        impl_->spiking.reset(list);
        impl_->shear.reset(list);
        for (size_t i = 0; i < list.count; ++i) impl_->last_steps[size_t(list[i])] = 0;
    });
}

size_t Skin::state_bytes(const Pads& pads) const {
    return scene::guarded(impl_->needs, [&] { return impl_->saved_state.bytes(impl_->list_of(pads).count); });
}

void Skin::save(void* state, size_t bytes, const Pads& pads) const {
    scene::guarded(impl_->needs, [&] {
        const plan::PadList list = impl_->list_of(pads);
        impl_->save(list, impl_->saved_state.write(state, bytes, list.count));
    });
}

void Skin::load(const void* state, size_t bytes, const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        const plan::PadList list = impl_->list_of(pads);
        const char* const given = static_cast<const char*>(state);
        const std::vector<char> own(given, given + (given ? bytes : 0)); // the caller's memory may change
        const plan::StateMemory<const char> from =
            impl_->saved_state.read(given ? own.data() : nullptr, bytes, list.count);
        impl_->spiking.need_possible(from.fibres, list.count);
        for (size_t i = 0; i < list.count; ++i) impl_->last_steps[size_t(list[i])] = 0; // where the state has none
        impl_->load(list, from);
    });
}

void Skin::set_material(const Material& material, const Pads& pads) {
    scene::guarded(impl_->needs, [&] {
        const DefaultFloats guard;
        Impl& s = *impl_;
        const plan::PadList list = s.list_of(pads);
        if (s.depth)
            scene::refuse("material", "(given)", "none with control = depth, where the strain follows from the depth");
        plan::need_new_material(s.uniform, !s.materials.empty(), list.count, s.count);
        const std::vector<plan::Element> elements =
            plan::elements_of_pad(s.description, material, s.chain, s.wanted, "material");
        Material taken = s.description.material; // Copies come first: they allocate, and the rest does not.
        scene::take_elements(taken, material);
        std::vector<Material> copies(s.materials.empty() ? 0 : list.count, material);
        s.shear.set_elements(list, elements); // first: it copies them
        s.stream->set_elements(list, elements);
        s.spiking.set_elements(list, elements);
        if (copies.empty()) s.description.material = std::move(taken);
        for (size_t i = 0; i < copies.size(); ++i) s.materials[size_t(list[i])] = std::move(copies[i]);
    });
}

Report Skin::report(int pad) const {
    return scene::guarded(impl_->needs, [&] {
        const DefaultFloats guard;
        const Impl& s = *impl_;
        scene::need(pad >= 0 && size_t(pad) < s.count, "pad", pad, "0.." + std::to_string(s.count - 1));
        SkinDescription own = s.description;
        scene::take_elements(own.material, s.material_of(pad));
        std::optional<plan::PreparedSkin> skin;
        if (!s.gain_at_rest) skin = plan::prepare_skin(own, s.threads);
        std::vector<plan::Element> elements;
        if (s.uniform) elements = scene::chain_of(own.material);
        Report report = report_of(own, s.uniform ? tau_range(elements) : s.tau, scene::cells_per_ridge(own),
                                  skin ? Impl::gain_of(*skin) : *s.gain_at_rest);
        if (const double dt = s.last_steps[size_t(pad)]; dt > 0 && !s.bent)
            report.vibration.value = vibration_between(dt);
        const std::vector<float> strain = s.strain_of(pad);
        report.strain.value = 0;
        for (float eps : strain) report.strain.value = std::max(report.strain.value, double(std::abs(eps)));
        if (skin && s.fields) s.bend(report, *skin, size_t(pad), {strain.begin(), strain.end()});
        if (own.grid.spacing) report.indentation.value = report.strain.value * own.material.thickness.value_or(0);
        return report;
    });
}

} // namespace dermis
