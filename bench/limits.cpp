// SPDX-License-Identifier: MIT
#include "bench/limits.hpp"

#include "host/core/base/pool.hpp"

#include <chrono>
#include <cstdlib>

namespace bench {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

Floats::Floats(size_t count) {
    constexpr size_t page = 2 << 20, line = 64;
    static size_t made = 0;
    const size_t shift = made++ % 13 * 5 * line, bytes = (count * sizeof(float) + shift + page - 1) / page * page;
    memory_.reset(std::aligned_alloc(page, bytes));
    dermis::simd::prefer_large_pages(memory_.get(), bytes);
    begin_ = reinterpret_cast<float*>(static_cast<char*>(memory_.get()) + shift);
    for (size_t i = 0; i < count; ++i) begin_[i] = float(i % 1021) * 1e-3f;
}

void Floats::Free::operator()(void* p) const { std::free(p); }

} // namespace bench
