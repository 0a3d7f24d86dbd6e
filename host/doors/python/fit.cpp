// SPDX-License-Identifier: MIT
// Chains of elements, relaxations, and files of measured curves.
#include "host/doors/python/pickle.hpp"
#include "host/lab/scenes/curve_file.hpp"

namespace dermis::python {
namespace {

using Columns = std::vector<std::vector<double>>;

// Reads files for dermis.fit: kind, residual, and times, strains and values of each.
std::tuple<std::string, std::string, std::vector<Columns>>
read_curves(const std::vector<std::string>& paths, const std::string& kind, const std::string& residual,
            std::optional<double> stress, std::optional<double> strain) {
    scene::Curves all =
        scene::read_curves(paths, {.kind = kind, .residual = residual, .stress = stress, .strain = strain});
    std::vector<Columns> curves;
    for (scene::Curve& c : all.list) curves.push_back({std::move(c.times), std::move(c.strains), std::move(c.values)});
    return {all.kind, all.residual, std::move(curves)};
}

} // namespace

void bind_fit(nb::module_& m) {
    nb::class_<KelvinVoigt>(m, "KelvinVoigt",
                            "A spring beside a dashpot: modulus*strain + viscosity*rate = pressure. Viscosity 0 is a\n"
                            "spring, modulus 0 a dashpot.")
        .def(Pickled())
        .def(
            "__init__",
            [](KelvinVoigt* self, double modulus, double viscosity) {
                new (self) KelvinVoigt{.modulus = modulus, .viscosity = viscosity};
            },
            nb::kw_only(), nb::arg("modulus") = 0.0, nb::arg("viscosity") = 0.0)
        .def_rw("modulus", &KelvinVoigt::modulus, "Pa, >= 0")
        .def_rw("viscosity", &KelvinVoigt::viscosity, "Pa s, >= 0");
    nb::class_<Relaxation>(m, "Relaxation", "The generalized Maxwell model: what papers call a Prony series.")
        .def(Pickled())
        .def(
            "__init__",
            [](Relaxation* self, const Numbers& moduli, const Numbers& times, double equilibrium) {
                new (self) Relaxation{numbers_in(moduli, "moduli"), numbers_in(times, "times"), equilibrium};
            },
            nb::kw_only(), nb::arg("moduli") = nb::tuple(), nb::arg("times") = nb::tuple(),
            nb::arg("equilibrium") = 0.0)
        .def_prop_rw(
            "moduli", [](const Relaxation& r) { return r.moduli; },
            [](Relaxation& r, const Numbers& moduli) { r.moduli = numbers_in(moduli, "moduli"); }, "Pa, > 0")
        .def_prop_rw(
            "times", [](const Relaxation& r) { return r.times; },
            [](Relaxation& r, const Numbers& times) { r.times = numbers_in(times, "times"); }, "s, > 0")
        .def_rw("equilibrium", &Relaxation::equilibrium, "Pa, >= 0");
    m.def("chain_of", &chain_of, nb::arg("relaxation"),
          "Return the chain of elements with this relaxation, for material.elements.");
    m.def(
        "relaxation_of",
        [](const Sequence<KelvinVoigt>& elements) {
            return relaxation_of(items_of<KelvinVoigt>(elements, "elements", "KelvinVoigt"));
        },
        nb::arg("elements"), "Return the relaxation of a chain, times ascending.");
    m.def("read_curves", &read_curves, nb::arg("paths"), nb::arg("kind"), nb::arg("residual"), nb::arg("stress").none(),
          nb::arg("strain").none(), "Read the files of dermis.fit.");
}

} // namespace dermis::python
