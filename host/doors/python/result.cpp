// SPDX-License-Identifier: MIT
// Runs, what they would cost, and their results as views by name.
#include "host/core/description/element.hpp"
#include "host/doors/python/pickle.hpp"

namespace dermis::python {
namespace {

// A result, and the scene that was run.
struct RunOfScene {
    Scene scene;
    Result result;
};
template <class Archive> void members(Archive& each, RunOfScene& s) { each(s.scene, s.result); }

RunOptions options_of(const std::optional<string_view>& precision, bool check) {
    RunOptions options;
    if (precision) options.precision = value_named<Precision>("precision", *precision);
    options.check = check;
    return options;
}

RunOfScene run_scene(const Scene& scene, nb::handle device, const std::optional<string_view>& precision, bool check,
                     nb::handle progress) {
    RunOptions options = options_of(precision, check);
    const SharedDevice on = device_of(device);
    Computing computing(on.in_use());
    options.progress = computing.progress(progress);
    return {scene, run(scene, on.device(), options)};
}

Explanation plan_of_scene(const Scene& scene, nb::handle device, const std::optional<string_view>& precision) {
    RunOptions options = options_of(precision, false);
    const SharedDevice on = device_of(device);
    Computing computing(on.in_use());
    options.progress = computing.progress(Py_None);
    return plan(scene, on.device(), options);
}

template <auto member> View<double> numbers_of(nb::handle_t<Trace> self) {
    return view(nb::cast<const Trace&>(self).*member, self);
}

nb::typed<nb::list, View<double>> probes_of(nb::handle_t<Trace> self) {
    nb::typed<nb::list, View<double>> probes;
    for (const std::vector<double>& probe : nb::cast<const Trace&>(self).probes) probes.append(view(probe, self));
    return probes;
}

nb::typed<nb::dict, std::tuple<nb::str, double>, View<double>> fields_of(nb::handle_t<RunOfScene> self) {
    const RunOfScene& r = nb::cast<const RunOfScene&>(self);
    nb::typed<nb::dict, std::tuple<nb::str, double>, View<double>> fields;
    for (const Field& f : r.result.fields)
        fields[nb::make_tuple(name(f.quantity), f.at)] =
            view(f.values.data(), {size_t(r.scene.grid.height), size_t(r.scene.grid.width)}, self);
    return fields;
}

View<double> responses_of(nb::handle_t<RunOfScene> self) {
    const RunOfScene& r = nb::cast<const RunOfScene&>(self);
    return view(r.result.responses.data(), {r.result.time.size(), r.scene.sites.size()}, self);
}

nb::typed<nb::dict, nb::str, double> outcomes_of(const RunOfScene& r) {
    nb::typed<nb::dict, nb::str, double> all;
    for (const TraceOutcome& outcome : outcomes(r.result)) all[outcome.name.c_str()] = outcome.value;
    return all;
}

bool has_trace(const RunOfScene& r, string_view quantity) {
    return std::ranges::any_of(r.result.traces, [&](const Trace& t) { return quantity == name(t.quantity); });
}

std::vector<const char*> trace_names(const RunOfScene& r) {
    std::vector<const char*> names;
    for (const Trace& t : r.result.traces) names.push_back(name(t.quantity));
    return names;
}

void bind_parts(nb::module_& m) {
    nb::class_<Trace>(m, "Trace", "One quantity over time. Its arrays have one float64 for each output time.")
        .def(Pickled())
        .def_prop_ro("quantity", [](const Trace& t) { return name(t.quantity); })
        .def_prop_ro("mean", numbers_of<&Trace::mean>, "Mean over all cells.")
        .def_prop_ro("min", numbers_of<&Trace::min>, "Least value of all cells; empty without output.extremes.")
        .def_prop_ro("max", numbers_of<&Trace::max>, "Greatest value of all cells; empty without output.extremes.")
        .def_prop_ro("probes", probes_of, "The values in each cell of output.probes.");
    nb::class_<Impulse>(m, "Impulse", "The weight per cell of an impulse in a response, at a jump of the load.")
        .def(Pickled())
        .def_ro("time", &Impulse::time, "s")
        .def_prop_ro("quantity", [](const Impulse& i) { return name(i.quantity); })
        .def_ro("mean", &Impulse::mean)
        .def_ro("min", &Impulse::min)
        .def_ro("max", &Impulse::max)
        .def_ro("probes", &Impulse::probes);
}

// Rows of _arrays.FIRED.
nb::object spikes_of_run(const RunOfScene& r) {
    std::string rows;
    for (const FiredSpike& s : r.result.spikes) {
        rows.append(reinterpret_cast<const char*>(&s.time), sizeof s.time);
        rows.append(reinterpret_cast<const char*>(&s.afferent), sizeof s.afferent);
    }
    return nb::module_::import_("numpy").attr("frombuffer")(nb::bytearray(rows.data(), rows.size()),
                                                            nb::module_::import_("dermis._arrays").attr("FIRED"));
}

// The result's numbers beside its arrays.
void add_figures(nb::class_<RunOfScene>& type) {
    const auto add = [&]<class Number>(const char* name, Number Result::*member, const char* doc) {
        type.def_prop_ro(
            name, [member](const RunOfScene& r) { return r.result.*member; }, doc);
    };
    add("impulses", &Result::impulses, "The impulses of the load's jumps.");
    type.def_prop_ro("spikes", spikes_of_run, nb::sig("def spikes(self) -> numpy.typing.NDArray[numpy.void]"),
                     "The spikes of the scene's afferents, as an array of its own of shape (spikes,) with the fields\n"
                     "time (float64, s) and afferent (int32, its number); by time, then by number.");
    add("device", &Result::device, "The device that computed.");
    add("steps", &Result::steps, "Steps of the whole skin.");
    add("seconds", &Result::seconds, "Time of stepping in s, without set-up.");
    add("predicted_error", &Result::predicted_error, "Bound of the error that tolerance limits; NaN: not needed.");
    add("measured_error", &Result::measured_error,
        "Greatest error in some cells that are computed once more in long double, and in means and extremes; NaN:\n"
        "nothing was measured, for want of a tolerance or of a cell that the load presses.");
    add("measured_cells", &Result::measured_cells, "How many of these cells the load presses; 0: none.");
    add("unmeasured", &Result::unmeasured, "Names of what was asked for and not computed once more.");
    add("greatest_curvature", &Result::greatest_curvature, "Greatest |C| in 1/m, at rest and at the end.");
    add("greatest_gain", &Result::greatest_gain, "Greatest |l*C|; above 1 responses change sign.");
    add("kinks", &Result::kinks, "Cells where the curvature does not converge; -1: not known.");
    add("cells_compared", &Result::cells_compared, "Cells whose bits were compared with another backend's.");
    add("cells_different", &Result::cells_different, "Cells whose bits differed.");
}

void bind_explanation(nb::module_& m) {
    nb::class_<Candidate>(m, "Candidate", "A model, precision and device that could serve a scene.")
        .def(Pickled())
        .def_prop_ro("model", [](const Candidate& c) { return name(c.model); })
        .def_prop_ro("precision", [](const Candidate& c) { return name(c.precision); })
        .def_ro("device", &Candidate::device)
        .def_ro("steps", &Candidate::steps)
        .def_ro("bytes", &Candidate::bytes, "Greatest memory in use.")
        .def_ro("seconds", &Candidate::seconds, "An estimate from a table of rates.")
        .def_ro("error", &Candidate::error, "Upper bound of the error that tolerance limits; NaN: not needed.")
        .def_ro("refused", &Candidate::refused, "The reason why it is not chosen; empty if it is.");
    nb::class_<Explanation>(m, "Explanation", "How run() would compute a scene.")
        .def(Pickled())
        .def_ro("candidates", &Explanation::candidates, "In the order in which they are tried.")
        .def_prop_ro(
            "chosen", [](const Explanation& e) { return e.candidates[e.chosen]; }, "The candidate that run() takes.")
        .def_ro("tolerance", &Explanation::tolerance)
        .def_ro("binding", &Explanation::binding, "Whether the tolerance is the scene's.")
        .def_ro("stencil_estimate", &Explanation::stencil_estimate, "Greatest |C5 - C4| at rest, 1/m.")
        .def_ro("greatest_curvature", &Explanation::greatest_curvature, "Greatest |C| at rest, 1/m.")
        .def_ro("strain_between_frames", &Explanation::strain_between_frames,
                "What frames of a sequence lose of the strain: by how much lines and parabolas between them differ.")
        .def_ro("fa1_between_frames", &Explanation::fa1_between_frames, "The same of FA1.")
        .def_ro("fine_load", &Explanation::fine_load, "The share of the load that is finer than receptors lie deep.");
    m.def("plan", plan_of_scene, nb::arg("scene"), nb::arg("device").none() = nb::none(),
          nb::arg("precision").none() = nb::none());
}

} // namespace

void bind_result(nb::module_& m) {
    bind_parts(m);
    nb::class_<RunOfScene> type(m, "Result",
                                "What a run gave. Arrays are views of the result's own numbers and cannot be written.");
    type.def(Pickled())
        .def_prop_ro(
            "time",
            [](nb::handle_t<RunOfScene> self) { return view(nb::cast<const RunOfScene&>(self).result.time, self); },
            "Output times in s, float64 of shape (times,).")
        .def(
            "__getitem__",
            [](const RunOfScene& r, string_view quantity) -> const Trace& {
                std::string allowed;
                for (const char* name : trace_names(r)) allowed += (allowed.empty() ? "" : ", ") + std::string(name);
                return r.result.trace(value_named<Quantity>("quantity", quantity, allowed));
            },
            nb::rv_policy::reference_internal, nb::arg("quantity"),
            nb::sig("def __getitem__(self, quantity: dermis._typing.OfTrace) -> Trace"),
            "The trace of a quantity of output.traces: \"strain\", \"sa1\", \"sa2\", \"fa1\", \"fa2\", ..")
        .def("keys", trace_names, nb::sig("def keys(self) -> list[dermis._typing.OfTrace]"),
             "The quantities that have traces.")
        .def("__contains__", has_trace, nb::arg("quantity"))
        .def(
            "__iter__", [](const RunOfScene& r) { return nb::iter(nb::cast(trace_names(r))); },
            nb::sig("def __iter__(self) -> collections.abc.Iterator[dermis._typing.OfTrace]"))
        .def("__len__", [](const RunOfScene& r) { return r.result.traces.size(); })
        .def_prop_ro("fields", fields_of,
                     "The fields of output.fields by (quantity, time in s), float64 of shape (height, width) each.")
        .def_prop_ro("responses", responses_of, "The responses at the sites, float64 of shape (times, sites).")
        .def_prop_ro(
            "scene", [](const RunOfScene& r) { return r.scene; }, "The scene that was run.")
        .def_prop_ro("outcomes", outcomes_of,
                     "Three numbers of each trace by name, the result columns of runs.csv: \"sa1_mean_final\", the\n"
                     "value at the last output time; \"sa1_mean_peak\", the one of greatest magnitude;\n"
                     "\"sa1_mean_peak_time\", the first time that has it, s. Likewise sa1_min, sa1_max, sa1_probe0, ..")
        .def_prop_ro(
            "model", [](const RunOfScene& r) { return name(r.result.model); }, "The model that computed.")
        .def_prop_ro(
            "precision", [](const RunOfScene& r) { return name(r.result.precision); },
            "The arithmetic that it computed in.")
        .def(
            "report", [](const RunOfScene& r) { return report(r.scene, r.result); },
            "Return the figures of the skin, with the ranges in which they are plausible.");
    add_figures(type);
    m.def("run", run_scene, nb::arg("scene"), nb::arg("device").none(), nb::arg("precision").none(), nb::arg("check"),
          nb::arg("progress").none());
    bind_explanation(m);
}

} // namespace dermis::python
