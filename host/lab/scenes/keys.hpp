// SPDX-License-Identifier: MIT
// The list of keys, from core/description/skin_keys.hpp on: a row for each key of a scene file's other tables.
#pragma once

#include "host/core/description/skin_keys.hpp"
#include "host/lab/scenes/scene_names.hpp"

namespace dermis::scene {

template <>
inline constexpr auto rows<Relaxation> =
    std::tuple{Key{"moduli", &Relaxation::moduli, "Pa", positive, "", "of the terms of a relaxation, at most 7"},
               Key{"times", &Relaxation::times, "s", positive, "", "their relaxation times"},
               Key{"equilibrium", &Relaxation::equilibrium, "Pa", not_negative, "", "the modulus that stays"}};

template <>
inline constexpr auto rows<Envelope::Window> =
    std::tuple{Key{"start", &Envelope::Window::start, "s", not_negative, "", "0 until then"},
               Key{"rise", &Envelope::Window::rise, "s", not_negative, "", "up to 1 within it"},
               Key{"until", &Envelope::Window::until, "s", positive, "none", "the begin of the fall"},
               Key{"fall", &Envelope::Window::fall, "s", not_negative, "", "down to 0 within it"}};

template <Envelope::Kind kind> constexpr bool is_kind(const Envelope& e) { return e.kind == kind; }
inline constexpr Only<Envelope> of_ramp{"only with load.envelope = \"ramp\"", is_kind<Envelope::Kind::ramp>},
    of_sine{"only with load.envelope = \"sine\"", is_kind<Envelope::Kind::sine>},
    of_pulse{"only with load.envelope = \"pulse\"", is_kind<Envelope::Kind::pulse>},
    of_table{"only with load.envelope = \"table\"", is_kind<Envelope::Kind::table>},
    with_start{"only with load.envelope \"step\", \"ramp\" or \"pulse\"", [](const Envelope&e) {
                   return e.kind == Envelope::Kind::step || of_ramp.holds(e) || of_pulse.holds(e);
               }};
template <>
inline constexpr auto rows<Envelope> =
    std::tuple{Key{"envelope", &Envelope::kind, "", no_range, "", "the load over time"},
               Key{"start", &Envelope::start, "s", not_negative, "", "of a step, a ramp or pulses", with_start},
               Key{"rise", &Envelope::rise, "s", positive, "", "time of a ramp from 0 to 1", of_ramp},
               Key{"frequency", &Envelope::frequency, "Hz", positive, "", "of a sine", of_sine},
               Key{"phase", &Envelope::phase, "rad", radians, "", "of a sine", of_sine},
               Key{"mean", &Envelope::mean, "", number, "", "of a sine", of_sine},
               Key{"amplitude", &Envelope::amplitude, "", number, "", "of a sine", of_sine},
               Key{"length", &Envelope::length, "s", positive, "", "of each pulse", of_pulse},
               Key{"period", &Envelope::period, "s", number, "", "from pulse to pulse", of_pulse},
               Key{"times", &Envelope::times, "s", not_negative, "", "points of a table, ascending", of_table},
               Key{"values", &Envelope::values, "", number, "", "of a table at its times", of_table},
               Key{"window", &Envelope::window, "", no_range, "none", "multiplies a step or a sine"}};

template <>
inline constexpr auto rows<Grating> =
    std::tuple{Key{"wavelength", &Grating::wavelength, "m", positive, "required", "from crest to crest"},
               Key{"direction", &Grating::direction, "rad", radians, "", "from the x axis towards the y axis"},
               Key{"velocity", &Grating::velocity, "m/s", no_range, "", "along the direction"},
               Key{"amplitudes", &Grating::amplitudes, "", number, "", "of the harmonics, 1 to 16"},
               Key{"phases", &Grating::phases, "rad", radians, "0 for each", "of the harmonics"}};

template <>
inline constexpr auto rows<Texture> =
    std::tuple{Key{"path", Special{"MapOrFile"}, "", no_range, "required", "a map of numbers that repeats itself"},
               Key{"high", Special{"Literal[\"black\", \"white\"]"}, "", no_range, "required with a PNG",
                   "the grey of the picture that is 1"},
               Key{"spacing", &Texture::spacing, "m", positive, "the grid's", "from number to number"},
               Key{"velocity", &Texture::velocity, "m/s", no_range, "", "along x and y"}};

template <>
inline constexpr auto rows<Taxels> =
    std::tuple{Key{"spacing", &Taxels::spacing, "m", positive, "required", "from taxel to taxel"},
               Key{"unit", Special{"NumberWithUnit"}, "Pa", no_range, "required",
                   "of 1 in the file, as \"kPa\", \"12 Pa\" or \"mN\""},
               Key{"offset", Special{"float | str"}, "", no_range, "required unless the first frame is 0",
                   "of a taxel at rest, or \"first\""},
               Key{"columns", &Taxels::columns, "", counts, "required with a CSV file", "taxels in a row"},
               Key{"rows", &Taxels::rows, "", counts, "required with a CSV file", "taxels in a column"},
               Key{"skip", &Taxels::skip, "", no_range, "", "columns of a CSV file before the taxels"},
               Key{"origin", &Taxels::origin, "m", number, "", "the outer corner of the first taxel"},
               Key{"spread", &Taxels::spread, "", no_range, "", "the B-spline by which a taxel's force is spread"},
               Key{"sampling_rate", Special{"NumberWithUnit"}, "Hz", positive, "none", "1/interval, in its place"}};

inline constexpr Only<Load> of_sequence{"only with load.kind = \"sequence\"",
                                        [](const Load&l) { return l.kind == Load::Kind::sequence; }},
    of_punch{"only with load.kind = \"punch\"", [](const Load&l) { return l.kind == Load::Kind::punch; }},
    of_ball{"only with load.kind = \"ball\"", [](const Load&l) { return l.kind == Load::Kind::ball; }},
    with_radius{"only with load.kind \"circular\", \"point\", \"linear\" or \"punch\"",
                [](const Load&l) { return l.kind != Load::Kind::map && !of_sequence.holds(l) && !of_ball.holds(l); }},
    with_crests{"only with load.contact = \"crests\"", [](const Load&l) { return l.contact == Load::Contact::crests; }};
template <>
inline constexpr auto rows<Load> = std::tuple{
    Key{"kind", &Load::kind, "", no_range, "", "the map of the pressure, or what is pressed in"},
    Key{"path", Special{"MapOrFile"}, "", no_range, "required with \"file\", \"sequence\"",
        "a map of pressures, or frames"},
    Key{"high", Special{"Literal[\"black\", \"white\"]"}, "", no_range, "required with a PNG",
        "the grey of the picture that is 1"},
    Key{"center", &Load::center, "cells", no_range, "the middle", "of what is pressed in, [x, y]"},
    Key{"radius", &Load::radius, "cells", radii, "a quarter of the shorter side", "of what is pressed in", with_radius},
    Key{"radius_y", &Load::radius_y, "cells", radii, "radius", "of a punch along y", of_punch},
    Key{"ball_radius", &Load::ball_radius, "m", positive, "required with \"ball\"", "of the ball", of_ball},
    Key{"intensity", Special{"NumberWithUnit"}, "Pa", number, "1", "multiplies the map; with control = \"depth\" in m"},
    Key{"interval", &Load::interval, "s", positive, "required with \"sequence\"", "between frames", of_sequence},
    Key{"hold", &Load::hold, "", no_range, "", "how the pressure runs from frame to frame"},
    Key{"control", &Load::control, "", no_range, "", "what intensity and map give"},
    Key{"contact", &Load::contact, "", no_range, "", "the cells that are pressed"},
    Key{"contact_share", &Load::contact_share, "", share, "", "of the cells that are crests", with_crests},
    Key{"contact_length", &Load::contact_length, "m", positive, "the ridge period", "over which the mean stays",
        with_crests},
    Key{"texture", Special{"Mapping[str, Any]"}, "", no_range, "none", "a rough surface that slides"},
    Key{"taxels", Special{"Mapping[str, Any]"}, "", no_range, "the cells",
        "of a sensor array, whose recording path is"},
    Key{"grating", &Load::grating, "", no_range, "none", "waves that move and multiply the pressure"}};

template <>
inline constexpr auto rows<Time> =
    std::tuple{Key{"step", &Time::step, "s", positive, "", "from output to output"},
               Key{"duration", &Time::duration, "s", number, "", "of the scene, at least a step"}};

inline constexpr Range traced{"", [](double q) { return q < double(Quantity::curvature); }},
    of_fields{"", [](double q) { return q <= double(Quantity::deformation); }};
template <>
inline constexpr auto rows<FieldRequest> =
    std::tuple{Key{"at", &FieldRequest::at, "s", not_negative, "required", "time of the maps"},
               Key{"what", &FieldRequest::what, "", of_fields, "required", "their quantities"}};
template <>
inline constexpr auto rows<Output> =
    std::tuple{Key{"traces", &Output::traces, "", traced, "", "mean, least and greatest value over time"},
               Key{"extremes", &Output::extremes, "", no_range, "", "whether least and greatest values are wanted"},
               Key{"probes", &Output::probes, "cells", no_range, "none", "cells with traces"},
               Key{"fields", &Output::fields, "", no_range, "none", "maps at times"}};

// Tables of a file that belong to no struct.
struct CurvatureTable {};
template <>
inline constexpr auto rows<CurvatureTable> =
    std::tuple{Key{"stencil", &Scene::stencil, "", no_range, "\"five-point\"", "of the Laplacian"},
               Key{"edges", &Scene::edges, "", no_range, "\"mirror\"", "the cell beyond an edge"}};
struct SitesTable {};
template <>
inline constexpr auto rows<SitesTable> =
    std::tuple{Key{"path", Special{"str | os.PathLike[str]"}, "", no_range, "none", "a table of sites: type,x,y"},
               Key{"density", Special{"Mapping[str, float]"}, "", no_range, "none", "sites per cm2, class by class"},
               Key{"seed", Special{"int"}, "", no_range, "1", "of the places that are drawn"}};

template <>
inline constexpr auto rows<Scene> = std::tuple{
    Key{"preset", Special{"str"}, "", no_range, "none", "\"fingertip\": a skin to begin with"},
    Key{"method", &Scene::method, "", no_range, "", "of each step in time"},
    Key{"allow_unstable", &Scene::allow_unstable, "", no_range, "", "runs an explicit method beyond its limit"},
    Key{"model", &Scene::model, "", no_range, "chosen", "by which a result is computed"},
    Key{"precision", &Scene::precision, "", no_range, "chosen", "arithmetic of march"},
    Key{"tolerance", &Scene::tolerance, "", positive, "1e-4, which does not bind", "greatest relative error"}};

// The tables of a file, each with the struct whose rows are its keys.
template <class T> struct Table {
    using Of = T;
    const char* name; // with a dot; empty: the top of the file
};
inline constexpr std::tuple tables{Table<Scene>{""},
                                   Table<Grid>{"grid."},
                                   Table<Surface>{"surface."},
                                   Table<Material>{"material."},
                                   Table<KelvinVoigt>{"material.elements."},
                                   Table<Relaxation>{"material.relaxation."},
                                   Table<Load>{"load."},
                                   Table<Envelope>{"load."},
                                   Table<Envelope::Window>{"load.window."},
                                   Table<Texture>{"load.texture."},
                                   Table<Taxels>{"load.taxels."},
                                   Table<Grating>{"load.grating."},
                                   Table<Time>{"time."},
                                   Table<CurvatureTable>{"curvature."},
                                   Table<Receptors>{"receptors."},
                                   Table<Depths>{"receptors.depth."},
                                   Table<DepthKernels>{"receptors.kernel."},
                                   Table<Follow>{"receptors.follow."},
                                   Table<SitesTable>{"sites."},
                                   Table<Density>{"sites.density."},
                                   Table<Output>{"output."},
                                   Table<FieldRequest>{"output.fields."},
                                   Table<Afferents>{"afferents."},
                                   Table<AfferentModel>{"afferents."},
                                   Table<AfterCurrent>{"afferents.after."}};

} // namespace dermis::scene
