// SPDX-License-Identifier: MIT
#include "bench/skins.hpp"

#include <algorithm>
#include <cstring>
#include <random>
#include <stdexcept>

namespace bench {

using namespace dermis;

SkinDescription rectangle(int width, int height, double spacing) {
    SkinDescription d;
    d.grid = {width, height, spacing};
    d.surface.relief = 5e-5;
    d.material = {.modulus = 20e3, .viscosity = 1e3, .thickness = 1e-3, .curvature_length = 1e-5};
    return d;
}

Material chain_of(int elements, bool spring) {
    Material m;
    if (elements == 1 && !spring) return m;
    for (int e = 0; e < elements; ++e) m.elements.push_back({2e6 / (1 + e), 8e3 * std::pow(3, e) / (1 + e)});
    if (spring) m.spring = 4e6;
    return m;
}

std::vector<size_t> materials_of(Spread spread, size_t n) {
    if (spread == Spread::uniform) return {};
    std::vector<size_t> of(n * n);
    std::mt19937 random(1);
    for (size_t i = 0; i < of.size(); ++i)
        of[i] = spread == Spread::patches    ? (i / n / (n / 4) + i % n / (n / 8)) % 4
                : spread == Spread::random   ? random() % 4
                : spread == Spread::thousand ? random() % 1000
                                             : i;
    return of;
}

SkinOptions in_f32(int pads) {
    SkinOptions options;
    options.precision = Precision::f32;
    options.count = pads;
    return options;
}

long long Press::cells_of_frame() const {
    return static_cast<long long>(skin.grid.width) * skin.grid.height * options.count;
}

namespace {

Frames frames_of(const Press& p) {
    std::mt19937 random(11);
    const auto cells = size_t(p.cells_of_frame());
    auto frames = std::make_shared<std::vector<float>>(cells * p.ring);
    for (size_t i = 0; i < frames->size(); ++i)
        (*frames)[i] = std::isnan(p.pressure) ? float(random() % 20000) : p.pressure * float(1 + i / cells);
    return frames;
}

class Presser {
  public:
    Presser(const Device& device, const Press& p, const Frames& frames)
        : p_(p), frames_(frames), numbers_(frames->size() / p.ring) {
        for (int i = 0; i < p.skins; ++i) skins_.push_back(std::make_unique<Skin>(device, p.skin, p.options));
        if (!p.cells) return;
        auto gathered = std::make_shared<std::vector<float>>();
        const size_t of_pad = numbers_ / size_t(p.options.count);
        for (size_t pad = 0; pad < p.ring * size_t(p.options.count); ++pad)
            for (int cell : skins_[0]->cells()) gathered->push_back((*frames)[pad * of_pad + size_t(cell)]);
        numbers_ = gathered->size() / p.ring;
        frames_ = gathered;
    }
    void press(size_t frames) {
        for (size_t i = 0; i < frames; i += p_.frames) {
            const float* const frame = frames_->data() + i % p_.ring * numbers_;
            for (const auto& skin : skins_)
                if (p_.cells) skin->press_cells(frame, numbers_, press_dt);
                else if (p_.frames > 1) skin->press_frames(frame, p_.frames, numbers_, press_dt);
                else skin->press(frame, numbers_, press_dt);
            if (p_.reads_each) skins_[0]->response(Quantity::fa2);
        }
        if (p_.reads_last) skins_[0]->response(Quantity::fa2);
    }
    bool same(const Presser& other) const {
        return std::ranges::all_of(p_.options.responses, [&](Quantity q) {
            const Skin::Response a = skins_[0]->response(q), b = other.skins_[0]->response(q);
            return a.size == b.size && std::memcmp(a.data, b.data, a.size * sizeof(float)) == 0;
        });
    }

  private:
    const Press p_;
    Frames frames_;
    size_t numbers_; // numbers of a frame
    std::vector<std::unique_ptr<Skin>> skins_;
};

std::function<double()> pressed(const Device& device, const Press& p, long long steps, const Frames& frames) {
    auto presser = std::make_shared<Presser>(device, p, frames);
    presser->press(8);
    if (device.info().vulkan || device.impl().backend->threads() > 1) {
        Presser one(Device::cpu(1), p, frames);
        one.press(8);
        if (!presser->same(one))
            throw std::runtime_error(fmt::format("{}: {} has other bits than one thread", p.model, device.info().name));
    }
    return [presser, steps] { return seconds_of([&] { presser->press(size_t(steps)); }); };
}

} // namespace

long long Length::of(const Device& device, const Press& p) const {
    const bool software = device.info().kind == "software";
    const double units = (software ? cells_on_software : cells) / double(p.cells_of_frame() * p.skins * unit);
    const int fewest = p.cells && !device.info().vulkan ? 100 : least; // takes microseconds
    return std::clamp(int(units), fewest, software ? most_on_software : most) * static_cast<long long>(unit);
}

Measurement described(Measurement r, const Press& p, long long steps) {
    r = row_of(r, p.model, name(*p.options.precision), steps);
    r.stencil = p.stencil;
    r.width = p.skin.grid.width;
    r.height = static_cast<long long>(p.skin.grid.height) * p.options.count * p.skins;
    r.method = p.method.empty() ? fmt::format("exact-{}x{}x{}", r.width, p.skin.grid.height, p.options.count * p.skins)
                                : p.method;
    r.receptors = static_cast<long long>(p.skin.sites.size()) * p.options.count;
    r.bytes_per_cell = 48; // pressures, strain and integral read and written, the pressure taken, four responses
    return r;
}

void measure_presses(Bench& bench, const char* workload, const std::vector<Device>& places,
                     const std::vector<Press>& presses, const Length& length, int times) {
    std::vector<Contender> all;
    Frames frames;
    float pressure = NAN; // of the frames
    for (const Device& place : places) {
        const size_t first = all.size();
        for (const Press& p : presses) {
            if (p.native && place.info().vulkan) continue;
            const bool same = std::isnan(p.pressure) ? std::isnan(pressure) : p.pressure == pressure;
            if (!same || !frames || frames->size() != size_t(p.cells_of_frame()) * p.ring) frames = frames_of(p);
            pressure = p.pressure;
            const long long steps = length.of(place, p);
            Contender c{described(bench.on(place, workload, 0), p, steps),
                        p.native ? native_pads(p, place.impl().backend->threads(), steps, frames)
                                 : pressed(place, p, steps, frames)};
            for (size_t k = first; k < all.size() && !p.ratio_to.empty(); ++k)
                if (all[k].row.model == p.ratio_to) c.ratio_to = p.ratio_to, c.reference = k;
            all.push_back(std::move(c));
        }
    }
    bench.measure(std::move(all), times);
}

} // namespace bench
