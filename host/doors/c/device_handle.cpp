// SPDX-License-Identifier: MIT
#include "host/doors/c/handles.hpp"

#include <cstring>

using namespace dermis::c;

dermis_status dermis_device_open(const char* which, dermis_device** device) {
    return guarded([&] {
        need_output(device, "device");
        need_pointer(which, "which");
        *device = new dermis_device{dermis::Device::open(which)};
    });
}

dermis_status dermis_device_open_cpu(int32_t threads, dermis_device** device) {
    return guarded([&] {
        need_output(device, "device");
        *device = new dermis_device{dermis::Device::cpu(threads)};
    });
}

void dermis_device_close(dermis_device* device) { delete device; }

dermis_status dermis_device_get_info(const dermis_device* device, dermis_device_info* info) {
    return guarded([&] {
        need_pointer(device, "device");
        need_size(info, "info", offsetof(dermis_device_info, uuid));
        const dermis::DeviceInfo& from = device->device.info();
        const dermis_device_info all{.size = info->size,
                                     .name = from.name.c_str(),
                                     .kind = from.kind.c_str(),
                                     .driver = from.driver.c_str(),
                                     .refused = from.refused.c_str(),
                                     .vulkan = from.vulkan,
                                     .exact = from.exact,
                                     .uuid = from.uuid.c_str()};
        std::memcpy(info, &all, info->size);
    });
}
