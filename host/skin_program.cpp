// SPDX-License-Identifier: MIT
// dermis::vulkan::SkinProgram: handles and buffers checked, presses recorded, the CPU path as judge.
#include "host/cpu/stream.hpp"
#include "host/plan/float_environment.hpp"
#include "host/plan/stepper.hpp"
#include "host/scene/refusal.hpp"
#include "host/vulkan/instance.hpp"
#include "host/vulkan/recorder.hpp"
#include "host/vulkan/requirements.hpp"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {
namespace {

using scene::refuse;

constexpr double check_dt = 0.125;
constexpr int check_presses = 2;

[[noreturn]] void lacks(const char* parameter, const std::string& what) {
    throw Error(Error::Code::bad_input, parameter, what);
}

template <class Function> Function function(const Handles& h, const char* name) {
    const auto f = reinterpret_cast<Function>(h.get_instance_proc_addr(h.instance, name));
    if (!f) lacks("get_instance_proc_addr", std::string("get_instance_proc_addr finds no ") + name);
    return f;
}

// What recording needs of the device, after everything about the handles has been looked at.
DeviceTable checked(const Handles& h) {
    const auto need = [](bool there, const char* parameter) {
        if (!there) refuse(parameter, "null", "a handle of the host's own device");
    };
    need(h.instance, "instance");
    need(h.physical, "physical");
    need(h.device, "device");
    need(h.get_instance_proc_addr, "get_instance_proc_addr");
    VkPhysicalDeviceProperties properties{};
    function<PFN_vkGetPhysicalDeviceProperties>(h, "vkGetPhysicalDeviceProperties")(h.physical, &properties);
    const auto version = [](uint32_t v) {
        return std::to_string(VK_API_VERSION_MAJOR(v)) + "." + std::to_string(VK_API_VERSION_MINOR(v));
    };
    const uint32_t least = requirements().api_version;
    for (uint32_t v : {h.api_version, properties.apiVersion})
        if (v < least) refuse("api_version", version(v), "at least " + version(least) + ", of instance and device");
    if (const std::string limit = why_not(properties.limits); !limit.empty())
        lacks("physical", std::string(properties.deviceName) + ": " + limit);
    const auto enumerate =
        function<PFN_vkEnumerateDeviceExtensionProperties>(h, "vkEnumerateDeviceExtensionProperties");
    uint32_t count = 0;
    check(enumerate(h.physical, nullptr, &count, nullptr), "vkEnumerateDeviceExtensionProperties");
    std::vector<VkExtensionProperties> offered(count);
    check(enumerate(h.physical, nullptr, &count, offered.data()), "vkEnumerateDeviceExtensionProperties");
    for (const char* name : requirements().required_if_offered)
        for (const VkExtensionProperties& e : offered)
            if (std::strcmp(e.extensionName, name) == 0 &&
                std::find(h.extensions.begin(), h.extensions.end(), name) == h.extensions.end())
                refuse("extensions", std::string("without ") + name, "with it, because this device offers it");
    DeviceTable gpu;
    gpu.device = h.device;
    gpu.limits = properties.limits;
    gpu.allocator = h.allocator;
    gpu.cache = h.cache;
    std::vector<std::string> enabled = h.extensions;
    if (std::min(h.api_version, properties.apiVersion) >= VK_API_VERSION_1_2) // part of it
        enabled.push_back(VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME);
    gpu.rounds = rounds_to_even(function<PFN_vkGetPhysicalDeviceProperties2>(h, "vkGetPhysicalDeviceProperties2"),
                                h.physical, enabled);
    function<PFN_vkGetDeviceProcAddr>(h, "vkGetDeviceProcAddr");
    load_calls(h.get_instance_proc_addr, h.instance, gpu);
    const VolkDeviceTable& vk = gpu.calls;
#define NAMED(f)                                                                                                       \
    std::pair { #f, reinterpret_cast < PFN_vkVoidFunction>(vk.f) }
    for (const auto& [name, found] : {NAMED(vkAllocateDescriptorSets),
                                      NAMED(vkCmdBindDescriptorSets),
                                      NAMED(vkCmdBindPipeline),
                                      NAMED(vkCmdDispatch),
                                      NAMED(vkCmdPipelineBarrier),
                                      NAMED(vkCmdPushConstants),
                                      NAMED(vkCmdUpdateBuffer),
                                      NAMED(vkCmdWriteTimestamp),
                                      NAMED(vkCreateComputePipelines),
                                      NAMED(vkCreateDescriptorPool),
                                      NAMED(vkCreateDescriptorSetLayout),
                                      NAMED(vkCreatePipelineLayout),
                                      NAMED(vkCreateShaderModule),
                                      NAMED(vkDestroyDescriptorPool),
                                      NAMED(vkDestroyDescriptorSetLayout),
                                      NAMED(vkDestroyPipeline),
                                      NAMED(vkDestroyPipelineLayout),
                                      NAMED(vkDestroyShaderModule),
                                      NAMED(vkGetBufferMemoryRequirements),
                                      NAMED(vkUpdateDescriptorSets)})
        if (!found) lacks("get_instance_proc_addr", std::string("get_instance_proc_addr finds no ") + name);
#undef NAMED
    return gpu;
}

// The skin that the device is tested on: small, but of the same kernels as `plan`.
plan::Plan check_plan(const plan::Plan& plan) {
    const SkinDescription& like = plan.scene;
    SkinDescription d = plan::sample_skin(*like.stencil, *like.edges, !plan.material.empty());
    SkinOptions options;
    options.precision = plan.precision;
    options.responses.clear();
    for (int q = 1; q < REDUCED_MAPS; ++q) {
        if (!plan.wanted[q]) continue;
        options.responses.push_back(Quantity(q));
        if (!like.sites.empty())
            for (int i = 0; i < 24; ++i)
                d.sites.push_back({Quantity(q), {(q * 31 + i * i * 7) % d.grid.width, i * 5 % d.grid.height}});
    }
    return plan::skin_plan(d, options);
}

} // namespace

struct SkinProgram::Impl {
    Impl(const Handles& h, plan::Plan&& plan, uint32_t max_bindings)
        : gpu(checked(h)), pipelines(gpu), check_with(pipelines, check_plan(plan), check_presses),
          recorder(pipelines, std::move(plan), max_bindings), max_bindings(max_bindings) {
        needs = recorder.needs();
        needs.check = check_memory();
        if (std::find(h.extensions.begin(), h.extensions.end(), VK_EXT_DEBUG_UTILS_EXTENSION_NAME) !=
            h.extensions.end()) {
            begin_label = function<PFN_vkCmdBeginDebugUtilsLabelEXT>(h, "vkCmdBeginDebugUtilsLabelEXT");
            end_label = function<PFN_vkCmdEndDebugUtilsLabelEXT>(h, "vkCmdEndDebugUtilsLabelEXT");
        }
    }

