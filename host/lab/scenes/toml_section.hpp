// SPDX-License-Identifier: MIT
// Typed access to one table of a TOML file. Errors give the dotted name of the key, its value and what is allowed.
#pragma once

#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/scene_names.hpp"
#include "host/lab/scenes/toml.hpp"
#include "host/lab/scenes/units.hpp"

#include <set>
#include <sstream>

namespace dermis::scene {

// Returns a value as it stands in a file, on one line. The parser's formatter is not used for lists and tables: it
// converts logarithms of their numbers to unsigned numbers, which is undefined for 0.1.
inline std::string text_of(const toml::node& value) {
    std::string items;
    const auto add = [&](const std::string& item) { items += (items.empty() ? " " : ", ") + item; };
    if (const toml::array* list = value.as_array()) {
        for (const toml::node& item : *list)
            if (items.size() < 100) add(text_of(item));
            else return "[" + items + ", .. ]";
        return "[" + items + (items.empty() ? "]" : " ]");
    }
    if (const toml::table* table = value.as_table()) {
        for (auto&& [key, item] : *table) add(std::string(key.str()) + " = " + text_of(item));
        return "{" + items + (items.empty() ? "}" : " }");
    }
    auto text = throwing(std::ostringstream());
    value.visit([&](auto& node) { text << node; });
    return text.str();
}

[[noreturn]] inline void refuse(const std::string& parameter, const toml::node& value, const std::string& allowed) {
    refuse(parameter, text_of(value), allowed);
}

inline std::string listed(const std::vector<std::string>& words, const char* separator) {
    std::string list;
    for (const std::string& word : words) list += (list.empty() ? "" : separator) + word;
    return list;
}

inline double number_in(const toml::node& node, const std::string& parameter, std::string_view unit) {
    if (node.is_integer()) return double(**node.as_integer());
    if (node.is_floating_point()) return **node.as_floating_point();
    if (const auto* text = node.as_string())
        if (const std::optional<double> number = number_in_unit(unit, **text)) return *number;
    refuse(parameter, node, allowed_in_unit(unit));
}

inline int whole_number_in(const toml::node& node, const std::string& parameter, const char* allowed) {
    if (!node.is_integer() || std::abs(double(**node.as_integer())) > 1e9)
        refuse(parameter, node, *allowed ? allowed : "a whole number, -1e9..1e9");
    return int(**node.as_integer());
}

// Reads a number of cells, or a length with its unit, which becomes one by of_length(length, grid).
inline int cells_in(const toml::node& node, const std::string& parameter, const Grid& grid,
                    std::optional<int> (*of_length)(double, const Grid&), const char* allowed = "") {
    const auto* text = node.as_string();
    return text ? cells_of(**text, parameter, text_of(node), grid, of_length)
                : whole_number_in(node, parameter, allowed);
}

inline Cell cell_in(const toml::node& node, const std::string& parameter, const Grid& grid) {
    const toml::array* xy = node.as_array();
    if (!xy || xy->size() != 2) refuse(parameter, node, "[x, y] in whole cells, or as lengths with their unit");
    return {cells_in((*xy)[0], parameter, grid, cell_at), cells_in((*xy)[1], parameter, grid, cell_at)};
}

template <class T, class ReadItem>
std::vector<T> list_in(const toml::node& node, const std::string& parameter, ReadItem&& read_item) {
    if (!node.is_array()) refuse(parameter, node, "a list in [ ]");
    std::vector<T> values;
    for (const toml::node& item : *node.as_array()) values.push_back(read_item(item, parameter));
    return values;
}

// Reads the keys of one table. A key that the table lacks leaves the value as it is. finish(), called after all known
// keys have been read, refuses a key that nobody has read.
class Section {
  public:
    // table: null where the file has no such table. prefix: dotted name of the table, as in "load.".
    Section(const toml::table* table, std::string prefix) : table_(table), prefix_(std::move(prefix)) {}

