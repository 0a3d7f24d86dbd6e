// SPDX-License-Identifier: MIT
// Reads the keys of a table by the rows of its struct.
#pragma once

#include "host/lab/scenes/keys.hpp"
#include "host/lab/scenes/toml_section.hpp"

namespace dermis::scene {

template <class Rows, class T> void read_rows(Section& table, T& to, const Grid* grid, bool given = true);

// Reads a table that stands in a list.
template <class T> T item_in(const toml::node& node, const std::string& parameter) {
    if (!node.is_table()) {
        std::string keys;
        each_row<T>([&](const auto& key) { keys += (keys.empty() ? "" : ", ") + std::string(key.name) + " = .."; });
        refuse(parameter, node, "tables { " + keys + " }");
    }
    Section table(node.as_table(), parameter + ".");
    T item;
    read_rows<T>(table, item, nullptr);
    table.finish();
    return item;
}

template <class Value>
void read_value(Section& table, const char* key, const char* unit, Value& value, const Grid* grid) {
    using T = typename Held<Value>::type;
    const auto number = [unit](const toml::node& node, const std::string& name) { return number_in(node, name, unit); };
    if constexpr (std::is_same_v<T, bool>) table.boolean(key, value);
    else if constexpr (std::is_enum_v<T>) table.choice(key, value);
    else if constexpr (std::is_same_v<Value, std::optional<Cell>>) table.cell(key, *grid, value);
    else if constexpr (std::is_same_v<Value, std::vector<Cell>>) table.cells(key, *grid, value);
    else if constexpr (std::is_same_v<T, int>) table.whole_number(key, value);
    else if constexpr (std::is_arithmetic_v<T>) table.number(key, value, unit);
    else if constexpr (std::is_same_v<T, std::vector<double>>) table.list(key, value, number);
    else if constexpr (std::is_same_v<T, std::array<double, 2>>) {
        std::vector<double> pair(value.begin(), value.end());
        table.list(key, pair, number);
        if (pair.size() != 2) refuse(table.parameter(key), std::to_string(pair.size()) + " numbers", "two, [ , ]");
        value = {pair[0], pair[1]};
    } else if constexpr (std::is_same_v<T, std::vector<Quantity>>) table.list(key, value, choice_in<Quantity>);
    else if constexpr (requires { value.push_back({}); }) table.list(key, value, item_in<typename T::value_type>);
    else {
        const bool given = table.has(key);
        Section inner = table.section(key);
        T own{};
        if constexpr (!Held<Value>::optional) own = value;
        read_rows<T>(inner, own, grid, given);
        inner.finish();
        if (given) value = own;
    }
}

// Reads the keys that have a member, and refuses those that are not allowed beside the others. grid: lengths have a
// unit where it has a spacing, and cells may be lengths; null: they have a unit. given: whether the file has the table,
// so that a key which a row calls required must be there.
template <class Rows, class T> void read_rows(Section& table, T& to, const Grid* grid, bool given) {
    each_row<Rows>([&]<class Member>(const Key<Member>& key) {
        if constexpr (!std::is_same_v<Member, Special>) {
            auto& value = to.*key.member;
            const bool length = key.unit == std::string_view("m");
            table.permit(key.name, !length || !grid || grid->spacing || !table.has_texts(key.name),
                         "a number of cells: the grid has no spacing");
            if constexpr (std::is_same_v<decltype(value), std::optional<int>&>)
                if (key.unit == std::string_view("cells")) return table.cells(key.name, *grid, value);
            read_value(table, key.name, key.unit, value, grid);
            if (given && key.by_default == std::string_view("required") && !table.has(key.name))
                refuse(table.parameter(key.name), "(not given)",
                       *key.range.words ? key.range.words : std::string("a value: ") + key.says);
        }
    });
    each_row<Rows>([&](const auto& key) {
        if constexpr (requires { key.only.holds(to); })
            if (key.only.holds) table.permit(key.name, key.only.holds(to), key.only.words);
    });
}

} // namespace dermis::scene
