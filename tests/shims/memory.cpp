// SPDX-License-Identifier: MIT
#include "tests/shims/shims.hpp"

#include <algorithm>
#include <cstring>

namespace shims {

uint32_t Memory::real_type(const VkPhysicalDeviceMemoryProperties& real) {
    constexpr VkMemoryPropertyFlags both = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    for (uint32_t i = 0; i < real.memoryTypeCount; ++i)
        if ((real.memoryTypes[i].propertyFlags & both) == both) return i;
    broken("the driver has no coherent memory to stand for all others");
}

Memory::Block& Memory::of(VkDeviceMemory memory) {
    const auto block = std::find_if(blocks_.begin(), blocks_.end(), [=](auto& b) { return b.first == memory; });
    if (block == blocks_.end()) broken("this memory is not allocated");
    return block->second;
}

void Memory::allocated(VkDeviceMemory memory, VkMemoryPropertyFlags flags, VkDeviceSize bytes) {
    blocks_.push_back({memory, {.flags = flags, .bytes = bytes}});
}

void Memory::freed(VkDeviceMemory memory) {
    std::erase_if(blocks_, [=](auto& b) { return b.first == memory; });
}

void* Memory::mapped(VkDeviceMemory memory, VkDeviceSize offset, VkDeviceSize bytes, void* real) {
    Block& block = of(memory);
    if (!(block.flags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)) broken("vkMapMemory of memory that the host cannot see");
    if (block.flags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT) return real;
    block.offset = offset;
    block.real = static_cast<char*>(real);
    block.shadow.assign(size_t(bytes == VK_WHOLE_SIZE ? block.bytes - offset : bytes), 0xcd);
    return block.shadow.data();
}

void Memory::unmapped(VkDeviceMemory memory) {
    Block& block = of(memory);
    block.real = nullptr;
    block.shadow.clear();
}

void Memory::copy(const VkMappedMemoryRange& range, VkDeviceSize atom, bool to_device) {
    Block& block = of(range.memory);
    const VkDeviceSize end = block.offset + block.shadow.size(),
                       last = range.size == VK_WHOLE_SIZE ? end : range.offset + range.size;
    if (!block.real) {
        if (block.flags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT) return;
        broken("a range of memory is flushed or invalidated that is not mapped");
    }
    if (range.offset % atom != 0 || (last % atom != 0 && last != block.bytes))
        broken("a range that is flushed or invalidated is not made of atoms of " + std::to_string(atom) + " bytes");
    if (range.offset < block.offset || last > end) broken("a range is flushed or invalidated beyond what is mapped");
    const size_t first = size_t(range.offset - block.offset), count = size_t(last - range.offset);
    unsigned char* shadow = block.shadow.data() + first;
    if (to_device) std::memcpy(block.real + first, shadow, count);
    else std::memcpy(shadow, block.real + first, count);
}

} // namespace shims
