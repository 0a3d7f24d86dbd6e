// SPDX-License-Identifier: MIT
// What stands between the library and the real loader: faults, smaller limits, a log of calls, and a ledger of objects.
#pragma once

#include "host/core/vulkan/instance.hpp"
#include "tests/ledger.hpp"

#include <functional>
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace test {

using namespace dermis;

inline constexpr const char* any_call = "*";

// One call of a function fails, or it and all that follow.
struct Fault {
    const char* call = "";      // the function's name, or any_call
    int before = 0;             // the calls of it that succeed before
    VkResult code = VK_SUCCESS; // the result of the call that fails
    bool made = false;          // it does its work all the same; calls that Vulkan says do none are not counted
    bool sticky = false; // the later calls fail too; one that loses the device, so that none follows, is not counted
    int times = 1;       // calls in a row that fail, where it is not sticky
    const char* struck = nullptr; // the first call that failed
};

// A barrier as it was recorded, with the first of its memory barriers.
struct Barrier {
    VkPipelineStageFlags from = 0, to = 0;
    VkAccessFlags source = 0, destination = 0;
};

struct Shim {
    bool no_driver = false, no_compute = false, few_buffers = false;
    bool miscompile = false;     // the 1 of every response is wrong
    bool miscompile_far = false; // 4/3 of the fourth-order stencil is wrong
    uint32_t range = 0;          // maxStorageBufferRange; 0: the device's own
    VkDeviceSize heap = 0;       // the size of each memory heap; 0: the device's own
    bool least = false;          // limits are the least that Vulkan 1.1 allows, but for 12 storage buffers
    bool portability = false;    // VK_KHR_portability_subset is offered
    bool twins = false;          // the first device is there twice, with a uuid that ends in 01 and in 02
    bool reversed = false;       // dispatches between two barriers run in reverse order, the last one first
    Fault fault;
    int sets_left = -1;                           // the descriptor sets that can be allocated; -1: all
    const char* absent = "";                      // a function that is not there
    std::vector<const char*> calls;               // of commands, submissions, what is made and what is destroyed
    std::vector<Barrier>* barriers = nullptr;     // if set, each vkCmdPipelineBarrier that is recorded
    Ledger* ledger = nullptr;                     // if set, what the library is told of its objects
    uint64_t copied = 0;                          // bytes that recorded commands copy from buffer to buffer
    uint64_t groups = 0;                          // workgroups that are recorded and not submitted
    std::vector<uint64_t>* submissions = nullptr; // if set, the workgroups of each submission
};
extern Shim shim; // of all devices whose loader is shimmed()

// While it lives, what is left to a driver for ever does not count as leaked.
#ifdef __SANITIZE_ADDRESS__
using LeftToDriver = __lsan::ScopedDisabler;
#else
struct LeftToDriver {
    LeftToDriver() {}
};
#endif

vulkan::Loader shimmed();
vulkan::Loader faulty(bool Shim::*fault); // nothing but this fault

} // namespace test
