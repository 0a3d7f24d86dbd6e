// SPDX-License-Identifier: MIT
#include "host/lab/scenes/key_rows.hpp"

#include "host/lab/scenes/keys.hpp"
#include "host/lab/scenes/units.hpp"

namespace dermis::scene {
namespace {

// Returns a default as a scene file has it; empty for what is not given.
template <class T> std::string shown(const T& value) {
    if constexpr (std::is_same_v<T, bool>) return value ? "true" : "false";
    else if constexpr (std::is_arithmetic_v<T>) return shortest(double(value));
    else if constexpr (std::is_enum_v<T>) return "\"" + std::string(text_of(value)) + "\"";
    else if constexpr (requires { shown(*value.begin()); }) {
        std::string all;
        for (const auto& item : value) all += (all.empty() ? "" : ", ") + shown(item);
        return "[" + all + "]";
    } else return "";
}

template <class T> std::string python_type(const std::string& unit, bool optional, Holds holds) {
    if constexpr (std::is_same_v<T, bool>) return "bool";
    else if constexpr (std::is_same_v<T, int>) return unit == "cells" && optional ? "CellOrPlace" : "int";
    else if constexpr (std::is_same_v<T, double>) return can_be_in(unit) ? "NumberWithUnit" : "float";
    else if constexpr (std::is_enum_v<T>) return "Literal[" + quoted_names<T>(holds) + "]";
    else if constexpr (std::is_same_v<T, Depths>) return "Literal[\"fingertip\"] | Mapping[str, Any]";
    else if constexpr (std::is_same_v<T, DepthKernels>)
        return "Literal[" + quoted_names<DepthKernel>() + "] | Mapping[str, Any]";
    else if constexpr (std::is_same_v<T, Cell>) return "Sequence[CellOrPlace]";
    else if constexpr (std::is_same_v<T, std::vector<Cell>>) return "Cells";
    else if constexpr (requires(T t) { double(*t.begin()); }) return "Numbers";
    else if constexpr (requires(T t) { t.begin(); }) {
        using Item = typename T::value_type;
        return "Sequence[" + python_type<Item>("", false, holds) + "]";
    } else return "Mapping[str, Any]";
}

template <class T> std::string allowed(Holds holds) {
    if constexpr (std::is_enum_v<T>) return quoted_names<T>(holds);
    else if constexpr (std::is_same_v<T, bool>) return "true, false";
    else if constexpr (requires { requires std::is_enum_v<typename T::value_type>; })
        return "a list of " + quoted_names<typename T::value_type>(holds);
    else return "";
}

template <class T, class Member> KeyRow row_of(const char* table, const Key<Member>& key) {
    KeyRow row{.table = table,
               .name = key.name,
               .unit = key.unit,
               .by_default = key.by_default,
               .allowed = key.range.words,
               .says = key.says,
               .type = {}};
    if constexpr (std::is_same_v<Member, Special>) row.type = key.member.type;
    else {
        using Owner = std::conditional_t<std::is_base_of_v<typename ClassOf<Member>::type, T>, T, Scene>;
        const auto value = Owner().*key.member;
        using Value = typename Held<std::remove_cvref_t<decltype(value)>>::type;
        if (row.by_default.empty()) row.by_default = shown(value);
        if (row.allowed.empty()) row.allowed = allowed<Value>(key.range.holds);
        row.type = python_type<Value>(row.unit, Held<std::remove_cvref_t<decltype(value)>>::optional, key.range.holds);
    }
    if (*key.only.words) row.allowed += (row.allowed.empty() ? "" : "; ") + std::string(key.only.words);
    return row;
}

} // namespace

const std::vector<KeyRow>& key_rows() {
    static const auto& all = *new const std::vector<KeyRow>([] { // never destroyed
        std::vector<KeyRow> list;
        std::apply(
            [&]<class... T>(const Table<T>&... table) {
                (each_row<T>([&](const auto& key) { list.push_back(row_of<T>(table.name, key)); }), ...);
            },
            tables);
        return list;
    }());
    return all;
}

} // namespace dermis::scene
