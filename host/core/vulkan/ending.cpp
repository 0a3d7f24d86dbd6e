// SPDX-License-Identifier: MIT
#include "host/core/vulkan/ending.hpp"

#include "host/core/vulkan/context.hpp"

#include <atomic>
#include <cstdlib>
#include <pthread.h>

namespace dermis::vulkan {
namespace {

constexpr int ending = 1 << 30;
std::atomic<int> uses{0};  // of all threads; and `ending`, once exit() has begun
thread_local int own_uses; // of this thread, which may call exit() in a callback

// Never destroyed, because threads may go on after the end of main().
struct Open {
    std::mutex mutex;
    std::vector<const Context*> contexts;
};
Open& open() {
    static Open& all = *new Open;
    return all;
}

void leave() noexcept {
    --own_uses;
    if (uses-- & ending) uses.notify_all();
}

void end() {
    if (uses.fetch_or(ending) & ending) return;
    for (int now; ((now = uses) & ~ending) != own_uses;) uses.wait(now);
    const std::lock_guard lock(open().mutex);
    for (const Context* context : open().contexts) context->wait_idle();
}

} // namespace

Use::Use(bool allowed) noexcept : entered_(allowed) {
    if (!allowed) return;
    ++own_uses;
    entered_ = !(uses++ & ending);
    if (!entered_) leave();
}

Use::~Use() {
    if (entered_) leave();
}

Use::Use(const std::string& device) : Use(true) {
    if (!entered_) throw Error(Error::Code::device, "", device + " is not used while the process is ending");
}

bool end_before_drivers() noexcept {
    // In a forked child no other thread uses anything.
    static const int watched = pthread_atfork([] { open().mutex.lock(); }, [] { open().mutex.unlock(); },
                                              [] { uses = own_uses, open().mutex.unlock(); });
    return watched == 0 && std::atexit(end) == 0;
}

void add_open(const Context* context) {
    const std::lock_guard lock(open().mutex);
    open().contexts.push_back(context);
}

void remove_open(const Context* context) {
    const std::lock_guard lock(open().mutex);
    std::erase(open().contexts, context);
}

} // namespace dermis::vulkan
