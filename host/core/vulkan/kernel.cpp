// SPDX-License-Identifier: MIT
#include "host/core/vulkan/kernel.hpp"

#include "dermis/description.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace dermis::vulkan {
namespace {

VkDescriptorType type_of(uint32_t texels, uint32_t binding) {
    return texels >> binding & 1 ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

} // namespace

std::string failure(VkResult result, const char* call) {
    const char* name = "";
    switch (result) {
    case VK_TIMEOUT: name = " (timeout)"; break;
    case VK_ERROR_OUT_OF_HOST_MEMORY: name = " (out of host memory)"; break;
    case VK_ERROR_OUT_OF_DEVICE_MEMORY: name = " (out of device memory)"; break;
    case VK_ERROR_DEVICE_LOST: name = " (device lost)"; break;
    default: break;
    }
    // Only the loader makes instances.
    const bool loader = result == VK_ERROR_OUT_OF_HOST_MEMORY && std::strstr(call, "Instance");
    return std::string(call) + " failed with VkResult " + std::to_string(result) +
           (loader ? ", by which loaders mean that memory is short or that the file of a driver or layer is not JSON; "
                     "VK_LOADER_DEBUG=error names it"
                   : name);
}

void check(VkResult result, const char* call) {
    if (result != VK_SUCCESS) throw Error(Error::Code::device, "", failure(result, call));
}

Pipelines::~Pipelines() {
    const Use use = this->use();
    if (!use) return;
    for (const auto& [key, pipeline] : pipelines_) destroy(*pipeline);
}

void Pipelines::destroy(const Pipeline& p) const {
    device_.calls.vkDestroyPipeline(device_.device, p.pipeline, device_.allocator);
    device_.calls.vkDestroyPipelineLayout(device_.device, p.layout, device_.allocator);
    device_.calls.vkDestroyDescriptorSetLayout(device_.device, p.set_layout, device_.allocator);
}

void Pipelines::drop_unused() {
    const auto unused = [](const auto& entry) { return entry.second.use_count() == 1; };
    if (size_t(std::ranges::count_if(pipelines_, unused)) <= most_unused) return;
    std::erase_if(pipelines_, [&](const auto& entry) {
        if (unused(entry)) destroy(*entry.second);
        return unused(entry);
    });
}

std::shared_ptr<const Pipeline> Pipelines::get(const Module& source, const std::vector<uint32_t>& specialization) {
    const std::pair key(source.code, specialization);
    if (const auto found = pipelines_.find(key); found != pipelines_.end()) return found->second;
    drop_unused();
    const auto own = std::make_shared<Pipeline>();
    const auto entry = pipelines_.emplace(key, own).first;
    Pipeline& made = *own;
    const VolkDeviceTable& vk = device_.calls;
    const VkDevice device = device_.device;
    VkShaderModule module = VK_NULL_HANDLE;
    try {
        std::vector<VkDescriptorSetLayoutBinding> slots(source.bindings);
        for (uint32_t i = 0; i < source.bindings; ++i)
            slots[i] = {i, type_of(source.texels, i), 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
        VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
        set_info.bindingCount = source.bindings;
        set_info.pBindings = slots.data();
        check_made(vk.vkCreateDescriptorSetLayout(device, &set_info, device_.allocator, &made.set_layout),
                   "vkCreateDescriptorSetLayout", made.set_layout);

        const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, source.constants_bytes};
        VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
        layout_info.setLayoutCount = 1;
        layout_info.pSetLayouts = &made.set_layout;
        layout_info.pushConstantRangeCount = 1;
        layout_info.pPushConstantRanges = &range;
        check_made(vk.vkCreatePipelineLayout(device, &layout_info, device_.allocator, &made.layout),
                   "vkCreatePipelineLayout", made.layout);

        VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        const std::vector<uint32_t> words = declare(device_.floats, source);
        module_info.codeSize = words.size() * sizeof(uint32_t);
        module_info.pCode = words.data();
        check_made(vk.vkCreateShaderModule(device, &module_info, device_.allocator, &module), "vkCreateShaderModule",
                   module);

        std::vector<VkSpecializationMapEntry> entries;
        for (uint32_t i = 0; i < specialization.size(); ++i) entries.push_back({i, i * 4, 4});
        const VkSpecializationInfo special{uint32_t(entries.size()), entries.data(), specialization.size() * 4,
                                           specialization.data()};
        VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
        info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
        info.stage.module = module;
        info.stage.pName = "main";
        info.stage.pSpecializationInfo = &special;
        info.layout = made.layout;
        check_made(vk.vkCreateComputePipelines(device, device_.cache, 1, &info, device_.allocator, &made.pipeline),
                   "vkCreateComputePipelines", made.pipeline);
    } catch (...) {
        vk.vkDestroyShaderModule(device, module, device_.allocator);
        destroy(made);
        pipelines_.erase(entry);
        throw;
    }
    vk.vkDestroyShaderModule(device, module, device_.allocator);
    fresh_ = true;
    return own;
}

Kernel::Kernel(Pipelines& pipelines, const Module& module, const std::vector<uint32_t>& specialization,
               uint32_t max_sets)
    : pipelines_(pipelines), constants_bytes_(module.constants_bytes), texels_(module.texels),
      pipeline_(pipelines.get(module, specialization)) {
    const DeviceTable& table = pipelines.device();
    const uint32_t texels = uint32_t(std::popcount(texels_));
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, (module.bindings - texels) * max_sets},
                                          {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, texels * max_sets}};
    VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    info.maxSets = max_sets;
    info.poolSizeCount = texels > 0 ? 2 : 1;
    info.pPoolSizes = sizes;
    check(table.calls.vkCreateDescriptorPool(table.device, &info, table.allocator, &pool_), "vkCreateDescriptorPool");
}

