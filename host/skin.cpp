// SPDX-License-Identifier: MIT
// dermis::Skin: frames in, responses out, on the CPU or on a device.
#include "host/device.hpp"
#include "host/plan/float_environment.hpp"
#include "host/plan/laplacian.hpp"
#include "host/plan/site_cells.hpp"
#include "host/report.hpp"
#include "host/scene/refusal.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace dermis {

namespace {

// What a saved state begins with.
struct StateHeader {
    char magic[8];
    uint32_t version, width, height, cells, elements, spring, compensated, integral, rate, sites;
};
static_assert(sizeof(StateHeader) == 48);
constexpr char state_magic[8] = {'d', 'e', 'r', 'm', 'i', 's', 's', 't'};

// FNV-1a of the sites that read cells.
uint32_t hash_of(const std::vector<Site>& sites) {
    uint32_t hash = 2166136261u;
    for (const Site& site : sites)
        for (const int n : {int(site.type), site.cell.x, site.cell.y})
            for (int i = 0; i < 4; ++i) hash = (hash ^ (uint32_t(n) >> (8 * i) & 255)) * 16777619u;
    return sites.empty() ? 0 : hash;
}

StateHeader header_of(const plan::StreamedSkin& skin, const plan::StateLayout& layout) {
    const plan::Variant v = skin.variant();
    StateHeader h{};
    std::memcpy(h.magic, state_magic, sizeof h.magic);
    h.version = 1;
    h.width = uint32_t(skin.skin.width());
    h.height = uint32_t(skin.skin.height());
    h.cells = uint32_t(layout.cells);
    h.elements = uint32_t(v.chain.elements());
    h.spring = v.chain.spring;
    h.compensated = v.compensated;
    h.integral = skin.wanted[QUANTITY_SA2];
    h.rate = v.carries_rate();
    h.sites = hash_of(skin.skin.description.sites);
    return h;
}

// Throws Error::bad_input naming the first thing in which a saved state differs from a skin's.
void check_header(const StateHeader& saved, const StateHeader& own) {
    if (std::memcmp(saved.magic, own.magic, sizeof own.magic) != 0)
        scene::refuse("state", "(other bytes)", "what Skin::save has written");
    const auto need_same = [](const char* what, uint32_t is, uint32_t allowed) {
        if (is != allowed)
            scene::refuse("state", "(" + std::string(what) + " " + std::to_string(is) + ")",
                          std::string(what) + " " + std::to_string(allowed) + ", as the skin has");
    };
    need_same("version", saved.version, own.version);
    need_same("width", saved.width, own.width);
    need_same("height", saved.height, own.height);
    need_same("sites of hash", saved.sites, own.sites);
    need_same("number of cells", saved.cells, own.cells);
    need_same("number of elements", saved.elements, own.elements);
    need_same("number of springs", saved.spring, own.spring);
    need_same("compensated sums", saved.compensated, own.compensated);
    need_same("integral for sa2", saved.integral, own.integral);
    need_same("rate of a spring for fa2", saved.rate, own.rate);
}

// The strain that a state means. springs_: the moduli of springs in series in the cells that it holds; one if they are
// alike, none without springs.
class Strains {
  public:
    explicit Strains(const plan::StreamedSkin& skin) : elements_(skin.skin.chain.elements()) {
        const plan::PreparedSkin& s = skin.skin;
        sums_ = elements_ * (skin.variant().compensated ? 2 : 1);
        if (!s.chain.spring) return;
        std::vector<Cell> at;
        for (const Site& site : s.description.sites) at.push_back(site.cell);
        if (!at.empty()) cells_ = plan::SiteCells(s, {s.whole()}, at).cells;
        const size_t count = s.uniform() ? 1 : cells_.empty() ? s.cells() : cells_.size();
        for (size_t i = 0; i < count; ++i)
            springs_.push_back(s.materials[s.material_at(cells_.empty() ? i : cells_[i]) + elements_].modulus);
    }

    // That of each cell that the state holds.
    std::vector<double> of(const float* state, const plan::StateLayout& layout) const {
        const float* pressure = state + layout.cells * layout.planes;
        std::vector<double> strains(layout.cells);
        for (size_t i = 0; i < layout.cells; ++i) {
            for (size_t e = 0; e < elements_; ++e)
                strains[i] += double(state[e * (sums_ / elements_) * layout.cells + i]);
            if (!springs_.empty())
                strains[i] += double(pressure[cells_.empty() ? i : cells_[i]]) / springs_[springs_.size() == 1 ? 0 : i];
        }
        return strains;
    }

  private:
    size_t elements_, sums_;
    std::vector<size_t> cells_; // that sites read; empty: all
    std::vector<double> springs_;
};

} // namespace

struct Skin::Impl {
    // Copies the numbers that it needs, so that the maps of the prepared skin are freed once the stream has read them.
    Impl(const plan::StreamedSkin& skin, plan::Backend& backend)
        : width(size_t(skin.skin.width())), height(size_t(skin.skin.height())),
          fields(skin.skin.description.sites.empty()), wanted(skin.wanted), layout(response_layout_of(skin)),
          state_layout(state_layout_of(skin)), header(header_of(skin, state_layout)), strains(skin),
          threads(backend.capabilities().threads), tau(tau_range(skin.skin.materials)),
          description(skin.skin.description), stream(backend.stream(skin)) {
        if (description.surface.kind == Surface::Kind::map) gain_at_rest = gain_of(skin.skin);
        description.surface.map = {};
        scene::drop_maps(description.material);
        description.sites.clear();
    }

