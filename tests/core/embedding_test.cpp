// SPDX-License-Identifier: MIT
// labels: device threads long
// SkinProgram in a host's command buffers: the host here is the test, with memory and submissions of its own.
#include "host/core/embedding/backend.hpp"
#include "host/core/embedding/check.hpp"
#include "host/core/press/device.hpp"
#include "host/lab/march/self_test.hpp"
#include "tests/drawn_skin.hpp"
#include "tests/embedding_host.hpp"
#include "tests/shim.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <thread>

using namespace test;

namespace {

SkinDescription ridged(int width, int height, Stencil stencil, Edges edges = Edges::mirror) {
    SkinDescription d = test::ridged(width, height);
    d.stencil = stencil;
    d.edges = edges;
    return d;
}

// Receptors at depths of so many cells, but for FA1's.
SkinDescription with_depths(SkinDescription d, double cells) {
    d.grid.spacing = 1e-3;
    for (auto* length : {&d.surface.relief, &d.material.thickness, &d.material.curvature_length}) *length = 1e-3;
    if (d.material.elements.empty()) d.material.modulus = 2;
    d.receptors.depth = {.sa1 = cells * 1e-3, .sa2 = 3 * cells * 1e-3, .fa1 = {}, .fa2 = 5 * cells * 1e-3};
    d.receptors.kernel.sa1 = d.receptors.kernel.sa2 = cells > 3 ? DepthKernel::strain : DepthKernel::stress;
    d.receptors.kernel.fa2 = DepthKernel::displacement;
    return d;
}

// A skin that a SkinProgram takes.
DrawnSkin drawn_program(Random& r) {
    DrawnSkin drawn;
    do drawn = drawn_skin(r);
    while (drawn.large() || drawn.skin.receptors.follow.sa1 == Signal::stress);
    SkinOptions& o = drawn.options;
    o.hold = Hold::linear, o.control = Control::pressure, o.shear = false;
    o.sa2_stretch.reset(), o.afferents.clear();
    return drawn;
}

std::string refused(auto&& call) { return refusal(Error::Code::bad_input, call); }

bool says(const std::string& message, const char* what) { return message.find(what) != std::string::npos; }

// Whether the queue that a device computes on, one of the first family with compute, can write timestamps.
bool has_timestamps(const vulkan::Handles& h) {
    const auto families_of = reinterpret_cast<PFN_vkGetPhysicalDeviceQueueFamilyProperties>(
        h.get_instance_proc_addr(h.instance, "vkGetPhysicalDeviceQueueFamilyProperties"));
    uint32_t count = 0;
    families_of(h.physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    families_of(h.physical, &count, families.data());
    return std::ranges::find_if(families, [](const auto& f) {
               return f.queueFlags & VK_QUEUE_COMPUTE_BIT;
           })->timestampValidBits > 0;
}

} // namespace

TEST_CASE("drawn skins in a host's command buffer have the CPU's bits, pads that are not pressed keep theirs, presses "
          "without "
          "responses leave them unwritten, and nothing else is touched") {
    const Validated vulkan;
    Context& context = *vulkan::context_of(*vulkan.device().impl().backend);
    constexpr int frames = 4;
    Random r;
    for (int n = 0; n < (night() ? 600 : 60); ++n) {
        const DrawnSkin drawn = drawn_program(r);
        CAPTURE(words_of(drawn));
        const int pads = drawn.options.count;
        Host host(context, drawn.skin, frames, drawn.options);
        Skin skin(Device::cpu(1), drawn.skin, drawn.options);
        vulkan::Recording recording(context);
        const VkCommandBuffer commands = recording.commands();
        std::vector<int> lists[frames + 1];
        std::map<Quantity, std::vector<float>> expected[frames + 1]; // nothing for a press without responses
        for (int i = 1; i <= frames; ++i) {
            std::vector<int>& list = lists[i];
            std::vector<float> all, pressed;
            for (int pad = 0; pad < pads; ++pad) {
                std::vector<float> one = frame(drawn.skin, i + pad);
                for (float& p : one) p *= 1e3f;
                all.insert(all.end(), one.begin(), one.end());
                if (pads > 1 && i % 2 == 0 && chance(r, 0.5)) continue;
                list.push_back(pad);
                pressed.insert(pressed.end(), one.begin(), one.end());
            }
            std::vector<double> dt(list.size() + 1, r.decades(-4, -1)); // one more, for a press of no pad
            const bool alike = pads == 1 || chance(r, 0.5);
            for (double& step : dt)
                if (!alike) step = chance(r, 0.1) ? 0 : r.decades(-4, -1);
            host.set_pressure(i, all);
            const Binding binding = host.bindings[size_t(i - 1)];
            const auto which = i == frames || chance(r, 0.6) ? vulkan::Answers::all : vulkan::Answers::none;
            REQUIRE((pads == 1 ? host.program.record_press(commands, binding, dt[0], {}, which)
                               : host.program.record_press(commands, binding, list, dt.data(), alike ? 1 : list.size(),
                                                           {}, which)));
            barrier(context, commands, host.program);
            skin.press(pressed.data(), pressed.size(), dt.data(), list.size(), pads == 1 ? Pads() : Pads(list));
            for (Quantity q : drawn.responses())
                if (which == vulkan::Answers::all) expected[i][q] = answers(skin, q);
        }
        for (const std::vector<int>& wrong : {std::vector<int>{1, 0}, {pads}}) {
            const double dt = 0.1;
            if (pads > 1) CHECK(!host.program.record_press(commands, host.bindings[0], wrong, &dt, 1));
        }
        context.barrier(commands);
        recording.submit();
        for (int i = 1; i <= frames; ++i)
            for (Quantity q : drawn.responses()) {
                CAPTURE(i);
                CAPTURE(name(q));
                const std::vector<float> got = host.response(i, q), &right = expected[i][q];
                if (right.empty()) {
                    CHECK(std::ranges::count(got, 0.0f) == std::ptrdiff_t(got.size()));
                    continue;
                }
                REQUIRE(got.size() == right.size());
                const size_t each = got.size() / size_t(pads);
                for (const int pad : lists[i])
                    CHECK(std::memcmp(&got[size_t(pad) * each], &right[size_t(pad) * each], each * sizeof(float)) == 0);
            }
        CHECK(host.not_finite() == 0);
        CHECK(host.untouched_around());
    }
}

TEST_CASE("a grid beyond what a device binds at once is pressed in bands of rows, in any order: the same bits") {
    const vulkan::Loader loader = shimmed();
    for (const auto& [stencil, edges] : {std::pair{Stencil::five_point, Edges::mirror},
                                         {Stencil::fourth_order, Edges::mirror},
                                         {published_stencil, published_edges}}) {
        if (!night() && stencil != Stencil::fourth_order) continue; // it reads most rows beyond a band
        shim.range = 1 << 27;
        const Validated vulkan(loader);
        shim.range = 52000; // 203 rows of a map of 64 cells, 50 of a state: bands of 42, cut to whole workgroups
        shim.reversed = true;
        const Validated banded(loader);
        Context& context = *vulkan::context_of(*banded.device().impl().backend);
        const SkinDescription d = ridged(64, 301, stencil, edges);
        shim.calls.clear();
        check_presses(context, d);
        size_t dispatches = 0;
        for (const char* call : shim.calls) dispatches += std::strcmp(call, "vkCmdDispatch") == 0;
        CHECK(dispatches > 4 * 5);
        check_presses(context, with_materials(d));
        check_presses(context, with_sites(d, 60));

        Scene s; // and the march of a whole scene, with traces, probes and fields
        static_cast<SkinDescription&>(s) = d;
        s.model = Model::march;
        s.time = {0.05, 0.3};
        s.load.radius = 190;
        s.output.probes = {{32, 150}, {0, 0}, {63, 300}};
        s.output.fields = {{0.25, {Quantity::strain, Quantity::fa2, Quantity::curvature, Quantity::deformation}}};
        const Result whole = run(s, vulkan.device()), parts = run(s, banded.device()), cpu = run(s, Device::cpu(1));
        for (const Result* r : {&parts, &cpu})
            for (size_t i = 0; i < whole.traces.size(); ++i) {
                CHECK(r->traces[i].mean == whole.traces[i].mean);
                CHECK(r->traces[i].probes == whole.traces[i].probes);
            }
        for (size_t i = 0; i < whole.fields.size(); ++i) CHECK(parts.fields[i].values == cpu.fields[i].values);
    }
    SkinDescription around = ridged(64, 301, Stencil::five_point, Edges::periodic);
    shim.range = 50000;
    const Device banded = open_device("0", loader);
    const std::string message = refused([&] { Skin(banded, around); });
    CHECK(says(message, "periodic edges"));
    CHECK(says(message, "maxStorageBufferRange = 50000"));
}

TEST_CASE("a response of more than 128 MiB: no binding above 128 MiB, the CPU's bits") {
    const int height = night() ? 8192 : 4160; // 256 or 130 MiB
    SkinDescription d;
    d.grid = {8192, height, {}};
    SkinOptions one{.responses = {Quantity::fa1}};
    const vulkan::Loader loader = shimmed();
    shim.range = 1 << 27;
    const Device vulkan = open_device("vulkan", loader);
    REQUIRE(vulkan::context_of(*vulkan.impl().backend)->limits().maxStorageBufferRange == 1 << 27);
    std::vector<float> pressure(size_t(8192) * size_t(height));
    for (size_t i = 0; i < pressure.size(); ++i) pressure[i] = float(i % 8191) * 1e-4f + float(i % 127);
    Skin device(vulkan, d, one);
    device.press(pressure, 0.01);
    Skin cpu(Device::cpu(), d, one);
    cpu.press(pressure, 0.01);
    const Skin::Response a = device.response(Quantity::fa1), b = cpu.response(Quantity::fa1);
    REQUIRE(a.size == pressure.size());
    CHECK(std::memcmp(a.data, b.data, a.size * sizeof(float)) == 0);
    CHECK(a[4100 * 8192 + 77] != 0);
}

TEST_CASE("millions of receptors: no more than 65535 groups along an axis, and every one answers") {
    const Validated vulkan;
    SkinDescription d = ridged(1600, 1600);
    d.surface.kind = Surface::Kind::flat;
    SkinOptions one{.responses = {Quantity::fa1}, .precision = Precision::f32};
    const std::vector<float> pressure = frame(d, 1);
    Skin fields(Device::cpu(), d, one);
    for (int i = 0; i < 1600 * 1600; ++i) d.sites.push_back({Quantity::fa1, {i % 1600, i / 1600}});
    one.responses.clear();
    Skin sites(vulkan.device(), d, one);
    fields.press(pressure, 0.1);
    sites.press(pressure, 0.1);
    const Skin::Response a = sites.response(Quantity::fa1), b = fields.response(Quantity::fa1);
    REQUIRE(a.size == b.size);
    CHECK(std::memcmp(a.data, b.data, a.size * sizeof(float)) == 0);
}

TEST_CASE("a pressure of the device's that is not finite counts as 0, and is counted") {
    const Validated vulkan;
    Context& context = *vulkan::context_of(*vulkan.device().impl().backend);
    const SkinDescription d = ridged(67, 19);
    for (const SkinDescription& skin : {d, with_sites(d, 1)}) {
        Host host(context, skin, 2);
        Skin cpu(Device::cpu(1), skin);
        std::vector<float> bad = frame(d, 1), good = bad;
        bad[0] = NAN; // the site's
        good[0] = 0;
        if (skin.sites.empty()) {
            bad[5 * 67 + 66] = INFINITY;
            bad[9 * 67 + 4] = -INFINITY;
            good[5 * 67 + 66] = good[9 * 67 + 4] = 0;
        }
        host.set_pressure(1, bad);
        host.set_pressure(2, frame(d, 2));
        vulkan::Recording recording(context);
        const VkCommandBuffer commands = recording.commands();
        for (int i = 0; i < 2; ++i) {
            REQUIRE(host.program.record_press(commands, host.bindings[size_t(i)], 0.1));
            barrier(context, commands, host.program);
        }
        context.barrier(commands);
        recording.submit();
        CHECK(host.not_finite() == (skin.sites.empty() ? 3 : 1));
        cpu.press(good, 0.1);
        cpu.press(frame(d, 2), 0.1);
        for (Quantity q : all_responses) {
            if (host.program.range(q).count == 0) continue;
            CHECK(host.response(2, q) == answers(cpu, q));
        }
    }
}

TEST_CASE("the recorded check passes on a right device and fails on a wrong one") {
    const auto passes = [](const Device& device, const SkinDescription& d) {
        Context& context = *vulkan::context_of(*device.impl().backend);
        SkinProgram program(context.handles(), d, 1);
        Range range(context, program.memory().check);
        CHECK_FALSE(program.check_passed(range.data(), program.memory().check.bytes)); // nothing has been pressed yet
        CHECK_FALSE(program.record_check(VK_NULL_HANDLE));                             // nor bound
        program.bind_check(range.info);
        vulkan::Recording recording(context);
        const VkCommandBuffer commands = recording.commands();
        CHECK(program.record_check(commands));
        context.barrier(commands);
        recording.submit();
        CHECK(range.untouched_around());
        return program.check_passed(range.data(), program.memory().check.bytes);
    };
    const Validated vulkan;
    const SkinDescription d = ridged(40, 20);
    for (const SkinDescription& skin : {d, with_materials(d), with_sites(d, 9), with_sites(with_materials(d), 9),
                                        with_depths(d, 3), with_sites(with_depths(d, 3), 9)})
        CHECK(passes(vulkan.device(), skin));
    const Device wrong = open_device("0", faulty(&Shim::miscompile));
    CHECK_FALSE(passes(wrong, d));
    CHECK_FALSE(passes(wrong, with_sites(d, 9)));
    CHECK_FALSE(passes(wrong, with_depths(d, 3)));
}

TEST_CASE("coefficients are written after those of the press before are written and read") {
    const Device device = open_device("0", shimmed());
    Context& context = *vulkan::context_of(*device.impl().backend);
    for (const SkinDescription& d :
         {with_materials(ridged(40, 20)), with_sites(with_materials(ridged(40, 20)), 9), with_chain(ridged(40, 20))}) {
        Host host(context, d, 2);
        Range check(context, host.program.memory().check);
        host.program.bind_check(check.info);
        std::vector<Barrier> barriers;
        shim.barriers = &barriers;
        shim.calls.clear();
        vulkan::Recording recording(context);
        const VkCommandBuffer commands = recording.commands();
        CHECK(host.program.record_check(commands));
        for (int i = 0; i < 2; ++i) {
            REQUIRE(host.program.record_press(commands, host.bindings[size_t(i)], 0.1));
            barrier(context, commands, host.program);
        }
        recording.submit();
        shim.barriers = nullptr;
        size_t updates = 0, recorded = 0;
        bool after_write = false, after_read = false;
        for (const std::string call : shim.calls) {
            if (call == "vkCmdUpdateBuffer") {
                if (updates++ > 0) CHECK((after_write && after_read));
                after_write = after_read = false;
            } else if (call == "vkCmdPipelineBarrier") {
                const Barrier b = barriers.at(recorded++);
                if (!(b.to & VK_PIPELINE_STAGE_TRANSFER_BIT)) continue;
                after_read |= (b.from & VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT) != 0;
                after_write |= b.from & VK_PIPELINE_STAGE_TRANSFER_BIT && b.source & VK_ACCESS_TRANSFER_WRITE_BIT &&
                               b.destination & VK_ACCESS_TRANSFER_WRITE_BIT;
            }
        }
        CHECK(updates == 4);
        CHECK(recorded == barriers.size());
    }
}

TEST_CASE("requirements are data: merged before a device is made, one limit beyond the least of Vulkan 1.1") {
    const vulkan::Requirements r = vulkan::requirements();
    CHECK(r.api_version == VK_API_VERSION_1_1);
    CHECK(r.storage_buffers == 12);
    REQUIRE(r.required_if_offered.size() == 1);
    CHECK(std::string(r.required_if_offered[0]) == "VK_KHR_portability_subset");
    const Device least = open_device("0", [] { // a device that has no more than that
        const vulkan::Loader loader = shimmed();
        shim.least = true;
        return loader;
    }());
    SkinDescription d = ridged(64, 40);
    check_presses(*vulkan::context_of(*least.impl().backend), d);
    check_presses(*vulkan::context_of(*least.impl().backend), with_sites(d, 40));
    CHECK(self_test(*least.impl().backend).exact());
}

TEST_CASE("a software driver reads maps as texel buffers, unless its limits for them are less: the same bits") {
    const auto reads_texels = [](Context& context) {
        const SkinProgram program(context.handles(), ridged(64, 40), 1);
        const vulkan::MemoryNeeds& m = program.memory();
        CHECK(!(m.response.usage & VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT));
        const bool reads = m.state.usage & VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
        for (const Memory* read : {&m.constants, &m.pressure, &m.check})
            CHECK(bool(read->usage & VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT) == reads);
        return reads;
    };
    const Device device = open_device("0", shimmed());
    Context& context = *vulkan::context_of(*device.impl().backend);
    const VkPhysicalDeviceLimits& limits = context.limits();
    const bool enough = limits.maxTexelBufferElements >= limits.maxStorageBufferRange / sizeof(float[4]);
    CHECK(reads_texels(context) == (context.physical().info.kind == "software" && enough));
    const Device least = open_device("0", [] {
        const vulkan::Loader loader = shimmed();
        shim.least = true;
        return loader;
    }());
    Context& storage = *vulkan::context_of(*least.impl().backend);
    CHECK(!reads_texels(storage));
    for (auto [stencil, edges] : {std::pair{Stencil::five_point, Edges::mirror},
                                  {Stencil::fourth_order, Edges::periodic},
                                  {published_stencil, published_edges}}) {
        const SkinDescription d = ridged(70, 30, stencil, edges);
        check_presses(storage, d);
        check_presses(storage, with_materials(d));
    }
}

TEST_CASE("what a host gets wrong is named at set-up") {
    const Validated vulkan(shimmed());
    Context& context = *vulkan::context_of(*vulkan.device().impl().backend);
    const SkinDescription d = ridged(64, 20);
    const auto with = [&](auto&& change) {
        vulkan::Handles h = context.handles();
        change(h);
        return refused([&] { SkinProgram(h, d, 1); });
    };
    CHECK(says(with([](auto& h) { h.instance = VK_NULL_HANDLE; }), "instance = null"));
    CHECK(says(with([](auto& h) { h.physical = VK_NULL_HANDLE; }), "physical = null"));
    CHECK(says(with([](auto& h) { h.device = VK_NULL_HANDLE; }), "device = null"));
    CHECK(says(with([](auto& h) { h.get_instance_proc_addr = nullptr; }), "get_instance_proc_addr = null"));
    CHECK(says(with([](auto& h) { h.api_version = VK_API_VERSION_1_0; }), "api_version = 1.0; allowed: at least 1.1"));
    CHECK(says(with([](auto&) { shim.portability = true; }), "VK_KHR_portability_subset"));
    shim.portability = false;
    CHECK(says(with([](auto&) { shim.few_buffers = true; }), "maxPerStageDescriptorStorageBuffers = 4; 12 are needed"));
    shim.few_buffers = false;
    for (const char* needed : {"vkCmdDispatch", "vkCreateComputePipelines", "vkCmdUpdateBuffer"})
        CHECK(says(with([&](auto&) { shim.absent = needed; }), needed));
    CHECK(says(with([](auto&) { shim.absent = "vkGetPhysicalDeviceProperties2"; }), "vkGetPhysicalDeviceProperties2"));
    CHECK(says(with([](auto&) { shim.absent = "vkGetDeviceProcAddr"; }), "vkGetDeviceProcAddr"));
    shim.absent = "";
    CHECK(says(refused([&] { SkinProgram(context.handles(), d, 0); }), "max_bindings = 0; allowed: 1..65536"));
    SkinOptions stretched;
    stretched.sa2_stretch = {1, 0};
    CHECK(says(refused([&] { SkinProgram(context.handles(), d, 1, stretched); }),
               "sa2_stretch = (given); allowed: none"));

    Host host(context, d, 2);
    const auto bad = [&](auto&& change) {
        Buffers b = host.buffers(1);
        change(b);
        shim.calls.clear();
        const std::string message = refused([&] { host.program.bind(b); });
        for (const char* call : shim.calls) CHECK_MESSAGE(false, call); // nothing made, nothing recorded
        return message;
    };
    const VkDeviceSize state = host.program.memory().state.bytes;
    CHECK(says(bad([](Buffers& b) { b.state_to.buffer = VK_NULL_HANDLE; }), "state_to.buffer = null"));
    CHECK(says(bad([](Buffers& b) { b.pressure_to.offset += 4; }), "pressure_to.offset = 516"));
    CHECK(says(bad([](Buffers& b) { b.state_from.range -= 1; }), ("at least " + std::to_string(state)).c_str()));
    CHECK(says(bad([](Buffers& b) { b.response.range = 0; }), "response.range = 0"));
    CHECK(says(bad([](Buffers& b) { b.response.offset += 512, b.response.range = VK_WHOLE_SIZE; }), "response"));
    CHECK(says(bad([](Buffers& b) { b.constants.offset = 1 << 20; }), "within the buffer"));
    CHECK(says(refused([&] { Host(context, with_depths(d, 3), 1).program.bind({}); }), "constants.buffer = null"));
    CHECK(says(bad([](Buffers& b) { b.state_to = b.state_from; }), "state_to = in the same memory as state_from"));
    CHECK(says(bad([](Buffers& b) { b.response = b.pressure_to, b.response.range = 1 << 20; }), "response"));
    CHECK(says(refused([&] { host.program.bind(host.buffers(1)); }), "max_bindings = 2"));
    CHECK(says(refused([&] { host.program.bind_check({VK_NULL_HANDLE, 0, 4}); }), "check.buffer = null"));

    const Host other(context, d, 1);
    vulkan::Recording recording(context);
    const VkCommandBuffer commands = recording.commands();
    shim.calls.clear();
    for (double dt : {-1.0, double(NAN), double(INFINITY)})
        CHECK_FALSE(host.program.record_press(commands, host.bindings[0], dt));
    CHECK_FALSE(host.program.record_press(commands, Binding(), 0.1));
    CHECK_FALSE(host.program.record_press(commands, other.bindings[0], 0.1));
    for (double dt : {1e-39, 5e-324, 1e39, 1e300}) // coefficients beyond float
        CHECK_FALSE(host.program.record_press(commands, host.bindings[0], dt));
    CHECK(shim.calls.empty());
    recording.submit();
}

TEST_CASE("a binding that fails leaves nothing behind: the next one is whole") {
    const vulkan::Loader loader = shimmed();
    shim.range = 50000;
    const Device banded = open_device("0", loader);
    Context& context = *vulkan::context_of(*banded.impl().backend);
    const SkinDescription d = with_materials(ridged(64, 301));
    Host host(context, d, 1);
    SkinProgram program(context.handles(), d, 1);
    Range lost(context, program.memory().constants); // of the binding that fails
    Buffers b = host.buffers(1);
    b.constants = lost.info;
    shim.sets_left = 1; // of several bands
    refusal(Error::Code::device, [&] { program.bind(b); });
    shim.sets_left = -1;
    const Binding binding = program.bind(host.buffers(1));
    host.set_pressure(1, frame(d, 1));
    vulkan::Recording recording(context);
    const VkCommandBuffer commands = recording.commands();
    REQUIRE(program.record_press(commands, binding, 0.1));
    context.barrier(commands);
    recording.submit();
    Skin skin(Device::cpu(1), d);
    skin.press(frame(d, 1), 0.1);
    CHECK(host.response(1, Quantity::sa1) == answers(skin, Quantity::sa1));
}

TEST_CASE("nothing of sites is bound beyond the limit either") {
    const vulkan::Loader loader = shimmed();
    shim.range = 14000;
    const Device device = open_device("0", loader);
    SkinOptions plain{.precision = Precision::f32};
    SkinDescription d = ridged(300, 100, Stencil::fourth_order);
    for (int i = 0; i < 230; ++i) d.sites.push_back({Quantity::fa1, {2 + 5 * (i % 50), 2 + 5 * (i / 50)}});
    CHECK(says(refused([&] { Skin(device, d, plain); }), "230 sites need 87808 bytes"));
}

TEST_CASE("timestamps, labels, the host's allocator and pipeline cache are used") {
    const Validated vulkan;
    Context& context = *vulkan::context_of(*vulkan.device().impl().backend);
    const VolkDeviceTable& vk = context.calls();
    static int alive, made;
    alive = made = 0;
    VkAllocationCallbacks allocator{};
    allocator.pfnAllocation = [](void*, size_t bytes, size_t alignment, VkSystemAllocationScope) -> void* {
        ++alive, ++made;
        return std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    };
    allocator.pfnReallocation = [](void*, void*, size_t, size_t, VkSystemAllocationScope) -> void* { return nullptr; };
    allocator.pfnFree = [](void*, void* p) {
        alive -= p != nullptr;
        std::free(p);
    };
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = 5;
    VkQueryPool pool = VK_NULL_HANDLE;
    REQUIRE(vk.vkCreateQueryPool(context.device(), &info, nullptr, &pool) == VK_SUCCESS);
    {
        vulkan::Handles h = context.handles();
        h.allocator = &allocator;
        h.extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        SkinProgram program(h, ridged(64, 20), 1);
        CHECK(made > 0);
        Host host(context, ridged(64, 20), 1);
        const Binding b = program.bind(host.buffers(1));
        vulkan::Recording recording(context);
        const VkCommandBuffer commands = recording.commands();
        vk.vkCmdResetQueryPool(commands, pool, 0, 5);
        const bool stamps = has_timestamps(h); // no other queue may write any
        CHECK(program.record_press(commands, b, 0.1, {stamps ? pool : VK_NULL_HANDLE, 3}));
        recording.submit();
        uint64_t ticks[2] = {0, 1};
        if (stamps)
            REQUIRE(vk.vkGetQueryPoolResults(context.device(), pool, 3, 2, sizeof ticks, ticks, 8,
                                             VK_QUERY_RESULT_64_BIT) == VK_SUCCESS);
        CHECK(ticks[1] > ticks[0]);
    }
    CHECK(alive == 0);
    vk.vkDestroyQueryPool(context.device(), pool, nullptr);
}

TEST_CASE("programs on several devices, set up and recorded by several threads, do not disturb one another") {
    std::vector<std::thread> threads;
    std::vector<std::string> failures(3);
    for (size_t i = 0; i < failures.size(); ++i)
        threads.emplace_back([&failures, i] {
            const Device device = Device::open("vulkan"); // an instance and a device of its own
            Context& context = *vulkan::context_of(*device.impl().backend);
            const SkinDescription d = ridged(50 + 20 * int(i), 30);
            Host host(context, i == 1 ? with_sites(d, 30) : d, 3);
            Skin skin(Device::cpu(1), host.description);
            for (int n = 1; n <= 3; ++n) {
                host.set_pressure(n, frame(d, n));
                skin.press(frame(d, n), 0.1);
                vulkan::Recording recording(context);
                const VkCommandBuffer commands = recording.commands();
                if (!host.program.record_press(commands, host.bindings[size_t(n - 1)], 0.1)) failures[i] = "refused";
                context.barrier(commands);
                recording.submit();
            }
            for (Quantity q : all_responses) {
                if (host.program.range(q).count == 0) continue;
                if (host.response(3, q) != answers(skin, q)) failures[i] = name(q);
            }
        });
    for (std::thread& t : threads) t.join();
    for (const std::string& f : failures) CHECK(f == "");
}
