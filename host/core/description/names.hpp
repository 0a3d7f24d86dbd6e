// SPDX-License-Identifier: MIT
// Names the values of the public enums as scene files, results and error messages do. Each enum has one table.
#pragma once

#include "dermis/description.hpp"

#include <algorithm>
#include <string_view>

namespace dermis::scene {

template <class Enum> struct Name {
    Enum value;
    const char* text;
};

template <class Enum> struct Names; // An enum without a table of names does not compile.

template <> struct Names<Quantity> {
    static constexpr Name<Quantity> table[] = {{Quantity::strain, "strain"},
                                               {Quantity::sa1, "sa1"},
                                               {Quantity::sa2, "sa2"},
                                               {Quantity::fa1, "fa1"},
                                               {Quantity::fa2, "fa2"},
                                               {Quantity::curvature, "curvature"},
                                               {Quantity::deformation, "deformation"},
                                               {Quantity::indentation, "indentation"},
                                               {Quantity::shear_x, "shear_x"},
                                               {Quantity::shear_y, "shear_y"},
                                               {Quantity::stretch_x, "stretch_x"},
                                               {Quantity::stretch_y, "stretch_y"},
                                               {Quantity::stretch_xy, "stretch_xy"}};
};
template <> struct Names<Precision> {
    static constexpr Name<Precision> table[] = {
        {Precision::f32, "f32"}, {Precision::f32_compensated, "f32-compensated"}, {Precision::f64, "f64"}};
};
template <> struct Names<Stencil> {
    static constexpr Name<Stencil> table[] = {{Stencil::five_point, "five-point"},
                                              {Stencil::fourth_order, "fourth-order"},
                                              {Stencil::published, "published"}};
};
template <> struct Names<Edges> {
    static constexpr Name<Edges> table[] = {
        {Edges::mirror, "mirror"}, {Edges::periodic, "periodic"}, {Edges::published, "published"}};
};
template <> struct Names<Fa2> {
    static constexpr Name<Fa2> table[] = {{Fa2::point, "point"}, {Fa2::step_mean, "step-mean"}};
};
template <> struct Names<Signal> {
    static constexpr Name<Signal> table[] = {
        {Signal::strain, "strain"},
        {Signal::stress, "stress"},
    };
};
template <> struct Names<Receptors::Kernel> {
    static constexpr Name<Receptors::Kernel> table[] = {
        {Receptors::Kernel::stress, "stress"},
        {Receptors::Kernel::strain, "strain"},
    };
};
template <> struct Names<Surface::Kind> {
    static constexpr Name<Surface::Kind> table[] = {{Surface::Kind::flat, "flat"},
                                                    {Surface::Kind::wave, "wave"},
                                                    {Surface::Kind::spiral, "spiral"},
                                                    {Surface::Kind::map, "file"}};
};

template <class Enum> constexpr const char* text_of(Enum value) noexcept {
    for (const Name<Enum>& name : Names<Enum>::table)
        if (name.value == value) return name.text;
    return "(no such value)";
}

// Returns nothing where no value has this name.
template <class Enum> constexpr std::optional<Enum> value_of(std::string_view text) noexcept {
    for (const Name<Enum>& name : Names<Enum>::table)
        if (name.text == text) return name.value;
    return {};
}

// Returns all names in alphabetical order.
template <class Enum> std::vector<std::string> names() {
    std::vector<std::string> texts;
    for (const Name<Enum>& name : Names<Enum>::table) texts.push_back(name.text);
    std::sort(texts.begin(), texts.end());
    return texts;
}

// Lists all names in quotes, for the allowed values in an error message.
template <class Enum> std::string quoted_names() {
    std::string list;
    for (const std::string& text : names<Enum>()) list += (list.empty() ? "\"" : ", \"") + text + "\"";
    return list;
}

} // namespace dermis::scene
