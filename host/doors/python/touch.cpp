// SPDX-License-Identifier: MIT
// Contacts of a whole batch, from arrays that are read in place.
#include "host/doors/python/module.hpp"

namespace dermis::python {
namespace {

using contact::Contacts, contact::Pad, contact::Poses, contact::Touch;

// Numbers of pads or contacts: `count` groups, `step` numbers apart.
template <class Number> struct Column {
    std::optional<AnyArray> array; // keeps the numbers
    std::vector<Number> own;       // those that are no array of this type
    const Number* data = nullptr;
    size_t count = 0, step = 0, numbers = 0; // numbers: of a group
};

// Whether an array is empty, or its last axes have these lengths without gaps, and its other axes are as one.
bool has_groups(const AnyArray& array, const std::vector<size_t>& group) {
    const size_t inner = group.size(), outer = array.ndim() - std::min(array.ndim(), inner);
    if (array.ndim() < inner || array.size() == 0) return array.ndim() >= inner;
    int64_t next = 1;
    for (size_t axis = array.ndim(); axis-- > outer; next *= int64_t(array.shape(axis)))
        if (array.shape(axis) != group[axis - outer] || array.stride(axis) != next) return false;
    for (size_t axis = 0; axis + 1 < outer; ++axis)
        if (array.stride(axis) != array.stride(axis + 1) * int64_t(array.shape(axis + 1))) return false;
    return outer == 0 || array.stride(outer - 1) >= 0;
}

// NumPy's copy of numbers of these kinds, or of none, in C order and of another type, lists among them. Others stay.
nb::object converted(nb::handle argument, string_view kinds, const char* type) {
    try {
        if (is_masked(argument)) return nb::none();
        const nb::object numpy = nb::module_::import_("numpy"), array = numpy.attr("asarray")(argument);
        if (kinds.find(nb::cast<std::string>(array.attr("dtype").attr("kind"))) == kinds.npos && nb::len(array) != 0)
            return nb::borrow(argument);
        return numpy.attr("ascontiguousarray")(array, type);
    } catch (const nb::python_error&) {
        return nb::borrow(argument); // no array, or a ragged one: what takes it refuses it
    }
}

// A column of groups of numbers. groups: the shapes that a group may have.
Column<double> column_in(nb::handle argument, const char* parameter, const std::vector<std::vector<size_t>>& groups) {
    Column<double> column{.array = array_in(argument)};
    const auto fits = [&](const std::vector<size_t>& group) {
        return column.array && column.array->dtype() == nb::dtype<double>() && has_groups(*column.array, group);
    };
    if (std::ranges::none_of(groups, fits)) column.array = array_in(converted(argument, "fiu", "float64"));
    std::string allowed;
    for (const std::vector<size_t>& group : groups) {
        if (const auto& a = column.array; fits(group)) {
            const size_t outer = a->ndim() - group.size();
            column.numbers = 1;
            for (size_t n : group) column.numbers *= n;
            column.count = a->size() / column.numbers;
            column.step = outer == 0 ? column.numbers : size_t(a->stride(outer - 1));
            column.data = static_cast<const double*>(a->data());
            return column;
        }
        std::string text = "(...";
        for (size_t n : group) text += ", " + std::to_string(n);
        allowed += (allowed.empty() ? "" : " or ") + text + ")";
    }
    scene::refuse(parameter, description_of(argument), "numbers of shape " + allowed);
}

// One number for all contacts, or a column of them; nothing for None.
Column<double> sizes_in(nb::handle argument, const char* parameter) {
    Column<double> column;
    if (argument.is_none()) return column;
    double one = 0;
    if (!nb::try_cast(argument, one)) return column_in(argument, parameter, {{}});
    column.own = {one};
    column.data = column.own.data();
    return column;
}

void need_count(const char* parameter, size_t given, size_t needed, const char* each) {
    if (given != needed)
        scene::refuse(parameter, std::to_string(given) + " of them", std::to_string(needed) + ", one for each " + each);
}

// Whole numbers, as NumPy makes them: of 32 or of 64 bits.
Column<int32_t> pads_in(nb::handle argument, const char* parameter) {
    Column<int32_t> column{.array = array_in(argument)};
    const auto& a = column.array;
    const auto is = [&](nb::dlpack::dtype type) { return a && a->dtype() == type && has_groups(*a, {}); };
    const auto whole = [&] {
        return is(nb::dtype<int64_t>()) || is(nb::dtype<uint64_t>()) || is(nb::dtype<int32_t>());
    };
    if (!whole()) column.array = array_in(converted(converted(argument, "u", "uint64"), "i", "int64"));
    if (!whole()) scene::refuse(parameter, description_of(argument), "whole numbers");
    column.count = a->size();
    column.step = a->ndim() == 0 ? 1 : size_t(a->stride(a->ndim() - 1));
    if (is(nb::dtype<int32_t>())) {
        column.data = static_cast<const int32_t*>(a->data());
        return column;
    }
    column.own.reserve(column.count);
    const bool unsign = is(nb::dtype<uint64_t>());
    for (size_t i = 0; i < column.count; ++i) {
        const int64_t pad = static_cast<const int64_t*>(a->data())[i * column.step];
        if (int32_t(pad) != pad || (unsign && pad < 0))
            scene::refuse(parameter, unsign ? std::to_string(uint64_t(pad)) : std::to_string(pad),
                          "whole numbers of 32 bits");
        column.own.push_back(int32_t(pad));
    }
    column.data = column.own.data(), column.step = 1;
    return column;
}

// The shapes of bodies: the columns of dermis.contact.Shapes.
struct ShapeColumns {
    Column<int32_t> pad, body, kind;
    Column<double> size, position, rotation, faces;

