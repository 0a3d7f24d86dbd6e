// SPDX-License-Identifier: MIT
#include "host/cpu/stepper.hpp"

#include "host/simd/pool.hpp"
#include "host/plan/float_environment.hpp"

#include <algorithm>
#include <array>
#include <barrier>
#include <limits>
#include <new>

namespace dermis {

using simd::Pool;

namespace f32 {
#include "host/cpu/stepper_real.inl"
}
namespace f64 {
#include "host/cpu/stepper_real.inl"
}

namespace cpu {

std::unique_ptr<plan::Stepper> march(const plan::Plan& plan, int threads, plan::Stepper::Sink sink,
                                     const simd::Isa& isa) {
    const DefaultFloats guard; // threads inherit it
    threads = simd::useful_threads(plan.maps.pressure.size(), threads);
    if (plan.precision == Precision::f64) return std::make_unique<f64::March>(plan, threads, isa, std::move(sink));
    return std::make_unique<f32::March>(plan, threads, isa, std::move(sink));
}

} // namespace cpu
} // namespace dermis
