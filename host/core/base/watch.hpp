// SPDX-License-Identifier: MIT
// Calls a run's progress from wherever the run spends its time: steps, the planner's own steps, and passes over all
// cells.
#pragma once

#include <chrono>
#include <functional>

namespace dermis::scene {

// While it lives, look() and reach() on this thread call `progress`, unless that is empty. An inner Watch takes the
// place of an outer one.
class Watch {
  public:
    using Progress = std::function<void(double)>;
    struct State {
        const Progress* progress = nullptr;
        double done = 0; // the fraction of the run that is done
        std::chrono::steady_clock::time_point last{};
        std::chrono::milliseconds pause{};
    };

    // pause: between two calls of look() that call progress.
    explicit Watch(const Progress& progress, std::chrono::milliseconds pause = std::chrono::milliseconds(100));
    ~Watch();
    Watch& operator=(Watch&&) = delete; // and no copies

  private:
    const State outer_;
};

// Calls progress if the watch's pause has passed since its last call. What it throws ends the run. For loops over steps
// or rows, each of which takes less than that. On a thread without a Watch it does nothing.
void look();

// Notes the fraction of the run that is done. tell: whether progress is called now.
void reach(double done, bool tell);

} // namespace dermis::scene
