// SPDX-License-Identifier: MIT
#include "host/core/press/device.hpp"

#include "host/core/base/memory.hpp"
#include "host/core/cpu/backend.hpp"

namespace dermis {
void Device::Impl::need_exact() const {
    if (!info.exact && !named)
        throw Error(Error::Code::no_device, "device",
                    info.name + ": its bits differ from the CPU path's; ask for it by name to use it all the same");
}

const Device& Device::Impl::best() {
    if (!best_if_open) best_if_open = Device::open("auto");
    return *best_if_open;
}

Device open_when_marching() {
    Device device = Device::cpu();
    device.impl().put_off = true;
    return device;
}

Device Device::cpu(int threads) {
    return scene::guarded("device \"cpu\"", [&] {
        if (threads < 0 || threads > 1024)
            throw Error(Error::Code::bad_input, "threads",
                        "threads = " + std::to_string(threads) + "; allowed: 0 (one per core) .. 1024");
        auto impl = std::make_shared<Impl>();
        impl->info.name = "cpu";
        impl->info.kind = "cpu path";
        impl->backend = std::make_shared<cpu::CpuBackend>(threads);
        return Device(impl);
    });
}

const DeviceInfo& Device::info() const noexcept { return impl_->info; }

} // namespace dermis
