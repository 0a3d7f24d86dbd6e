// SPDX-License-Identifier: MIT
// What runs ask of each kind of backend.
#include "host/lab/march/march.hpp"

#include "host/core/cpu/backend.hpp"
#include "host/lab/march/capabilities.hpp"
#include "host/lab/march/self_test.hpp"

#ifdef DERMIS_VULKAN
#include "host/core/embedding/backend.hpp"
#endif

namespace dermis {
namespace plan {

Capabilities capabilities_of(const Backend& backend) {
    Capabilities c;
    c.name = backend.name();
    c.threads = backend.threads();
#ifdef DERMIS_VULKAN
    if (const auto* vulkan = dynamic_cast<const vulkan::VulkanBackend*>(&backend)) {
        c.double_buffered = true;
        // Measured on lavapipe; for a GPU estimated from its memory bandwidth.
        c.cell_step = vulkan->context()->physical().info.kind == "software" ? 28e-9 : 3e-10;
        c.dispatch = 5e-6;
        return c;
    }
#endif
    c.f64 = true;
    c.cell_step = 1.8e-9 / c.threads; // measured on two cores of a server
    return c;
}

std::unique_ptr<Stepper> march(Backend& backend, const PreparedSkin& skin, const Schedule& schedule,
                               Precision precision, Stepper::Sink sink) {
#ifdef DERMIS_VULKAN
    if (const auto* vulkan = dynamic_cast<vulkan::VulkanBackend*>(&backend)) {
        const vulkan::Use use = vulkan->context()->need_working();
        return vulkan::stepper(skin, schedule, precision, vulkan->context(), std::move(sink));
    }
#endif
    const auto& cpu = dynamic_cast<cpu::CpuBackend&>(backend);
    return cpu::stepper(skin, schedule, precision, cpu.threads(), std::move(sink), cpu.isa());
}

} // namespace plan

namespace {

void need_exact(Device::Impl& d, const plan::Variant& v) {
    using Tested = Device::Impl::Tested;
    const bool plain =
        v.stencil == STENCIL_FIVE_POINT && v.edges == EDGES_MIRROR && !v.compensated && !v.materials && !v.framed;
    const Tested needed = plain ? Tested::plain_march : Tested::every_march;
    if (d.tested < needed) d.info.exact &= self_test(*d.backend, !plain).exact();
    d.tested = std::max(d.tested, needed);
    d.need_exact();
}

} // namespace

std::unique_ptr<plan::Stepper> march(const Device& device, const plan::PreparedSkin& skin,
                                     const plan::Schedule& schedule, Precision precision, plan::Stepper::Sink sink) {
    need_exact(device.impl(), variant_of(skin, schedule, precision));
    return plan::march(*device.impl().backend, skin, schedule, precision, std::move(sink));
}

} // namespace dermis
