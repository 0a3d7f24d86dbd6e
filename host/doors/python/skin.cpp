// SPDX-License-Identifier: MIT
// Skins pressed frame by frame: arrays in, views out.
#include "host/core/description/element.hpp"
#include "host/doors/python/pickle.hpp"
#include "host/doors/python/skin_arguments.hpp"
#include "host/lab/scenes/scene_names.hpp"

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstddef>
#include <utility>

namespace dermis::python {
namespace {

// Warns once of a strain beyond 1, which skin does not have. It looks at up to 64 pads, in turn, and again after a
// quarter more presses, so that in the long run this takes no time.
void warn_of_strain(SkinWithShapes& s) {
    if (++s.presses < s.next_look) return;
    s.next_look = s.presses + s.presses / 4 + 1;
    Figure strain;
    int pad = 0;
    try {
        const Computing computing(s.in_use.get());
        for (int n = std::min(s.skin->count(), 64); n > 0 && !strain.outside(); --n)
            pad = s.look_at++ % s.skin->count(), strain = s.skin->report(pad).strain;
    } catch (const Error& e) {
        if (e.code() != Error::Code::no_memory) throw;
        return; // it has pressed, and looks another time
    }
    if (!strain.outside()) return;
    s.next_look = SIZE_MAX;
    const std::string words = "pad " + std::to_string(pad) + " has a strain of " + dermis::shortest(strain.value) +
                              ", indentation over thickness; skin: 0..1. Are pressures and moduli in Pa?";
    if (PyErr_WarnEx(PyExc_RuntimeWarning, words.c_str(), 1) != 0) nb::raise_python_error();
}

// Calls `one` with the place in the list, and the number, of each pad.
template <class One> void each_of(const Pads& pads, size_t all, One one) {
    for (size_t i = 0; i < (pads.all ? all : pads.count); ++i) one(i, pads.all ? i : size_t(pads.numbers[i]));
}

// Presses pads by frames of dt seconds, one for all or one for each pad, and fills arrays. It notes how long they were
// pressed, also where a signal ends the press after some of the frames.
template <class Press>
void press_timed(SkinWithShapes& s, const Pads& pads, const std::vector<double>& dt, size_t frames,
                 const Outputs& outputs, Press press) {
    const auto note = [&](double done) {
        if (const double pressed = std::round(done * double(frames)); pressed > 0)
            each_of(pads, s.time.size(), [&](size_t i, size_t pad) {
                s.step[pad] = dt[dt.size() > 1 ? i : 0];
                s.time[pad] += pressed * s.step[pad];
            });
    };
    {
        const Computing computing(s.in_use.get());
        const double outer = std::exchange(s.done, 0); // of a press whose signal's handler calls this one
        try {
            press();
        } catch (...) {
            note(std::exchange(s.done, outer));
            throw;
        }
        note(1);
        fill(outputs);
    }
    warn_of_strain(s);
}

void press_touch(SkinWithShapes& s, const SharedTouch& shared, nb::handle dt, nb::handle pads, nb::handle out) {
    double step = 0;
    if (!pads.is_none()) scene::refuse("pads", description_of(pads), "None: a Touch presses the pads that it touches");
    if (!nb::try_cast(dt, step)) scene::refuse("dt", description_of(dt), "seconds, one number for all pads of a Touch");
    const Outputs outputs = outputs_in(s, out);
    press_timed(s, {}, {step}, 1, outputs, [&] {
        const std::scoped_lock touch(shared.in_use);
        s.skin->press(shared.touch, step);
    });
}

void press(SkinWithShapes& s, nb::handle pressure, nb::handle dt, nb::handle pads, nb::handle out,
           nb::handle traction) {
    if (const SharedTouch* touch = nullptr; nb::try_cast(pressure, touch) && touch) {
        if (!traction.is_none()) scene::refuse("traction", description_of(traction), "None: a Touch has its own");
        return press_touch(s, *touch, dt, pads, out);
    }
    const PadNumbers numbers(pads, s.leading);
    const AnyArray array = pressure_in(s, pressure, numbers);
    const auto* data = static_cast<const float*>(array.data());
    std::vector<double> steps(1);
    const bool one = nb::try_cast(dt, steps[0]), sheared = !traction.is_none();
    if (!one && sheared) scene::refuse("dt", description_of(dt), "seconds, one number beside tractions");
    if (!one) steps = steps_in(s, dt, numbers);
    const AnyArray tractions = sheared ? pressure_in(s, traction, numbers, "traction", "2") : AnyArray();
    const auto* along = static_cast<const float*>(sheared ? tractions.data() : nullptr);
    const Outputs outputs = outputs_in(s, out);
    press_timed(s, numbers.pads(), steps, 1, outputs, [&] {
        if (sheared) s.skin->press(data, along, array.size(), steps[0], numbers.pads());
        else if (one) s.skin->press(data, array.size(), steps[0], numbers.pads());
        else s.skin->press(data, array.size(), steps.data(), steps.size(), numbers.pads());
    });
}

void press_frames(SkinWithShapes& s, nb::handle pressure, double dt, nb::handle pads, nb::handle out) {
    const PadNumbers numbers(pads, s.leading);
    const AnyArray array = pressure_in(s, pressure, numbers, "pressure", "frames");
    if (array.shape(0) == 0) scene::refuse("pressure", description_of(pressure), "one frame or more");
    const Outputs outputs = outputs_in(s, out);
    size_t of_frame = 1;
    for (size_t n : shape_of(s, numbers)) of_frame *= n;
    press_timed(s, numbers.pads(), {dt}, array.shape(0), outputs, [&] {
        s.skin->press_frames(static_cast<const float*>(array.data()), array.shape(0), of_frame, dt, numbers.pads());
    });
}

void press_cells(SkinWithShapes& s, nb::handle pressure, double dt, nb::handle pads) {
    const PadNumbers numbers(pads, s.leading);
    const std::optional<AnyArray> array = array_in(pressure);
    if (!array || array->dtype() != nb::dtype<float>() || !is_dense(*array))
        scene::refuse("pressure", description_of(pressure), "float32 array in C order, a number for each of cells");
    press_timed(s, numbers.pads(), {dt}, 1, {}, [&] {
        s.skin->press_cells(static_cast<const float*>(array->data()), array->size(), dt, numbers.pads());
    });
}

View<float> response(nb::handle_t<SkinWithShapes> self, nb::handle named) {
    const SkinWithShapes& s = nb::cast<const SkinWithShapes&>(self);
    std::vector<Quantity> these = responses_of(s);
    these.insert(these.end(), {Quantity::strain, Quantity::indentation, Quantity::curvature});
    if (s.options.shear)
        these.insert(these.end(), {Quantity::shear_x, Quantity::shear_y, Quantity::stretch_x, Quantity::stretch_y,
                                   Quantity::stretch_xy});
    const Skin::Response response = response_of(s, named, these);
    return view(response.data, shape_of(s, response), self);
}

// A row of _arrays.SPIKE.
struct TimedSpike {
    Spike spike;
    double time; // s, from the beginning of the call
};

// A copy, because a press may move the skin's own spikes.
nb::bytearray spikes_of(const SkinWithShapes& s) {
    static_assert(sizeof(Spike) == 16 && offsetof(Spike, pad) == 0 && offsetof(Spike, afferent) == 4 &&
                  offsetof(Spike, frame) == 8 && offsetof(Spike, share) == 12 && sizeof(TimedSpike) == 24);
    std::vector<TimedSpike> spikes;
    {
        const Computing computing(s.in_use.get());
        spikes.reserve(s.skin->spikes().size);
        for (const Spike& spike : s.skin->spikes())
            spikes.push_back({spike, (spike.frame + double(spike.share)) * s.step[size_t(spike.pad)]});
    }
    return nb::bytearray(spikes.data(), spikes.size() * sizeof(TimedSpike));
}

// The class of each afferent of a pad, by its number.
std::vector<const char*> classes_of(const SkinWithShapes& s) {
    std::vector<const char*> classes;
    for (const Afferents& a : s.options.afferents) {
        const auto sites = std::ranges::count(s.scene.sites, a.type, &Site::type); // each with an afferent
        const size_t afferents = a.cells.empty() ? size_t(sites) : a.cells.size() / size_t(a.endings);
        classes.insert(classes.end(), afferents, name(a.type));
    }
    return classes;
}

nb::object fibres(const SkinWithShapes& s) {
    nb::list names;
    for (const char* one : classes_of(s)) names.append(one);
    return nb::module_::import_("numpy").attr("array")(names, "U3");
}

nb::object zeros(const std::vector<size_t>& shape, const char* type) {
    return nb::module_::import_("numpy").attr("zeros")(shape, type);
}

nb::object spike_counts(const SkinWithShapes& s, nb::handle out) {
    std::vector<size_t> shape(s.leading.begin(), s.leading.end());
    const size_t of_pad = classes_of(s).size();
    shape.push_back(of_pad);
    nb::object filled = out.is_none() ? zeros(shape, "float32") : nb::borrow(out);
    const Output<float> counts = output_in<float>(filled, shape);
    const Computing computing(s.in_use.get());
    std::fill_n(counts.data(), counts.size(), 0.0f);
    for (const Spike& spike : s.skin->spikes()) ++counts.data()[size_t(spike.pad) * of_pad + size_t(spike.afferent)];
    return filled;
}

nb::object time_of(const SkinWithShapes& s) {
    const std::vector<size_t> shape =
        s.leading.empty() ? std::vector<size_t>{1} : std::vector<size_t>(s.leading.begin(), s.leading.end());
    nb::object filled = zeros(shape, "float64");
    const Output<double> seconds = output_in<double>(filled, shape);
    {
        const Computing computing(s.in_use.get());
        std::ranges::copy(s.time, seconds.data());
    }
    return s.leading.empty() ? nb::object(filled[0]) : filled;
}

nb::object save(const SkinWithShapes& s, nb::handle pads, nb::handle out) {
    const PadNumbers numbers(pads, s.leading);
    size_t size = 0;
    {
        const Computing computing(s.in_use.get());
        size = s.skin->state_bytes(numbers.pads());
    }
    nb::object filled = out.is_none() ? nb::object(nb::bytes(nullptr, size)) : nb::borrow(out);
    const Output<uint8_t> array = out.is_none() ? Output<uint8_t>() : output_in<uint8_t>(out, {size});
    void* state = array.is_valid() ? array.data() : static_cast<void*>(PyBytes_AsString(filled.ptr()));
    const Computing computing(s.in_use.get());
    s.skin->save(state, size, numbers.pads());
    return filled;
}

// Lets the time of pads begin anew. The skin is in use.
void forget_time(SkinWithShapes& s, const Pads& pads) {
    each_of(pads, s.time.size(), [&](size_t, size_t pad) { s.time[pad] = 0; });
}

void load(SkinWithShapes& s, nb::handle state, nb::handle pads) {
    const PadNumbers numbers(pads, s.leading);
    const std::optional<AnyArray> bytes = array_in(state);
    if (!bytes || !is_dense(*bytes))
        scene::refuse("state", description_of(state), "bytes, as Skin.save has returned them");
    const Computing computing(s.in_use.get());
    s.skin->load(bytes->data(), bytes->nbytes(), numbers.pads());
    forget_time(s, numbers.pads());
}

void reset(SkinWithShapes& s, nb::handle pads) {
    const PadNumbers numbers(pads, s.leading);
    const Computing computing(s.in_use.get());
    s.skin->reset(numbers.pads());
    forget_time(s, numbers.pads());
}

// Gives pads a material, and remembers it. The skin is in use.
void take(SkinWithShapes& s, const Material& material, const Pads& pads) {
    s.skin->set_material(material, pads);
    std::vector<Material>& materials = s.options.materials;
    if (materials.empty()) return scene::take_elements(s.scene.material, material);
    each_of(pads, materials.size(), [&](size_t, size_t pad) { materials[pad] = material; });
}

// The number of a material that a name of the package means, as "material.elements[1].modulus".
double& number_of(Material& material, const std::string& name) {
    const bool modulus = name.ends_with("modulus");
    if (name.ends_with("spring")) return *material.spring;
    if (name.ends_with("dashpot")) return *material.dashpot;
    const size_t index = name.find('[') + 1; // 0: of no element
    if (!index) return *(modulus ? material.modulus : material.viscosity);
    KelvinVoigt& element = material.elements[size_t(std::stoi(name.substr(index)))];
    return modulus ? element.modulus : element.viscosity;
}

using RowOfNumbers = nb::ndarray<nb::ro, double, nb::c_contig, nb::device::cpu>;

// Gives pads the material of a scene, or each pad its own of the numbers in `rows`, by name; no pad where one is
// refused.
void set_material(SkinWithShapes& s, const Scene& scene, const nb::typed<nb::dict, nb::str, RowOfNumbers>& rows,
                  nb::handle pads) {
    const PadNumbers numbers(pads, s.leading);
    const Pads named = numbers.pads();
    const size_t count = named.all ? size_t(s.skin->count()) : named.count;
    const std::vector<size_t> shape = s.leading.empty() ? std::vector<size_t>{1} : numbers.shape();
    Material own = scene.material;
    std::vector<std::pair<double*, RowOfNumbers>> columns;
    for (const auto [name, row] : rows) {
        const auto text = nb::cast<std::string>(name);
        columns.emplace_back(&number_of(own, text), nb::cast<RowOfNumbers>(row));
        if (!has_shape(columns.back().second, shape))
            scene::refuse(text, description_of(row), "a number, or an array of shape " + shape_text(shape));
    }
    const Computing computing(s.in_use.get());
    if (columns.empty()) return take(s, own, named);
    s.skin->state_bytes(named); // refuses a list with a pad twice, or one that the skin does not have
    int pad = 0;
    const auto one = [&](size_t i) {
        pad = named.all ? int(i) : named.numbers[i];
        return Pads(&pad, 1);
    };
    std::vector<Material> before;
    before.reserve(count);
    try {
        for (size_t i = 0; i < count; ++i) {
            for (const auto& [number, row] : columns) *number = row.data()[i];
            const Pads next = one(i);
            Material old = s.options.materials.empty() ? s.scene.material : s.options.materials[size_t(pad)];
            take(s, own, next);
            before.push_back(std::move(old));
        }
    } catch (...) {
        for (; !before.empty(); before.pop_back()) take(s, before.back(), one(before.size() - 1));
        throw;
    }
}

Report report_of(const SkinWithShapes& s, nb::handle pad) {
    int number = 0;
    if (s.leading.size() > 1 && !pad.is_none()) {
        const PadNumbers named(pad, s.leading);
        if (named.pads().count != 1) scene::refuse("pad", description_of(pad), "a tuple that names one pad");
        number = named.pads().numbers[0];
    } else if (!pad.is_none() && !nb::try_cast(pad, number))
        scene::refuse("pad", description_of(pad), "a whole number");
    const Computing computing(s.in_use.get());
    return s.skin->report(number);
}

void make_on(SkinWithShapes* self, const SharedDevice& on, const std::vector<int>& leading, const Scene& scene,
             const SkinOptions& options, const std::string& state = {}, std::vector<double> time = {}) {
    need_memory(scene, options);
    const std::shared_ptr<std::recursive_mutex> in_use =
        on.in_use() ? std::shared_ptr<std::recursive_mutex>(on.open, on.in_use())
                    : std::make_shared<std::recursive_mutex>();
    const Computing computing(in_use.get());
    SkinOptions stoppable = options;
    stoppable.progress = [self](double done) {
        self->done = done;
        let_signals_act(done);
    };
    Skin skin(on.device(), scene, stoppable);
    time.resize(size_t(skin.count()));
    if (!state.empty()) skin.load(state.data(), state.size());
    new (self) SkinWithShapes{// last: what is thrown after it would leave an object that nobody destroys
                              .in_use = in_use,   .device = on, .leading = leading,     .scene = scene,
                              .options = options, .time = time, .skin = std::move(skin)};
}

// The lengths of the axes of pads.
std::vector<int> axes_of(nb::handle count) {
    const char* allowed = "None, a number of pads, or a tuple of lengths, as in (64, 5)";
    if (count.is_none()) return {};
    if (int one = 0; nb::try_cast(count, one)) return {one};
    if (!is_row(count)) scene::refuse("count", description_of(count), allowed);
    return items_of<int>(count, "count", allowed);
}

void make_skin(SkinWithShapes* self, const Scene& scene, nb::handle axes, nb::handle device,
               const std::optional<Sequence<nb::str>>& responses, const std::optional<string_view>& precision,
               const Sequence<Scene>& materials, string_view hold, string_view control,
               const std::optional<Sequence<Afferents>>& afferents, bool shear,
               const std::optional<Numbers>& sa2_stretch) {
    const std::vector<int> leading = axes_of(axes);
    SkinOptions options;
    long long count = 1; // of which the library refuses what is too much
    for (int length : leading) count = std::min(count, 1LL << 31) * std::max(length, 0);
    options.count = int(std::min<long long>(count, INT_MAX));
    if (responses) {
        options.responses.clear();
        for (string_view name : items_of<string_view>(*responses, "responses", "texts"))
            options.responses.push_back(value_named<Quantity>("responses", name));
    }
    if (precision) options.precision = value_named<Precision>("precision", *precision, "\"f32\", \"f32-compensated\"");
    for (const Scene* s : items_of<const Scene*>(materials, "materials", "scenes"))
        options.materials.push_back(s->material);
    options.hold = value_named<Hold>("hold", hold);
    options.control = value_named<Control>("control", control);
    options.afferents = afferents ? afferents_in(*afferents) : scene.afferents;
    options.shear = shear;
    if (sa2_stretch) {
        const std::vector<double> n = numbers_in(*sa2_stretch, "sa2_stretch");
        if (n.size() != 2) scene::refuse("sa2_stretch", std::to_string(n.size()) + " numbers", "two numbers, x and y");
        options.sa2_stretch = {n[0], n[1]};
    }
    make_on(self, device_of(device), leading, scene, options);
}

std::string text_of(const SkinWithShapes& s) {
    std::string text = "<Skin ";
    for (int n : s.leading) text += std::to_string(n) + " x ";
    if (!s.leading.empty()) text.replace(text.size() - 2, 2, "pads of ");
    text += std::to_string(s.scene.grid.width) + " x " + std::to_string(s.scene.grid.height) + " cells,";
    for (Quantity q : responses_of(s)) text += std::string(" ") + name(q);
    return text + ", " + s.device.device().info().name + ">";
}

} // namespace

void write(Writer& writer, const SkinWithShapes& s) {
    const Computing computing(s.in_use.get());
    std::string state(s.skin->state_bytes(), '\0');
    s.skin->save(state.data(), state.size());
    write(writer, s.device);
    writer(s.leading, s.scene, s.options, s.time, state);
}

void make(SkinWithShapes* self, Reader& reader) {
    const SharedDevice device = device_in(reader);
    std::string state;
    std::vector<int> leading;
    Scene scene;
    SkinOptions options;
    std::vector<double> time;
    reader(leading, scene, options, time, state);
    make_on(self, device, leading, scene, options, state, time);
}

void bind_skin(nb::module_& m) {
    nb::class_<SkinWithShapes>(m, "Skin", "A skin, or a batch of them, pressed frame by frame.")
        .def(Pickled())
        .def("__init__", make_skin, nb::arg("scene"), nb::arg("count").none(), nb::arg("device").none(),
             nb::arg("responses").none(), nb::arg("precision").none(), nb::arg("materials"), nb::arg("hold"),
             nb::arg("control"), nb::arg("afferents").none(), nb::arg("shear"), nb::arg("sa2_stretch").none())
        .def(
            "press", press, nb::arg("pressure").none(), nb::arg("dt"), nb::arg("pads").none() = nb::none(),
            nb::arg("out").none() = nb::none(), nb::arg("traction").none() = nb::none(),
            nb::sig("def press(self, pressure: dermis._typing.AnyArray | Touch, dt: dermis._typing.Numbers, "
                    "pads: dermis._typing.Pads | None = None, out: dermis._typing.Outputs | None = None, "
                    "traction: dermis._typing.AnyArray | None = None) -> None"),
            "Press the skin: the pressure runs linearly from the last press to this one, over a step of dt seconds.\n\n"
            "pressure: float32 in C order, Pa, of shape (height, width), or (count, height, width) with a count;\n"
            "anything with DLPack or a buffer. Other types are refused, not converted. It is copied. With control\n"
            "\"depth\" it is in m. A contact.Touch gives the pressures of all its pads; pads at rest then take no "
            "time.\n"
            "dt: s, >= 0, or one for each pad that is pressed. 0 is a pause.\n"
            "pads: None is all; else numbers or a mask of count bools, and pressure has a map for each of them. With\n"
            "count = (E, P) they are named as an array a of that shape is indexed: (e, p) is one pad and e all of\n"
            "a[e]; a list of such tuples, an array with a row for each, or a mask of shape (E,) or (E, P) is some.\n"
            "Pressures and steps of their own have the shape of a[pads] and the axes of maps: (P, height, width) for "
            "e.\n"
            "out: float32 arrays by response, as in {\"sa1\": array} of the shape of skin[\"sa1\"], to be filled; one\n"
            "array for two responses is refused, and others are as by spike_counts.\n"
            "traction: Pa, of a skin with shear: pressures along x and along y, of shape (2, count, height, width).\n"
            "Other Python threads run meanwhile. Arrays of responses show the new values at once.\n"
            "What a signal's handler raises, as Ctrl-C does, ends a press within a second: of many frames, or of many\n"
            "steps of afferents. The skin then has the state after the last whole frame, and spikes up to it; no\n"
            "handler may press, change or save a skin in its press.\n"
            "A strain beyond 1, which skin does not have, is a RuntimeWarning, once. It is looked for ever more "
            "rarely:\n"
            "each time after a quarter more presses.")
        .def("press_frames", press_frames, nb::arg("pressure").none(), nb::arg("dt"),
             nb::arg("pads").none() = nb::none(), nb::arg("out").none() = nb::none(),
             nb::sig("def press_frames(self, pressure: dermis._typing.AnyArray, dt: float, "
                     "pads: dermis._typing.Pads | None = None, out: dermis._typing.Outputs | None = None) -> None"),
             "Press the skin with several frames, pressure[0], pressure[1] .., of dt seconds each.\n\n"
             "The same as a press of each, to the bit, in less time: only the responses of the last one are computed.\n"
             "All frames are checked before one is pressed. pads and out: as in press.")
        .def("press_cells", press_cells, nb::arg("pressure").none(), nb::arg("dt"), nb::arg("pads").none() = nb::none(),
             nb::sig("def press_cells(self, pressure: dermis._typing.AnyArray, dt: float, "
                     "pads: dermis._typing.Pads | None = None) -> None"),
             "Press the skin with the pressures of cells alone, float32, for each pad that is pressed.\n\n"
             "The same as press, to the bit, in a time that depends on these cells and not on the grid.")
        .def_prop_ro(
            "cells", [](const SkinWithShapes& s) { return s.skin->cells(); },
            "The cells whose pressure the skin needs, y*width + x: where there are sites, and neither a depth nor a\n"
            "stress that SA1 follows, the cells that the sites read; otherwise all cells.")
        .def("__getitem__", response,
             nb::sig("def __getitem__(self, response: dermis._typing.OfSkin) -> numpy.typing.NDArray[numpy.float32]"),
             nb::arg("response").none(),
             "The response \"sa1\", \"sa2\", \"fa1\" or \"fa2\" at the end of each pad's last press, 0 before the "
             "first.\n\n"
             "A view, float32 of shape (count, height, width), with sites (count, sites of that class); without a\n"
             "count the first axis is missing. The memory stays the same: after each press it holds the new values. "
             "\"strain\",\n"
             "\"indentation\" (m) and \"curvature\" (1/m) are read from the state each time they are asked for, with\n"
             "sites of all sites in the order given. So are, with shear, \"shear_x\", \"shear_y\",\n"
             "\"stretch_x\", \"stretch_y\" and \"stretch_xy\", the strain of the surface.")
        .def("_spike_bytes", spikes_of, "As spikes, in bytes.")
        .def("spike_counts", spike_counts, nb::arg("out").none() = nb::none(),
             nb::sig("def spike_counts(self, out: dermis._typing.AnyArray | None = None) -> typing.Any"),
             "Return how often each afferent of each pad fired in the last call that pressed, in all of its frames.\n\n"
             "An array of float32 of shape (count, len(fibres)); without a count the first axis is missing.\n"
             "out: a float32 array of this shape in C order, as a tensor of torch, to be filled; it is returned then. "
             "Any\n"
             "other one is refused, as one that cannot be written: no array of JAX can.")
        .def_prop_ro("fibres", fibres, nb::sig("def fibres(self) -> numpy.typing.NDArray[numpy.str_]"),
                     "The class of each afferent, or nerve fibre, of a pad, as \"sa1\", in an array by their numbers.")
        .def_prop_ro("time", time_of, nb::sig("def time(self) -> typing.Any"),
                     "How long each pad has been pressed, s, since it was made, reset or loaded: a copy, float64 of\n"
                     "shape (count,); without a count one number. States have no time; what copy and pickle make goes "
                     "on\nfrom it.")
        .def("reset", reset, nb::arg("pads").none() = nb::none(),
             nb::sig("def reset(self, pads: dermis._typing.Pads | None = None) -> None"),
             "Bring pads back to rest. pads: as in press.")
        .def("save", save, nb::arg("pads").none() = nb::none(), nb::arg("out").none() = nb::none(),
             nb::sig(
                 "def save(self, pads: dermis._typing.Pads | None = None, out: dermis._typing.AnyArray | None = None) "
                 "-> typing.Any"),
             "Return the state of pads as bytes, the same on every device. pads: as in press.\n\n"
             "out: a uint8 array with as many numbers, to be filled and returned; others are refused, as by "
             "spike_counts.")
        .def("load", load, nb::arg("state").none(), nb::arg("pads").none() = nb::none(),
             nb::sig("def load(self, state: dermis._typing.AnyArray, pads: dermis._typing.Pads | None = None) -> None"),
             "Take a state for the same number of pads of such a skin. state: bytes that save has returned. A number "
             "of an\nafferent that no press makes is refused.\n"
             "pads: as in press.")
        .def("_take_material", set_material, nb::arg("scene"), nb::arg("rows"), nb::arg("pads").none(),
             "As set_material, with the material of a scene, and a number for each pad by name.")
        .def(
            "report", report_of, nb::arg("pad").none() = nb::none(),
            nb::sig("def report(self, pad: dermis._typing.Pads | None = None) -> Report"),
            "Return the figures of a pad, with the ranges in which they are plausible. Takes up to as long as Skin().\n"
            "pad: its number, with count = (E, P) a tuple (e, p); None: the first.")
        .def_prop_ro(
            "count", [](const SkinWithShapes& s) { return s.skin->count(); }, "Pads.")
        .def_prop_ro(
            "scene",
            [](const SkinWithShapes& s) {
                const Computing computing(s.in_use.get()); // another thread may set the material
                return s.scene;
            },
            "The scene, with the present material; a skin that was made with materials has the scene's own there.")
        .def("__repr__", text_of);
}

} // namespace dermis::python