    // Of the check's one range: constants, two states, three pressures, a response per press, what was not finite.
    struct Layout {
        VkDeviceSize constants = 0, state[2], pressure[3], response[check_presses], invalid, end = 0;
    };
    Layout layout_of_check() const {
        const MemoryNeeds& n = check_with.needs();
        Layout l;
        const auto place = [&](const Memory& m) {
            const VkDeviceSize at = l.end;
            l.end = (at + m.bytes + 255) / 256 * 256; // the most that a device may ask of an offset
            return at;
        };
        l.constants = place(n.constants);
        for (VkDeviceSize& at : l.state) at = place(n.state);
        for (VkDeviceSize& at : l.pressure) at = place(n.pressure);
        for (VkDeviceSize& at : l.response) at = place(n.response);
        l.invalid = place(n.invalid);
        return l;
    }

    // Frame i of the check: at rest, noise, other noise with two cells that are not finite.
    std::vector<float> check_frame(int i) const {
        const plan::Plan& plan = check_with.plan();
        std::vector<float> map = plan::padded<float>(plan::sample_pressure(), plan, "");
        if (i == 0) std::fill(map.begin(), map.end(), 0.0f);
        if (i == 2) std::reverse(map.begin(), map.end());
        return map;
    }
    // Where two of the cells are that the check's skin looks at.
    std::array<size_t, 2> not_finite() const {
        const plan::Plan& plan = check_with.plan();
        const auto at = [&](Cell c) { return size_t(c.y) * size_t(plan.pitch) + size_t(c.x); };
        if (plan.scene.sites.empty()) return {at({3, 2}), at({66, 12})};
        return {at(plan.scene.sites[0].cell), at(plan.scene.sites[1].cell)};
    }

    Memory check_memory() const {
        Memory m = check_with.needs().constants;
        const Layout l = layout_of_check();
        m.initial.resize(l.end, 0);
        m.bytes = l.end;
        for (int i = 0; i < 3; ++i) {
            std::vector<float> map = check_frame(i);
            if (i == 2) map[not_finite()[0]] = NAN, map[not_finite()[1]] = -INFINITY;
            std::memcpy(m.initial.data() + l.pressure[i], map.data(), map.size() * sizeof(float));
        }
        return m;
    }

