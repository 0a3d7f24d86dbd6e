// SPDX-License-Identifier: MIT
#include "bench/limits.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace bench {
namespace {

constexpr size_t page = 2 << 20, line = 64;

uint64_t sum(const float* from, size_t n) {
    uint64_t sums[8] = {};
    for (size_t i = 0; i < n; i += 16) {
        uint64_t words[8];
        std::memcpy(words, from + i, sizeof words);
        for (int k = 0; k < 8; ++k) sums[k] += words[k];
    }
    uint64_t all = 0;
    for (uint64_t s : sums) all += s;
    return all;
}

} // namespace

#ifdef __SSE2__
void stream(float* to, const float* from, size_t n) {
    for (size_t i = 0; i < n; i += 16)
        for (size_t k = 0; k < 16; k += 4) _mm_stream_ps(to + i + k, _mm_load_ps(from + i + k));
}
void fence_streams() { _mm_sfence(); }
#else
void stream(float* to, const float* from, size_t n) { std::memcpy(to, from, n * sizeof(float)); }
void fence_streams() {}
#endif

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

Floats::Floats(size_t count) {
    static size_t made = 0;
    const size_t shift = made++ % 13 * 5 * line, bytes = (count * sizeof(float) + shift + page - 1) / page * page;
    memory_.reset(std::aligned_alloc(page, bytes));
    dermis::simd::prefer_large_pages(memory_.get(), bytes);
    begin_ = reinterpret_cast<float*>(static_cast<char*>(memory_.get()) + shift);
    for (size_t i = 0; i < count; ++i) begin_[i] = float(i % 1021) * 1e-3f;
}

void Floats::Free::operator()(void* p) const { std::free(p); }

Limits::Limits(int threads) : pool_(threads) {}

double Limits::copy() {
    const double start = now();
    pool_.share(1024, [&](int first, int last) {
        stream(to_.data() + count / 1024 * size_t(first), from_.data() + count / 1024 * size_t(first),
               count / 1024 * size_t(last - first));
        fence_streams();
    });
    return now() - start;
}

double Limits::read() {
    std::atomic<uint64_t> all = 0;
    const double start = now();
    for (const Floats* map : {&from_, &to_})
        pool_.share(1024, [&](int first, int last) {
            all += sum(map->data() + count / 1024 * size_t(first), count / 1024 * size_t(last - first));
        });
    const double seconds = now() - start;
    return all == 1 ? NAN : seconds; // the sum is used, so that the reads are not optimised away
}

} // namespace bench
