// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace dermis::cpu {

// Shares the rows of a grid among threads; the calling one takes part.
class Pool {
  public:
    explicit Pool(int threads);
    ~Pool();
    // body(first, last) over bands that together are 0..rows; returns when all are done.
    void rows(int rows, const std::function<void(int, int)>& body);

  private:
    void work(int band);

    std::mutex mutex_;
    std::condition_variable start_, done_;
    const std::function<void(int, int)>* body_ = nullptr;
    int rows_ = 0, running_ = 0;
    long long round_ = 0;
    bool stop_ = false;
    std::vector<std::thread> threads_;
};

} // namespace dermis::cpu