    // Returns the dotted name of a key, as in "load.radius".
    std::string parameter(const char* key) const { return prefix_ + key; }
    bool given() const { return table_; } // whether the file has this table
    bool has(const char* key) const { return table_ && table_->contains(key); }
    bool has_text(const char* key) const { return has(key) && table_->get(key)->is_string(); }
    // Whether it is a text, or a list with one.
    bool has_texts(const char* key) const {
        const toml::array* list = has(key) ? table_->get(key)->as_array() : nullptr;
        return has_text(key) || (list && std::ranges::any_of(*list, [](auto& item) { return item.is_string(); }));
    }
    // Refuses the key, where the table has it, unless it is permitted.
    void permit(const char* key, bool permitted, const char* allowed) const {
        if (has(key) && !permitted) refuse(parameter(key), *table_->get(key), allowed);
    }

    // Reads the key, where the table has it, as read(node, parameter(key)).
    template <class Value, class Read> void value(const char* key, Value& value, Read&& read) {
        if (const toml::node* node = find(key)) value = read(*node, parameter(key));
    }
    // In the unit that the list of keys has.
    template <class Number> void number(const char* key, Number& to) {
        value(key, to, [](auto& node, const auto& name) { return number_in(node, name, unit_of_key(name)); });
    }
    std::optional<std::string> text(const char* key) {
        const toml::node* node = find(key);
        if (!node) return {};
        if (!node->is_string()) refuse(parameter(key), *node, "a text in quotes");
        return **node->as_string();
    }
    // Replaces the values by read_item(item, parameter(key)) for every item of a list.
    template <class T, class ReadItem> void list(const char* key, std::vector<T>& values, ReadItem&& read_item) {
        value(key, values, [&](auto& node, const auto& name) { return list_in<T>(node, name, read_item); });
    }
    // The tables of a list, as key[0], or the one that stands in its place.
    std::vector<Section> sections(const char* key) {
        const toml::array* list = has(key) ? table_->get(key)->as_array() : nullptr;
        if (!list) return {section(key)};
        find(key);
        tables_.push_back(key);
        if (list->empty()) refuse(parameter(key), *list, "at least one table");
        std::vector<Section> all;
        for (const toml::node& item : *list) {
            const std::string name = parameter(key) + "[" + std::to_string(all.size()) + "]";
            if (!item.is_table()) refuse(name, item, "a table");
            all.push_back(Section(item.as_table(), name + "."));
        }
        return all;
    }
    bool has_list(const char* key) const { return has(key) && table_->get(key)->is_array(); }
    // or_list: whether a list may stand in place of the table, which is then not given.
    Section section(const char* key, bool or_list = false) {
        const toml::node* node = find(key);
        tables_.push_back(key);
        if (node && !node->is_table() && !(or_list && node->is_array())) refuse(parameter(key), *node, "a table");
        return Section(node ? node->as_table() : nullptr, parameter(key) + ".");
    }

    void finish() const {
        if (!table_) return;
        for (auto&& [key, node] : *table_)
            if (!read_.count(std::string(key.str()))) refuse_unknown(std::string(key.str()), node);
    }

  private:
    [[noreturn]] void refuse_unknown(const std::string& key, const toml::node& node) const {
        const std::string name = prefix_ + key;
        if (node.is_table() && !tables_.empty()) {
            const std::string meant = nearest(key, tables_);
            throw Error(Error::Code::bad_input, name,
                        "[" + name + "]: no such table; " +
                            (meant.empty() ? "known: [" + listed(tables_, "], [") + "]"
                                           : "the nearest is [" + prefix_ + meant + "]"));
        }
        const std::vector<std::string> keys(read_.begin(), read_.end());
        std::vector<std::string> tables; // the tables that have such a key
        for (const std::string& known : known_keys())
            if (known == key) tables.push_back("the top of the file");
            else if (known.ends_with("." + key)) tables.push_back("[" + known.substr(0, known.rfind('.')) + "]");
        throw Error(Error::Code::bad_input, name,
                    name + " = " + text_of(node) + "; no such key here; known: " + listed(keys, ", ") +
                        (tables.empty() ? suggestion(key, keys) : "; " + key + " belongs to " + listed(tables, ", ")));
    }

    const toml::node* find(const char* key) {
        read_.insert(key);
        return table_ ? table_->get(key) : nullptr;
    }

    const toml::table* table_;
    std::string prefix_;
    std::set<std::string> read_;
    std::vector<std::string> tables_; // the keys in read_ that are tables
};

} // namespace dermis::scene
