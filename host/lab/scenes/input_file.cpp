// SPDX-License-Identifier: MIT
#include "host/lab/scenes/input_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace dermis::scene {

std::string why_no_file(const std::string& path, uintmax_t most_bytes) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) // `error` may say more than that there is none
        return "cannot be read (" +
               (error ? error : std::make_error_code(std::errc::no_such_file_or_directory)).message() + ")";
    if (std::filesystem::is_directory(status)) return "is a directory";
    if (!std::filesystem::is_regular_file(status)) return "is a device, pipe or socket";
    const uintmax_t bytes = std::filesystem::file_size(path, error);
    if (error) return "cannot be read (" + error.message() + ")";
    return bytes <= most_bytes ? "" : "has " + std::to_string(bytes) + " bytes";
}

std::string read_file(const std::string& path, std::string& content, uintmax_t most_bytes) {
    std::ifstream in;
    if (std::string why = open_file(path, in, most_bytes); !why.empty()) return why;
    try {
        content.assign(std::istreambuf_iterator<char>(in), {});
    } catch (const std::ios::failure& e) {
        return std::string("cannot be read (") + e.what() + ")";
    }
    return "";
}

std::string open_file(const std::string& path, std::ifstream& in, uintmax_t most_bytes) {
    if (std::string why = why_no_file(path, most_bytes); !why.empty()) return why;
    errno = 0;
    in.open(path, std::ios::binary);
    if (!in && errno == ENOMEM) throw std::bad_alloc();
    if (!in) return std::string("cannot be read (") + std::strerror(errno) + ")";
    in.exceptions(std::ios::badbit);
    return "";
}

bool read_bytes(std::istream& in, char* to, std::streamsize bytes) {
    try {
        return bool(in.read(to, bytes));
    } catch (const std::ios::failure&) {
        return false;
    }
}

} // namespace dermis::scene
