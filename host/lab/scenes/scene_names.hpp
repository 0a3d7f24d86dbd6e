// SPDX-License-Identifier: MIT
// Names of the enums that a scene has besides a skin's enums.
#pragma once

#include "dermis/scene.hpp"
#include "host/core/description/names.hpp"

namespace dermis::scene {

template <> struct Names<Method> {
    static constexpr Name<Method> table[] = {{Method::exact, "exact"},
                                             {Method::euler, "euler"},
                                             {Method::rk2, "rk2"},
                                             {Method::rk4, "rk4"},
                                             {Method::backward_euler, "backward-euler"},
                                             {Method::crank_nicolson, "crank-nicolson"},
                                             {Method::sdirk2, "sdirk2"},
                                             {Method::published, "published"}};
};
template <> struct Names<Model> {
    static constexpr Name<Model> table[] = {
        {Model::moments, "moments"}, {Model::maps, "maps"}, {Model::sites, "sites"}, {Model::march, "march"}};
};
template <> struct Names<Load::Control> {
    static constexpr Name<Load::Control> table[] = {
        {Load::Control::pressure, "pressure"},
        {Load::Control::depth, "depth"},
    };
};
template <> struct Names<Load::Contact> {
    static constexpr Name<Load::Contact> table[] = {
        {Load::Contact::even, "even"},
        {Load::Contact::crests, "crests"},
    };
};
template <> struct Names<Load::Kind> {
    static constexpr Name<Load::Kind> table[] = {{Load::Kind::circular, "circular"}, {Load::Kind::point, "point"},
                                                 {Load::Kind::linear, "linear"},     {Load::Kind::map, "file"},
                                                 {Load::Kind::sequence, "sequence"}, {Load::Kind::punch, "punch"},
                                                 {Load::Kind::ball, "ball"}};
};
template <> struct Names<Taxels::Spread> {
    static constexpr Name<Taxels::Spread> table[] = {
        {Taxels::Spread::nearest, "nearest"}, {Taxels::Spread::linear, "linear"}, {Taxels::Spread::cubic, "cubic"}};
};
enum class High { white, black }; // what is high in a picture
template <> struct Names<High> {
    static constexpr Name<High> table[] = {{High::white, "white"}, {High::black, "black"}};
};
template <> struct Names<Hold> {
    static constexpr Name<Hold> table[] = {{Hold::linear, "linear"}, {Hold::parabolic, "parabolic"}};
};
template <> struct Names<Envelope::Kind> {
    static constexpr Name<Envelope::Kind> table[] = {{Envelope::Kind::step, "step"},
                                                     {Envelope::Kind::ramp, "ramp"},
                                                     {Envelope::Kind::sine, "sine"},
                                                     {Envelope::Kind::pulse, "pulse"},
                                                     {Envelope::Kind::table, "table"}};
};

} // namespace dermis::scene
