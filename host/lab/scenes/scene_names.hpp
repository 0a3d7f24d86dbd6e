// SPDX-License-Identifier: MIT
// Names of the enums that a scene has besides a skin's enums.
#pragma once

#include "dermis/scene.hpp"
#include "host/core/description/names.hpp"

namespace dermis::scene {

DERMIS_NAMES(Method, {exact, "exact"}, {euler, "euler"}, {rk2, "rk2"}, {rk4, "rk4"}, {backward_euler, "backward-euler"},
             {crank_nicolson, "crank-nicolson"}, {sdirk2, "sdirk2"}, {published, "published"})
DERMIS_NAMES(Model, {moments, "moments"}, {maps, "maps"}, {sites, "sites"}, {march, "march"})
DERMIS_NAMES(Control, {pressure, "pressure"}, {depth, "depth"})
DERMIS_NAMES(Load::Contact, {even, "even"}, {crests, "crests"})
DERMIS_NAMES(Load::Kind, {circular, "circular"}, {point, "point"}, {linear, "linear"}, {map, "file"},
             {sequence, "sequence"}, {punch, "punch"}, {ball, "ball"})
DERMIS_NAMES(Taxels::Spread, {nearest, "nearest"}, {linear, "linear"}, {cubic, "cubic"})
enum class High { white, black }; // what is high in a picture
DERMIS_NAMES(High, {white, "white"}, {black, "black"})
DERMIS_NAMES(Hold, {linear, "linear"}, {parabolic, "parabolic"})
DERMIS_NAMES(Envelope::Kind, {step, "step"}, {ramp, "ramp"}, {sine, "sine"}, {pulse, "pulse"}, {table, "table"})
#undef DERMIS_NAMES

} // namespace dermis::scene