    void check_range(const char* name, const VkDescriptorBufferInfo& b, const Memory& m) const {
        const std::string parameter = name;
        if (!b.buffer)
            refuse(parameter + ".buffer", "null", "a buffer of at least " + std::to_string(m.bytes) + " bytes");
        if (b.offset % m.alignment != 0)
            refuse(parameter + ".offset", std::to_string(b.offset),
                   "a multiple of minStorageBufferOffsetAlignment = " + std::to_string(m.alignment));
        if (b.range < m.bytes || b.range == VK_WHOLE_SIZE)
            refuse(parameter + ".range", b.range == VK_WHOLE_SIZE ? "VK_WHOLE_SIZE" : std::to_string(b.range),
                   "at least " + std::to_string(m.bytes) + " bytes, and a number");
        VkMemoryRequirements there{};
        gpu.calls.vkGetBufferMemoryRequirements(gpu.device, b.buffer, &there);
        if (b.offset > there.size || b.range > there.size - b.offset)
            refuse(parameter, std::to_string(b.offset) + " + " + std::to_string(b.range) + " bytes",
                   "within the buffer, which has at most " + std::to_string(there.size));
    }

    const DeviceTable gpu;
    Pipelines pipelines;
    Recorder check_with, recorder;
    uint32_t max_bindings, bindings = 0;
    MemoryNeeds needs;
    PFN_vkCmdBeginDebugUtilsLabelEXT begin_label = nullptr;
    PFN_vkCmdEndDebugUtilsLabelEXT end_label = nullptr;
    bool check_bound = false;
};

namespace {

plan::Plan planned(const SkinDescription& d, uint32_t max_bindings, const SkinOptions& options) {
    scene::need(max_bindings >= 1 && max_bindings <= 65536, "max_bindings", max_bindings, "1..65536");
    return plan::skin_plan(d, options);
}

} // namespace

SkinProgram::SkinProgram(const Handles& handles, const SkinDescription& description, uint32_t max_bindings,
                         const SkinOptions& options) {
    const DefaultFloats guard;
    impl_ = std::make_unique<Impl>(handles, planned(description, max_bindings, options), max_bindings);
}

SkinProgram::~SkinProgram() = default;
SkinProgram::SkinProgram(SkinProgram&&) noexcept = default;
SkinProgram& SkinProgram::operator=(SkinProgram&&) noexcept = default;

const MemoryNeeds& SkinProgram::memory() const noexcept { return impl_->needs; }

int SkinProgram::pitch() const noexcept { return impl_->recorder.plan().pitch; }

SkinProgram::Range SkinProgram::range(Quantity q) const noexcept {
    if (q < Quantity::sa1 || q > Quantity::fa2) return {};
    const plan::ResponseLayout::Range& r = impl_->recorder.answers().of[size_t(q)];
    return {r.first, r.count};
}

Access SkinProgram::first_access() const noexcept {
    Access a{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
    if (impl_->recorder.writes_constants()) {
        a.stages |= VK_PIPELINE_STAGE_TRANSFER_BIT;
        a.access |= VK_ACCESS_TRANSFER_WRITE_BIT;
    }
    return a;
}

Access SkinProgram::last_access() const noexcept {
    return {VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT};
}

Binding SkinProgram::bind(const Buffers& b) {
    Impl& impl = *impl_;
    struct Named {
        const char* name;
        const VkDescriptorBufferInfo& info;
        const Memory& needs;
        bool written;
    };
    const MemoryNeeds& n = impl.needs;
    const Named all[] = {{"constants", b.constants, n.constants, impl.recorder.writes_constants()},
                         {"state_from", b.state_from, n.state, false},
                         {"state_to", b.state_to, n.state, true},
                         {"pressure_from", b.pressure_from, n.pressure, false},
                         {"pressure_to", b.pressure_to, n.pressure, false},
                         {"response", b.response, n.response, true},
                         {"invalid", b.invalid, n.invalid, true}};
    for (const Named& one : all) impl.check_range(one.name, one.info, one.needs);
    for (const Named& one : all)
        for (const Named& other : all)
            if (&one != &other && one.written && one.info.buffer == other.info.buffer &&
                one.info.offset < other.info.offset + other.needs.bytes &&
                other.info.offset < one.info.offset + one.needs.bytes)
                refuse(one.name, "in the same memory as " + std::string(other.name),
                       "memory of its own, because a press writes it");
    if (impl.bindings == impl.max_bindings)
        refuse("max_bindings", std::to_string(impl.max_bindings), "as many as are bound, and this is one more");
    Binding binding;
    binding.program = impl_.get();
    binding.set = impl.bindings;
    impl.recorder.bind(binding.set, b);
    ++impl.bindings;
    return binding;
}

bool SkinProgram::record_press(VkCommandBuffer commands, Binding binding, double dt,
                               const Timestamps& stamps) const noexcept {
    const Impl& impl = *impl_;
    if (!scene::finite(dt) || dt < 0 || binding.program != &impl) return false;
    if (!impl.recorder.in_float(dt)) return false;
    const VolkDeviceTable& vk = impl.gpu.calls;
    VkDebugUtilsLabelEXT label{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
    label.pLabelName = "dermis press";
    if (impl.begin_label) impl.begin_label(commands, &label);
    if (stamps.pool) vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, stamps.pool, stamps.first);
    impl.recorder.record(commands, binding.set, dt);
    if (stamps.pool)
        vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, stamps.pool, stamps.first + 1);
    if (impl.begin_label) impl.end_label(commands);
    return true;
}

void SkinProgram::bind_check(const VkDescriptorBufferInfo& range) {
    Impl& impl = *impl_;
    impl.check_range("check", range, impl.needs.check);
    if (impl.check_bound) refuse("check", "bound already", "one binding");
    const Impl::Layout l = impl.layout_of_check();
    const MemoryNeeds& n = impl.check_with.needs();
    const auto part = [&](VkDeviceSize at, const Memory& m) {
        return VkDescriptorBufferInfo{range.buffer, range.offset + at, m.bytes};
    };
    for (int i = 0; i < check_presses; ++i)
        impl.check_with.bind(size_t(i), {part(l.constants, n.constants), part(l.state[i % 2], n.state),
                                         part(l.state[1 - i % 2], n.state), part(l.pressure[i], n.pressure),
                                         part(l.pressure[i + 1], n.pressure), part(l.response[i], n.response),
                                         part(l.invalid, n.invalid)});
    impl.check_bound = true;
}

bool SkinProgram::record_check(VkCommandBuffer commands) const noexcept {
    const Impl& impl = *impl_;
    if (!impl.check_bound) return false;
    for (int i = 0; i < check_presses; ++i) {
        impl.check_with.record(commands, size_t(i), check_dt);
        const VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_SHADER_WRITE_BIT,
                                     VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
        if (i + 1 < check_presses)
            impl.gpu.calls.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                                VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1, &memory, 0, nullptr, 0,
                                                nullptr);
    }
    return true;
}

