// SPDX-License-Identifier: MIT
#include "host/cpu/march.hpp"

#include "host/cpu/pool.hpp"
#include "host/plan/float_environment.hpp"

#include <algorithm>
#include <limits>

namespace dermis {

using cpu::Pool;

namespace f32 {
#include "host/cpu/march_real.inl"
}
namespace f64 {
#include "host/cpu/march_real.inl"
}

namespace cpu {

std::unique_ptr<plan::Marcher> march(const plan::Plan& plan, int threads, plan::Marcher::Sink sink) {
    if (threads == 0) threads = int(std::thread::hardware_concurrency());
    // a thread is worth waking from some 32768 cells a step on
    const int useful = std::clamp(int(plan.maps.pressure.size() / 32768), 1, std::max(threads, 1));
    const DefaultFloats guard; // threads inherit it
    if (plan.precision == Precision::f64) return std::make_unique<f64::March>(plan, useful, std::move(sink));
    return std::make_unique<f32::March>(plan, useful, std::move(sink));
}

} // namespace cpu
} // namespace dermis
