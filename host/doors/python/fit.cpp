// SPDX-License-Identifier: MIT
// Chains of elements from measured curves.
#include "dermis/fit.hpp"
#include "host/doors/python/pickle.hpp"

namespace dermis::python {
namespace {

using FitFunction = decltype(&fit_creep);

Residual residual_named(string_view name) {
    if (name == "relative") return Residual::relative;
    if (name == "absolute") return Residual::absolute;
    scene::refuse("residual", "\"" + std::string(name) + "\"", "\"absolute\", \"relative\"");
}

// None is 0 elements: as few as describe the data.
int count_of(std::optional<int> n) {
    if (n && *n == 0) scene::refuse("n", "0", "1 to 8 elements, or None: as few as describe the data");
    return n.value_or(0);
}

template <FitFunction function>
Fit fit(const Numbers& times, const Numbers& values, std::optional<int> n, string_view residual) {
    const Residual kind = residual_named(residual);
    const std::vector<double> at = numbers_in(times, "times"),
                              measured = numbers_in(values, function == fit_creep ? "compliances" : "moduli");
    const Computing computing(nullptr);
    return function(at, measured, count_of(n), kind);
}

Fit fit_to_histories(const Sequence<nb::typed<nb::tuple, Numbers, Numbers, Numbers>>& histories, std::optional<int> n,
                     string_view residual) {
    const char* allowed = "a list of (times, strains, stresses)";
    const Residual kind = residual_named(residual);
    std::vector<History> all;
    for (const auto& [times, strains, stresses] :
         items_of<std::tuple<Numbers, Numbers, Numbers>>(histories, "histories", allowed))
        all.push_back({numbers_in(times, "times"), numbers_in(strains, "strains"), numbers_in(stresses, "stresses")});
    const Computing computing(nullptr);
    return fit_histories(all, count_of(n), kind);
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
    nb::class_<Fit>(m, "Fit", "A chain of elements that was fitted to a measured curve.")
        .def(Pickled())
        .def_ro("elements", &Fit::elements, "A spring, elements by ascending retardation time, a dashpot.")
        .def_ro("errors", &Fit::errors, "Standard error of the logarithm of each number of the elements.")
        .def_ro("choice", &Fit::choice, "Why there are so many elements; empty where n was given.")
        .def_ro("residual", &Fit::residual, "Root mean square of the residual.")
        .def_prop_ro(
            "model", [](nb::handle_t<Fit> self) { return view(nb::cast<const Fit&>(self).model, self); },
            "The curve at the times of the data, float64 of shape (times,).")
        .def_ro("undetermined", &Fit::undetermined, "Sentences about what the data leave open.");
    m.def("chain_of", &chain_of, nb::arg("relaxation"),
          "Return the chain of elements with this relaxation, for material.elements.");
    m.def(
        "relaxation_of",
        [](const Sequence<KelvinVoigt>& elements) {
            return relaxation_of(items_of<KelvinVoigt>(elements, "elements", "KelvinVoigt"));
        },
        nb::arg("elements"), "Return the relaxation of a chain, times ascending.");
    m.def("fit_creep", fit<fit_creep>, nb::arg("times"), nb::arg("compliances"), nb::arg("n").none() = nb::none(),
          nb::arg("residual") = "relative",
          "Fit a chain of at most n elements, 1..8, to measured creep; None: as few as describe the data.\n\n"
          "times: s, >= 0; compliances: 1/Pa; at least 2*n + 1 of each. residual: \"relative\" or \"absolute\".");
    m.def("fit_relaxation", fit<fit_relaxation>, nb::arg("times"), nb::arg("moduli"), nb::arg("n").none() = nb::none(),
          nb::arg("residual") = "relative",
          "Fit a chain of at most n elements, 1..8, to a measured relaxation; None: as few as describe the data.\n\n"
          "times: s, >= 0; moduli: Pa; at least 2*n + 1 of each. residual: \"relative\" or \"absolute\".");
    m.def("fit_histories", fit_to_histories, nb::arg("histories"), nb::arg("n").none() = nb::none(),
          nb::arg("residual") = "absolute",
          "Fit a chain of at most n elements, 1..8, to the stress under strains of any course; None: as few as\n"
          "describe the data.\n\n"
          "histories: a list of (times, strains, stresses), s, ascending, and Pa, equally many; the strain is 0\n"
          "before, and runs along lines. residual: \"relative\" or \"absolute\".");
}

} // namespace dermis::python