bool SkinProgram::check_passed(const void* bytes) const {
    const DefaultFloats guard;
    const Impl& impl = *impl_;
    const plan::Plan plan = check_plan(impl.recorder.plan()); // with its maps
    const plan::ResponseLayout& answers = impl.check_with.answers();
    const Impl::Layout l = impl.layout_of_check();
    const auto* memory = static_cast<const unsigned char*>(bytes);
    cpu::Frames frames(plan, 1, simd::plain);
    std::vector<float> map[3], mine(answers.all), theirs(answers.all);
    for (int i = 0; i < 3; ++i) map[i] = impl.check_frame(i);
    for (size_t at : impl.not_finite()) map[2][at] = 0;
    float* response[4];
    for (int q = 1; q < REDUCED_MAPS; ++q)
        response[q - 1] = plan.wanted[q] ? mine.data() + answers.of[size_t(q)].first : nullptr;
    bool same = true;
    for (int i = 0; i < check_presses; ++i) {
        frames.press(check_dt, map[i].data(), map[i + 1].data(), response);
        std::memcpy(theirs.data(), memory + l.response[i], answers.all * sizeof(float));
        for (const plan::ResponseLayout::Range& r : answers.of)
            for (size_t k = 0; k < r.count; ++k) { // of a field, what lies beyond the width is nobody's
                if (plan.scene.sites.empty() && int(k % size_t(plan.pitch)) >= plan.constants.width) continue;
                same &= std::memcmp(&mine[r.first + k], &theirs[r.first + k], sizeof(float)) == 0;
            }
    }
    uint32_t invalid = 0;
    std::memcpy(&invalid, memory + l.invalid, sizeof invalid);
    return same && invalid == impl.not_finite().size();
}

} // namespace dermis::vulkan
