// SPDX-License-Identifier: MIT
// Reads .npy maps: format versions 1 to 3, float32 or float64, little-endian, C order.
#include "host/scene/scene.hpp"

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <regex>

namespace dermis::scene {

std::vector<double> read_npy(const std::string& path, int width, int height, const std::string& parameter) {
    const auto fail = [&](const std::string& what) -> Error {
        return Error(Error::Code::bad_input, parameter, parameter + " = \"" + path + "\": " + what);
    };
    const std::string wanted = "a .npy file of float32 or float64, C order, shape (" + std::to_string(height) + ", " +
                               std::to_string(width) + ")";
    std::ifstream in(path, std::ios::binary);
    if (!in) throw fail(std::string("cannot be read (") + std::strerror(errno) + "); allowed: " + wanted);
    char magic[8] = {};
    if (!in.read(magic, 8) || std::memcmp(magic, "\x93NUMPY", 6) != 0)
        throw fail("is not a .npy file; allowed: " + wanted);
    unsigned char length[4] = {};
    in.read(reinterpret_cast<char*>(length), magic[6] == 1 ? 2 : 4);
    const uint32_t size = length[0] | length[1] << 8 | uint32_t(length[2]) << 16 | uint32_t(length[3]) << 24;
    if (!in || size > 4096) throw fail("has a damaged header; allowed: " + wanted);
    std::string header(size, ' ');
    std::smatch descr, shape;
    if (!in.read(header.data(), size) || !std::regex_search(header, descr, std::regex("'descr': *'([^']*)'")) ||
        !std::regex_search(header, shape, std::regex("'shape': *(\\([^)]*\\))")))
        throw fail("has a damaged header; allowed: " + wanted);
    const bool f4 = descr[1] == "<f4", f8 = descr[1] == "<f8";
    if ((!f4 && !f8) || header.find("'fortran_order': False") == std::string::npos)
        throw fail("holds '" + descr[1].str() + "', or Fortran order; allowed: " + wanted);
    const std::regex expected("\\( *" + std::to_string(height) + " *, *" + std::to_string(width) + " *,? *\\)");
    if (!std::regex_match(shape[1].str(), expected)) throw fail("has shape " + shape[1].str() + "; allowed: " + wanted);
    const size_t cells = size_t(width) * height;
    std::vector<double> map(cells);
    if (f8) {
        in.read(reinterpret_cast<char*>(map.data()), std::streamsize(cells * 8));
    } else {
        std::vector<float> raw(cells);
        in.read(reinterpret_cast<char*>(raw.data()), std::streamsize(cells * 4));
        map.assign(raw.begin(), raw.end());
    }
    if (!in) throw fail("is cut short; allowed: " + wanted);
    if (in.peek() != std::ifstream::traits_type::eof()) throw fail("goes on after its last cell; allowed: " + wanted);
    for (size_t i = 0; i < cells; ++i)
        if (!std::isfinite(map[i]))
            throw fail("cell [" + std::to_string(i % width) + ", " + std::to_string(i / width) + "] is " +
                       (std::isnan(map[i]) ? "NaN" : "infinite") + "; allowed: finite numbers");
    return map;
}

} // namespace dermis::scene
