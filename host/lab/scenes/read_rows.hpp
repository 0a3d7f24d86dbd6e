// SPDX-License-Identifier: MIT
// Reads the keys of a table by the rows of its struct.
#pragma once

#include "host/lab/scenes/keys.hpp"
#include "host/lab/scenes/toml_section.hpp"

namespace dermis::scene {

template <class Rows, class T> void read_rows(Section& table, T& to, const Grid* grid);

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

// Reads what stands behind a key, or in a list behind it. grid: as for read_rows(). Of whole numbers and names `range`
// says which are taken; other numbers are checked later.
template <class T>
T value_in(const toml::node& node, const std::string& name, const char* unit, const Grid* grid, const Range& range) {
    if constexpr (std::is_same_v<T, bool>) {
        if (!node.is_boolean()) refuse(name, node, "true or false");
        return **node.as_boolean();
    } else if constexpr (std::is_enum_v<T>) {
        const std::string text = node.value_or(std::string());
        if (const std::optional<T> value = value_of<T>(text)) return *value;
        refuse(name, node, quoted_names<T>(range.holds) + suggestion(text, names<T>(range.holds)));
    } else if constexpr (std::is_same_v<T, Cell>) return cell_in(node, name, *grid);
    else if constexpr (std::is_same_v<T, int>) {
        const int whole = grid && unit == std::string_view("cells")
                              ? cells_in(node, name, *grid, nearest_cells, range.words)
                              : whole_number_in(node, name, range.words);
        if (!range.holds(whole)) refuse(name, node, range.words);
        return whole;
    } else if constexpr (std::is_same_v<T, double>) return number_in(node, name, unit);
    else if constexpr (requires { typename T::value_type; }) {
        using Item = typename T::value_type;
        constexpr bool any = std::is_same_v<T, std::vector<Item>>; // otherwise two
        const toml::array* list = node.as_array();
        if (!any && (!list || list->size() != 2)) refuse(name, node, "two numbers, as [0.5, 1]");
        std::vector<Item> items = list_in<Item>(node, name, [=](const toml::node& item, const std::string& of) {
            return value_in<Item>(item, of, unit, grid, range);
        });
        if constexpr (any) return items;
        else return {items[0], items[1]};
    } else return item_in<T>(node, name);
}

template <class Value>
void read_value(Section& table, const char* key, const char* unit, Value& value, const Grid* grid,
                const Range& range = no_range) {
    using T = typename Held<Value>::type;
    if constexpr (!std::is_class_v<T> || std::is_same_v<T, Cell> || requires { typename T::value_type; })
        table.value(key, value,
                    [&](auto& node, const auto& name) { return value_in<T>(node, name, unit, grid, range); });
    else {
        if constexpr (std::is_same_v<T, Depths>)
            if (table.has_text(key)) {
                table.permit(key, table.text(key) == "fingertip", "\"fingertip\", or a table of depths");
                return void(value = fingertip_depths());
            }
        if constexpr (std::is_same_v<T, DepthKernels>)
            if (table.has_text(key)) {
                DepthKernel all{};
                read_value(table, key, unit, all, grid);
                return void(value = all);
            }
        Section inner = table.section(key);
        T own{};
        if constexpr (!Held<Value>::optional) own = value;
        read_rows<T>(inner, own, grid);
        inner.finish();
        if (inner.given()) value = own;
    }
}

// Reads the keys that have a member, and refuses those that are not allowed beside the others. grid: lengths have a
// unit where it has a spacing, and cells may be lengths; null: they have a unit. A key that a row calls required must
// be there, if the file has the table.
template <class Rows, class T> void read_rows(Section& table, T& to, const Grid* grid) {
    each_row<Rows>([&]<class Member>(const Key<Member>& key) {
        if constexpr (!std::is_same_v<Member, Special>) {
            auto& value = to.*key.member;
            const bool length = key.unit == std::string_view("m");
            table.permit(key.name, !length || !grid || grid->spacing || !table.has_texts(key.name),
                         "a number of cells: the grid has no spacing");
            read_value(table, key.name, key.unit, value, grid, key.range);
            if (table.given() && key.by_default == std::string_view("required") && !table.has(key.name))
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
