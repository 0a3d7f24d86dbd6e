// SPDX-License-Identifier: MIT
// Presses of a skin, recorded into the host program's own Vulkan command buffer. The library has no queue, submits
// nothing, allocates no device memory and keeps no state outside these objects: device, memory and frame are the
// host's. This header needs Vulkan headers, no Vulkan library. A program that has volk includes volk.h before it, or
// defines VK_NO_PROTOTYPES, as for every header that includes vulkan_core.h.
//
//     const auto needs = dermis::vulkan::requirements();            // before vkCreateDevice
//     dermis::vulkan::SkinProgram skin(handles, description, 2);    // set-up: checks, pipelines
//     skin.memory();                                                // allocate, fill with the initial bytes
//     dermis::vulkan::Buffers buffers;
//     buffers.constants = constants;
//     buffers.state_from = state0, buffers.state_to = state1;
//     buffers.pressure_from = pressure0, buffers.pressure_to = pressure1;
//     buffers.response = response, buffers.invalid = invalid;
//     dermis::vulkan::Binding binding = skin.bind(buffers);
//     skin.record_press(commands, binding, dt);                     // every frame
//
// A press is a step of dt seconds, over which the pressure runs linearly from pressure_from to pressure_to. The
// responses at its end have the bits of dermis::Skin on the CPU. A skin at rest has states and pressure_from of zeros.
// The next press swaps the two states and the two pressures, by another binding. A press
//   - reads constants, state_from, pressure_from and pressure_to;
//   - writes state_to, response and, if a pressure is not finite, invalid; with Receptors::depth it works in scratch;
//   - writes coefficients into constants if the material varies or has several elements, and for pads
//     (SkinOptions::count). Barriers of its own order this write after the accesses of earlier presses on the queue and
//     before its own reads; so presses of one program must then not run on two queues at once;
//   - clobbers the bound compute pipeline, every descriptor set of the compute bind point (another layout of set 0
//     disturbs the sets behind it) and push constants. All other state of the command buffer stays.
// Barriers are the host's:
//   - first_access() gives the stages and accesses with which a press begins: make its inputs available and visible to
//     them.
//   - last_access() gives the stages and accesses with which a press ends: put a barrier from them between the press
//     and every command that reads its results or overwrites its inputs. The next press does both.
//   - All buffers belong to the queue family that runs the commands.
//   - In a ring of k slots press n reads slot (n - 1) mod k and writes slot n mod k. The last press that read slot n
//     mod k is press n - k + 1: wait for that press before recording press n.
#pragma once

#include <dermis/skin.hpp>

#include <cstdint>

#include <vulkan/vulkan_core.h>

namespace dermis::vulkan {

// What a press needs of a device, to be merged with the needs of the rest of the program. No feature is required, and
// no limit beyond the minimum that Vulkan 1.1 guarantees, except for storage buffers.
struct Requirements {
    uint32_t api_version = VK_API_VERSION_1_1; // least version of instance and device
    uint32_t storage_buffers = 0; // maxPerStageDescriptorStorageBuffers must be at least this (Vulkan guarantees 4)
    std::vector<const char*> required_if_offered; // device extensions to be enabled where the device has them
    // Optional device extensions: where they are enabled, kernels declare rounding to nearest even, and that NaN and
    // infinity are kept. On Vulkan 1.2 kernels do so without them.
    std::vector<const char*> used_if_enabled;
    std::vector<const char*> used_if_enabled_instance; // optional instance extensions: labels in the command buffer
};
DERMIS_API Requirements requirements();

// The host's objects, none null except allocator and cache. They must outlive the program, except for the extensions,
// which are copied.
struct Handles {
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    PFN_vkGetInstanceProcAddr get_instance_proc_addr = nullptr;
    uint32_t api_version = VK_API_VERSION_1_1; // VkApplicationInfo::apiVersion, at least Requirements::api_version
    std::vector<std::string> extensions;       // the extensions enabled on instance and device
    const VkAllocationCallbacks* allocator = nullptr;
    VkPipelineCache cache = VK_NULL_HANDLE;
};

// What a range of a buffer must be; the host creates the buffer.
struct Memory {
    VkDeviceSize bytes = 0;             // least size of the range
    VkDeviceSize alignment = 0;         // alignment of its offset in the buffer: minStorageBufferOffsetAlignment
    VkBufferUsageFlags usage = 0;       // least usage; add the flags of copies that fill or read the range
    std::vector<unsigned char> initial; // first content; empty: zeros, needed only where a press reads before it writes
};

struct MemoryNeeds {
    Memory constants; // one per program: curvature at rest, materials, sites. The host never changes it.
    // Two or more per skin: a press reads one and writes another. Each row of cells has its planes one after another,
    // pitch() floats each: the strain of each element in series; the integral for SA2; last the rate of a spring for
    // FA2. If sums are compensated, each strain and the integral is followed by a plane of what it has lost to
    // rounding. With sites, cells that none of them reads may have any number. A skin of the same description that is
    // given copies of a state and of pressure_to goes on with the same bits. The pads of a batch follow one another,
    // each with an equal part of the range.
    Memory state;
    // float, Pa, pushing is positive; pitch()*height for each pad, row 0 first: index = y*pitch() + x
    Memory pressure;
    Memory response; // float; see range()
    Memory invalid;  // uint32_t: a count, over all presses, of pressures in pressure_to that were not finite (with
                     // sites, in cells that sites read). A press takes such a pressure as 0. The host may clear the
                     // count.
    Memory check;    // for record_check
    Memory scratch;  // float; 0 bytes without Receptors::depth. A press works in it, and expects the zeros that it had.
                     // Presses that run one after another may share it.
};

// The memory of a press. No ranges may overlap, except that ranges that are only read may overlap each other, and that
// pressure_from and pressure_to may be the same range: the pressure is then held.
struct Buffers {
    VkDescriptorBufferInfo constants, state_from, state_to, pressure_from, pressure_to, response, invalid;
    VkDescriptorBufferInfo scratch{}; // none without Receptors::depth
};

// The result of SkinProgram::bind, valid as long as its program.
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

// Queries `first` and `first + 1` of a timestamp pool that the host has reset: the times before and after a press.
struct Timestamps {
    VkQueryPool pool = VK_NULL_HANDLE; // null: none are written; else the queue's family has timestampValidBits > 0
    uint32_t first = 0;
};

// What a press computes beside the state. none: nothing, and the range `response` stays as it is. Several frames of
// which only the last one's responses are read are recorded as a press each, with none for all but the last.
enum class Answers { all, none };

// Whether a press was recorded.
struct Recorded {
    const char* refused = nullptr; // the reason why it was not recorded; null if it was
    operator bool() const noexcept { return !refused; }
};

// A skin's pipelines and descriptor sets. A program outlives the execution of what it has recorded. Several programs,
// devices and threads may work at once: one thread at a time constructs and binds; any number call record_press and the
// other const functions, each with a command buffer of its own.
class DERMIS_API SkinProgram {
  public:
    // max_bindings: number of bind() calls allowed, 1..65536. Throws Error::bad_input naming the fault in description,
    // options or handles, or the extension, limit or function that the device lacks; Error::device naming the call that
    // failed.
    SkinProgram(const Handles&, const SkinDescription&, uint32_t max_bindings, const SkinOptions& = {});
    ~SkinProgram();
    SkinProgram(SkinProgram&&) noexcept;
    SkinProgram& operator=(SkinProgram&&) noexcept;