Kernel::~Kernel() {
    const DeviceTable& table = pipelines_.device();
    const Use use = pipelines_.use();
    if (!use) return;
    table.calls.vkDestroyDescriptorPool(table.device, pool_, table.allocator);
    for (std::vector<VkBufferView>& views : views_) destroy_views(views);
}

void Kernel::destroy_views(std::vector<VkBufferView>& views) const {
    const DeviceTable& table = pipelines_.device();
    for (VkBufferView view : views) table.calls.vkDestroyBufferView(table.device, view, table.allocator);
    views.clear();
}

void Kernel::bind(size_t number, const std::vector<BoundRange>& bound) {
    const DeviceTable& table = pipelines_.device();
    if (sets_.size() <= number) {
        views_.resize(number + 1);
        sets_.resize(number + 1, VK_NULL_HANDLE);
    }
    VkDescriptorSet& set = sets_[number];
    VkDescriptorSetAllocateInfo allocation{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocation.descriptorPool = pool_;
    allocation.descriptorSetCount = 1;
    allocation.pSetLayouts = &pipeline_->set_layout;
    if (!set) check(table.calls.vkAllocateDescriptorSets(table.device, &allocation, &set), "vkAllocateDescriptorSets");
    std::vector<VkDescriptorBufferInfo> ranges;
    for (const BoundRange& b : bound) ranges.push_back({b.range.buffer, b.range.offset, b.range.bytes});
    std::vector<VkBufferView>& views = views_[number];
    destroy_views(views);
    views.reserve(bound.size()); // the descriptors point into it
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    std::vector<VkWriteDescriptorSet> writes(bound.size(), write);
    for (uint32_t i = 0; i < writes.size(); ++i) {
        writes[i].dstSet = set;
        writes[i].dstBinding = bound[i].binding;
        writes[i].descriptorCount = 1;
        writes[i].descriptorType = type_of(texels_, bound[i].binding);
        writes[i].pBufferInfo = &ranges[i];
        if (writes[i].descriptorType == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER) continue;
        VkBufferViewCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
        info.buffer = ranges[i].buffer;
        info.format = VK_FORMAT_R32G32B32A32_UINT;
        info.offset = ranges[i].offset;
        info.range = ranges[i].range;
        VkBufferView view = VK_NULL_HANDLE;
        check(table.calls.vkCreateBufferView(table.device, &info, table.allocator, &view), "vkCreateBufferView");
        writes[i].pTexelBufferView = &views.emplace_back(view);
    }
    table.calls.vkUpdateDescriptorSets(table.device, uint32_t(writes.size()), writes.data(), 0, nullptr);
}

void Kernel::record(VkCommandBuffer commands, size_t set, const void* constants, uint32_t x, uint32_t y,
                    uint32_t z) const noexcept {
    const VolkDeviceTable& vk = pipelines_.device().calls;
    vk.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_->pipeline);
    vk.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_->layout, 0, 1, &sets_[set], 0,
                               nullptr);
    vk.vkCmdPushConstants(commands, pipeline_->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, constants_bytes_, constants);
    vk.vkCmdDispatch(commands, x, y, z);
}

} // namespace dermis::vulkan
