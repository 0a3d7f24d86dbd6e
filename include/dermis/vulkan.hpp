// SPDX-License-Identifier: MIT
// Presses recorded into somebody else's Vulkan command buffer: no queue, no submission, no device memory of its own, no
// state outside these objects. Device, memory and frame stay the host's. Needs Vulkan headers, no Vulkan library. A
// program that has volk includes volk.h before this, or defines VK_NO_PROTOTYPES, as for every header that brings
// vulkan_core.h.
//
//     const auto needs = dermis::vulkan::requirements();                     // before vkCreateDevice
//     dermis::vulkan::SkinProgram skin(handles, description, 2);             // set-up: checks, pipelines
//     skin.memory();                                                         // allocate, fill with the initial bytes
//     Binding b = skin.bind({constants, state0, state1, pressure0, pressure1, response, invalid});
//     skin.record_press(commands, b, dt);                                    // every frame
//
// A press takes the skin from state_from to state_to while the pressure runs straight from pressure_from to pressure_to
// in dt seconds, and writes the responses at its end: the bits of dermis::Skin on the CPU. At first states and
// pressure_from are zeros: a skin at rest. For the next press states and pressures change places, by another binding.
//
// Barriers are the host's. A press first accesses its buffers as first_access() says and last as last_access() says; it
// reads constants, state_from, pressure_from and pressure_to, and overwrites state_to, response and, where a pressure
// is not finite, invalid. Where material varies from cell to cell it also writes coefficients into constants, with
// barriers of its own around that: presses of one program are then not for two queues at once. Make what it reads
// available and visible to first_access(), and put a barrier from last_access() between it and whatever reads what it
// has written or writes what it reads, the next press too. What else stands in the command buffer stays, but for the
// bound compute pipeline, every descriptor set of the compute bind point (another layout of set 0 disturbs those behind
// it) and push constants. All buffers belong to the queue family that runs the commands. In a ring of k slots press n
// reads slot n - 1 as well: the slot that it writes is free when press n - k + 1 is done.
#pragma once

#include "dermis/dermis.hpp"

#include <vulkan/vulkan_core.h>

namespace dermis::vulkan {

// What a device must have, to be merged with what the rest of the program asks for. No feature is needed, and of the
// limits nothing beyond the least that Vulkan 1.1 allows, but for the storage buffers.
struct Requirements {
    uint32_t api_version = VK_API_VERSION_1_1;    // of instance and device, at least
    uint32_t storage_buffers = 12;                // maxPerStageDescriptorStorageBuffers, at least (Vulkan's least is 4)
    std::vector<const char*> required_if_offered; // device extensions
    // Device extensions: round-to-nearest-even is then declared, as it is where host and device have Vulkan 1.2.
    std::vector<const char*> used_if_enabled;
    std::vector<const char*> used_if_enabled_instance; // instance extensions: labels in the command buffer
};
DERMIS_API Requirements requirements();

// The host's own. What is given here outlives the program, but for the extensions, which are copied.
struct Handles {
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    PFN_vkGetInstanceProcAddr get_instance_proc_addr = nullptr;
    uint32_t api_version = VK_API_VERSION_1_1; // VkApplicationInfo::apiVersion
    std::vector<std::string> extensions;       // enabled, of instance and device
    const VkAllocationCallbacks* allocator = nullptr;
    VkPipelineCache cache = VK_NULL_HANDLE;
};

// A range of a buffer that the host makes.
struct Memory {
    VkDeviceSize bytes = 0;             // of the range, at least
    VkDeviceSize alignment = 0;         // of its offset in the buffer: minStorageBufferOffsetAlignment
    VkBufferUsageFlags usage = 0;       // at least; to fill or read it by copies add theirs
    std::vector<unsigned char> initial; // what it holds at first; empty: zeros, where it is read before it is written
};

struct MemoryNeeds {
    Memory constants; // one per program: curvature at rest, materials, sites. The host never changes it.
    Memory state;     // two at least, for each skin: a press reads one and writes another
    Memory pressure;  // float, Pa, pushing is positive; pitch()*height, row 0 first: index = y*pitch() + x
    Memory response;  // float; see range()
    Memory invalid;   // uint32_t: adds up the cells of pressure_to, or of those that sites look at, that were not
                      // finite, each counted as 0. The host may clear it.
    Memory check;     // see record_check
};

// Where a press finds its memory. Only pressure_from and pressure_to may be the same range (a pressure that is held) or
// overlap others that are only read.
struct Buffers {
    VkDescriptorBufferInfo constants, state_from, state_to, pressure_from, pressure_to, response, invalid;
};

// Of SkinProgram::bind; good as long as its program.
class Binding {
    friend class SkinProgram;
    const void* program = nullptr;
    uint32_t set = UINT32_MAX;
};

// One side of a barrier.
struct Access {
    VkPipelineStageFlags stages;
    VkAccessFlags access;
};

// Queries `first` and `first + 1` of a pool of timestamps, which the host has reset: before and after.
struct Timestamps {
    VkQueryPool pool = VK_NULL_HANDLE; // none: not written
    uint32_t first = 0;
};

// Outlives the execution of what it has recorded. Several programs, devices and threads may be at work at once. Set-up
// by one thread at a time; record_press and the other const functions from any number, each into a command buffer of
// its own.
class DERMIS_API SkinProgram {
  public:
    // max_bindings: how often bind() may be called, 1..65536. Throws Error::bad_input naming what is wrong with
    // description, options or handles, or which extension, limit or function the device lacks; Error::device naming the
    // call that failed.
    SkinProgram(const Handles&, const SkinDescription&, uint32_t max_bindings, const SkinOptions& = {});
    ~SkinProgram();
    SkinProgram(SkinProgram&&) noexcept;
    SkinProgram& operator=(SkinProgram&&) noexcept;

    const MemoryNeeds& memory() const noexcept;
    int pitch() const noexcept; // cells from row to row of pressures and fields: the width rounded up to 16
    // Where in a response the floats of sa1, sa2, fa1 or fa2 stand: as a field pitch()*height, row 0 first, or, where
    // the description has sites, those of that class in the order given. count 0: not asked for.
    struct Range {
        size_t first = 0, count = 0;
    };
    Range range(Quantity) const noexcept;
    Access first_access() const noexcept;
    Access last_access() const noexcept;

    // Throws Error::bad_input where a range is too small, misaligned, outside its buffer, overlaps another, or too many
    // have been bound.
    Binding bind(const Buffers&);
    // dt >= 0 s; 0 is a pause: the state is kept, and the next press begins with pressure_to. False, and nothing is
    // recorded, where dt is not a finite number >= 0, where a coefficient of the step is beyond float, or where the
    // binding is not this program's.
    [[nodiscard]] bool record_press(VkCommandBuffer, Binding, double dt, const Timestamps& = {}) const noexcept;

    // Whether this device gives the CPU's bits: two presses of a small skin by these very pipelines. Bind a range of
    // memory().check that holds its initial bytes (host-visible memory is the shortest way), record, submit, and hand
    // over the bytes of the range. Until it has passed nothing is known. record_check is false where none is bound.
    void bind_check(const VkDescriptorBufferInfo&);
    [[nodiscard]] bool record_check(VkCommandBuffer) const noexcept;
    bool check_passed(const void* bytes) const;

  private:
    friend struct Internal;
    SkinProgram();
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace dermis::vulkan
