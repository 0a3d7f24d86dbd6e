// SPDX-License-Identifier: MIT
#include "host/core/base/pool.hpp"

#include "host/core/base/cores.hpp"

#include <algorithm>
#include <utility>

#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace dermis::simd {

namespace {

// Waits until value != same. It spins for some microseconds, because steps follow each other closely, then sleeps.
template <class T> void wait_while(const std::atomic<T>& value, T same) {
    for (int i = 0; i < 2000; ++i) {
        if (value != same) return;
#ifdef DERMIS_X86_64
        __builtin_ia32_pause();
#endif
    }
    value.wait(same);
}

} // namespace

int useful_threads(size_t cells, int asked) {
    if (asked == 0) asked = cores();
    return std::clamp(int(cells / 32768), 1, std::max(asked, 1));
}

size_t second_level_cache() {
#ifdef _SC_LEVEL2_CACHE_SIZE
    if (const long bytes = sysconf(_SC_LEVEL2_CACHE_SIZE); bytes > 0) return size_t(bytes);
#endif
    return size_t(1) << 19;
}

size_t last_level_cache() {
#ifdef _SC_LEVEL3_CACHE_SIZE
    constexpr long most = 32 << 20; // some systems name the sum of several caches
    if (const long bytes = sysconf(_SC_LEVEL3_CACHE_SIZE); bytes > 0) return size_t(std::min(bytes, most));
#endif
    return second_level_cache();
}

void prefer_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] size_t bytes) {
#ifdef __linux__
    const size_t begin = (reinterpret_cast<size_t>(memory) + large_page - 1) / large_page * large_page,
                 end = (reinterpret_cast<size_t>(memory) + bytes) / large_page * large_page;
    if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#endif
}

Pool::Pool(int threads) {
    try {
        threads_.reserve(size_t(std::max(threads, 1)));
        for (int thread = 1; thread < threads; ++thread) threads_.emplace_back([this, thread] { work(thread); });
    } catch (const std::exception&) { // The system or memory allows no more; fewer threads give the same bits.
    }
}

Pool::~Pool() {
    if (!process_.calls()) { // in the child of a fork: to join the threads would take for ever
        leave(threads_);
        return;
    }
    stop_ = true;
    round_ += one_round;
    round_.notify_all();
    for (std::thread& t : threads_) t.join();
}

void Pool::each(const std::function<void(int)>& body, bool all) {
    if (threads_.empty()) return body(0);
    if (!process_.calls()) process_.refuse("a pool of " + std::to_string(threads()) + " threads was");
    const bool wake = all || unwoken_ == 0;
    body_ = &body;
    done_ = 0;
    round_ = (round_ / one_round + 1) * one_round;
    if (wake) round_.notify_all();
    run(0);
    const int entered = int(all ? threads_.size() : round_.fetch_or(closed) % closed);
    if (entered > 0) pause_ = unwoken_ = 0;
    else if (wake) unwoken_ = pause_ = std::min(2 * pause_ + 1, 31);
    else --unwoken_;
    for (int done; (done = done_) != entered;) wait_while(done_, done);
    if (failed_.exchange(false)) std::rethrow_exception(std::exchange(thrown_, nullptr));
}

void Pool::run(int thread) noexcept {
    try {
        (*body_)(thread);
    } catch (...) {
        if (!failed_.exchange(true)) thrown_ = std::current_exception();
    }
}

void Pool::share(long long count, const std::function<void(long long, long long)>& body) {
    const long long threads = this->threads();
    const auto part = [&](int thread) { body(count * thread / threads, count * (thread + 1) / threads); };
    each(std::ref(part)); // a reference: nothing is allocated
}

void Pool::work(int thread) {
    for (uint64_t seen = 0;;) {
        uint64_t round = round_;
        if (stop_) return;
        if (round / one_round == seen || (round & closed)) wait_while(round_, round);
        else if (round_.compare_exchange_strong(round, round + 1)) {
            seen = round / one_round;
            run(thread);
            ++done_;
            done_.notify_one();
        }
    }
}

} // namespace dermis::simd
