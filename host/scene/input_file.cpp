// SPDX-License-Identifier: MIT
#include "host/scene/input_file.hpp"

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

} // namespace dermis::scene