    ShapeColumns() = default;
    explicit ShapeColumns(nb::handle given)
        : pad(pads_in(given.attr("pad"), "shapes.pad")), body(pads_in(given.attr("body"), "shapes.body")),
          kind(pads_in(given.attr("kind"), "shapes.kind")), size(column_in(given.attr("size"), "shapes.size", {{3}})),
          position(column_in(given.attr("position"), "shapes.position", {{3}})),
          rotation(column_in(given.attr("rotation"), "shapes.rotation", {{3, 3}, {9}})),
          faces(column_in(given.attr("faces"), "shapes.faces", {{4}})) {
        const std::pair<const char*, size_t> others[] = {{"shapes.body", body.count},
                                                         {"shapes.kind", kind.count},
                                                         {"shapes.size", size.count},
                                                         {"shapes.position", position.count},
                                                         {"shapes.rotation", rotation.count}};
        for (const auto& [name, count] : others) need_count(name, count, pad.count, "shape");
        if (faces.count > 1 && faces.step != 4) scene::refuse("shapes.faces", "a part of a table", "four columns");
    }
    contact::Shapes columns() const {
        return {.count = pad.count,
                .pad = pad.data,
                .body = body.data,
                .kind = kind.data,
                .size = size.data,
                .position = position.data,
                .rotation = rotation.data,
                .faces = faces.data,
                .face_count = faces.count,
                .pad_step = pad.step,
                .body_step = body.step,
                .kind_step = kind.step,
                .size_step = size.step,
                .position_step = position.step,
                .rotation_step = rotation.step};
    }
};

contact::ContactReport add_to_touch(SharedTouch& shared, nb::handle middle, nb::handle rotation, nb::handle pad,
                                    nb::handle position, nb::handle force, nb::handle radius, nb::handle ball,
                                    double modulus, nb::handle body, nb::handle shapes) {
    const Column<double> middles = column_in(middle, "middle", {{3}});
    const Column<double> axes = column_in(rotation, "rotation", {{3, 3}, {9}});
    const Column<int32_t> pads = pads_in(pad, "pad");
    Column<int32_t> bodies;
    if (!body.is_none()) bodies = pads_in(body, "body");
    const ShapeColumns listed = shapes.is_none() ? ShapeColumns() : ShapeColumns(shapes);
    const Column<double> places = column_in(position, "position", {{3}}),
                         forces = column_in(force, "force", {{3}, {6}});
    const Column<double> radii = sizes_in(radius, "radius"), balls = sizes_in(ball, "ball");
    if (radius.is_none() && ball.is_none() && body.is_none())
        scene::refuse("radius", "None", "m, of the patches; or ball and modulus; or body, with shapes");
    Touch& touch = shared.touch;
    need_count("middle", middles.count, size_t(touch.count()), "pad");
    need_count("rotation", axes.count, size_t(touch.count()), "pad");
    need_count("position", places.count, pads.count, "contact");
    need_count("force", forces.count, pads.count, "contact");
    if (radii.step) need_count("radius", radii.count, pads.count, "contact");
    if (balls.step) need_count("ball", balls.count, pads.count, "contact");
    if (bodies.data) need_count("body", bodies.count, pads.count, "contact");
    const Poses poses{middles.data, axes.data, middles.step, axes.step};
    const Computing computing(&shared.in_use);
    return touch.add(poses,
                     {.count = pads.count,
                      .pad = pads.data,
                      .position = places.data,
                      .force = forces.data,
                      .radius = radii.data,
                      .ball = balls.data,
                      .modulus = modulus,
                      .body = bodies.data,
                      .torque = forces.numbers == 6 ? forces.data + 3 : nullptr,
                      .pad_step = pads.step,
                      .position_step = places.step,
                      .force_step = forces.step,
                      .radius_step = radii.step,
                      .ball_step = balls.step,
                      .body_step = bodies.step,
                      .torque_step = forces.step},
                     listed.columns());
}

contact::ContactReport add_images(SharedTouch& shared, nb::handle depth, nb::handle force, bool gaps) {
    Touch& touch = shared.touch;
    const contact::Pad& pad = touch.shape();
    const size_t cells = size_t(pad.width) * size_t(pad.height);
    nb::ndarray<nb::ro, float, nb::c_contig, nb::device::cpu> images;
    const bool fits = nb::try_cast(readable(converted(depth, "fiu", "float32")), images, false) && images.ndim() >= 2 &&
                      images.shape(images.ndim() - 1) == size_t(pad.width) &&
                      images.shape(images.ndim() - 2) == size_t(pad.height);
    if (!fits || images.size() != size_t(touch.count()) * cells)
        scene::refuse("depth", description_of(depth),
                      "numbers of shape (.., " + std::to_string(pad.height) + ", " + std::to_string(pad.width) +
                          "), for " + std::to_string(touch.count()) + " pads");
    const Column<double> forces = column_in(force, "force", {{3}});
    need_count("force", forces.count, size_t(touch.count()), "pad");
    const Computing computing(&shared.in_use);
    return touch.add({.depth = images.data(), .force = forces.data, .gaps = gaps, .force_step = forces.step});
}

void make_touch(SharedTouch* self, int width, int height, double spacing, int count, double reach, double radius_x,
                double radius_y, bool tiled, bool shear, double stiffness, const Numbers& around, bool keep) {
    const Pad shape{.width = width,
                    .height = height,
                    .spacing = spacing,
                    .tiled = tiled,
                    .radius_x = radius_x,
                    .radius_y = radius_y,
                    .keep = keep};
    contact::Source source{.stiffness = stiffness};
    const std::vector<double> four = numbers_in(around, "around");
    if (four.size() != 4) scene::refuse("around", std::to_string(four.size()) + " numbers", "4 numbers, m");
    std::ranges::copy(four, source.around.begin());
    new (self) SharedTouch{.touch = Touch(shape, count, reach, shear, source)};
}

std::vector<size_t> shape_of_touch(const Touch& t) {
    return {size_t(t.count()), size_t(t.shape().height), size_t(t.shape().width)};
}

} // namespace

void bind_touch(nb::module_& m) {
    nb::class_<SharedTouch>(m, "Touch", "The pressures of a batch of pads, from contacts of all of them.")
        .def("__init__", make_touch, nb::arg("width"), nb::arg("height"), nb::arg("spacing"), nb::arg("count"),
             nb::arg("reach"), nb::arg("radius_x"), nb::arg("radius_y"), nb::arg("tiled"), nb::arg("shear"),
             nb::arg("stiffness"), nb::arg("around"), nb::arg("keep"))
        .def("add", add_to_touch, nb::arg("middle").none(), nb::arg("rotation").none(), nb::arg("pad").none(),
             nb::arg("position").none(), nb::arg("force").none(), nb::arg("radius").none() = nb::none(),
             nb::arg("ball").none() = nb::none(), nb::arg("modulus") = 0.0, nb::arg("body").none() = nb::none(),
             nb::arg("shapes").none() = nb::none(),
             nb::sig("def add(self, middle: dermis._typing.AnyArray, rotation: dermis._typing.AnyArray, "
                     "pad: dermis._typing.AnyArray, position: dermis._typing.AnyArray, force: dermis._typing.AnyArray, "
                     "radius: float | dermis._typing.AnyArray | None = None, "
                     "ball: float | dermis._typing.AnyArray | None = None, modulus: float = 0.0, "
                     "body: dermis._typing.AnyArray | None = None, shapes: dermis.contact.Shapes | None = None) "
                     "-> ContactReport"),
             "Take away what the last call added, add contacts, and return the report of all pads.\n\n"
             "Arrays of float64 are read in place, also columns of a table; other numbers and lists are converted.\n"
             "middle: m, the middle of each pad in the world, of shape (count, 3). rotation: its axes as columns, of\n"
             "shape (count, 3, 3) or (count, 9), as MuJoCo's site_xmat.\n"
             "pad: the pad that each contact presses, integers. position: m, in the world, (contacts, 3).\n"
             "force: N, in the world, (contacts, 3): the force on the pad; a force of 0 is no contact. (contacts, 6):\n"
             "and the moment on it, N m, of torsion and rolling friction; shapes press with it, patches do not.\n"
             "radius: m, of the patch, for each contact or one for all. None: Hertz's, by ball and modulus, but at\n"
             "least 2*spacing; this without ball. ball: m, 1/(1/R1 + 1/R2) of radii R1 and R2. modulus: Pa, as\n"
             "hertz_radius takes it. body: the body of each contact, from 0 on, or -1. shapes: what bodies look like.\n"
             "A body with shapes presses by them: contacts give force, centre, shear and torsion, shapes the profile.")
        .def(
            "add_depths", add_images, nb::arg("depth").none(), nb::arg("force").none(), nb::arg("gaps"),
            nb::sig(
                "def add_depths(self, depth: dermis._typing.AnyArray, force: dermis._typing.AnyArray, gaps: bool) -> "
                "ContactReport"),
            "Take away what the last call added, press each pad by a depth image, and return all pads' report.\n\n"
            "depth: m, of shape (.., height, width), one image for each pad; deeper is greater. float32 is read\n"
            "in place, other numbers and lists are converted.\n"
            "force: N, (.., 3), the force on each pad in its own frame, of which -z presses.\n"
            "gaps: whether a depth below 0 is a gap, as rays give it. False: images stop at 0 where nothing does so,\n"
            "as of tactile sensors; then a force that wants to press cells beside them counts in the report's clipped.")
        .def(
            "report",
            [](const SharedTouch& t, int pad) {
                const Computing computing(&t.in_use);
                return t.touch.report(pad);
            },
            nb::arg("pad"), "Return the report of one pad of the last add.")
        .def_prop_ro(
            "pressure",
            [](nb::handle_t<SharedTouch> self) {
                const Touch& t = nb::cast<const SharedTouch&>(self).touch;
                return view(t.pressure(), shape_of_touch(t), self);
            },
            "Pa: float32 of shape (count, height, width), always the same memory.")
        .def_prop_ro(
            "traction",
            [](nb::handle_t<SharedTouch> self) {
                const Touch& t = nb::cast<const SharedTouch&>(self).touch;
                std::vector<size_t> shape = shape_of_touch(t);
                shape.insert(shape.begin(), t.traction() ? 2 : 0);
                return view(t.traction(), shape, self);
            },
            "Pa: along x and y, float32 of shape (2, count, height, width); of shape (0, ..) without shear.")
        .def_prop_ro(
            "count", [](const SharedTouch& t) { return t.touch.count(); }, "Pads.")
        .def("__repr__", [](const SharedTouch& shared) {
            const Touch& t = shared.touch;
            return "<Touch " + std::to_string(t.count()) + " pads of " + std::to_string(t.shape().width) + " x " +
                   std::to_string(t.shape().height) + " cells>";
        });
}

} // namespace dermis::python
