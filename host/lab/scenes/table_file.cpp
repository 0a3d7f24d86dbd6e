// SPDX-License-Identifier: MIT
#include "host/lab/scenes/table_file.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/units.hpp"

#include <algorithm>

namespace dermis::scene {
namespace {

std::string_view stripped(std::string_view text, std::string_view around = " \t\r\"") {
    const size_t first = text.find_first_not_of(around);
    return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(around) + 1 - first);
}

// Returns the beginning of a text in quotes, with ? in place of what is not a printable character of ASCII.
std::string quoted(std::string_view text) {
    std::string shown = beginning_of(std::string(text), 100);
    std::ranges::replace_if(
        shown, [](char c) { return c < ' ' || c > '~'; }, '?');
    return "\"" + shown + "\"";
}

} // namespace

bool is_number(std::string_view word) {
    double x = 0;
    word = without_plus(word);
    const auto [end, error] = leading_number(word, x);
    return error != std::errc::invalid_argument && end == word.data() + word.size();
}

TableFile::TableFile(const std::string& path, const std::string& key, uintmax_t most_bytes)
    : file_(key.empty() ? path : key + " = \"" + path + "\""), key_(key) {
    if (const std::string why = open_file(path, in_, most_bytes); !why.empty())
        refuse_file(why + "; allowed: a CSV file" +
                    (most_bytes < UINTMAX_MAX ? " of at most " + bytes_text(double(most_bytes)) : ""));
}

bool TableFile::next() {
    while (std::getline(in_, line_)) {
        std::string_view rest = line_;
        if (++number_ == 1 && rest.starts_with("\xef\xbb\xbf")) rest.remove_prefix(3); // byte order mark
        if (rest.find('\0') != rest.npos) refuse_line("text in UTF-8: UTF-16 and binary files have bytes of 0");
        rest = stripped(rest, " \t\r");
        if (rest.empty() || rest[0] == '#') continue;
        if (rest.find('\r') != rest.npos) refuse_line("lines that end in LF or CR LF, not in CR alone");
        words_.clear();
        for (size_t comma = 0; comma != rest.npos; rest.remove_prefix(comma == rest.npos ? 0 : comma + 1)) {
            comma = rest.find(',');
            words_.push_back(stripped(rest.substr(0, comma)));
            if (std::ranges::count(rest.substr(0, comma), '"') % 2)
                refuse_line("no comma within quotes: commas between columns, and decimals with a point");
        }
        return true;
    }
    return false;
}

void TableFile::need_columns(size_t count, const std::string& hint) const {
    if (words_.size() != count)
        refuse_line(std::to_string(count) + " columns with commas between them, and decimals with a point" + hint);
}

double TableFile::number(size_t column, std::string_view what, const char* allowed) const {
    double x = 0;
    if (read_number(without_plus(words_[column]), x)) return x;
    const bool out_of_range =
        is_number(words_[column]) && words_[column].find_first_of("0123456789") != words_[column].npos;
    const char* names = std::ranges::none_of(words_, is_number) ? "; names take one line, and units none" : "";
    refuse(what.empty() ? "column " + std::to_string(column + 1) : std::string(what), words_[column],
           (out_of_range ? "0, or a number from 5e-324 to 1.7e308" : allowed) + std::string(names));
}

void TableFile::refuse(std::string_view what, std::string_view value, const std::string& allowed) const {
    const std::string line = quoted(stripped(line_)), name(what),
                      shown = is_number(value) && value.size() < 100 ? std::string(value) : quoted(value);
    throw Error(Error::Code::bad_input, key_.empty() ? name : key_,
                file_ + ":" + std::to_string(number_) + ": " + name + " = " + shown + "; allowed: " + allowed +
                    (shown == line ? "" : "; the line: " + line));
}

void TableFile::refuse_line(const std::string& allowed) const { refuse("line", stripped(line_), allowed); }

void TableFile::refuse_file(const std::string& why) const {
    throw Error(Error::Code::bad_input, key_.empty() ? "data" : key_, file_ + ": " + why);
}

} // namespace dermis::scene
