// SPDX-License-Identifier: MIT
// Tables in text files, in one dialect: commas between columns, decimals with a point, and a number may begin with +.
// Empty lines and lines that begin with # are skipped; a byte order mark, ends of lines as in Windows, and blanks and
// quotes around a line or a word do not count.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace dermis::scene {

class TableFile {
  public:
    // key: names the file in errors, as "load.path"; empty: its path alone does. Throws Error::bad_input unless the
    // path is that of a regular file of at most `most_bytes`.
    TableFile(const std::string& path, const std::string& key, uintmax_t most_bytes = UINTMAX_MAX);

    // Goes to the next line that is not skipped. Returns false where the file ends.
    bool next();
    // The words of this line, until the next one is read.
    const std::vector<std::string_view>& words() const { return words_; }

    // Each of these throws Error::bad_input with the file, and all but the last with the line and its text. what: the
    // name of a value; empty: "column 1" and so on.
    void need_columns(size_t count, const std::string& hint = {}) const;
    double number(size_t column, std::string_view what = {}, const char* allowed = "a finite number") const;
    [[noreturn]] void refuse(std::string_view what, std::string_view value, const std::string& allowed) const;
    [[noreturn]] void refuse_line(const std::string& allowed) const;
    [[noreturn]] void refuse_file(const std::string& why) const;

  private:
    std::string file_, key_, line_; // file_: as errors name it
    std::ifstream in_;
    int number_ = 0; // of the line
    std::vector<std::string_view> words_;
};

// Whether a word is a number, finite or not.
bool is_number(std::string_view word);

} // namespace dermis::scene
