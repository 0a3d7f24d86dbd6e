// SPDX-License-Identifier: MIT
// Reads .npy maps: format versions 1 to 3.
#include "host/scene/refusal.hpp"
#include "host/scene/scene.hpp"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <regex>

namespace dermis::scene {

Error NpyFile::error(const std::string& what) const {
    return Error(Error::Code::bad_input, parameter_, parameter_ + " = \"" + path_ + "\": " + what);
}

NpyFile::NpyFile(const std::string& path, int width, int height, bool sequence, const std::string& parameter)
    : path_(path), parameter_(parameter), width_(width), cells_(size_t(width) * height), sequence_(sequence),
      in_(path, std::ios::binary) {
    allowed_ = "; allowed: a .npy file of float32 or float64, C order, shape (" +
               std::string(sequence ? "frames, " : "") + std::to_string(height) + ", " + std::to_string(width) + ")";
    if (!in_) throw error(std::string("cannot be read (") + std::strerror(errno) + ")" + allowed_);
    char magic[8] = {};
    if (!in_.read(magic, 8) || std::memcmp(magic, "\x93NUMPY", 6) != 0) throw error("is not a .npy file" + allowed_);
    unsigned char length[4] = {};
    in_.read(reinterpret_cast<char*>(length), magic[6] == 1 ? 2 : 4);
    const uint32_t size = length[0] | length[1] << 8 | uint32_t(length[2]) << 16 | uint32_t(length[3]) << 24;
    if (!in_ || size > 4096) throw error("has a damaged header" + allowed_);
    std::string header(size, ' ');
    std::smatch descr, shape, counted;
    if (!in_.read(header.data(), size) || !std::regex_search(header, descr, std::regex("'descr': *'([^']*)'")) ||
        !std::regex_search(header, shape, std::regex("'shape': *(\\([^)]*\\))")))
        throw error("has a damaged header" + allowed_);
    f8_ = descr[1] == "<f8";
    if ((!f8_ && descr[1] != "<f4") || header.find("'fortran_order': False") == std::string::npos)
        throw error("holds '" + descr[1].str() + "', or Fortran order" + allowed_);
    const std::string shown = shape[1].str();
    const std::regex expected("\\( *" + std::string(sequence ? "([1-9][0-9]{0,9}) *, *" : "()") +
                              std::to_string(height) + " *, *" + std::to_string(width) + " *,? *\\)");
    if (!std::regex_match(shown, counted, expected)) throw error("has shape " + shown + allowed_);
    if (sequence) maps_ = std::stoll(counted[1].str());
    first_ = in_.tellg();
    in_.seekg(0, std::ios::end);
    const double there = double(in_.tellg() - first_), wanted = double(maps_) * double(cells_) * (f8_ ? 8 : 4);
    if (there < wanted) throw error("is cut short" + allowed_);
    if (there > wanted) throw error("goes on after its last cell" + allowed_);
}

void NpyFile::read(long long map, std::vector<double>& values) {
    const std::streamoff bytes = std::streamoff(cells_) * (f8_ ? 8 : 4);
    values.resize(cells_);
    if (!f8_) raw_.resize(cells_);
    in_.seekg(first_ + map * bytes);
    in_.read(f8_ ? reinterpret_cast<char*>(values.data()) : reinterpret_cast<char*>(raw_.data()), bytes);
    if (!in_) throw error("is cut short" + allowed_);
    if (!f8_) values.assign(raw_.begin(), raw_.end());
    for (size_t i = 0; i < cells_; ++i)
        if (!finite(values[i]))
            throw error((sequence_ ? "frame " + std::to_string(map) + ", " : "") + "cell " + cell_text(i, width_) +
                        " is " + shortest(values[i]) + "; allowed: finite numbers");
}

std::vector<double> read_npy(const std::string& path, int width, int height, const std::string& parameter) {
    std::vector<double> map;
    NpyFile(path, width, height, false, parameter).read(0, map);
    return map;
}

} // namespace dermis::scene
