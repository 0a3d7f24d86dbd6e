// SPDX-License-Identifier: MIT
// The list of keys of a skin: a row for each key of a scene file's tables that describe a skin and its afferents.
// Readers, ranges, units, "did you mean" and help follow from it; lab/scenes/keys.hpp has the other tables. A key of a
// file alone, as a path, has its type in Python in place of a member, and is read in lab/scenes/scene_tables.cpp. First
// comes what a row is, and the checks that follow from it.
#pragma once

#include "dermis/afferents.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/description/names.hpp"

#include <cmath>
#include <tuple>

namespace dermis::scene {

// The numbers that a key takes. words: the text of an error; empty for an enum, because its error lists the names.
struct Range {
    const char* words;
    Holds holds;
};
inline constexpr Range no_range{"", always};

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

inline constexpr Range number{"a finite number", [](double) { return true; }},
    positive{"a finite number > 0", [](double x) { return x > 0; }},
    not_negative{"a finite number >= 0", [](double x) { return x >= 0; }},
    sides{"whole cells, 1..16384", [](double x) { return x >= 1 && x <= 16384; }},
    radii{"whole cells, 1..65536", [](double x) { return x >= 1 && x <= 65536; }},
    share{"> 0, at most 1", [](double x) { return x > 0 && x <= 1; }},
    half{"0..0.5", [](double x) { return x >= 0 && x <= 0.5; }},
    radians{"-1e9..1e9", [](double x) { return std::abs(x) <= 1e9; }},
    counts{"a whole number, 1..16384", [](double x) { return x >= 1 && x <= 16384; }},
    below_1{"a finite number < 1", [](double x) { return x < 1; }},
    fibre_endings{"a whole number, 1..64", [](double x) { return x >= 1 && x <= 64; }},
    sensitivities{"a number > 0, at most 1e6; in tables of a scene also \"median\" or \"threshold\"",
                  [](double x) { return x > 0 && x <= 1e6; }},
    seeds{"a whole number, -1e9..1e9", [](double x) { return std::abs(x) <= 1e9; }},
    spreads{"0 to 5", [](double x) { return x >= 0 && x <= 5; }},
    of_classes{"", [](double q) { return q >= double(Quantity::sa1) && q <= double(Quantity::fa2); }};

template <>
inline constexpr auto rows<Grid> =
    std::tuple{Key{"width", &Grid::width, "cells", sides, "", "cells in each row of every map"},
               Key{"height", &Grid::height, "cells", sides, "", "rows of every map"},
               Key{"spacing", &Grid::spacing, "m", positive, "none: the scene is dimensionless", "from cell to cell"}};

inline constexpr Only<Surface> of_ridges{"only with surface.kind \"wave\" or \"spiral\"", [](const Surface& s) {
                                             return s.kind == Surface::Kind::wave || s.kind == Surface::Kind::spiral;
                                         }};
template <>
inline constexpr auto rows<Surface> = std::tuple{
    Key{"kind", &Surface::kind, "", no_range, "", "the heights of the skin"},
    Key{"path", Special{"MapOrFile"}, "", no_range, "required with \"file\"", "a map of heights, in units of relief"},
    Key{"high", Special{"Literal[\"black\", \"white\"]"}, "", no_range, "required with a PNG",
        "the grey of the picture that is high"},
    Key{"spacing", Special{"NumberWithUnit"}, "m", positive, "the grid's", "from number to number of the file"},
    Key{"ridges", &Surface::ridges, "", number, "wave 15, spiral 25", "how many ridges", of_ridges},
    Key{"ridge_period", &Surface::ridge_period, "m", positive, "none", "from crest to crest, in place of ridges"},
    Key{"noise", &Surface::noise, "", not_negative, "wave 2, spiral 0.5", "of the ridges' amplitude", of_ridges},
    Key{"noise_length", &Surface::noise_length, "cells", positive, "wave 50, spiral 40", "size of noise", of_ridges},
    Key{"relief", &Surface::relief, "m", positive, "1 without grid.spacing", "factor of the heights"}};

template <>
inline constexpr auto rows<KelvinVoigt> = std::tuple{
    Key{"modulus", Special{"NumberOrMap"}, "Pa", not_negative, "0", "of the spring, or a map of it"},
    Key{"viscosity", Special{"NumberOrMap"}, "Pa s", not_negative, "0", "of the dashpot beside it, or a map of it"}};
template <>
inline constexpr auto rows<Material> = std::tuple{
    Key{"modulus", Special{"NumberOrMap"}, "Pa", not_negative, "1.54 without grid.spacing",
        "of a spring, or a map of it"},
    Key{"viscosity", Special{"NumberOrMap"}, "Pa s", not_negative, "1 without grid.spacing",
        "of the dashpot beside it, or a map of it"},
    Key{"elements", Special{"Sequence[KelvinVoigt | Mapping[str, Any]]"}, "", no_range, "none",
        "1 to 8 of modulus and viscosity in series"},
    Key{"relaxation", Special{"Relaxation | Mapping[str, Any]"}, "", no_range, "none",
        "moduli, times and equilibrium, in place of elements"},
    Key{"spring", &Material::spring, "Pa", positive, "none", "in series with the elements"},
    Key{"dashpot", &Material::dashpot, "Pa s", positive, "none", "in series with the elements"},
    Key{"thickness", &Material::thickness, "m", not_negative, "1 without grid.spacing",
        "times the strain: indentation"},
    Key{"curvature_length", &Material::curvature_length, "m", number, "1 without grid.spacing", "gain of curvature"}};

template <>
inline constexpr auto rows<Depths> =
    std::tuple{Key{"sa1", &Depths::sa1, "m", not_negative, "none", "below the surface"},
               Key{"sa2", &Depths::sa2, "m", not_negative, "none", "below the surface"},
               Key{"fa1", &Depths::fa1, "m", not_negative, "none", "below the surface"},
               Key{"fa2", &Depths::fa2, "m", not_negative, "none", "below the surface"}};
template <>
inline constexpr auto rows<DepthKernels> = std::tuple{Key{"sa1", &DepthKernels::sa1, "", no_range, "", "acts on SA1"},
                                                      Key{"sa2", &DepthKernels::sa2, "", no_range, "", "acts on SA2"},
                                                      Key{"fa1", &DepthKernels::fa1, "", no_range, "", "acts on FA1"},
                                                      Key{"fa2", &DepthKernels::fa2, "", no_range, "", "acts on FA2"}};
template <>
inline constexpr auto rows<Follow> = std::tuple{Key{"sa1", &Follow::sa1, "", no_range, "", "the input of SA1"},
                                                Key{"sa2", &Follow::sa2, "", no_range, "", "the input of SA2"}};
template <>
inline constexpr auto rows<Receptors> = std::tuple{
    Key{"fa2", &Receptors::fa2, "", no_range, "\"point\", or \"step-mean\" where a point has no value",
        "FA2 at an output's time, or its mean over the step"},
    Key{"fa2_gains", &Receptors::fa2_gains, "", number, "", "of positive and of negative values"},
    Key{"depth", &Receptors::depth, "", no_range, "none", "of each class below the surface, or \"fingertip\""},
    Key{"follow", &Receptors::follow, "", no_range, "", "the input of a class: strain or stress"},
    Key{"kernel", &Receptors::kernel, "", no_range, "\"stress\"", "what acts at the depth of a class, or of all"},
    Key{"poisson", &Receptors::poisson, "", half, "0.4", "Poisson's ratio of the half-space"},
    Key{"sa2_adaptation", &Receptors::sa2_adaptation, "s", positive, "none: SA2 is a plain integral", "of SA2"}};

template <>
inline constexpr auto rows<Density> = std::tuple{Key{"sa1", &Density::sa1, "per cm2", not_negative, "", "sites"},
                                                 Key{"sa2", &Density::sa2, "per cm2", not_negative, "", "sites"},
                                                 Key{"fa1", &Density::fa1, "per cm2", not_negative, "", "sites"},
                                                 Key{"fa2", &Density::fa2, "per cm2", not_negative, "", "sites"}};

template <>
inline constexpr auto rows<AfterCurrent> =
    std::tuple{Key{"amplitude", &AfterCurrent::amplitude, "", number, "", "of the current that a spike starts"},
               Key{"time", &AfterCurrent::time, "s", positive, "", "in which it decays"}};
template <>
inline constexpr auto rows<AfferentModel> = std::tuple{
    Key{"time_constants", &AfferentModel::time_constants, "s", positive, "the class's", "of the low-pass's poles"},
    Key{"frequency", &AfferentModel::frequency, "Hz", positive, "the class's", "of a pair of poles"},
    Key{"quality", &AfferentModel::quality, "", positive, "the class's", "of the pair"},
    Key{"value", &AfferentModel::value, "", number, "the class's", "factor of the input"},
    Key{"rate", &AfferentModel::rate, "s", number, "the class's", "factor of its rate"},
    Key{"gains", Special{"Sequence[Numbers]"}, "", no_range, "the class's",
        "of y, y' and y'', in pairs for positive and negative values"},
    Key{"membrane_time", &AfferentModel::membrane_time, "s", positive, "the class's", "of the membrane"},
    Key{"refractory_time", &AfferentModel::refractory_time, "s", positive, "the class's", "after a spike"},
    Key{"reset", &AfferentModel::reset, "", below_1, "", "of the membrane after a spike"},
    Key{"sensitivity", Special{"float | Literal[\"median\", \"threshold\"]"}, "", sensitivities,
        "\"threshold\"; with gains 1", "factor of the rate"},
    Key{"spread", &AfferentModel::spread, "", spreads, "the class's; with gains 0",
        "of the logarithm of the factor s of each afferent"},
    Key{"after", Special{"Sequence[Mapping[str, Any]]"}, "", no_range, "none",
        "up to two currents that a spike starts"}};
template <>
inline constexpr auto rows<Afferents> = std::tuple{
    Key{"type", &Afferents::type, "", of_classes, "", "of the afferents"},
    Key{"cells", &Afferents::cells, "cells", no_range, "the sites of the class", "of their endings"},
    Key{"follow", &Afferents::follow, "", no_range, "", "the input: strain or stress"},
    Key{"endings", &Afferents::endings, "", fibre_endings, "", "of each afferent"},
    Key{"radius", &Afferents::radius, "m", positive, "none", "around a site, in which its endings are drawn"},
    Key{"seed", &Afferents::seed, "", seeds, "sites.seed, or 1", "of endings and factors s"}};

} // namespace dermis::scene
