// SPDX-License-Identifier: MIT
#include "host/loops/pool.hpp"

#include <algorithm>
#include <system_error>

namespace dermis::loops {

int useful_threads(size_t cells, int asked) {
    if (asked == 0) asked = int(std::thread::hardware_concurrency());
    return std::clamp(int(cells / 32768), 1, std::max(asked, 1));
}

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

void Pool::each(const std::function<void(int)>& body) {
    if (threads_.empty()) return body(0);
    {
        std::lock_guard lock(mutex_);
        body_ = &body;
        running_ = int(threads_.size());
        ++round_;
    }
    start_.notify_all();
    body(0);
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return running_ == 0; });
}

void Pool::rows(int rows, const std::function<void(int, int)>& body) {
    const long long bands = this->bands();
    each([&](int band) { body(int(rows * band / bands), int(rows * (band + 1) / bands)); });
}

void Pool::work(int band) {
    long long seen = 0;
    std::unique_lock lock(mutex_);
    for (;;) {
        start_.wait(lock, [&] { return stop_ || round_ != seen; });
        if (stop_) return;
        seen = round_;
        const auto* body = body_;
        lock.unlock();
        (*body)(band);
        lock.lock();
        if (--running_ == 0) done_.notify_one();
    }
}

} // namespace dermis::loops
