// SPDX-License-Identifier: MIT
#include "host/cpu/stream.hpp"

#include "host/simd/pool.hpp"
#include "host/reduced/sites.hpp"
#include "host/plan/float_environment.hpp"
#include "host/plan/stepper.hpp"

#include <algorithm>
#include <array>
#include <barrier>
#include <limits>
#include <new>
#include <optional>

namespace dermis {

using simd::Pool;

namespace f32 {
#include "host/cpu/cells.inl"
#include "host/plan/site_stepper.inl"
} // namespace f32

namespace cpu {

using f32::Constants;

struct Frames::Impl {
    Impl(const plan::Plan& plan, int threads, const simd::Isa& isa) : plan(plan) {
        if (plan.scene.sites.empty()) {
            rest = plan::padded<float>(plan.maps.rest_curvature, plan, "surface.relief");
            table.resize(plan.material.empty() ? 0 : plan.media.size());
            cells.emplace(plan, threads, isa);
        } else {
            std::vector<Cell> at;
            for (const Site& site : plan.scene.sites) at.push_back(site.cell);
            looked_at.emplace(plan, at);
            loop.emplace(plan, looked_at->material);
            for (const Cell& c : at) places.push_back(loop->place(*looked_at, c));
            for (auto* pressure : {&from, &to}) pressure->resize(looked_at->cells.size());
            rows.resize(looked_at->media.size());
        }
    }

    void press_fields(double dt, const float* p, const float* q, float* const (&response)[4]) {
        const auto c = plan::frame_constants<Constants>(plan, plan.media.front(), dt);
        if (dt != table_dt)
            for (size_t i = 0; i < table.size(); ++i)
                table[i] = plan::rounded<f32::Coefficients>(plan::exact_coefficients(plan.media[i], dt));
        table_dt = dt;
        f32::Cells::Outputs handed{};
        std::copy(response, response + 4, handed.response);
        cells->press(c, table.data(), p, q, rest.data(), true, handed);
    }

    void press_sites(double dt, const float* p, const float* q, float* const (&response)[4]) {
        const auto c = plan::frame_constants<Constants>(plan, looked_at->media.front(), dt);
        if (dt != table_dt)
            for (size_t i = 0; i < rows.size(); ++i)
                rows[i] = f32::lanes_of(plan::rounded<f32::Coefficients>(plan::exact_coefficients(looked_at->media[i], dt)));
        table_dt = dt;
        const size_t width = size_t(plan.constants.width);
        for (size_t i = 0; i < from.size(); ++i) {
            const size_t cell = looked_at->cells[i], at = cell / width * size_t(plan.pitch) + cell % width;
            from[i] = p[at];
            to[i] = q[at];
        }
        loop->advance(c, rows.data(), from.data(), to.data(), 0, from.size());
        std::array<size_t, 4> next{};
        for (size_t i = 0; i < places.size(); ++i) {
            const Quantity type = plan.scene.sites[i].type;
            const size_t r = size_t(type) - 1;
            response[r][next[r]++] = loop->value(places[i], type, c, rows.data(), from.data(), to.data());
        }
        loop->keep();
    }

    const plan::Plan& plan;
    double table_dt = std::nan("");
    // fields
    std::optional<f32::Cells> cells;
    std::vector<float> rest;
    std::vector<f32::Coefficients> table;
    // sites
    std::optional<plan::SiteCells> looked_at;
    std::optional<f32::SiteStepper> loop;
    std::vector<f32::SiteStepper::Place> places;
    std::vector<float> from, to;
    std::vector<f32::LaneCoefficients> rows;
};

Frames::Frames(const plan::Plan& plan, int threads, const simd::Isa& isa) {
    const DefaultFloats guard; // threads inherit it
    const size_t cells = size_t(plan.constants.width) * size_t(plan.constants.height);
    impl_ = std::make_unique<Impl>(plan, simd::useful_threads(cells, threads), isa);
}

Frames::~Frames() = default;

void Frames::reset() {
    if (impl_->looked_at) impl_->loop->reset();
    else impl_->cells->rest();
}

void Frames::press(double dt, const float* from, const float* to, float* const (&response)[4]) {
    const DefaultFloats guard;
    if (impl_->looked_at) impl_->press_sites(dt, from, to, response);
    else impl_->press_fields(dt, from, to, response);
}

} // namespace cpu
} // namespace dermis
