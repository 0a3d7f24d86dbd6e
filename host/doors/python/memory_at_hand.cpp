// SPDX-License-Identifier: MIT
// The memory that skins may take.
#include "host/core/base/cores.hpp"
#include "host/core/base/memory.hpp"
#include "host/doors/python/module.hpp"

#include <cmath>
#include <fstream>
#include <limits>

namespace dermis::python {
namespace {

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

} // namespace dermis::python
