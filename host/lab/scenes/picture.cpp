// SPDX-License-Identifier: MIT
// Maps of any size, from .npy files and pictures.
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/scene.hpp"

#include <limits>
#include <memory>

#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>

namespace dermis::scene {
namespace {

constexpr int most_pixels = 16384;                                       // along a side
constexpr double most_bytes = double(most_pixels) * double(most_pixels); // of all pixels: one for each

// Returns the kind of a file by its first bytes, as "PNG"; empty: it has none.
std::string kind_of(const std::string& path) {
    char start[4] = {};
    if (!why_no_file(path).empty() || !std::ifstream(path, std::ios::binary).read(start, sizeof start)) return "";
    using Bytes = std::string_view;
    for (auto [bytes, kind] : {std::pair{Bytes("\x89PNG"), "PNG"},
                               {Bytes("BM"), "BMP"},
                               {Bytes("\xff\xd8\xff"), "JPEG"},
                               {Bytes("II*\0", 4), "TIFF"},
                               {Bytes("MM\0*", 4), "TIFF"},
                               {Bytes("GIF8"), "GIF"},
                               {Bytes("\x93NUM"), "npy"}})
        if (Bytes(start, sizeof start).starts_with(bytes)) return kind;
    return path.ends_with(".npy") ? "" : "file of another kind";
}

// Returns how a PNG is damaged, which its reader does not look for; empty: its chunks, each with a checksum, are whole.
// Fills its palette up with transparent colours, because the reader takes the colour of a number beyond it from memory
// that nothing has set.
std::string damage_of(std::string& png) {
    size_t colours = 0; // of the palette
    bool indexed = false;
    const auto number_at = [&](size_t at) {
        uint32_t n = 0;
        for (size_t i = 0; i < 4; ++i) n = n << 8 | uint8_t(png[at + i]);
        return n;
    };
    for (size_t at = 8; at + 12 <= png.size();) {
        const size_t length = number_at(at);
        const std::string kind = png.substr(at + 4, 4);
        if (length > png.size() - at - 12) break;
        uint32_t sum = ~0u; // CRC-32
        for (const char byte : std::string_view(png).substr(at + 4, 4 + length)) {
            sum ^= uint8_t(byte);
            for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ (sum & 1 ? 0xedb88320 : 0);
        }
        const bool too_long = kind == "tRNS" && indexed && length > colours;
        if (~sum != number_at(at + 8 + length) || too_long) return "is damaged in its chunk " + kind;
        if (kind == "IEND") return "";
        if (kind == "IHDR" && length == 13) indexed = png[at + 17] == 3;
        at += 12 + length;
        if (kind == "PLTE") colours = length / 3;
        if (kind != "PLTE" || !indexed || length % 3 || length >= 768) continue;
        const std::string opacities = std::string(colours, '\xff') + std::string(256 - colours, '\0');
        png.insert(at, std::string("\0\0\1\0tRNS", 8) + opacities + std::string(4, '\0')); // with no checksum
        png.replace(at - 12 - length, 4, std::string("\0\0\3\0", 4)).insert(at - 4, 768 - length, '\0');
        at += 768 - length + 12 + 256;
    }
    return "ends before its last chunk";
}

// Writes the grey values of pixels with their channels: grey or colours, and the opacity behind them where there are
// two or four. Returns the first pixel that is not opaque, or how many there are.
template <class Number> size_t to_grey(const Number* pixel, int channels, std::vector<double>& values) {
    constexpr auto most = std::numeric_limits<Number>::max();
    for (size_t i = 0; i < values.size(); ++i, pixel += channels) {
        if (channels % 2 == 0 && pixel[channels - 1] != most) return i;
        values[i] = channels < 3 ? pixel[0] : (77 * pixel[0] + 150 * pixel[1] + 29 * pixel[2]) >> 8;
        values[i] /= most;
    }
    return values.size();
}

FileMap read_picture(const std::string& path, int asked_width, int asked_height, const std::string& parameter) {
    const auto size_text = [](int width, int height) { return std::to_string(width) + " x " + std::to_string(height); };
    const auto fail = [&](const std::string& what) {
        return Error(Error::Code::bad_input, parameter,
                     parameter + " = \"" + path + "\": " + what + "; allowed: a PNG of " +
                         (asked_width ? size_text(asked_width, asked_height) : "up to 16384 x 16384") +
                         " opaque pixels of at most " + bytes_text(most_bytes) + " in all");
    };
    std::string content;
    if (const std::string why = read_file(path, content, INT_MAX); !why.empty()) throw fail(why);
    const auto* bytes = reinterpret_cast<const stbi_uc*>(content.data());
    int size = int(content.size());
    int width = 0, height = 0, channels = 0;
    if (!stbi_info_from_memory(bytes, size, &width, &height, &channels))
        throw fail(std::string("cannot be read (") + stbi_failure_reason() + ")");
    const bool fits =
        asked_width ? width == asked_width && height == asked_height : std::max(width, height) <= most_pixels;
    if (!fits) throw fail("has " + size_text(width, height) + " pixels");
    const bool deep = stbi_is_16_bit_from_memory(bytes, size);
    const double in_memory = double(width) * height * channels * (deep ? 2 : 1);
    if (in_memory > most_bytes)
        throw fail("has " + size_text(width, height) + " pixels of " + bytes_text(in_memory) + " in all");
    if (const std::string why = damage_of(content); !why.empty()) throw fail(why);
    const bool filled = content.size() > size_t(size);
    bytes = reinterpret_cast<const stbi_uc*>(content.data()), size = int(content.size());
    const std::unique_ptr<void, void (*)(void*)> pixels(
        deep ? static_cast<void*>(stbi_load_16_from_memory(bytes, size, &width, &height, &channels, 0))
             : stbi_load_from_memory(bytes, size, &width, &height, &channels, 0),
        stbi_image_free);
    if (!pixels && std::string_view(stbi_failure_reason()) == "outofmem") throw std::bad_alloc();
    if (!pixels) throw fail(std::string("cannot be read (") + stbi_failure_reason() + ")");
    FileMap map{.values = {}, .width = width, .height = height, .picture = true};
    std::vector<double>& values = map.values.edit();
    values.resize(size_t(width) * size_t(height));
    const size_t opaque = deep ? to_grey(static_cast<const stbi_us*>(pixels.get()), channels, values)
                               : to_grey(static_cast<const stbi_uc*>(pixels.get()), channels, values);
    if (opaque < values.size())
        throw fail((filled ? "is transparent, or has a colour that its palette lacks, at pixel "
                           : "is transparent at pixel ") +
                   cell_text(opaque, width));
    return map;
}

} // namespace

FileMap read_map(const std::string& path, int width, int height, const std::string& parameter) {
    const std::string kind = kind_of(path);
    if (kind == "PNG") return read_picture(path, width, height, parameter);
    if (!kind.empty() && kind != "npy")
        refuse(parameter, "\"" + path + "\", a " + kind,
               "a .npy file of numbers, or a PNG: save the picture as one, as Pillow's Image.open(..).save(\"..png\") "
               "does");
    NpyFile file(path, width, height, false, parameter);
    FileMap map{.values = {}, .width = file.width(), .height = file.height()};
    file.read(0, map.values.edit());
    return map;
}

} // namespace dermis::scene