    // The ranges of memory that presses need.
    const MemoryNeeds& memory() const noexcept;
    // Cells from row to row of pressures and fields: the width rounded up to a multiple of 16, or of 4 in a batch of
    // pads.
    int pitch() const noexcept;
    // The floats of one class (sa1 ..) within a response, pad by pad: a field of pitch()*height, row 0 first, or, if
    // the description has sites, one float per site of that class in the order given. count 0: not asked for.
    struct Range {
        size_t first = 0, count = 0;
    };
    Range range(Quantity) const noexcept;
    // The first and last accesses of a press to its buffers (see the top of this file).
    Access first_access() const noexcept;
    Access last_access() const noexcept;

    // Makes a descriptor set of these ranges, each with a size or VK_WHOLE_SIZE. Throws Error::bad_input if one is
    // too small, misaligned, outside its buffer or overlaps another, or if max_bindings is reached.
    Binding bind(const Buffers&);
    // Records one press, of all pads. dt: s, finite, >= 0; 0 is a pause: the state is kept, and the next press starts
    // at pressure_to. Refuses, and records nothing, if:
    //   - dt is not a finite number >= 0;
    //   - a coefficient of the step is beyond float;
    //   - the binding is not this program's.
    [[nodiscard]] Recorded record_press(VkCommandBuffer, Binding, double dt, const Timestamps& = {},
                                        Answers = Answers::all) const noexcept;
    // Records a press of some pads of a batch; their numbers must ascend. steps: 1 for one dt of all these pads, or one
    // for each. For the other pads the press copies the state and, unless the pressure is held, the pressure; their
    // responses stay as they are. Refuses, and records nothing, also if the numbers do not ascend or the number of
    // steps is wrong.
    [[nodiscard]] Recorded record_press(VkCommandBuffer, Binding, const Pads&, const double* dt, size_t steps,
                                        const Timestamps& = {}, Answers = Answers::all) const noexcept;

    // Records the pressures of a Touch into pressure_to, the range that a press recorded after it reads: zeros, and
    // the cells of Touch::block() of the pads touched, which travel in the command buffer itself, so that the host
    // uploads nothing. The press has the bits of a press of Touch::pressure(). The Touch may be used again at once. The
    // buffer needs VK_BUFFER_USAGE_TRANSFER_DST_BIT. The host sets barriers as for a copy of its own: all accesses are
    // transfer writes. Refuses, and records nothing, if number, size or spacing of the Touch's pads are not the
    // program's, or the range does not hold memory().pressure.bytes.
    [[nodiscard]] Recorded record_touch(VkCommandBuffer, const VkDescriptorBufferInfo& pressure_to,
                                        const contact::Touch&) const noexcept;

    // As Skin::set_material, for the presses that are recorded from now on.
    void set_material(const Material&, const Pads& = {});

    // The check tells whether this device gives the CPU's bits, by two presses of a small skin with these very
    // pipelines. Nothing is known before it has passed. bind_check takes a range of memory().check that holds its
    // initial bytes, preferably host-visible; it is called once. Throws Error::bad_input for a second call, or a range
    // that is too small, misaligned or outside its buffer.
    void bind_check(const VkDescriptorBufferInfo&);
    // Records the check. Returns false, and records nothing, if no range is bound.
    [[nodiscard]] bool record_check(VkCommandBuffer) const noexcept;
    // Compares `bytes`, the content of the range after the check has run, with the CPU's. Throws Error::bad_input if
    // there are fewer than memory().check.bytes.
    bool check_passed(const void* bytes, size_t size) const;

  private:
    friend struct Internal;
    SkinProgram();
    struct DERMIS_HIDDEN Impl;
    std::unique_ptr<Impl> impl_;
};

class [[deprecated("copy host/examples/vulkan_trial.hpp, which has it")]] Trial;

} // namespace dermis::vulkan
