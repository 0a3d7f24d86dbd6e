// SPDX-License-Identifier: MIT
#include "tests/ledger.hpp"

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
    owners_[object] = owner;
}

// Whether an object is one of these devices, an object of theirs, or the instance that one was made of.
bool Ledger::is_of(const std::set<uint64_t>& devices, const Object& object, uint64_t owner) const {
    if (object.first != "Instance") return devices.count(object.first == "Device" ? object.second : owner) > 0;
    for (const auto& [other, of] : owners_)
        if (other.first == "Device" && of == object.second && devices.count(other.second)) return true;
    return false;
}

bool Ledger::ended(const char* call, uint64_t handle) {
    if (handle == 0) return true;
    const auto found = owners_.find({kind_of(call), handle});
    if (found == owners_.end()) {
        faults_.push_back(std::string(call) + " of what is not there");
        return false;
    }
    if (is_of(lost_, found->first, found->second) || is_of(running_, found->first, found->second))
        faults_.push_back(std::string(call) + " of what may be in use");
    const bool owns = found->first.first == "Device" || found->first.first == "Instance";
    owners_.erase(found);
    if (owns)
        for (const auto& [object, owner] : owners_)
            if (owner == handle) faults_.push_back(std::string(call) + " before its " + object.first);
    return true;
}

void Ledger::submitted(uint64_t fence, bool accepted) {
    const uint64_t device = owners_[{"Fence", fence}];
    running_.insert(device);
    if (!accepted) lose(device);
}

void Ledger::waited(uint64_t device, bool done) {
    if (done) running_.erase(device);
    else lose(device);
}

std::vector<std::string> Ledger::left() const {
    std::vector<std::string> kinds;
    for (const auto& [object, owner] : owners_)
        if (!is_of(lost_, object, owner)) kinds.push_back(object.first);
    return kinds;
}

} // namespace test
