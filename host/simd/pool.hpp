// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace dermis::simd {

// Of those asked for (0: one per core), as many as are worth waking: one for some 32768 cells.
int useful_threads(size_t cells, int asked);

// A hint: maps of many megabytes are walked from end to end, and small pages would have to be looked up all the way.
void prefer_large_pages(void* memory, size_t bytes);

// Threads that share the work of a call; the calling one takes part.
class Pool {
  public:
    explicit Pool(int threads);
    ~Pool();
    int bands() const { return int(threads_.size()) + 1; }
    // body(0) .. body(bands() - 1), at the same time; returns when all are done.
    void each(const std::function<void(int)>& body);
    // body(first, last) over bands that together are 0..rows.
    void rows(int rows, const std::function<void(int, int)>& body);

  private:
    void work(int band);

    const std::function<void(int)>* body_ = nullptr;
    std::atomic<unsigned> round_{0};
    std::atomic<int> running_{0};
    std::atomic<bool> stop_{false};
    std::vector<std::thread> threads_;
};

} // namespace dermis::simd
