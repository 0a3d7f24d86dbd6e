// SPDX-License-Identifier: MIT
// Skins pressed frame by frame: arrays in, views out.
#include "host/doors/python/module.hpp"

namespace dermis::python {
namespace {

// A skin, and the shapes that its arrays have.
struct SkinWithShapes {
    std::shared_ptr<std::mutex> in_use; // one thread at a time may use a skin
    bool batch;                         // whether arrays have an axis of pads
    std::vector<size_t> map;            // height, width
    std::vector<Site> sites;
    std::optional<Skin> skin; // never empty before the destructor, which uses a Vulkan device too

    ~SkinWithShapes() {
        const Computing computing(in_use.get());
        skin.reset();
    }
};

// The numbers of the pads that an argument names. None: all pads. A list or an array of integers: these numbers. An
// array of bools, one for each pad: the pads where it is true.
class PadNumbers {
  public:
    PadNumbers(nb::handle argument, int count) {
        if (argument.is_none()) return;
        all_ = false;
        const std::optional<AnyArray> array = array_in(argument);
        if (array ? !take(*array, count) : !take(argument))
            scene::refuse("pads", description_of(argument),
                          "integers, or an array of " + std::to_string(count) + " bools, one for each pad");
    }
    Pads pads() const { return all_ ? Pads() : Pads(numbers_); }
    size_t count(size_t all) const { return all_ ? all : numbers_.size(); }

  private:
    bool take(const AnyArray& array, int count) {
        if (array.ndim() != 1) return false;
        if (array.dtype() == nb::dtype<bool>()) return array.shape(0) == size_t(count) && take_mask(array);
        if (array.size() == 0) return true; // even of doubles: what NumPy makes of an empty list
        return take_as_one_of<int64_t, int32_t, int16_t, int8_t, uint64_t, uint32_t, uint16_t, uint8_t>(array);
    }
    template <class... Integers> bool take_as_one_of(const AnyArray& array) {
        return (take_as<Integers>(array) || ...);
    }
    bool take_mask(const AnyArray& array) {
        const auto mask = array.view<const bool, nb::ndim<1>>();
        for (size_t i = 0; i < mask.shape(0); ++i)
            if (mask(i)) numbers_.push_back(int(i));
        return true;
    }
    template <class Integer> bool take_as(const AnyArray& array) {
        if (array.dtype() != nb::dtype<Integer>()) return false;
        const auto numbers = array.view<const Integer, nb::ndim<1>>();
        for (size_t i = 0; i < numbers.shape(0); ++i) numbers_.push_back(pad((long long)(numbers(i))));
        return true;
    }
    // A bool is an integer in Python, but a list of them is meant as a mask.
    bool take(nb::handle argument) {
        if (!PySequence_Check(argument.ptr())) return false;
        for (nb::handle item : nb::borrow<nb::sequence>(argument)) {
            long long number = 0;
            if (PyBool_Check(item.ptr()) || !nb::try_cast(item, number)) return false;
            numbers_.push_back(pad(number));
        }
        return true;
    }
    static int pad(long long number) {
        if (int(number) != number) scene::refuse("pads", std::to_string(number), "numbers of pads, from 0 on");
        return int(number);
    }

