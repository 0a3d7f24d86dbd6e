// SPDX-License-Identifier: MIT
// A row of the list of keys (skin_keys.hpp, and lab/scenes/keys.hpp), and the checks that follow from it.
#pragma once

#include "host/core/base/refusal.hpp"
#include "host/core/description/names.hpp"

#include <tuple>

namespace dermis::scene {

// The numbers that a key takes, in the words of an error.
struct Range {
    const char* words;
    bool (*holds)(double);
};
inline constexpr Range no_range{"", [](double) { return true; }};

// In place of a member where a key's table is read by code: what Python calls its type.
struct Special {
    const char* type;
};
template <class Member> struct ClassOf { using type = Special; };
template <class T, class Value> struct ClassOf<Value T::*> { using type = T; };

// Says whether a struct may have a key. words: of the error if it may not.
template <class T> struct Only {
    const char* words = "";
    bool (*holds)(const T&) = nullptr; // null: everywhere
};

template <class Member> struct Key {
    const char* name;
    Member member; // a pointer to a member of the table's struct, or Special
    const char* unit;
    Range range;
    const char* by_default; // where the member of a new struct does not tell it
    const char* says;
    Only<typename ClassOf<Member>::type> only{};
};
template <class Member, class... Rest> Key(const char*, Member, Rest...) -> Key<Member>;

// The type in an optional, or the type itself.
template <class T> struct Held {
    using type = T;
    static constexpr bool optional = false;
};
template <class T> struct Held<std::optional<T>> {
    using type = T;
    static constexpr bool optional = true;
};

template <class T> inline constexpr std::tuple<> rows{}; // the keys of a struct's table

template <class T, class F> constexpr void each_row(F&& f) {
    std::apply([&](const auto&... key) { (f(key), ...); }, rows<T>);
}

// Checks the numbers that a struct's rows name: their ranges, and that an optional is empty where its key is not
// allowed; other numbers do not count there. table: "load." and the like. Throws Error::bad_input.
template <class T> void check_rows(const std::string& table, const T& of) {
    each_row<T>([&]<class Member>(const Key<Member>& key) {
        if constexpr (!std::is_same_v<Member, Special>) {
            const auto& value = of.*key.member;
            const auto check = [&](auto x, bool given) {
                const bool is_allowed = !key.only.holds || key.only.holds(of);
                if (is_allowed ? !*key.range.words || (finite(double(x)) && key.range.holds(double(x))) : !given)
                    return;
                refuse(table + key.name,
                       std::is_same_v<decltype(x), int> ? std::to_string(int(x)) : shortest(double(x)),
                       is_allowed ? key.range.words : key.only.words);
            };
            using Value = std::remove_cvref_t<decltype(value)>;
            if constexpr (std::is_same_v<Value, double> || std::is_same_v<Value, int>) check(value, false);
            else if constexpr (std::is_same_v<Value, std::optional<double>> ||
                               std::is_same_v<Value, std::optional<int>>) {
                if (value) check(*value, true);
            } else if constexpr (requires { double(*value.begin()); })
                for (const double x : value) check(x, false);
        }
    });
}

} // namespace dermis::scene
