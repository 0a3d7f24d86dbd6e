// SPDX-License-Identifier: MIT
// What stands between the library and the real loader: faults, smaller limits, and a log of calls.
#pragma once

#include "host/vulkan/instance.hpp"

#include <functional>

namespace test {

using namespace dermis;

struct Shim {
    bool no_driver = false, no_compute = false, few_buffers = false;
    bool miscompile = false;        // the 1 of every response is wrong
    bool miscompile_far = false;    // 4/3 of the fourth-order stencil is wrong
    uint32_t range = 0;             // maxStorageBufferRange; 0: the device's own
    bool least = false;             // limits are the least that Vulkan 1.1 allows, but for 12 storage buffers
    bool portability = false;       // VK_KHR_portability_subset is offered
    bool timeout = false;           // submissions do not come back in time
    int sets_left = -1;             // the descriptor sets that can be allocated; -1: all
    const char* absent = "";        // a function that is not there
    std::vector<const char*> calls; // of commands, submissions and what is made
};
extern Shim shim; // of all devices whose loader is shimmed()

vulkan::Loader shimmed();
vulkan::Loader faulty(bool Shim::*fault); // nothing but this fault

} // namespace test