    bool all_ = true;
    std::vector<int> numbers_;
};

// The step of a press, or one for each pad.
std::vector<double> steps_in(nb::handle dt) {
    const char* allowed = "seconds, or an array of them, one for each pad";
    if (!PySequence_Check(dt.ptr())) scene::refuse("dt", description_of(dt), allowed);
    return items_of<double>(nb::borrow<nb::sequence>(dt), "dt", allowed);
}

bool is_dense(const AnyArray& array) {
    if (array.size() == 0) return true;
    int64_t expected = 1;
    for (size_t i = array.ndim(); i-- > 0; expected *= int64_t(array.shape(i)))
        if (array.shape(i) != 1 && array.stride(i) != expected) return false;
    return true;
}

std::vector<size_t> shape_of(const SkinWithShapes& s, size_t pads) {
    std::vector<size_t> shape = s.map;
    if (s.batch) shape.insert(shape.begin(), pads);
    return shape;
}

// Whether an array of pressures has the shape of `pads` pads, or is one row of all their numbers.
bool fits(const AnyArray& array, const SkinWithShapes& s, size_t pads) {
    if (array.ndim() == 1) return array.shape(0) == pads * s.map[0] * s.map[1];
    const size_t own = s.batch ? 3 : 2;
    return array.ndim() == own && array.shape(own - 2) == s.map[0] && array.shape(own - 1) == s.map[1] &&
           (!s.batch || array.shape(0) == pads);
}

// Returns the numbers as they stand in memory: nothing is converted.
AnyArray pressure_in(const SkinWithShapes& s, nb::handle argument, size_t pads) {
    std::optional<AnyArray> array = array_in(argument);
    if (!array || array->dtype() != nb::dtype<float>() || !is_dense(*array) || !fits(*array, s, pads)) {
        const bool strided = array && array->dtype() == nb::dtype<float>() && !is_dense(*array);
        scene::refuse("pressure", (strided ? "strided " : "") + description_of(argument),
                      "float32 array in C order, of shape " + shape_text(shape_of(s, pads)) + " in Pa");
    }
    return std::move(*array);
}

void press(SkinWithShapes& s, nb::handle pressure, nb::handle dt, nb::handle pads) {
    const PadNumbers numbers(pads, s.skin->count());
    const AnyArray array = pressure_in(s, pressure, numbers.count(size_t(s.skin->count())));
    const auto* data = static_cast<const float*>(array.data());
    if (double step = 0; nb::try_cast(dt, step)) {
        const Computing computing(s.in_use.get());
        return s.skin->press(data, array.size(), step, numbers.pads());
    }
    const std::vector<double> steps = steps_in(dt);
    const Computing computing(s.in_use.get());
    s.skin->press(data, array.size(), steps.data(), steps.size(), numbers.pads());
}

Skin::Response response_of(const SkinWithShapes& s, Quantity quantity) {
    const Computing computing(s.in_use.get());
    return s.skin->response(quantity);
}

View<float> response(nb::handle_t<SkinWithShapes> self, string_view quantity) {
    const SkinWithShapes& s = nb::cast<const SkinWithShapes&>(self);
    const Skin::Response response = response_of(s, value_named<Quantity>("response", quantity));
    const size_t pads = size_t(s.skin->count());
    std::vector<size_t> shape = shape_of(s, pads);
    if (!s.sites.empty()) {
        shape.resize(s.batch ? 1 : 0);
        shape.push_back(response.size / pads);
    }
    return view(response.data, shape, self);
}

nb::bytes save(const SkinWithShapes& s, nb::handle pads) {
    const PadNumbers numbers(pads, s.skin->count());
    size_t size = 0;
    {
        const Computing computing(s.in_use.get());
        size = s.skin->state_bytes(numbers.pads());
    }
    nb::object bytes = nb::steal(PyBytes_FromStringAndSize(nullptr, Py_ssize_t(size)));
    if (!bytes.is_valid()) nb::raise_python_error();
    char* state = PyBytes_AsString(bytes.ptr());
    {
        const Computing computing(s.in_use.get());
        s.skin->save(state, size, numbers.pads());
    }
    return nb::borrow<nb::bytes>(bytes);
}

// The bytes of a buffer, which stays as it is meanwhile.
class Buffer {
  public:
    explicit Buffer(nb::handle argument) {
        if (PyObject_GetBuffer(argument.ptr(), &buffer_, PyBUF_C_CONTIGUOUS) == 0) return;
        PyErr_Clear();
        scene::refuse("state", description_of(argument), "bytes, as Skin.save has returned them");
    }
    ~Buffer() { PyBuffer_Release(&buffer_); }
    Buffer(const Buffer&) = delete;
    const void* data() const { return buffer_.buf; }
    size_t size() const { return size_t(buffer_.len); }