    // Counts the curvature under a strain of every cell in: the gain, and the responses that it makes change sign.
    void bend(Report& report, const plan::PreparedSkin& skin, const std::vector<double>& strain) const {
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
                    if (wanted[q]) changed[q] |= stream->response(Quantity(q))[y * width + x] != 0;
            }
        }
        for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
            if (changed[q]) report.sign_changed.push_back(Quantity(q));
    }

    static double gain_of(const plan::PreparedSkin& skin) {
        return std::abs(skin.constants.curvature_length) * greatest_rest_curvature(skin);
    }

    const size_t width, height;
    const bool fields;
    const plan::Wanted wanted;
    const plan::ResponseLayout layout;
    const plan::StateLayout state_layout;
    const StateHeader header;
    const Strains strains;
    const int threads;
    const scene::TauRange tau;
    SkinDescription description;        // without maps and sites
    std::optional<double> gain_at_rest; // of a surface that cannot be made again
    std::unique_ptr<plan::Stream> stream;

    size_t cells() const { return width * height; }
    size_t state_bytes() const { return sizeof header + state_layout.floats() * sizeof(float); }
    void need_state(const void* state, size_t bytes) const {
        if (!state || bytes != state_bytes())
            scene::refuse("state", state ? std::to_string(bytes) + " bytes" : "(null)",
                          std::to_string(state_bytes()) + " bytes");
    }
    void refuse_pressure(const float* pressure) const;
};

// Throws Error::bad_input naming the first cell that is not finite.
void Skin::Impl::refuse_pressure(const float* pressure) const {
    for (size_t i = 0; i < cells(); ++i)
        if (!scene::finite(double(pressure[i])))
            scene::refuse("pressure", shortest(double(pressure[i])) + " in cell " + scene::cell_text(i, int(width)),
                          "finite numbers");
}

Skin::Skin(const Device& device, const SkinDescription& description, const SkinOptions& options) {
    const DefaultFloats guard;
    Device::Impl& d = device.impl();
    impl_ = std::make_unique<Impl>(plan::streamed_skin(description, options, d.backend->capabilities().threads),
                                   *d.backend);
    d.info.exact &= impl_->stream->exact();
    d.need_exact();
}

Skin::~Skin() = default;
Skin::Skin(Skin&&) noexcept = default;
Skin& Skin::operator=(Skin&&) noexcept = default;

void Skin::press(const float* pressure, size_t cells, double dt) {
    Impl& s = *impl_;
    // Only on failure: need_not_negative() builds its message first, which allocates.
    if (!scene::finite(dt) || dt < 0) scene::need_not_negative("dt", dt);
    if (cells != s.cells())
        scene::refuse("pressure", std::to_string(cells) + " cells",
                      "width*height = " + std::to_string(s.cells()) + ", row 0 first");
    if (!s.stream->take(pressure, s.width)) s.refuse_pressure(pressure);
    if (!s.stream->press(dt))
        scene::need(false, "dt", dt, "seconds over which the coefficients of a step stay below 3.4e38");
}

Skin::Response Skin::response(Quantity q) const {
    const Impl& s = *impl_;
    if (!scene::is_receptor_class(q) || !s.wanted[size_t(q)])
        scene::refuse("response", std::string("\"") + name(q) + "\"",
                      s.fields ? "what SkinOptions::responses asks for" : "the classes of the description's sites");
    return {s.stream->response(q), s.fields ? s.cells() : s.layout.of[size_t(q)].count}; // throws if the device is lost
}

size_t Skin::state_bytes() const { return impl_->state_bytes(); }

void Skin::save(void* state, size_t bytes) const {
    const Impl& s = *impl_;
    s.need_state(state, bytes);
    std::vector<float> floats(s.state_layout.floats());
    s.stream->save(floats.data());
    std::memcpy(state, &s.header, sizeof s.header);
    std::memcpy(static_cast<char*>(state) + sizeof s.header, floats.data(), floats.size() * sizeof(float));
}

void Skin::load(const void* state, size_t bytes) {
    const Impl& s = *impl_;
    StateHeader saved{};
    if (state && bytes >= sizeof saved) {
        std::memcpy(&saved, state, sizeof saved);
        check_header(saved, s.header);
    }
    s.need_state(state, bytes);
    std::vector<float> floats(s.state_layout.floats());
    std::memcpy(floats.data(), static_cast<const char*>(state) + sizeof saved, floats.size() * sizeof(float));
    for (float x : floats)
        if (!scene::finite(double(x))) scene::refuse("state", "(a number that is not finite)", "finite numbers");
    s.stream->load(floats.data());
}

Report Skin::report() const {
    const DefaultFloats guard;
    const Impl& s = *impl_;
    std::optional<plan::PreparedSkin> skin;
    if (!s.gain_at_rest) skin = plan::prepare_skin(s.description, s.threads);
    Report report = report_of(s.description, s.tau, scene::cells_per_ridge(s.description),
                              skin ? Impl::gain_of(*skin) : *s.gain_at_rest);
    std::vector<float> state(s.state_layout.floats());
    s.stream->save(state.data());
    const std::vector<double> strain = s.strains.of(state.data(), s.state_layout);
    report.strain.value = 0;
    for (double eps : strain) report.strain.value = std::max(report.strain.value, std::abs(eps));
    if (skin && s.fields) s.bend(report, *skin, strain);
    if (s.description.grid.spacing)
        report.indentation.value = report.strain.value * s.description.material.thickness.value_or(0);
    return report;
}

void Skin::reset() { impl_->stream->reset(); }

} // namespace dermis
