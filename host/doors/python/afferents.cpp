// SPDX-License-Identifier: MIT
// Afferents, and what turns their input into spikes.
#include "host/doors/python/pickle.hpp"

#include <nanobind/stl/array.h>

namespace dermis::python {
namespace {

using Gains = decltype(AfferentModel::gains);
using Pair = std::tuple<double, double>;
using Pairs = Sequence<Sequence<double>>;

// A tuple, whose items cannot be set: in a list, which is a copy, a change would be lost without a word.
template <class Item> using Row = nb::typed<nb::tuple, Item, nb::ellipsis>;
template <class Made, class Items> Made row_of(const Items& items) {
    return nb::borrow<Made>(nb::tuple(nb::cast(items)));
}
using PairRow = Row<nb::typed<nb::tuple, double, double>>;

Gains gains_in(const Pairs& pairs) {
    Gains gains{};
    if (!nb::try_cast(pairs, gains))
        scene::refuse("gains", description_of(pairs),
                      "three pairs of numbers, of y, y' and y'', each for its positive and its negative values");
    return gains;
}

std::array<AfterCurrent, 2> after_in(const Pairs& pairs) {
    const char* allowed = "at most two pairs (amplitude, time)";
    std::array<AfterCurrent, 2> after;
    const std::vector<Pair> given = items_of<Pair>(pairs, "after", allowed);
    if (given.size() > after.size()) scene::refuse("after", std::to_string(given.size()) + " pairs", allowed);
    for (size_t i = 0; i < given.size(); ++i) std::tie(after[i].amplitude, after[i].time) = given[i];
    return after;
}

PairRow gains_of(const AfferentModel& m) {
    std::vector<Pair> pairs;
    for (const auto& [positive, negative] : m.gains) pairs.emplace_back(positive, negative);
    return row_of<PairRow>(pairs);
}

PairRow after_of(const AfferentModel& m) {
    std::vector<Pair> pairs;
    for (const AfterCurrent& a : m.after) pairs.emplace_back(a.amplitude, a.time);
    return row_of<PairRow>(pairs);
}

void make_model(AfferentModel* self, const Numbers& time_constants, std::optional<double> frequency,
                std::optional<double> quality, double value, double rate, const Pairs& gains, double membrane_time,
                double refractory_time, double reset, const Pairs& after, double sensitivity, double spread) {
    new (self) AfferentModel{.time_constants = numbers_in(time_constants, "time_constants"),
                             .frequency = frequency,
                             .quality = quality,
                             .value = value,
                             .rate = rate,
                             .gains = gains_in(gains),
                             .membrane_time = membrane_time,
                             .refractory_time = refractory_time,
                             .reset = reset,
                             .after = after_in(after),
                             .sensitivity = sensitivity,
                             .spread = spread};
}

void bind_model(nb::module_& m) {
    const auto zeros = nb::make_tuple(0.0, 0.0);
    nb::class_<AfferentModel> type(m, "AfferentModel",
                                   "How an afferent turns its input q into spikes.\n\n"
                                   "A low-pass of 1 to 3 poles makes y of s*(value*q + sensitivity*rate*q'), s = "
                                   "e^(spread*n) with a drawn normal number n. gains times y, y' and y''\n"
                                   "make the current I, and membrane_time*V' = -V + I + after. V = 1 is a spike; then\n"
                                   "V is reset for refractory_time. A skin or a scene checks the numbers it is given.");
    type.def(Pickled())
        .def("__init__", make_model, nb::kw_only(), nb::arg("time_constants") = nb::tuple(),
             nb::arg("frequency").none() = nb::none(), nb::arg("quality").none() = nb::none(), nb::arg("value") = 1.0,
             nb::arg("rate") = 0.0, nb::arg("gains") = nb::make_tuple(nb::make_tuple(1.0, 0.0), zeros, zeros),
             nb::arg("membrane_time"), nb::arg("refractory_time"), nb::arg("reset") = 0.0,
             nb::arg("after") = nb::tuple(), nb::arg("sensitivity") = 1.0, nb::arg("spread") = 0.0)
        .def_prop_rw(
            "time_constants", [](const AfferentModel& a) { return row_of<Row<double>>(a.time_constants); },
            [](AfferentModel& a, const Numbers& times) { a.time_constants = numbers_in(times, "time_constants"); },
            "s, > 0: a real pole of the low-pass for each")
        .def_rw("frequency", &AfferentModel::frequency, nb::for_setter(nb::arg("value").none()),
                "Hz, > 0, of a pair of poles; None: there is no pair")
        .def_rw("quality", &AfferentModel::quality, nb::for_setter(nb::arg("value").none()),
                "> 0, of the pair; None without a frequency")
        .def_rw("value", &AfferentModel::value, "of q, a finite number")
        .def_rw("rate", &AfferentModel::rate, "of q', s")
        .def_prop_rw(
            "gains", gains_of, [](AfferentModel& a, const Pairs& gains) { a.gains = gains_in(gains); },
            "pairs for y (numbers), y' (s) and y'' (s2), each for positive and for negative values")
        .def_rw("membrane_time", &AfferentModel::membrane_time, "s, > 0")
        .def_rw("refractory_time", &AfferentModel::refractory_time, "s, > 0")
        .def_rw("reset", &AfferentModel::reset, "a number < 1: V after a spike")
        .def_rw("sensitivity", &AfferentModel::sensitivity,
                "factor of the rate, > 0, at most 1e6: how much smaller a change may be than for the median afferent")
        .def_rw("spread", &AfferentModel::spread,
                "0 to 5: the standard deviation of the natural logarithm of s among the afferents, which is drawn; "
                "0: all are alike")
        .def_prop_rw(
            "after", after_of, [](AfferentModel& a, const Pairs& after) { a.after = after_in(after); },
            "at most two pairs (amplitude, time): each spike starts the current amplitude*exp(-t/time); time: s, > 0");
}

} // namespace

void bind_afferents(nb::module_& m) {
    bind_model(m);
    nb::class_<Afferents>(m, "Afferents",
                          "Afferents (nerve fibres) of one class, one for each cell, or for each `endings` of them.\n\n"
                          "Skin and Scene take a list of them, numbered from 0 on through all its entries.")
        .def(Pickled())
        .def(
            "__init__",
            [](Afferents* self, string_view type, const AfferentModel* model, const Items& cells, string_view follow,
               int endings, std::optional<double> radius, int seed) {
                Afferents made{.type = value_named<Quantity>("type", type),
                               .model = {},
                               .cells = {},
                               .follow = value_named<Signal>("follow", follow),
                               .endings = endings,
                               .radius = radius,
                               .seed = seed};
                if (model) made.model = *model;
                for (const auto& [x, y] :
                     items_of<std::tuple<int, int>>(cells, "cells", "a list of cells, as in [(12, 40)]"))
                    made.cells.push_back({x, y});
                new (self) Afferents(std::move(made));
            },
            nb::kw_only(), nb::arg("type") = "sa1", nb::arg("model").none() = nb::none(),
            nb::arg("cells") = nb::tuple(), nb::arg("follow") = "strain", nb::arg("endings") = 1,
            nb::arg("radius").none() = nb::none(), nb::arg("seed") = 1,
            nb::sig("def __init__(self, *, type: dermis._typing.ReceptorType = \"sa1\", "
                    "model: AfferentModel | None = None, "
                    "cells: collections.abc.Sequence[collections.abc.Sequence[int]] | "
                    "numpy.typing.NDArray[numpy.integer] = (), "
                    "follow: dermis._typing.Signal = \"strain\", endings: int = 1, radius: float | None = None, "
                    "seed: int = 1) -> None"))
        .def_prop_ro(
            "type", [](const Afferents& a) { return name(a.type); },
            nb::sig("def type(self) -> dermis._typing.ReceptorType"),
            "The class, \"sa1\", \"sa2\", \"fa1\" or \"fa2\".")
        .def_prop_ro(
            "model", [](const Afferents& a) { return a.model ? &*a.model : nullptr; },
            nb::rv_policy::reference_internal, nb::sig("def model(self) -> AfferentModel | None"),
            "None: afferent_model(type), which SA2 has not.")
        .def_prop_ro(
            "cells",
            [](const Afferents& a) {
                std::vector<std::tuple<int, int>> cells;
                for (const Cell c : a.cells) cells.emplace_back(c.x, c.y);
                return row_of<Row<nb::typed<nb::tuple, int, int>>>(cells);
            },
            "The endings' cells (x, y), which are cells of sites where there are sites; empty: all sites of the "
            "class.")
        .def_prop_ro(
            "follow", [](const Afferents& a) { return scene::text_of(a.follow); },
            nb::sig("def follow(self) -> dermis._typing.Signal"),
            "What q is: \"strain\" of the cell, or \"stress\": its pressure over the modulus at which it comes to "
            "rest.")
        .def_ro("endings", &Afferents::endings,
                "Endings of each afferent, 1 to 64, taken in their order. The first one whose V reaches 1 fires the "
                "afferent.")
        .def_ro("radius", &Afferents::radius,
                "m, or cells without a spacing: each site of the class is then the middle of an afferent, whose "
                "endings are drawn within the radius, on the grid. None with cells.")
        .def_ro("seed", &Afferents::seed, "-1e9..1e9: of the endings and factors s that are drawn.");
    m.def(
        "afferent_model", [](string_view type) { return afferent_model(value_named<Quantity>("type", type)); },
        nb::arg("type"), nb::sig("def afferent_model(type: dermis._typing.ReceptorType) -> AfferentModel"),
        "Return the parameters of a class, fitted to published thresholds and rates. type: \"sa1\", \"fa1\" or "
        "\"fa2\". The sensitivity is that of the afferents whose thresholds for vibrations were measured; 1 gives the "
        "median one.");
}

} // namespace dermis::python
