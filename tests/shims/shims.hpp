// SPDX-License-Identifier: MIT
// A Vulkan layer that makes of a device one that is not at hand. The variable DERMIS_SHIM says which one, as "least" or
// "subgroup=16" (tests/shims/README.md lists them). Whatever breaks a rule of that device ends the program with a
// sentence.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

namespace shims {

enum class Kind {
    none,          // a layer that changes nothing
    noncoherent,   // mapped memory is a copy, filled with 0xCD, until ranges are flushed or invalidated
    split,         // the host cannot see device memory
    subgroup,      // the size of a subgroup is `number`
    no_timestamps, // queues write none
    alignment,     // everything begins at multiples of 256 bytes
    least,       // limits are the least that Vulkan 1.1 allows, but for 12 storage buffers; no rounding mode is offered
    few_buffers, // every limit is the least: a shader has 4 storage buffers
    contracting, // a product and a sum are rounded once
    metal,       // arithmetic is that of SPIRV-Cross for Metal: fma(a, b, 0), fma(1, a, b), fma(-1, b, a)
    groups,      // a workgroup of the kernel `press` has `number` invocations
    narrow       // a shader binds `number` bytes of a buffer
};

struct Choice {
    Kind kind = Kind::none;
    uint32_t number = 0;
    std::string name; // as it was asked for
};
const Choice& chosen();
inline bool is(Kind kind) { return chosen().kind == kind; }

[[noreturn]] void broken(const std::string& rule);

// Each makes of the driver's answer that of the device which is chosen.
void change(VkPhysicalDeviceProperties&);
void change(VkPhysicalDeviceSubgroupProperties&);
void change(VkPhysicalDeviceFloatControlsProperties&);
void change(VkPhysicalDeviceMemoryProperties&);
void change(VkQueueFamilyProperties&);
void change(VkMemoryRequirements&);

// Memory as programs see it where that is not the driver's own.
class Memory {
  public:
    static bool changed() { return is(Kind::noncoherent) || is(Kind::split); }
    // Returns the driver's memory type for one that the device seems to have.
    static uint32_t real_type(const VkPhysicalDeviceMemoryProperties& real);
    void allocated(VkDeviceMemory, VkMemoryPropertyFlags, VkDeviceSize bytes);
    void freed(VkDeviceMemory);
    void* mapped(VkDeviceMemory, VkDeviceSize offset, VkDeviceSize bytes, void* real);
    void unmapped(VkDeviceMemory);
    // to_device: a flush, otherwise an invalidation.
    void copy(const VkMappedMemoryRange&, VkDeviceSize atom, bool to_device);

  private:
    struct Block {
        VkMemoryPropertyFlags flags;
        VkDeviceSize bytes;
        VkDeviceSize offset = 0;                // of what is mapped
        char* real = nullptr;                   // where the driver has mapped it
        std::vector<unsigned char> shadow = {}; // what the program sees in its place
    };
    Block& of(VkDeviceMemory);
    std::vector<std::pair<VkDeviceMemory, Block>> blocks_;
};

// Rewrites a module as the device would execute it.
std::vector<uint32_t> change(const uint32_t* code, size_t words);
// Returns whether the host sets the size of a workgroup of this module.
bool has_variable_groups(const uint32_t* code, size_t words);

} // namespace shims
