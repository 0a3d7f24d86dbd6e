// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/base/process.hpp"

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

namespace dermis::simd {

// The number of threads worth using: one per 32768 cells, at most `asked` (0: one per core).
int useful_threads(size_t cells, int asked);

// The bytes of a core's second-level cache, half a MiB where the system does not say; and of the cache that cores
// share.
size_t second_level_cache();
size_t last_level_cache();

constexpr size_t large_page = 2 << 20; // bytes, of most processors

// Asks the system to back a map of many megabytes with large pages. Maps are read from end to end, and each small page
// would cost an address translation.
void prefer_large_pages(void* memory, size_t bytes);

// Returns `cells` times a value, in large pages where the system grants them.
template <class T> std::vector<T> map_of(size_t cells, T value) {
    std::vector<T> map;
    map.reserve(cells);
    prefer_large_pages(map.data(), cells * sizeof(T));
    map.resize(cells, value);
    return map;
}

// Threads that share the work of a call. The calling thread takes part. After a fork, the child's copy of a pool has no
// threads but the calling one.
class Pool {
  public:
    explicit Pool(int threads);
    ~Pool();
    int threads() const { return int(threads_.size()) + 1; }
    // Runs body(0) .. body(threads() - 1) concurrently and returns when all are done. Throws the exception of the first
    // body that failed. In the child of a fork it throws Error::device, unless the pool has one thread. With all =
    // false it runs body(0), and the body on each other thread that comes before body(0) returns: for work that threads
    // take in shares until none is left. It waits for no thread that sleeps, as one may take longer to wake (0.2 ms on
    // a virtual machine) than the work takes, and wakes them more and more rarely while they come too late.
    void each(const std::function<void(int)>& body, bool all = true);
    // Whether the body has thrown on some thread, after which the work of the others is in vain.
    bool failed() const { return failed_; }
    // Runs body(first, last) on each thread for its share of 0 .. count - 1.
    void share(long long count, const std::function<void(long long, long long)>& body);

  private:
    void work(int thread);
    void run(int thread) noexcept;

    const std::function<void(int)>* body_ = nullptr;
    // The number of the round, from bit 16 on; bit 15: no thread may enter it any more; below: how many have entered.
    std::atomic<uint64_t> round_{0};
    static constexpr uint64_t one_round = 1 << 16, closed = 1 << 15;
    std::atomic<int> done_{0};    // threads that have ended the round
    int unwoken_ = 0, pause_ = 0; // how many more rounds wake nobody; how many did so after the last call in vain
    std::atomic<bool> stop_{false}, failed_{false};
    std::exception_ptr thrown_;
    const Process process_;
    std::vector<std::thread> threads_;
};

} // namespace dermis::simd
