// SPDX-License-Identifier: MIT
#include "host/device.hpp"
#include "host/plan/float_environment.hpp"
#include "host/plan/frames.hpp"

#include "host/cpu/march.hpp"

#include <algorithm>
#include <bit>
#include <cctype>

namespace dermis {
namespace {

using vulkan::Physical;

std::string lower(std::string s) {
    std::transform(s.begin(), s.end(), s.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return s;
}

[[noreturn]] void no_device(const std::string& which, const std::string& why) {
    throw Error(Error::Code::no_device, "device", "device = \"" + which + "\": " + why);
}

Device open_vulkan(const std::shared_ptr<const vulkan::Instance>& instance, const Physical& physical) {
    auto impl = std::make_shared<Device::Impl>();
    impl->info = physical.info;
    impl->context = std::make_shared<vulkan::Context>(instance, physical);
    Device device(impl);
    impl->info.exact = self_test(device, false).exact();
    return device;
}

// The first of `candidates` that works and computes the CPU path's bits; otherwise says why not in `why`.
std::optional<Device> first_exact(const std::shared_ptr<const vulkan::Instance>& instance, bool hardware_only,
                                  std::string& why) {
    for (const Physical& p : instance->devices()) {
        std::string reason = p.info.refused;
        if (reason.empty() && hardware_only && p.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU)
            reason = "a software driver, slower than the CPU path";
        if (reason.empty()) {
            try {
                Device device = open_vulkan(instance, p);
                if (device.info().exact) return device;
                reason = "its bits differ from the CPU path's; ask for it by name to use it all the same";
            } catch (const Error& e) {
                reason = e.what();
            }
        }
        why += (why.empty() ? "" : "; ") + p.info.name + ": " + reason;
    }
    return {};
}

const Physical& named(const std::vector<Physical>& devices, const std::string& which) {
    std::string names;
    const bool number = !which.empty() && which.size() < 6 &&
                        std::all_of(which.begin(), which.end(), [](unsigned char c) { return std::isdigit(c); });
    for (size_t i = 0; i < devices.size(); ++i) {
        const std::string& name = devices[i].info.name;
        if (number ? size_t(std::stoi(which)) == i : lower(name).find(lower(which)) != std::string::npos)
            return devices[i];
        names += ", " + std::to_string(i) + " or part of \"" + name + "\"";
    }
    throw Error(Error::Code::bad_input, "device",
                "device = \"" + which + "\": no such device; allowed: auto, cpu, vulkan" + names);
}

plan::Plan self_test_plan(Stencil stencil, Edges edges, Precision precision, bool materials, bool framed) {
    Scene s;
    static_cast<SkinDescription&>(s) = plan::sample_skin(stencil, edges, materials);
    s.time = {0.125, 1};
    s.load.envelope.start = 0.2;
    s.load.kind = Load::Kind::map;
    s.load.map = plan::sample_pressure();
    s.output.fields = {{0.3, {Quantity::curvature, Quantity::deformation}}};
    plan::Plan plan = plan::make_plan(s, precision);
    plan.framed = framed;
    return plan;
}

void compare(SelfTest::Kernel& kernel, double device, double cpu) {
    const auto bits = std::bit_cast<uint64_t>(device);
    for (int i = 0; i < 8; ++i) kernel.hash = (kernel.hash ^ (bits >> (8 * i) & 255)) * 1099511628211u;
    ++kernel.values;
    kernel.different += bits != std::bit_cast<uint64_t>(cpu);
}

} // namespace

SelfTest self_test(const Device& device, bool every_variant) {
    const DefaultFloats guard;
    SelfTest test;
    const std::vector<Quantity> pressed = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1,
                                           Quantity::fa2};
    const std::vector<Quantity> derived = {Quantity::curvature, Quantity::deformation};
    for (auto [stencil, edges, precision, materials, framed] :
         {std::tuple{Stencil::five_point, Edges::mirror, Precision::f32, false, false},
          {Stencil::five_point, Edges::mirror, Precision::f32, true, true},
          {Stencil::fourth_order, Edges::periodic, Precision::f32_compensated, false, true},
          {Stencil::published, Edges::published, Precision::f32, true, false}}) {
        if (!every_variant && (materials || framed || edges != Edges::mirror)) continue;
        const plan::Plan plan = self_test_plan(stencil, edges, precision, materials, framed);
        std::vector<plan::Sample> samples[2];
        const auto take = [&](int i) { return [&samples, i](auto&, auto& sample) { samples[i].push_back(sample); }; };
        const Device::Impl& d = device.impl();
        const auto one = d.context ? vulkan::march(plan, d.context, take(0)) : cpu::march(plan, 1, take(0));
        const auto two = cpu::march(plan, 1, take(1), loops::plain);
        std::vector<std::vector<double>> a, b;
        plan::Timeline timeline(plan);
        for (plan::Step step; timeline.next(step);) {
            if (framed) {
                one->frame(step.keep ? plan.maps.pressure : plan.maps.surface);
                two->frame(step.keep ? plan.maps.pressure : plan.maps.surface);
            }
            one->press(step);
            two->press(step);
            for (const auto& [what, kernel] : {std::pair{&pressed, 0}, {&derived, 1}}) {
                one->read(*what, a);
                two->read(*what, b);
                for (size_t q = 0; q < a.size(); ++q)
                    for (size_t i = 0; i < a[q].size(); ++i) compare(test.kernels[kernel], a[q][i], b[q][i]);
            }
        }
        one->finish();
        for (size_t i = 0; i < samples[1].size(); ++i)
            for (int q = 0; q < REDUCED_MAPS; ++q) {
                const plan::Totals a = samples[0][i].totals[q], b = samples[1][i].totals[q];
                compare(test.kernels[2], a.mean, b.mean);
                compare(test.kernels[2], a.min, b.min);
                compare(test.kernels[2], a.max, b.max);
            }
    }
    return test;
}

Device open_device(const std::string& which, const vulkan::Loader& loader, const vulkan::InstanceOptions& options) {
    if (which == "cpu") return Device::cpu();
    std::string why;
    try {
        const auto instance = std::make_shared<const vulkan::Instance>(loader, options);
        if (which == "auto" || which == "vulkan") {
            if (auto device = first_exact(instance, which == "auto", why)) {
                device->impl().asked = which == "vulkan";
                return *device;
            }
        } else {
            const Physical& p = named(instance->devices(), which);
            if (!p.info.refused.empty()) no_device(which, p.info.name + ": " + p.info.refused);
            Device device = open_vulkan(instance, p);
            device.impl().asked = device.impl().named = true;
            return device;
        }
    } catch (const Error& e) {
        if (which != "auto" && (which != "vulkan" || e.parameter() == "device")) {
            if (e.parameter() == "device") throw;
            no_device(which, e.what());
        }
        why = e.what();
    }
    if (which == "vulkan") no_device(which, why);
    Device device = Device::cpu();
    device.impl().info.refused = "no Vulkan device used: " + why;
    return device;
}

std::unique_ptr<plan::Marcher> march(const Device& device, const plan::Plan& plan, plan::Marcher::Sink sink) {
    Device::Impl& d = device.impl();
    if (!d.context) return cpu::march(plan, d.threads, std::move(sink));
    const bool plain = plan.stencil == STENCIL_FIVE_POINT && plan.edges == EDGES_MIRROR && !plan.compensated &&
                       plan.material.empty() && !plan.framed;
    if (!plain && !d.tested) {
        d.tested = true;
        d.info.exact &= self_test(device).exact();
    }
    if (!plain && !d.info.exact && !d.named)
        throw Error(Error::Code::no_device, "device",
                    d.info.name + ": its bits differ from the CPU path's; ask for it by name to use it all the same");
    return vulkan::march(plan, d.context, std::move(sink));
}

Device Device::cpu(int threads) {
    if (threads < 0 || threads > 1024)
        throw Error(Error::Code::bad_input, "threads",
                    "threads = " + std::to_string(threads) + "; allowed: 0 (one per core) .. 1024");
    auto impl = std::make_shared<Impl>();
    impl->info.name = "cpu";
    impl->info.kind = "cpu path";
    impl->threads = threads;
    return Device(impl);
}

Device Device::open(const std::string& which) { return open_device(which, vulkan::system_loader()); }

std::vector<DeviceInfo> Device::list() {
    const vulkan::Instance instance(vulkan::system_loader());
    std::vector<DeviceInfo> list;
    for (const Physical& p : instance.devices()) list.push_back(p.info);
    return list;
}

const DeviceInfo& Device::info() const noexcept { return impl_->info; }

} // namespace dermis
