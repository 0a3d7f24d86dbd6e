// SPDX-License-Identifier: MIT
#include "host/lab/scenes/input_file.hpp"

#include <algorithm>
#include <string_view>

namespace dermis::scene {
namespace {

constexpr std::string_view decimals = "0123456789_", before_words = " \t\r\n,[]{}#\"'", behind_words = " \t\r\n,]}#";
constexpr size_t longest_word = 100;

bool is_in(std::string_view all, char c) { return all.find(c) != all.npos; }

// Returns the place behind a string that begins at text[at], or the place of the line's end that cuts the string short;
// npos if a backslash in it stands before a space, the line's end or a character that is not ASCII.
size_t after_string(const std::string& text, size_t at) {
    const char quote = text[at];
    const bool basic = quote == '"'; // has escapes
    const std::string three(3, quote);
    const bool lines = text.compare(at, 3, three) == 0;
    for (size_t i = at + (lines ? 3 : 1); i < text.size(); ++i) {
        if (basic && text[i] == '\\') {
            if (++i < text.size() && (text[i] <= ' ' || text[i] > '~')) return text.npos; // char may be signed
        } else if (lines ? text.compare(i, 3, three) == 0 : text[i] == quote) {
            if (!lines) return i + 1;
            for (i += 3; i < text.size() && text[i] == quote;) ++i; // up to two more are in the string
            return i;
        } else if (!lines && text[i] == '\n') return i;
    }
    return text.size();
}

// Returns whether the name of a table, behind a bracket that begins a line at text[at], begins as the parser assumes
// without a check.
bool begins_name(const std::string& text, size_t at) {
    at = text.find_first_not_of(" \t", at + (text.compare(at, 2, "[[") == 0 ? 2 : 1));
    return at == text.npos || is_in("-_\"']0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ", text[at]);
}

// Takes digits and single underscores between them from the front.
bool take_digits(std::string_view& word, std::string_view allowed) {
    const std::string_view digits = word.substr(0, word.find_first_not_of(allowed));
    word.remove_prefix(digits.size());
    return !digits.empty() && digits.front() != '_' && digits.back() != '_' && digits.find("__") == digits.npos;
}

bool take_any(std::string_view& word, std::string_view of) {
    if (word.empty() || !is_in(of, word[0])) return false;
    word.remove_prefix(1);
    return true;
}

// Returns whether a word is what a value without quotes can be: a number, true or false.
bool is_plain(std::string_view word) {
    if (word.size() > longest_word) return false;
    if (word == "true" || word == "false") return true;
    for (auto [start, digits] : {std::pair<std::string_view, std::string_view>{"0x", "0123456789abcdefABCDEF_"},
                                 {"0o", "01234567_"},
                                 {"0b", "01_"}})
        if (word.starts_with(start)) return word.remove_prefix(2), take_digits(word, digits) && word.empty();
    take_any(word, "+-");
    if (word == "inf" || word == "nan") return true;
    if (!take_digits(word, decimals) || (take_any(word, ".") && !take_digits(word, decimals))) return false;
    if (take_any(word, "eE")) {
        take_any(word, "+-");
        if (!take_digits(word, decimals)) return false;
    }
    return word.empty();
}

} // namespace

Unreadable unreadable(const std::string& text) {
    int line = 1;
    size_t dots = 0;
    std::string open;                  // open brackets; ( stands for [ around the name of a table
    bool begins = true, value = false; // nothing but spaces stands in the line so far, or behind an =
    char last = '\n';                  // the last character that is no space
    for (size_t i = text.starts_with("\xef\xbb\xbf") ? 3 : 0; i < text.size(); ++i) {
        const char c = text[i], inner = open.empty() ? '\0' : open.back();
        if (c == '"' || c == '\'') {
            if (!is_in("\n=[{,.", last)) // to the parser it belongs to what stands before it, and begins nothing
                return {line, "a quote where no text begins; allowed: behind =, [, {, a comma or a dot, and in a text"};
            last = c;
            const size_t behind = after_string(text, i);
            if (behind == text.npos)
                return {line, "a backslash in a text stands before a space, the line's end or a character that is not "
                              "ASCII; allowed: before a letter, a quote or a backslash"};
            line += int(std::count(text.begin() + std::ptrdiff_t(i), text.begin() + std::ptrdiff_t(behind), '\n'));
            i = behind - 1;
            begins = value = false;
            continue;
        }
        if (c == '#') i = std::min(text.find('\n', i), text.size()) - 1;
        if (static_cast<unsigned char>(c) >= 0x80)
            return {line, "a character that is not ASCII; allowed: in a text in quotes, and in a comment"};
        if ((value || inner == '[') && !is_in(before_words, c)) {
            const std::string word = text.substr(i, text.find_first_of(behind_words, i) - i);
            if (!is_plain(word))
                return {line, word.substr(0, longest_word) + " without quotes; allowed: a number, true or false, or a "
                                                             "text in quotes"};
            i += word.size() - 1;
            last = word.back();
            value = false;
            continue;
        }
        if (c == '[' && begins && open.empty() && !begins_name(text, i))
            return {line, "a table begins without a name; allowed: letters, digits, - and _, or a text in quotes"};
        if (c == '[' && ((begins && open.empty()) || (open == "(" && text[i - 1] == '['))) open += '(';
        else if (c == '[' || c == '{') open += c;
        if ((c == ']' || c == '}') && !open.empty()) {
            if ((c == '}') != (inner == '{')) return {line, std::string(1, c) + " closes another bracket"};
            open.pop_back();
        }
        dots = c == '.' ? dots + 1 : is_in("\n=,[]{}", c) ? 0 : dots;
        if (open.size() > most_levels || dots >= most_levels) return {line, too_deep, true};
        if (c == '\n' && inner == '(') open.clear(); // the parser has refused it
        line += c == '\n';
        begins = c == '\n' || (begins && (c == ' ' || c == '\t'));
        value = c == '=' || (value && (c == ' ' || c == '\t'));
        if (!is_in(" \t\r", c)) last = c;
    }
    return {};
}

} // namespace dermis::scene
