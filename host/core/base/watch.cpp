// SPDX-License-Identifier: MIT
#include "host/core/base/watch.hpp"

namespace dermis::scene {
namespace {

using Clock = std::chrono::steady_clock;

thread_local Watch::State now;

// Calls progress. If progress runs another scene, this watch does not watch that run.
void call() {
    {
        const Watch::State running = now;
        const Watch unwatched({});
        (*running.progress)(running.done);
    }
    now.last = Clock::now();
}

} // namespace

Watch::Watch(const Progress& progress, std::chrono::milliseconds pause) : outer_(now) {
    now = {};
    if (progress) now = {.progress = &progress, .done = 0, .last = Clock::now(), .pause = pause};
}

Watch::~Watch() { now = outer_; }

void look() {
    if (now.progress && Clock::now() - now.last >= now.pause) call();
}

void reach(double done, bool tell) {
    now.done = done;
    if (now.progress && tell) call();
}

} // namespace dermis::scene
