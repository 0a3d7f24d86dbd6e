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

} // namespace cpu
} // namespace dermis
