// SPDX-License-Identifier: MIT
#include "host/lab/scenes/input_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>

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
    content.clear();
    if (std::string why = why_no_file(path, most_bytes); !why.empty()) return why;
    const auto why_not = [] { return std::string("cannot be read (") + std::strerror(errno) + ")"; };
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return why_not();
    char part[1 << 14];
    ssize_t n = 0;
    try {
        while ((n = ::read(file, part, sizeof part)) > 0 || (n < 0 && errno == EINTR))
            if (n > 0) content.append(part, size_t(n));
    } catch (...) {
        ::close(file);
        throw;
    }
    const std::string why = n == 0 ? "" : why_not();
    ::close(file);
    return why;
}

bool read_bytes(std::istream& in, char* to, std::streamsize bytes) {
    try {
        return bool(in.read(to, bytes));
    } catch (const std::ios::failure&) {
        return false;
    }
}

} // namespace dermis::scene
