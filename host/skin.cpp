// SPDX-License-Identifier: MIT
// dermis::Skin: frames in, responses out, on the CPU or on a device.
#include "host/device.hpp"
#include "host/plan/float_environment.hpp"
#include "host/plan/laplacian.hpp"
#include "host/report.hpp"
#include "host/scene/refusal.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace dermis {

struct Skin::Impl {
    // Copies the numbers that it needs, so that the maps of the prepared skin are freed once the stream has read them.
    Impl(const plan::StreamedSkin& skin, plan::Backend& backend)
        : width(size_t(skin.skin.width())), height(size_t(skin.skin.height())), pitch(size_t(skin.skin.pitch)),
          fields(skin.skin.description.sites.empty()), wanted(skin.wanted), layout(response_layout_of(skin)),
          threads(backend.capabilities().threads), tau(tau_range(skin.skin.materials)),
          description(skin.skin.description), stream(backend.stream(skin)) {
        for (size_t r = 0; r < dense.size(); ++r)
            if (fields && width != pitch && wanted[QUANTITY_SA1 + r]) dense[r].assign(width * height, 0.0f);
        if (description.surface.kind == Surface::Kind::map) gain_at_rest = gain_of(skin.skin);
        description.surface.map = {};
        scene::drop_maps(description.material);
        description.sites.clear();
    }

    static double gain_of(const plan::PreparedSkin& skin) {
        return std::abs(skin.constants.curvature_length) * greatest_rest_curvature(skin);
    }

    const size_t width, height, pitch;
    const bool fields;
    const plan::Wanted wanted;
    const plan::ResponseLayout layout;
    const int threads;
    const scene::TauRange tau;
    SkinDescription description;        // without maps and sites
    std::optional<double> gain_at_rest; // of a surface that cannot be made again
    std::unique_ptr<plan::Stream> stream;
    std::array<std::vector<float>, RESPONSE_MAPS> dense; // fields of width*height, where the pitch is greater

    size_t cells() const { return width * height; }
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
    for (size_t r = 0; r < s.dense.size(); ++r) {
        std::vector<float>& dense = s.dense[r];
        if (dense.empty()) continue;
        const float* response = s.stream->response(Quantity(QUANTITY_SA1 + r));
        for (size_t y = 0; y < s.height; ++y)
            std::memcpy(dense.data() + y * s.width, response + y * s.pitch, s.width * sizeof(float));
    }
}

Skin::Response Skin::response(Quantity q) const {
    const Impl& s = *impl_;
    if (!scene::is_receptor_class(q) || !s.wanted[size_t(q)])
        scene::refuse("response", std::string("\"") + name(q) + "\"",
                      s.fields ? "what SkinOptions::responses asks for" : "the classes of the description's sites");
    const std::vector<float>& dense = s.dense[size_t(q) - QUANTITY_SA1];
    const float* response = s.stream->response(q); // throws if the device is lost
    return {dense.empty() ? response : dense.data(), s.fields ? s.cells() : s.layout.of[size_t(q)].count};
}

Report Skin::report() const {
    const DefaultFloats guard;
    const Impl& s = *impl_;
    const double gain = s.gain_at_rest ? *s.gain_at_rest : Impl::gain_of(plan::prepare_skin(s.description, s.threads));
    return report_of(s.description, s.tau, scene::cells_per_ridge(s.description), gain);
}

void Skin::reset() {
    impl_->stream->reset();
    for (std::vector<float>& dense : impl_->dense) std::fill(dense.begin(), dense.end(), 0.0f);
}

} // namespace dermis
