// SPDX-License-Identifier: MIT
// Reads .npy files, format versions 1 to 3.
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/scene.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace dermis::scene {

// A type of numbers as a .npy file names it, without the order of its bytes.
struct NumberType {
    std::string_view name;
    size_t bytes;
    double (*number)(const char*); // from bytes in this machine's order
};

namespace {

template <class T> double number_of(const char* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return double(value);
}

double half_of(const char* bytes) {
    uint16_t bits;
    std::memcpy(&bits, bytes, sizeof bits);
    const int exponent = bits >> 10 & 31, fraction = bits & 1023;
    const double size = exponent == 31  ? (fraction ? std::nan("") : HUGE_VAL)
                        : exponent == 0 ? std::ldexp(fraction, -24)
                                        : std::ldexp(fraction + 1024, exponent - 25);
    return bits >> 15 ? -size : size;
}

constexpr NumberType number_types[] = {
    {"f8", 8, number_of<double>},   {"f4", 4, number_of<float>},    {"f2", 2, half_of},
    {"i1", 1, number_of<int8_t>},   {"i2", 2, number_of<int16_t>},  {"i4", 4, number_of<int32_t>},
    {"i8", 8, number_of<int64_t>},  {"u1", 1, number_of<uint8_t>},  {"u2", 2, number_of<uint16_t>},
    {"u4", 4, number_of<uint32_t>}, {"u8", 8, number_of<uint64_t>}, {"b1", 1, number_of<uint8_t>}};
static_assert(std::endian::native == std::endian::little);

void skip_spaces(std::string_view& text) { text.remove_prefix(std::min(text.find_first_not_of(' '), text.size())); }

// Takes spaces and then `token` from the front of the text. Returns false where the token is not there.
bool take(std::string_view& text, std::string_view token) {
    skip_spaces(text);
    if (!text.starts_with(token)) return false;
    text.remove_prefix(token.size());
    return true;
}

// Takes spaces and then a whole number of 1 to 10 digits, the first of which is not 0.
bool take_count(std::string_view& text, long long& count) {
    skip_spaces(text);
    const std::string_view digits = text.substr(0, text.find_first_not_of("0123456789"));
    if (digits.empty() || digits.size() > 10 || digits[0] == '0') return false;
    count = std::stoll(std::string(digits));
    text.remove_prefix(digits.size());
    return true;
}

// Returns how often a header has a key, in quotes of either kind.
int count_of(std::string_view header, const std::string& key) {
    int count = 0;
    for (const char* quote : {"'", "\""}) {
        const std::string quoted = quote + key + quote;
        for (size_t at = header.find(quoted); at != header.npos; at = header.find(quoted, at + 1)) ++count;
    }
    return count;
}

// Returns the value of a key in a header, with the delimiters that it begins and ends with; empty where there is none.
std::string_view value_in(std::string_view header, std::string_view key, char first, char last) {
    const size_t at = header.find(key);
    if (at == header.npos) return {};
    std::string_view value = header.substr(at + key.size());
    skip_spaces(value);
    const size_t end = value.find(last, 1);
    return value.starts_with(first) && end != value.npos ? value.substr(0, end + 1) : std::string_view();
}

} // namespace

Error NpyFile::error(const std::string& what) const {
    return Error(Error::Code::bad_input, parameter_, parameter_ + " = \"" + path_ + "\": " + what);
}

std::string NpyFile::read_header() {
    char magic[8] = {};
    if (!read_bytes(in_, magic, 8) || std::memcmp(magic, "\x93NUMPY", 6) != 0)
        throw error("is not a .npy file" + allowed_);
    unsigned char length[4] = {};
    const bool there = read_bytes(in_, reinterpret_cast<char*>(length), magic[6] == 1 ? 2 : 4);
    const uint32_t size = length[0] | length[1] << 8 | uint32_t(length[2]) << 16 | uint32_t(length[3]) << 24;
    std::string header(there && size <= 4096 ? size : 0, ' ');
    if (header.empty() || !read_bytes(in_, header.data(), size)) throw error("has a damaged header" + allowed_);
    return header;
}

NpyFile::NpyFile(const std::string& path, int width, int height, bool sequence, const std::string& parameter)
    : path_(path), parameter_(parameter), width_(width), cells_(size_t(width) * height), sequence_(sequence) {
    const bool any = width == 0;
    const std::string rows = any ? "1..16384" : std::to_string(height), columns = any ? rows : std::to_string(width);
    allowed_ = "; allowed: a .npy file of numbers, shape (" + std::string(sequence ? "frames, " : "") + rows + ", " +
               columns + ")";
    if (const std::string why = open_file(path, in_); !why.empty()) throw error(why + allowed_);
    const std::string header = read_header();
    for (const char* key : {"descr", "fortran_order", "shape"})
        if (const int count = count_of(header, key); count > 1)
            throw error("has the key '" + std::string(key) + "' " + std::to_string(count) + " times in its header" +
                        allowed_);
    if (!value_in(header, "'descr':", '[', ']').empty())
        throw error("holds a structured array; save one of its fields, as np.save(path, array['p'])" + allowed_);
    const std::string type(value_in(header, "'descr':", '\'', '\'')), shape(value_in(header, "'shape':", '(', ')'));
    by_columns_ = header.find("'fortran_order': True") != std::string::npos;
    if (type.empty() || shape.empty() || (!by_columns_ && header.find("'fortran_order': False") == std::string::npos))
        throw error("has a damaged header" + allowed_);
    for (const NumberType& known : number_types)
        if (type.size() == 5 && known.name == type.substr(2, 2)) type_ = &known;
    const bool ordered = type_ && std::string_view(type_->bytes == 1 ? "|<>" : "<>").find(type[1]) != std::string::npos;
    if (!ordered) throw error("holds " + type + allowed_);
    swapped_ = type[1] == '>';
    std::string_view rest = shape;
    long long of_rows = 0, of_columns = 0;
    const bool fits = take(rest, "(") && (!sequence || (take_count(rest, maps_) && take(rest, ","))) &&
                      (any ? take_count(rest, of_rows) && take(rest, ",") && take_count(rest, of_columns) &&
                                 std::max(of_rows, of_columns) <= 16384
                           : take(rest, rows) && take(rest, ",") && take(rest, columns));
    take(rest, ","); // A Python tuple may end with a comma.
    if (!fits || !take(rest, ")")) throw error("has shape " + shape + allowed_);
    if (any) {
        width_ = int(of_columns);
        cells_ = size_t(of_rows * of_columns);
    }
    first_ = in_.tellg();
    in_.seekg(0, std::ios::end);
    const double bytes = double(in_.tellg() - first_), expected = double(maps_) * double(cells_) * double(type_->bytes);
    if (bytes < expected) throw error("is cut short" + allowed_);
    if (bytes > expected) throw error("goes on after its last cell" + allowed_);
}

// Reads the bytes of a map. In the order of Fortran each map is spread over the file: all maps are read once.
void NpyFile::read_bytes_of(long long map) {
    const size_t each = type_->bytes, bytes = cells_ * each * (by_columns_ ? size_t(maps_) : 1);
    if (by_columns_ && raw_.size() == bytes) return;
    raw_.resize(bytes);
    in_.seekg(first_ + (by_columns_ ? 0 : map * std::streamoff(bytes)));
    if (!read_bytes(in_, raw_.data(), std::streamoff(bytes))) {
        raw_.clear();
        throw error("is cut short" + allowed_);
    }
    for (size_t i = 0; swapped_ && i < bytes; i += each)
        std::reverse(raw_.begin() + long(i), raw_.begin() + long(i + each));
}

void NpyFile::read(long long map, std::vector<double>& values) {
    const size_t each = type_->bytes, width = size_t(width_), rows = cells_ / width, maps = size_t(maps_);
    read_bytes_of(map);
    values.resize(cells_);
    if (by_columns_)
        for (size_t i = 0; i < cells_; ++i)
            values[i] = type_->number(raw_.data() + (size_t(map) + maps * (i / width + rows * (i % width))) * each);
    else if (type_->name == "f8") std::memcpy(values.data(), raw_.data(), raw_.size());
    else if (type_->name == "f4")
        for (size_t i = 0; i < cells_; ++i) values[i] = number_of<float>(raw_.data() + i * each); // in registers
    else
        for (size_t i = 0; i < cells_; ++i) values[i] = type_->number(raw_.data() + i * each);
    uint64_t joined = 0;
    for (double v : values) joined |= not_finite(std::bit_cast<uint64_t>(v));
    for (size_t i = 0; any_not_finite(joined); ++i)
        if (!finite(values[i]))
            throw error((sequence_ ? "frame " + std::to_string(map) + ", " : "") + "cell " + cell_text(i, width_) +
                        " is " + shortest(values[i]) + "; allowed: finite numbers");
}

} // namespace dermis::scene
