// SPDX-License-Identifier: MIT
// The kernels `halve` and `spread` over memory of the caller's: they spread the signals of classes to their depths, and
// answer there.
#pragma once

#include "host/core/model/streamed_skin.hpp"
#include "host/core/vulkan/recording.hpp"

#include <map>

namespace dermis::vulkan {

class SpreadKernel {
  public:
    struct Maps {
        BufferRange scratch, weights, response;
        BufferRange pads; // the list of pads of a press; any range for a single skin
    };
    // pads_of_group: the list of pads ends with a workgroup of so many. Throws Error::bad_input for maps beyond the
    // limits of the device.
    SpreadKernel(Pipelines&, const model::StreamedSkin&, const model::ResponseLayout&, size_t pads_of_group,
                 uint32_t max_bindings);
    // Floats that presses work in, zeros at first.
    VkDeviceSize scratch_bytes() const { return scratch_bytes_; }
    // Where `press` writes the signal of a class.
    BufferRange signal(int quantity, const BufferRange& scratch) const {
        return part_of(scratch, signal_[size_t(quantity)]);
    }
    BufferRange gain(const BufferRange& scratch) const { return part_of(scratch, gain_); } // and the cells' gain
    const std::vector<float>& weights() const { return weights_; }                         // of all levels
    void bind(size_t binding, const Maps&);
    // Records what follows a press of the pads list[first] .. list[last - 1]. own: see PressKernel::record().
    void record(VkCommandBuffer, size_t binding, const model::PadList& list, size_t first, size_t last,
                Recording* own) const;
    double work_of_pad() const { return work_; }
    bool copies() const { return !picks_.empty(); } // a press ends with a copy

  private:
    using Specialization = std::vector<uint32_t>;
    struct Part { // of the scratch memory, in bytes
        VkDeviceSize first = 0, bytes = 0;
    };
    struct Use { // of a kernel, for one class
        f32::SpreadConstants constants;
        double work_of_row;
        const Specialization* kernel;
        size_t number; // among the uses of the kernel
        Part fine, coarse, to;
        bool answers; // `to` is a part of the response
    };
    static BufferRange part_of(const BufferRange& all, const Part& part) {
        return {all.buffer, all.offset + part.first, part.bytes};
    }
    f32::NodeMap map_of(const model::SpreadLevel&) const;
    Part take(size_t floats);
    Part take(const model::SpreadLevel& level) {
        return take(size_t(map_of(level).pad) * size_t(pads_) + 2 * SPREAD_MARGIN);
    }
    void add(size_t pass, Use, int radius, bool coarser);
    void plan(const model::StreamedSkin&, int quantity, const Part& response);
    void pick(const model::StreamedSkin&, const model::ResponseLayout&, const std::array<Part, REDUCED_MAPS>& fields);

    const DeviceTable& device_;
    const int pads_;
    std::array<int, 3> group_; // size of a workgroup
    VkDeviceSize scratch_bytes_ = 0;
    std::array<Part, REDUCED_MAPS> signal_; // by quantity
    Part gain_;
    std::vector<float> weights_;
    std::map<Specialization, size_t> kinds_; // the number of uses of each kernel
    std::map<Specialization, Kernel> kernels_;
    std::vector<std::vector<Use>> passes_; // one after another
    double work_ = 0;
    std::vector<VkBufferCopy> picks_; // of sites, from fields in the scratch memory to the response, pad by pad
    struct Copy {
        VkBuffer from, to;
        std::vector<VkBufferCopy> regions;
    };
    std::vector<Copy> copies_; // the picks of each binding
};

} // namespace dermis::vulkan
