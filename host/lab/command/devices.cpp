// SPDX-License-Identifier: MIT
// dermis devices and dermis check.
#include "host/lab/command/commands.hpp"

#include "host/core/press/device.hpp"
#include "host/lab/march/self_test.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace dermis::cli {
namespace {

using Kernels = std::vector<SelfTest::Kernel>;

// Receptors of a fingertip, in every class, over whose crests a texture slides, its pressure along parabolas.
Scene touched() {
    Scene s{fingertip()};
    s.grid = {.width = 61, .height = 37, .spacing = 5e-5};
    s.load.intensity = 1e4;
    s.load.contact = Load::Contact::crests;
    s.load.hold = Hold::parabolic;
    s.load.texture = {.width = 7, .height = 5, .velocity = {0.04, 0.01}};
    for (int i = 0; i < 35; ++i) s.load.texture->map.edit().push_back(1 + i * 11 % 13 / 16.0);
    s.time = {.step = 0x1p-9, .duration = 0x1p-5};
    for (int i = 0; i < 240; ++i) s.sites.push_back({Quantity(QUANTITY_SA1 + i % 4), {i * 31 % 61, i * i * 7 % 37}});
    s.output.traces.clear();
    s.precision = Precision::f32; // every cell is stepped, on the device
    return s;
}

// Compares receptors of a surface, and below it, under a sliding texture with those of one thread of the CPU path.
SelfTest::Kernel touch(const Device& device) {
    const Scene surface = touched();
    Scene below = surface;
    below.precision.reset();
    below.model = Model::sites; // in double on the CPU, whatever the device
    below.receptors.depth = {.sa1 = 3e-4, .sa2 = 1e-3, .fa1 = 3e-4, .fa2 = 2e-3};
    SelfTest::Kernel kernel{"touch"};
    for (const Scene& s : {surface, below}) {
        const Result one = run(s, device), two = run(s, Device::cpu(1));
        for (size_t i = 0; i < two.responses.size(); ++i) // in float: last bits in double are the C library's
            kernel.compare(double(float(one.responses[i])), double(float(two.responses[i])));
    }
    return kernel;
}

bool is_exact(const Kernels& kernels) { return std::ranges::none_of(kernels, &SelfTest::Kernel::different); }

output::Json json_of(const DeviceInfo& d) {
    output::Json json;
    DERMIS_KEYS(json, d, name, kind, driver, uuid, vulkan, refused);
    output::empty_as_null(json, {"driver", "uuid", "refused"});
    return json;
}

output::Json json_of(const DeviceInfo& d, const Kernels& kernels) {
    output::Json json;
    DERMIS_KEYS(json, d, name, driver, uuid);
    output::empty_as_null(json, {"driver", "uuid"});
    json["exact"] = is_exact(kernels);
    json["kernels"] = output::Json::array();
    for (const SelfTest::Kernel& k : kernels) {
        output::Json& kernel = json["kernels"].emplace_back();
        DERMIS_KEYS(kernel, k, name, hash, values, different);
        kernel["hash"] = fmt::format("{:016x}", k.hash);
    }
    return json;
}

} // namespace

std::string shown(const DeviceInfo& d) { return d.driver.empty() ? d.name : fmt::format("{} ({})", d.name, d.driver); }

int list_devices(bool json) {
    if (json) {
        output::Json devices = output::Json::array({json_of(Device::cpu().info())});
        for (const DeviceInfo& d : Device::list()) devices.push_back(json_of(d));
        output::print(devices);
        return 0;
    }
    fmt::print("cpu: the CPU path, {} threads\n", Device::cpu().impl().backend->threads());
    try {
        int row = 0;
        for (const DeviceInfo& d : Device::list())
            fmt::print("{}: {}, {}, {}{}{}\n", row++, d.name, d.kind, d.driver, d.uuid.empty() ? "" : ", " + d.uuid,
                       d.refused.empty() ? "" : "; not usable: " + d.refused);
    } catch (const Error& e) {
        if (e.code() == Error::Code::no_memory) throw;
        fmt::print("no Vulkan device: {}\n", e.what());
    }
    return 0;
}

int check_devices(const std::string& only, bool json) {
    const size_t devices = only.empty() ? Device::list().size() : 1;
    bool exact = true;
    output::Json answers = output::Json::array();
    for (size_t i = 0; i < devices; ++i) {
        const Device device = Device::open(only.empty() ? std::to_string(i) : only);
        const SelfTest test = self_test(*device.impl().backend);
        Kernels kernels(std::begin(test.kernels), std::end(test.kernels));
        kernels.push_back(touch(device));
        const bool same = is_exact(kernels);
        exact &= same;
        if (json) {
            answers.push_back(json_of(device.info(), kernels));
            continue;
        }
        fmt::print("{}:", shown(device.info()));
        for (const SelfTest::Kernel& k : kernels)
            fmt::print(" {} {:016x} {} of {} differ;", k.name, k.hash, k.different, k.values);
        fmt::print(" {}\n", same ? "exact" : "NOT exact");
    }
    if (json) output::print(answers);
    else if (exact)
        fmt::print("next: dermis run scene.toml --out results{}\n", only.empty() ? "" : " --device " + only);
    else fmt::print("next: dermis devices; a device that is not exact is used only if it is named\n");
    return exact ? 0 : 1;
}

} // namespace dermis::cli
