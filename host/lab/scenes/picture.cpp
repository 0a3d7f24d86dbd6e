// SPDX-License-Identifier: MIT
// Maps of any size, from .npy files and pictures.
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/scene.hpp"

#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>

namespace dermis::scene {
namespace {

constexpr int most_pixels = 16384; // along a side
constexpr std::string_view png = "\x89PNG";

bool is_picture(const std::string& path) {
    if (!why_no_file(path).empty()) return false;
    std::ifstream in(path, std::ios::binary);
    char start[png.size()] = {};
    return in.read(start, sizeof start) && std::string_view(start, sizeof start) == png;
}

FileMap read_picture(const std::string& path, int asked_width, int asked_height, const std::string& parameter) {
    const auto size_text = [](int width, int height) { return std::to_string(width) + " x " + std::to_string(height); };
    const auto fail = [&](const std::string& what) {
        return Error(Error::Code::bad_input, parameter,
                     parameter + " = \"" + path + "\": " + what + "; allowed: a PNG of " +
                         (asked_width ? size_text(asked_width, asked_height) : "up to 16384 x 16384") + " pixels");
    };
    std::string content;
    if (const std::string why = read_file(path, content, INT_MAX); !why.empty()) throw fail(why);
    const auto* bytes = reinterpret_cast<const stbi_uc*>(content.data());
    const int size = int(content.size());
    int width = 0, height = 0, channels = 0;
    if (!stbi_info_from_memory(bytes, size, &width, &height, &channels))
        throw fail(std::string("cannot be read (") + stbi_failure_reason() + ")");
    const bool fits =
        asked_width ? width == asked_width && height == asked_height : std::max(width, height) <= most_pixels;
    if (!fits) throw fail("has " + size_text(width, height) + " pixels");
    const std::unique_ptr<stbi_us, void (*)(void*)> grey(
        stbi_load_16_from_memory(bytes, size, &width, &height, &channels, 1), stbi_image_free);
    if (!grey && std::string_view(stbi_failure_reason()) == "outofmem") throw std::bad_alloc();
    if (!grey) throw fail(std::string("cannot be read (") + stbi_failure_reason() + ")");
    FileMap map{.values = {}, .width = width, .height = height, .picture = true};
    std::vector<double>& values = map.values.edit();
    values.resize(size_t(width) * size_t(height));
    // 8 bits are repeated in 16, so that 255 is 65535.
    for (size_t i = 0; i < values.size(); ++i) values[i] = grey.get()[i] / 65535.0;
    return map;
}

} // namespace

FileMap read_map(const std::string& path, int width, int height, const std::string& parameter) {
    if (is_picture(path)) return read_picture(path, width, height, parameter);
    NpyFile file(path, width, height, false, parameter);
    FileMap map{.values = {}, .width = file.width(), .height = file.height()};
    file.read(0, map.values.edit());
    return map;
}

} // namespace dermis::scene
