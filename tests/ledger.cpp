// SPDX-License-Identifier: MIT
#include "tests/ledger.hpp"

#include <algorithm>

namespace test {
namespace {

// "Buffer" of vkCreateBuffer and vkDestroyBuffer.
std::string kind_of(const std::string& call) {
    if (call == "vkCreateComputePipelines") return "Pipeline";
    for (const std::string begin : {"vkCreate", "vkAllocate", "vkDestroy", "vkFree"})
        if (call.rfind(begin, 0) == 0) return call.substr(begin.size());
    return call;
}

} // namespace

void Ledger::made(const char* call, uint64_t owner, uint64_t handle) {
    const Object object{kind_of(call), handle};
    if (object.first == "Device") {
        owner = instance_of_[owner];
        lost_.erase(handle); // a handle may come again after its device has been destroyed
    }
    if (lost_.count(owner)) left_to_driver_.insert(object);
    else owners_[object] = owner;
}

// Whether an object is a device that runs a submission, an object of one, or the instance that one was made of. A fence
// is only its own submission's.
bool Ledger::is_running(const Object& object, uint64_t owner) const {
    if (object.first == "Device") return running_.count(object.second) > 0;
    if (object.first != "Instance") {
        const auto fences = running_.find(owner);
        if (fences == running_.end()) return false;
        return object.first != "Fence" || std::ranges::count(fences->second, object.second) > 0;
    }
    for (const auto& [other, of] : owners_)
        if (other.first == "Device" && of == object.second && running_.count(other.second)) return true;
    return false;
}

bool Ledger::ended(const char* call, uint64_t handle) {
    if (handle == 0) return true;
    const Object object{kind_of(call), handle};
    const auto found = owners_.find(object);
    const bool of_lost = left_to_driver_.count(object) > 0;
    if (found == owners_.end() && !of_lost) {
        faults_.push_back(std::string(call) + " of what is not there");
        return false;
    }
    if (of_lost || is_running(object, found->second)) faults_.push_back(std::string(call) + " of what may be in use");
    if (left_to_driver_.erase(object)) return true;
    const bool owns = object.first == "Device" || object.first == "Instance";
    owners_.erase(found);
    if (owns)
        for (const auto& [other, owner] : owners_)
            if (owner == handle) faults_.push_back(std::string(call) + " before its " + other.first);
    return true;
}

void Ledger::submitted(uint64_t fence, bool accepted) {
    const auto found = owners_.find({"Fence", fence});
    const uint64_t device = found == owners_.end() ? 0 : found->second;
    running_[device].push_back(fence);
    if (!accepted) lose(device);
}

void Ledger::waited(uint64_t device, uint64_t fence, bool done) {
    if (!done) return lose(device);
    std::vector<uint64_t>& fences = running_[device];
    const auto at = std::find(fences.begin(), fences.end(), fence);
    if (at != fences.end()) fences.erase(fences.begin(), at + 1);
    if (fences.empty()) running_.erase(device);
}

size_t Ledger::running() const {
    size_t all = 0;
    for (const auto& [device, fences] : running_) all += fences.size();
    return all;
}

void Ledger::lose(uint64_t device) {
    lost_.insert(device);
    const auto of = owners_.find({"Device", device});
    const uint64_t instance = of == owners_.end() ? 0 : of->second;
    for (auto i = owners_.begin(); i != owners_.end();) {
        const auto& [object, owner] = *i;
        const bool its =
            owner == device || object == Object("Device", device) || object == Object("Instance", instance);
        if (its) left_to_driver_.insert(object);
        i = its ? owners_.erase(i) : std::next(i);
    }
}

std::vector<std::string> Ledger::left() const {
    std::vector<std::string> kinds;
    for (const auto& [object, owner] : owners_) kinds.push_back(object.first);
    return kinds;
}

} // namespace test
