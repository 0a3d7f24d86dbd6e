// SPDX-License-Identifier: MIT
#include "host/cpu/pool.hpp"

#include <system_error>

namespace dermis::cpu {

Pool::Pool(int threads) {
    try {
        for (int band = 1; band < threads; ++band) threads_.emplace_back([this, band] { work(band); });
    } catch (const std::system_error&) { // fewer threads give the same bits
    }
}

Pool::~Pool() {
    {
        std::lock_guard lock(mutex_);
        stop_ = true;
    }
    start_.notify_all();
    for (std::thread& t : threads_) t.join();
}

void Pool::rows(int rows, const std::function<void(int, int)>& body) {
    const int bands = int(threads_.size()) + 1;
    if (bands == 1) return body(0, rows);
    {
        std::lock_guard lock(mutex_);
        body_ = &body;
        rows_ = rows;
        running_ = bands - 1;
        ++round_;
    }
    start_.notify_all();
    body(0, rows / bands);
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return running_ == 0; });
}

void Pool::work(int band) {
    long long seen = 0;
    std::unique_lock lock(mutex_);
    for (;;) {
        start_.wait(lock, [&] { return stop_ || round_ != seen; });
        if (stop_) return;
        seen = round_;
        const long long bands = long(threads_.size()) + 1, rows = rows_;
        const auto* body = body_;
        lock.unlock();
        (*body)(int(rows * band / bands), int(rows * (band + 1) / bands));
        lock.lock();
        if (--running_ == 0) done_.notify_one();
    }
}

} // namespace dermis::cpu
