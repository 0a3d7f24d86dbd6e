// SPDX-License-Identifier: MIT
#include "host/core/vulkan/press_kernel.hpp"

#include <algorithm>
#include <climits>

namespace dermis::vulkan {

static_assert(sizeof(f32::Constants) <= 128, "push constants: every device has 128 bytes");

namespace {

bool is_batch(const model::Variant& variant) { return variant.pads != model::Variant::Pads::none; }

std::vector<uint32_t> specialization_of(const model::Variant& variant, int x, int y, int z) {
    std::vector<uint32_t> constants = specialization(variant);
    constants[VARIANT_GROUP_X] = uint32_t(x);
    constants[VARIANT_GROUP_Y] = uint32_t(y);
    constants[VARIANT_GROUP_Z] = uint32_t(z);
    return constants;
}

} // namespace

Module press_module_for(const DeviceTable& device, const model::Variant& variant) {
    if (variant.spreads) return press_signals_module(device.texels);
    return variant.sites ? press_sites_module(device.texels) : press_module(device.texels);
}

std::vector<f32::SiteEntry> site_entries(const model::StreamedSkin& s, const model::ResponseLayout& layout,
                                         const model::SiteCells& needed) {
    const auto entry = [](int x, int y) { return f32::SiteEntry{.x = x / PRESS_CELLS * PRESS_CELLS, .y = y}; };
    const auto alike = [](const f32::SiteEntry& a, const f32::SiteEntry& b) { return a.x == b.x && a.y == b.y; };
    std::vector<f32::SiteEntry> all, joined;
    for (const size_t cell : needed.cells) {
        const int x = int(cell) % s.skin.width(), y = int(cell) / s.skin.width();
        if (all.empty() || !alike(all.back(), entry(x, y))) all.push_back(entry(x, y));
        all.back().needed |= 1 << x % PRESS_CELLS;
    }
    for (size_t i = 0; i < s.skin.description.sites.size(); ++i) {
        const Site& site = s.skin.description.sites[i];
        f32::SiteEntry& e = all.emplace_back(entry(site.cell.x, site.cell.y));
        e.lane = site.cell.x % PRESS_CELLS;
        e.quantity = int(site.type);
        e.response = int(layout.site[i]);
        e.of_class = int(layout.of[size_t(site.type)].count / size_t(s.pads));
    }
    std::ranges::stable_sort(all, {}, [](const f32::SiteEntry& e) { return std::pair(e.y, e.x); });
    for (f32::SiteEntry& e : all) { // cells have their first site in their own entry
        const bool first = !joined.empty() && alike(joined.back(), e) && joined.back().quantity == 0;
        if (first) e.needed = joined.back().needed, joined.back() = e;
        else joined.push_back(e);
    }
    return joined;
}

PressKernel::PressKernel(Pipelines& pipelines, const model::PreparedSkin& skin, const model::Variant& variant,
                         const model::PressedBox& pressed, uint32_t max_bindings,
                         const std::vector<f32::SiteEntry>& sites)
    : variant_(variant), pitch_(skin.pitch),
      columns_(is_batch(variant) ? skin.width() : pressed.last_tile * TILE_CELLS - pressed.first_column()),
      group_(group_of(skin, variant, pressed)), windows_(row_windows(pipelines.device(), skin,
                                                                     {.first = pressed.first_row,
                                                                      .last = pressed.last_row,
                                                                      .planes = variant.state().planes(),
                                                                      .work = double(numbers_of_press(variant)),
                                                                      .group_rows = group_.y})),
      kernel_(pipelines, press_module_for(pipelines.device(), variant),
              specialization_of(variant, group_.x, group_.y, group_.z), max_bindings * uint32_t(windows_.size())) {
    if (variant.sites) divide(sites);
}

// Gives each window the entries of its rows, and entries of no cells until they fill its workgroups.
void PressKernel::divide(const std::vector<f32::SiteEntry>& all) {
    constexpr size_t most = 65535; // workgroups along an axis that every device allows
    auto next = all.begin();
    for (const RowWindow& window : windows_) {
        const size_t first = sites_.size();
        for (; next != all.end() && next->y < window.last; ++next) sites_.push_back(*next);
        const size_t groups = std::max<size_t>((sites_.size() - first + SITES_X - 1) / SITES_X, 1),
                     y = (groups + most - 1) / most, x = (groups + y - 1) / y, count = x * y * SITES_X;
        sites_.resize(first + count, {.x = INT_MAX});
        site_windows_.push_back({first, count, uint32_t(x), uint32_t(y)});
    }
}

// A workgroup takes as many rows of a pad as fill it, shared evenly among the workgroups of the pad; or several pads.
// Of a skin that is pressed in part it takes one row, because no other row may be written.
PressKernel::Group PressKernel::group_of(const model::PreparedSkin& skin, const model::Variant& variant,
                                         const model::PressedBox& pressed) {
    if (variant.sites) return {.x = SITES_X, .y = 1, .z = 1};
    if (!is_batch(variant) && (pressed.first_row > 0 || pressed.last_row < skin.height()))
        return {.x = PRESS_X * PRESS_Y, .y = 1, .z = 1};
    if (!is_batch(variant)) return {.x = PRESS_X, .y = PRESS_Y, .z = 1};
    constexpr int all = 128, deep = 64; // invocations that every device allows, in all and along z
    const int x = std::min((skin.width() + PRESS_CELLS - 1) / PRESS_CELLS, all), most = std::max(all / x, 1),
              count = (skin.height() + most - 1) / most, y = (skin.height() + count - 1) / count;
    return {.x = x, .y = y, .z = count > 1 ? 1 : std::clamp(all / (x * y), 1, deep)};
}

void PressKernel::bind(size_t binding, const Maps& m) {
    const int planes = variant_.state().planes();
    for (size_t w = 0; w < windows_.size(); ++w) {
        const RowWindow& window = windows_[w];
        const auto map = [&](const BufferRange& range, bool used = true) {
            return used && !is_batch(variant_) ? window.of(range, pitch_) : range;
        };
        const auto state = [&](const BufferRange& range) {
            return is_batch(variant_) ? range : window.of(range, pitch_, planes);
        };
        std::vector<BoundRange> bound = {
            {PRESS_PRESSURE_FROM, map(m.pressure_from)},
            {PRESS_PRESSURE_TO, map(variant_.framed ? m.pressure_to : m.pressure_from)},
            {PRESS_REST_CURVATURE, map(m.rest_curvature)},
            {PRESS_STATE_FROM, state(m.state_from)},
            {PRESS_STATE_TO, state(m.state_to)},
            {PRESS_COEFFICIENTS, m.coefficients},
            {PRESS_MATERIAL, map(m.material, variant_.materials)},
            {PRESS_INVALID, m.invalid},
        };
        std::array<BufferRange, RESPONSE_MAPS> response;
        for (size_t i = 0; i < m.response.size(); ++i)
            response[i] = map(m.response[i], variant_.wanted[QUANTITY_SA1 + i] && !variant_.spreads);
        if (variant_.sites) {
            const VkDeviceSize entry = sizeof(f32::SiteEntry), first = site_windows_[w].first * entry;
            response.fill(m.invalid);
            response[PRESS_SITES - PRESS_RESPONSE(QUANTITY_SA1)] = {m.sites.buffer, m.sites.offset + first,
                                                                    site_windows_[w].count * entry};
            response[PRESS_SITES_RESPONSE - PRESS_RESPONSE(QUANTITY_SA1)] = m.responses;
        }
        for (size_t i = 0; i < response.size(); ++i)
            bound.push_back({PRESS_RESPONSE(QUANTITY_SA1 + uint32_t(i)), response[i]});
        kernel_.bind(binding * windows_.size() + w, bound);
    }
}

void PressKernel::record(VkCommandBuffer commands, size_t binding, const f32::Constants& constants, uint32_t pads,
                         Recording* own) const {
    f32::Constants c = constants;
    for (size_t i = 0; i < windows_.size(); ++i) {
        const RowWindow& window = windows_[i];
        c.first_row = window.first;
        c.base_row = window.base;
        if (window.rows() == 0) continue; // Vulkan allows a dispatch of 0 groups, but some layers do not.
        if (own) own->add(work_of(i) * pads);
        const uint32_t x = variant_.sites ? site_windows_[i].x : groups(columns_, PRESS_CELLS * group_.x),
                       y = variant_.sites ? site_windows_[i].y : groups(window.rows(), group_.y);
        kernel_.record(commands, binding * windows_.size() + i, &c, x, y, groups(int(pads), group_.z));
    }
}

} // namespace dermis::vulkan
