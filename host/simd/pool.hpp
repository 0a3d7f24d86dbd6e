// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace dermis::simd {

// As many of the threads asked for (0: one per core) as are worth waking: one for some 32768 cells.
int useful_threads(size_t cells, int asked);

// A hint: maps of many megabytes are walked from end to end, and small pages would have to be looked up all the way.
void prefer_large_pages(void* memory, size_t bytes);

// Threads that share the work of a call; the calling one takes part.
class Pool {
  public:
    explicit Pool(int threads);
    ~Pool();
    int threads() const { return int(threads_.size()) + 1; }
    // Runs body(0) .. body(threads() - 1) at the same time, and returns when all are done.
    void each(const std::function<void(int)>& body);
    // Runs body(first, last) on each thread over its share of 0..count.
    void share(int count, const std::function<void(int, int)>& body);

  private:
    void work(int thread);

    const std::function<void(int)>* body_ = nullptr;
    std::atomic<unsigned> round_{0};
    std::atomic<int> running_{0};
    std::atomic<bool> stop_{false};
    std::vector<std::thread> threads_;
};

} // namespace dermis::simd
