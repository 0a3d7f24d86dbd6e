// SPDX-License-Identifier: MIT
#include "host/cpu/march.hpp"

#include "host/loops/pool.hpp"
#include "host/plan/float_environment.hpp"

#include <algorithm>
#include <array>
#include <barrier>
#include <limits>
#include <new>

namespace dermis {

using loops::Pool;

namespace f32 {
#include "host/cpu/march_real.inl"
}
namespace f64 {
#include "host/cpu/march_real.inl"
}

namespace cpu {

std::unique_ptr<plan::Marcher> march(const plan::Plan& plan, int threads, plan::Marcher::Sink sink,
                                     const loops::Set& set) {
    const DefaultFloats guard; // threads inherit it
    threads = loops::useful_threads(plan.maps.pressure.size(), threads);
    if (plan.precision == Precision::f64) return std::make_unique<f64::March>(plan, threads, set, std::move(sink));
    return std::make_unique<f32::March>(plan, threads, set, std::move(sink));
}

struct Frames::Impl {
    const plan::Plan& plan;
    f32::Cells cells;
    std::vector<float> rest;
};

Frames::Frames(const plan::Plan& plan, int threads, const loops::Set& set) {
    const DefaultFloats guard; // threads inherit it
    impl_.reset(new Impl{plan,
                         {plan, loops::useful_threads(plan.maps.pressure.size(), threads), set},
                         plan::padded<float>(plan.maps.rest_curvature, plan, "surface.relief")});
}

Frames::~Frames() = default;

void Frames::press(const plan::Step& step, const float* from, const float* to, float* const (&response)[4]) {
    const DefaultFloats guard;
    const auto c = plan::constants_of<f32::Constants>(impl_->plan, step);
    f32::Cells::Handed handed{};
    std::copy(response, response + 4, handed.response);
    impl_->cells.press(c, nullptr, from, to, impl_->rest.data(), true, handed);
}

} // namespace cpu
} // namespace dermis
