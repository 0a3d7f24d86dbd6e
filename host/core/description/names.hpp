// SPDX-License-Identifier: MIT
// Names the values of the public enums as scene files, results and error messages do. Each enum has one table.
#pragma once

#include "dermis/description.hpp"

#include <algorithm>
#include <string_view>

namespace dermis::scene {

// Stencil and edges of the published study, for scenes alone: dermis/scene.hpp.
inline constexpr Stencil study_stencil{2};
inline constexpr Edges study_edges{2};

template <class Enum> struct Name {
    Enum value;
    const char* text;
};

template <class Enum> struct Names; // An enum without a table of names does not compile.

// Gives an enum its table: each value, without the enum's name, and its text.
#define DERMIS_NAMES(Enum, ...)                                                                                        \
    template <> struct Names<Enum> {                                                                                   \
        using enum Enum;                                                                                               \
        static constexpr Name<Enum> all[] = {__VA_ARGS__};                                                             \
    };

DERMIS_NAMES(Quantity, {strain, "strain"}, {sa1, "sa1"}, {sa2, "sa2"}, {fa1, "fa1"}, {fa2, "fa2"},
             {curvature, "curvature"}, {deformation, "deformation"}, {indentation, "indentation"}, {shear_x, "shear_x"},
             {shear_y, "shear_y"}, {stretch_x, "stretch_x"}, {stretch_y, "stretch_y"}, {stretch_xy, "stretch_xy"})
DERMIS_NAMES(Precision, {f32, "f32"}, {f32_compensated, "f32-compensated"}, {f64, "f64"})
DERMIS_NAMES(Stencil, {five_point, "five-point"}, {fourth_order, "fourth-order"}, {study_stencil, "published"})
DERMIS_NAMES(Edges, {mirror, "mirror"}, {periodic, "periodic"}, {study_edges, "published"})
DERMIS_NAMES(Fa2, {point, "point"}, {step_mean, "step-mean"})
DERMIS_NAMES(Signal, {strain, "strain"}, {stress, "stress"})
DERMIS_NAMES(DepthKernel, {stress, "stress"}, {strain, "strain"}, {displacement, "displacement"})
DERMIS_NAMES(Surface::Kind, {flat, "flat"}, {wave, "wave"}, {spiral, "spiral"}, {map, "file"})

template <class Enum> constexpr const char* text_of(Enum value) noexcept {
    for (const Name<Enum>& name : Names<Enum>::all)
        if (name.value == value) return name.text;
    return "(no such value)";
}

// Returns nothing where no value has this name.
template <class Enum> constexpr std::optional<Enum> value_of(std::string_view text) noexcept {
    for (const Name<Enum>& name : Names<Enum>::all)
        if (name.text == text) return name.value;
    return {};
}

using Holds = bool (*)(double); // whether a key takes a number, or a value of an enum
inline constexpr Holds always = [](double) { return true; };

// Returns the names of the values that hold in alphabetical order.
template <class Enum> std::vector<std::string> names(Holds holds = always) {
    std::vector<std::string> texts;
    for (const Name<Enum>& name : Names<Enum>::all)
        if (holds(double(name.value))) texts.push_back(name.text);
    std::sort(texts.begin(), texts.end());
    return texts;
}

// Lists these names in quotes, for the allowed values in an error message.
template <class Enum> std::string quoted_names(Holds holds = always) {
    std::string list;
    for (const std::string& text : names<Enum>(holds)) list += (list.empty() ? "\"" : ", \"") + text + "\"";
    return list;
}

} // namespace dermis::scene
