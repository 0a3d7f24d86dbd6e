// SPDX-License-Identifier: MIT
// A list of the Vulkan objects that are there, by which what is left, destroyed twice or destroyed too early is found.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace test {

class Ledger {
  public:
    // These tell what happened: an object was made or ended, a submission began or its fence was waited for.
    // owner: the device, or what a device was made of.
    void made(const char* call, uint64_t owner, uint64_t handle);
    void found_device(uint64_t physical, uint64_t instance) { instance_of_[physical] = instance; }
    // Returns false where no such object is there, which the driver should then not see.
    bool ended(const char* call, uint64_t handle);
    void submitted(uint64_t fence, bool accepted);
    void waited(uint64_t device, uint64_t fence, bool done);
    void lose(uint64_t device);

    // The number of submissions, of all devices, that may be running: neither they nor later ones were waited for.
    size_t running() const;
    bool lost(uint64_t device) const { return lost_.count(device) > 0; }
    // Returns the kinds of the objects that are there, but for those of lost devices and their instances.
    std::vector<std::string> left() const;
    // Returns in words what was ended wrongly, and forgets it.
    std::vector<std::string> faults() { return std::exchange(faults_, {}); }

  private:
    using Object = std::pair<std::string, uint64_t>; // kind and handle
    bool is_running(const Object&, uint64_t owner) const;

    std::map<Object, uint64_t> owners_;        // of the objects that are not left to a driver
    std::set<Object> left_to_driver_;          // lost devices, their objects and their instances
    std::map<uint64_t, uint64_t> instance_of_; // of a physical device
    std::set<uint64_t> lost_;                  // devices
    // Of each device the fences of its submissions that may be running, in the order in which they were submitted.
    std::map<uint64_t, std::vector<uint64_t>> running_;
    std::vector<std::string> faults_;
};

} // namespace test
