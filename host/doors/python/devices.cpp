// SPDX-License-Identifier: MIT
// Devices, the memory that skins may take, and the reports that runs and skins share.
#include "host/core/base/cores.hpp"
#include "host/core/base/memory.hpp"
#include "host/doors/python/pickle.hpp"

#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <unistd.h>

namespace dermis::python {
namespace {

// The devices that this process has opened and still uses. A child process does not use its parent's.
using Key = std::tuple<std::string, int, pid_t>;
std::map<Key, std::weak_ptr<OpenDevice>>& open_devices() {
    static std::map<Key, std::weak_ptr<OpenDevice>> devices;
    return devices;
}

SharedDevice opened(const std::string& which, int threads) {
    SharedDevice shared{nullptr, which, threads};
    {
        const Computing computing(nullptr);
        shared.open = std::make_shared<OpenDevice>(which == "cpu" ? Device::cpu(threads) : Device::open(which));
    }
    open_devices()[{which, threads, getpid()}] = shared.open;
    return shared;
}

SharedDevice open(string_view which) { return opened(std::string(which), 0); }
SharedDevice open_cpu(int threads) { return opened("cpu", threads); }

std::vector<DeviceInfo> list() {
    const Computing computing(nullptr);
    return Device::list();
}

// The number in a file, or behind a word of it; infinity where there is none, as where a limit is "max".
double number_in(const std::string& path, const char* word = nullptr) {
    std::ifstream file(path);
    double number = 0;
    for (std::string read; word && file >> read && read != word;) continue;
    return file >> number ? number : std::numeric_limits<double>::infinity();
}

} // namespace

double memory_at_hand(string_view where) {
    const std::string root(where);
    double free = 1024 * number_in(root + "/proc/meminfo", "MemAvailable:");
    for (const std::string& group : simd::control_groups("memory", root)) {
        const double files = number_in(group + "/memory.stat", "inactive_file"); // which the system can drop
        for (const auto& [limit, used] : {std::pair{"max", "current"}, {"limit_in_bytes", "usage_in_bytes"}}) {
            const double taken = number_in(group + "/memory." + used) - (std::isfinite(files) ? files : 0);
            if (std::isfinite(taken))
                free = std::min(free, std::max(0.0, number_in(group + "/memory." + limit) - taken));
        }
    }
    return free;
}

void need_memory(const Scene& scene, const SkinOptions& options) {
    const double needed = scene::bytes_of(scene, options);
    if (needed < 0x1p28 || options.count > 1 << 20) return; // the library refuses so many pads
    if (const double free = memory_at_hand(""); needed > free)
        throw Error(Error::Code::no_memory, "",
                    scene::needs_of(scene, options) + ", and " + scene::bytes_text(free) + " are available");
}

void write(Writer& writer, const SharedDevice& device) { writer(device.which, device.threads); }

SharedDevice device_in(Reader& reader) {
    SharedDevice device;
    reader(device.which, device.threads);
    device.open = open_devices()[{device.which, device.threads, getpid()}].lock();
    return device.open ? device : opened(device.which, device.threads);
}
void make(SharedDevice* self, Reader& reader) { new (self) SharedDevice(device_in(reader)); }

SharedDevice device_of(nb::handle argument) {
    if (argument.is_none()) return open_cpu(0);
    SharedDevice* device = nullptr;
    if (nb::try_cast(argument, device) && device) return *device;
    string_view which;
    if (nb::try_cast(argument, which)) return open(which);
    scene::refuse("device", description_of(argument), "a Device, a text as Device.open takes it, or None");
}

void bind_device(nb::module_& m) {
    nb::class_<DeviceInfo>(m, "DeviceInfo", "What is known of a device.")
        .def(Pickled())
        .def_ro("name", &DeviceInfo::name, "\"cpu\", or what the driver calls the device.")
        .def_ro("kind", &DeviceInfo::kind, "\"cpu path\", \"discrete GPU\", \"software\" ..")
        .def_ro("driver", &DeviceInfo::driver, "Name and version; empty for the CPU path.")
        .def_ro("uuid", &DeviceInfo::uuid, "By which devices of one name differ; empty for the CPU path.")
        .def_ro("vulkan", &DeviceInfo::vulkan)
        .def_ro("exact", &DeviceInfo::exact, "Whether a self-test gave the bits of the CPU path.")
        .def_ro("refused", &DeviceInfo::refused, "The reason why the device cannot be used; empty if it can.")
        .def("__repr__", [](const DeviceInfo& i) { return "<DeviceInfo " + i.name + ", " + i.kind + ">"; });
    nb::class_<SharedDevice>(m, "Device", "Where runs and skins compute. Open one once and hand it to each.")
        .def(Pickled())
        .def_static(
            "cpu", open_cpu, nb::arg("threads") = 0,
            "Return the CPU path. threads: 0 is one per core that the process may use, 1 only the calling thread.")
        .def_static(
            "open", open, nb::arg("which") = "auto",
            "Open a device: \"auto\" (a GPU if there is one, else the CPU path), \"cpu\", \"vulkan\", a number\n"
            "of list(), or a part of a Vulkan device's name or, from 8 characters on, of its uuid.")
        .def_static("list", list, "Return every Vulkan device, usable or not.")
        .def_prop_ro("info", [](const SharedDevice& d) { return d.device().info(); })
        .def("__repr__", [](const SharedDevice& d) { return "<Device " + d.device().info().name + ">"; });
}

void bind_report(nb::module_& m) {
    nb::class_<Figure>(m, "Figure", "A figure, and the range in which it is plausible for skin. NaN: not known.")
        .def(Pickled())
        .def_ro("value", &Figure::value)
        .def_ro("least", &Figure::least)
        .def_ro("greatest", &Figure::greatest)
        .def_prop_ro("outside", &Figure::outside, "Whether the value is known and outside the range.")
        .def("__repr__", [](const Figure& f) {
            return "<Figure " + shortest(f.value) + " in " + shortest(f.least) + ".." + shortest(f.greatest) + ">";
        });
    nb::class_<Report>(m, "Report", "What the numbers of a skin mean.")
        .def(Pickled())
        .def_ro("strain", &Report::strain, "Greatest |eps|: indentation over thickness.")
        .def_ro("indentation", &Report::indentation, "m: thickness*strain.")
        .def_ro("gain", &Report::gain, "Greatest |l*C|; above 1 responses can change sign.")
        .def_ro("cells_per_ridge", &Report::cells_per_ridge)
        .def_ro("retardation_times", &Report::retardation_times, "s")
        .def_prop_ro(
            "sign_changed",
            [](const Report& r) {
                std::vector<const char*> names;
                for (Quantity q : r.sign_changed) names.push_back(name(q));
                return names;
            },
            "The responses that have in some cell another sign than what they answer to.")
        .def_ro("vibration", &Report::vibration,
                "Hz: where frames lose a tenth of a vibration, 0.178 over the time between two frames.")
        .def_ro("fine_load", &Report::fine_load, "The share of the load that is finer than receptors lie deep.");
}

} // namespace dermis::python