  private:
    Py_buffer buffer_;
};

void load(SkinWithShapes& s, nb::handle state, nb::handle pads) {
    const PadNumbers numbers(pads, s.skin->count());
    const Buffer buffer(state);
    const Computing computing(s.in_use.get());
    s.skin->load(buffer.data(), buffer.size(), numbers.pads());
}

void reset(SkinWithShapes& s, nb::handle pads) {
    const PadNumbers numbers(pads, s.skin->count());
    const Computing computing(s.in_use.get());
    s.skin->reset(numbers.pads());
}

void set_material(SkinWithShapes& s, const Scene& scene, nb::handle pads) {
    const PadNumbers numbers(pads, s.skin->count());
    const Computing computing(s.in_use.get());
    s.skin->set_material(scene.material, numbers.pads());
}

Report report_of(const SkinWithShapes& s, int pad) {
    const Computing computing(s.in_use.get());
    return s.skin->report(pad);
}

void make(SkinWithShapes* self, const Scene& scene, std::optional<int> n, nb::handle device,
          const std::optional<Sequence<nb::str>>& responses, const std::optional<string_view>& precision,
          const Sequence<Scene>& materials) {
    SkinOptions options;
    options.count = n.value_or(1);
    if (responses) {
        options.responses.clear();
        for (string_view name : items_of<string_view>(*responses, "responses", "texts"))
            options.responses.push_back(value_named<Quantity>("responses", name));
    }
    if (precision) options.precision = value_named<Precision>("precision", *precision);
    for (const Scene* s : items_of<const Scene*>(materials, "materials", "scenes"))
        options.materials.push_back(s->material);
    const SharedDevice on = device_of(device);
    const std::shared_ptr<std::mutex> in_use = on.in_use ? on.in_use : std::make_shared<std::mutex>();
    const Computing computing(in_use.get());
    new (self) SkinWithShapes{.in_use = in_use,
                              .batch = n.has_value(),
                              .map = {size_t(scene.grid.height), size_t(scene.grid.width)},
                              .sites = scene.sites,
                              .skin = Skin(on.device, scene, options)};
}

} // namespace

void bind_skin(nb::module_& m) {
    nb::class_<SkinWithShapes>(m, "Skin", "A skin, or a batch of them, pressed frame by frame.")
        .def("__init__", make, nb::arg("scene"), nb::arg("n").none(), nb::arg("device").none(),
             nb::arg("responses").none(), nb::arg("precision").none(), nb::arg("materials"))
        .def(
            "press", press, nb::arg("pressure").none(), nb::arg("dt").none(), nb::arg("pads").none() = nb::none(),
            "Press the skin: the pressure runs linearly from the last press to this one, over a step of dt seconds.\n\n"
            "pressure: float32 in C order, Pa, of shape (height, width), or (n, height, width) with n; anything\n"
            "with DLPack or a buffer. Other types are refused, not converted. It is copied.\n"
            "dt: s, >= 0, or one for each pad that is pressed. 0 is a pause.\n"
            "pads: None is all; else numbers or a mask of (n,) bools, and pressure has a map for each of them.\n"
            "Other Python threads run meanwhile. Arrays of responses show the new values at once.")
        .def("__getitem__", response, nb::arg("response"),
             "The response \"sa1\", \"sa2\", \"fa1\" or \"fa2\" at the end of each pad's last press, 0 before the "
             "first.\n\n"
             "A view, float32 of shape (n, height, width), with sites (n, sites of that class); without n the first\n"
             "axis is missing. The memory stays the same: after each press it holds the new values. \"strain\",\n"
             "\"indentation\" (m) and \"curvature\" (1/m) are read from the state each time they are asked for, with\n"
             "sites of all sites in the order given.")
        .def("reset", reset, nb::arg("pads").none() = nb::none(), "Bring pads back to rest. pads: as in press.")
        .def("save", save, nb::arg("pads").none() = nb::none(),
             "Return the state of pads as bytes, the same on every device. pads: as in press.")
        .def("load", load, nb::arg("state").none(), nb::arg("pads").none() = nb::none(),
             "Take a state that save has returned for the same number of pads of such a skin. pads: as in press.")
        .def("take_material", set_material, nb::arg("scene"), nb::arg("pads").none(),
             "As set_material, with the material of a scene.")
        .def("report", report_of, nb::arg("pad") = 0,
             "Return the figures of a pad, with the ranges in which they are plausible. Takes up to as long as Skin().")
        .def_prop_ro(
            "count", [](const SkinWithShapes& s) { return s.skin->count(); }, "Pads.");
}

} // namespace dermis::python
