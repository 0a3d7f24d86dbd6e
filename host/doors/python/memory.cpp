// SPDX-License-Identifier: MIT
// The memory that skins may take.
#include "host/core/base/memory.hpp"
#include "host/core/base/cores.hpp"
#include "host/doors/python/module.hpp"

#include <cmath>
#include <fstream>
#include <limits>

namespace dermis::python {
namespace {

// The number in a file; infinity where there is none, as where it says "max".
double number_in(const std::string& path) {
    double number = 0;
    return std::ifstream(path) >> number ? number : std::numeric_limits<double>::infinity();
}

// The number behind a word in a file; 0 where there is none.
double number_behind(const char* word, const std::string& path) {
    std::ifstream file(path);
    double number = 0;
    for (std::string read; file >> read;)
        if (read == word && file >> number) return number;
    return 0;
}

// The bytes that this process may still take: of the machine, and of each control group, version 1 or 2, that it is in.
// Files that the system can drop are not counted as taken. Infinity where nothing is known. root: as in cores.hpp.
double memory_at_hand(string_view where) {
    const std::string root(where);
    const double machine = 1024 * number_behind("MemAvailable:", root + "/proc/meminfo");
    double free = machine > 0 ? machine : std::numeric_limits<double>::infinity();
    for (const std::string& group : simd::control_groups("memory", root))
        for (const auto& [limit, used] :
             {std::pair{"/memory.max", "/memory.current"}, {"/memory.limit_in_bytes", "/memory.usage_in_bytes"}}) {
            const double taken = number_in(group + used) - number_behind("inactive_file", group + "/memory.stat");
            if (std::isfinite(taken)) free = std::min(free, std::max(0.0, number_in(group + limit) - taken));
        }
    return free;
}

} // namespace

void need_memory(const Scene& scene, const SkinOptions& options) {
    const double needed = scene::bytes_of(scene, options);
    if (needed < 0x1p28 || options.count > 1 << 20) return; // the library refuses so many pads
    if (const double free = memory_at_hand(""); needed > free)
        throw Error(Error::Code::no_memory, "",
                    scene::needs_of(scene, options) + ", and " + scene::bytes_text(free) + " are available");
}

void bind_memory(nb::module_& m) {
    m.def("memory_at_hand", memory_at_hand, nb::arg("root") = "",
          "Return the bytes that this process may still take, of the machine and of each control group that it is in.\n"
          "root: a folder in place of the system's root.");
}

} // namespace dermis::python
