// SPDX-License-Identifier: MIT
// Contacts to pressure, on an array of the caller's.
#include "dermis/contact.hpp"
#include "host/doors/python/pickle.hpp"

#include <climits>
#include <nanobind/stl/array.h>

namespace dermis::python {
namespace {

using contact::Contact, contact::ContactReport, contact::Pad, contact::Pose, contact::WorldContact;
using Vector = std::array<double, 3>;

// The stride of an axis, in numbers; `one` if the axis has a single place, because an array may then give any stride.
template <class Array> int64_t step_of(const Array& array, size_t axis, int64_t one) {
    return array.shape(axis) == 1 ? one : array.stride(axis);
}

// A pad with the array that it adds to.
struct PadOnArray {
    nb::ndarray<float, nb::ndim<2>, nb::device::cpu> pressure;
    double spacing;
    bool tiled;
    double radius_x, radius_y;
    Pad pad() const {
        return {.width = int(pressure.shape(1)),
                .height = int(pressure.shape(0)),
                .spacing = spacing,
                .pressure = pressure.data(),
                .pitch = size_t(step_of(pressure, 0, 0)),
                .tiled = tiled,
                .radius_x = radius_x,
                .radius_y = radius_y};
    }
};

// Whether the numbers of a row follow each other, and rows do not overlap.
template <class Array> bool has_rows(const Array& array) {
    const auto width = int64_t(array.shape(1));
    return array.size() == 0 || (step_of(array, 1, 1) == 1 && step_of(array, 0, width) >= width);
}

void make_pad(PadOnArray* self, nb::handle pressure, double spacing, bool tiled, double radius_x, double radius_y) {
    PadOnArray made{.pressure = {}, .spacing = spacing, .tiled = tiled, .radius_x = radius_x, .radius_y = radius_y};
    if (!nb::try_cast(readable(pressure, true), made.pressure, false) || !has_rows(made.pressure))
        scene::refuse("pressure", description_of(pressure),
                      "float32 array of shape (height, width) in Pa that can be written, its rows one after another");
    new (self) PadOnArray(std::move(made));
}

// Calls while other Python threads run.
template <class Call> auto unlocked(Call&& call) {
    const Computing computing(nullptr);
    return call();
}

ContactReport add_local(const PadOnArray& pad, const Sequence<Contact>& contacts) {
    const auto local = items_of<Contact>(contacts, "contacts", "a list of contact.Contact");
    return unlocked([&] { return add_contacts(pad.pad(), local); });
}

ContactReport add_in_world(const PadOnArray& pad, const Pose& pose, double reach,
                           const Sequence<WorldContact>& contacts) {
    const auto in_world = items_of<WorldContact>(contacts, "contacts", "a list of contact.WorldContact");
    return unlocked([&] { return add_contacts(pad.pad(), pose, reach, in_world); });
}

template <class Array> Array array_of(const Numbers& numbers, const char* parameter, const char* allowed) {
    Array array{};
    if (!nb::try_cast(numbers, array)) scene::refuse(parameter, description_of(numbers), allowed);
    return array;
}
Vector vector_of(const Numbers& numbers, const char* parameter) {
    return array_of<Vector>(numbers, parameter, "three numbers");
}

void make_world_contact(WorldContact* self, const Numbers& position, double force, double radius, double area,
                        const Numbers& direction) {
    new (self) WorldContact{.position = vector_of(position, "position"),
                            .force = force,
                            .radius = radius,
                            .area = area,
                            .direction = vector_of(direction, "direction")};
}

void make_pose(Pose* self, const Numbers& position, const Numbers& rotation) {
    Pose pose{.position = vector_of(position, "position")};
    std::array<Vector, 3> rows{};
    if (nb::try_cast(rotation, rows))
        for (size_t i = 0; i < 9; ++i) pose.rotation[i] = rows[i / 3][i % 3];
    else
        pose.rotation =
            array_of<decltype(pose.rotation)>(rotation, "rotation", "nine numbers, or an array of shape (3, 3)");
    new (self) Pose(pose);
}

ContactReport add_depths_of(const PadOnArray& pad, nb::handle depth, double force, double stiffness) {
    nb::ndarray<nb::ro, float, nb::ndim<2>, nb::device::cpu> array;
    const size_t height = pad.pressure.shape(0), width = pad.pressure.shape(1);
    if (!nb::try_cast(readable(depth), array, false) || !has_rows(array) || array.shape(0) != height ||
        array.shape(1) != width)
        scene::refuse("depth", description_of(depth),
                      "float32 array of shape " + shape_text({height, width}) + " in m, its rows one after another");
    const contact::DepthMap depths{
        .depth = array.data(), .force = force, .stiffness = stiffness, .pitch = size_t(step_of(array, 0, 0))};
    return unlocked([&] { return contact::add_depths(pad.pad(), depths); });
}

void make_body(contact::Body* self, string_view kind, const Numbers& size, const Numbers& position,
               const Numbers& rotation) {
    constexpr string_view kinds[] = {"sphere", "capsule", "box", "plane", "cylinder", "ellipsoid"};
    const auto named = std::ranges::find(kinds, kind);
    if (named == std::end(kinds))
        scene::refuse("kind", "\"" + std::string(kind) + "\"",
                      "\"sphere\", \"capsule\", \"box\", \"plane\", \"cylinder\", \"ellipsoid\"");
    contact::Body body{.kind = contact::Body::Kind(named - std::begin(kinds))};
    const std::vector<double> sizes = numbers_in(size, "size");
    if (sizes.size() > 3) scene::refuse("size", std::to_string(sizes.size()) + " numbers", "at most three numbers");
    std::ranges::copy(sizes, body.size.begin());
    make_pose(&body.pose, position, rotation);
    new (self) contact::Body(body);
}

// Fills an array of the pad's shape.
nb::object fill_depths(const PadOnArray& pad, const Pose& pose, const contact::Body& body) {
    const size_t height = pad.pressure.shape(0), width = pad.pressure.shape(1);
    auto* depth = new float[height * width];
    const nb::capsule owner(depth, [](void* p) noexcept { delete[] static_cast<float*>(p); });
    unlocked([&] { contact::fill_depths(pad.pad(), pose, body, depth); });
    const size_t shape[] = {height, width};
    return nb::cast(nb::ndarray<nb::numpy, float>(depth, 2, shape, owner));
}

// Taxels may lie in memory in any order, as a transposed array does, but forward.
ContactReport add_taxels_of(const PadOnArray& pad, nb::handle values, double width, double height, double x, double y,
                            string_view unit) {
    nb::ndarray<nb::ro, float, nb::ndim<2>, nb::device::cpu> array;
    if (!nb::try_cast(readable(values), array, false) ||
        (array.size() > 0 && (step_of(array, 0, 1) < 1 || step_of(array, 1, 1) < 1)) || array.shape(0) > INT_MAX ||
        array.shape(1) > INT_MAX)
        scene::refuse("values", description_of(values), "float32 array of shape (rows, columns), of positive strides");
    if (unit != "newton" && unit != "pascal")
        scene::refuse("unit", "\"" + std::string(unit) + "\"", "\"newton\", \"pascal\"");
    const contact::TaxelReadings taxels{.unit = unit == "newton" ? contact::TaxelReadings::Unit::newton
                                                                 : contact::TaxelReadings::Unit::pascal,
                                        .values = array.data(),
                                        .columns = int(array.shape(1)),
                                        .rows = int(array.shape(0)),
                                        .width = width,
                                        .height = height,
                                        .x = x,
                                        .y = y,
                                        .column_step = size_t(step_of(array, 1, 1)),
                                        .row_step = size_t(step_of(array, 0, 1))};
    return unlocked([&] { return contact::add_taxels(pad.pad(), taxels); });
}

template <class Struct> void bind_patch(nb::class_<Struct>& type) {
    type.def_rw("force", &Struct::force, "N, >= 0")
        .def_rw("radius", &Struct::radius, "m, >= 0")
        .def_rw("area", &Struct::area, "m^2, >= 0, in place of the radius");
}

void bind_contacts(nb::module_& m) {
    nb::class_<Contact> local(m, "Contact", "A force on a round patch, in the pad's frame.");
    local.def(Pickled())
        .def(
            "__init__",
            [](Contact* self, double x, double y, double force, double radius, double area) {
                new (self) Contact{.x = x, .y = y, .force = force, .radius = radius, .area = area};
            },
            nb::arg("x"), nb::arg("y"), nb::arg("force"), nb::arg("radius") = 0.0, nb::arg("area") = 0.0)
        .def_rw("x", &Contact::x, "m, along a row, from the outer corner of cell [0, 0]")
        .def_rw("y", &Contact::y, "m, from row to row");
    bind_patch(local);
    nb::class_<WorldContact> world(m, "WorldContact", "A force on a round patch, in the world.");
    world.def(Pickled())
        .def("__init__", make_world_contact, nb::arg("position"), nb::arg("force"), nb::arg("radius") = 0.0,
             nb::arg("area") = 0.0, nb::arg("direction") = nb::make_tuple(0.0, 0.0, 0.0))
        .def_rw("position", &WorldContact::position, "m")
        .def_rw("direction", &WorldContact::direction, "where the force pushes the pad; 0: straight into it");
    bind_patch(world);
}

void bind_pad(nb::module_& m) {
    nb::class_<PadOnArray> pad(m, "Pad", "A grid of cells on an array of the caller's.");
    pad.def("__repr__",
            [](const PadOnArray& p) {
                return "<Pad " + std::to_string(p.pressure.shape(1)) + " x " + std::to_string(p.pressure.shape(0)) +
                       " cells of " + shortest(p.spacing) + " m>";
            })
        .def(
            "__init__", make_pad, nb::arg("pressure"), nb::arg("spacing"), nb::arg("tiled") = false,
            nb::arg("radius_x") = 0.0, nb::arg("radius_y") = 0.0,
            nb::sig("def __init__(self, pressure: dermis._typing.AnyArray, spacing: float, tiled: bool = False, "
                    "radius_x: float = 0.0, radius_y: float = 0.0) -> None"),
            "pressure: float32 of shape (height, width), Pa, which is added to in place. spacing: m between cells.\n"
            "tiled: whether pads side by side share patches; what lies beyond the border is then the neighbours' own.\n"
            "radius_x, radius_y: m, of the surface along x and y at the pad's middle; 0: straight in that direction.");
    nb::class_<Pose>(m, "Pose", "Where a pad is: world = position + rotation*local.")
        .def(Pickled())
        .def("__init__", make_pose, nb::arg("position") = nb::make_tuple(0.0, 0.0, 0.0),
             nb::arg("rotation") = nb::make_tuple(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
        .def_static(
            "from_quaternion",
            [](const Numbers& position, const Numbers& quaternion) {
                const Vector at = vector_of(position, "position");
                const auto q = array_of<std::array<double, 4>>(quaternion, "quaternion", "four numbers");
                return Pose::from_quaternion(at.data(), q.data());
            },
            nb::arg("position"), nb::arg("quaternion"), nb::call_guard<DefaultFloats>(),
            "position: m; quaternion: w, x, y, z.")
        .def(
            "from_middle", [](const Pose& pose, const PadOnArray& pad) { return pose.from_middle(pad.pad()); },
            nb::arg("pad"), nb::call_guard<DefaultFloats>(),
            "Return this frame, moved from the middle of the pad to the outer corner of cell [0, 0].")
        .def_rw("position", &Pose::position, "m, the outer corner of cell [0, 0]")
        .def_rw("rotation", &Pose::rotation, "Nine numbers, row by row; columns are the pad's axes in the world.");
}

void bind_contact_report(nb::module_& m) {
    nb::class_<ContactReport>(m, "ContactReport",
                              "What became of the forces: asked = placed + outside + sideways, up to rounding.")
        .def(Pickled())
        .def_ro("asked", &ContactReport::asked, "N: the forces given.")
        .def_ro("placed", &ContactReport::placed, "N: the part that presses cells, measured in the array.")
        .def_ro("outside", &ContactReport::outside,
                "N: the part beside the pad, too far, turned away, or of depths that nowhere exceed 0.")
        .def_ro("sideways", &ContactReport::sideways,
                "N: of forces at an angle to the pad, the force less its component into it.")
        .def_ro("shear", &ContactReport::shear,
                "N: of contacts in the world that press the pad, their forces along its x and y.")
        .def_ro("greatest", &ContactReport::greatest, "Greatest pressure of the cells pressed, Pa.")
        .def_ro("cells", &ContactReport::cells, "Cells that are pressed now and were not before.")
        .def_ro("below_cell", &ContactReport::below_cell, "Patches that press a single cell.")
        .def_ro("beside", &ContactReport::beside)
        .def_ro("too_far", &ContactReport::too_far)
        .def_ro("turned_away", &ContactReport::turned_away)
        .def_ro("level", &ContactReport::level, "m: of add_depths with a stiffness.")
        .def_ro("by_body", &ContactReport::by_body, "Bodies that press by their shapes.")
        .def_ro("by_patch", &ContactReport::by_patch, "Contacts of a body that is below no cell: pressed by a patch.")
        .def_ro("tilted", &ContactReport::tilted, "Bodies whose centre of pressure cannot be their contacts'.")
        .def_ro("centre_off", &ContactReport::centre_off, "m: the greatest distance between the two.")
        .def_ro("clipped", &ContactReport::clipped, "Depth images that stop at 0 where the force wants to press too.")
        .def_prop_ro("plausible", &ContactReport::plausible,
                     "Whether at least 0.5 of the force is placed, at most 0.1 outside, and no pressure is doubtful.")
        .def_prop_ro("doubts", &ContactReport::doubts, nb::call_guard<DefaultFloats>(),
                     "Sentences that say why not; empty if plausible.");
}

} // namespace

void bind_contact(nb::module_& m) {
    bind_contact_report(m);
    bind_contacts(m);
    bind_pad(m);
    m.def("add_contacts", add_local, nb::arg("pad"), nb::arg("contacts"),
          "Add forces on round patches to the pad's pressure, in the pad's frame.");
    m.def("add_contacts", add_in_world, nb::arg("pad"), nb::arg("pose"), nb::arg("reach"), nb::arg("contacts"),
          "The same in the world, of contacts at most reach metres from the pad's plane.");
    nb::class_<contact::Body>(m, "Body", "A rigid body in the world.")
        .def("__init__", make_body, nb::arg("kind"), nb::arg("size") = nb::make_tuple(),
             nb::arg("position") = nb::make_tuple(0.0, 0.0, 0.0),
             nb::arg("rotation") = nb::make_tuple(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
             nb::sig("def __init__(self, kind: dermis._typing.BodyKind, "
                     "size: collections.abc.Sequence[float] | numpy.typing.NDArray[numpy.floating] = (), "
                     "position: collections.abc.Sequence[float] | numpy.typing.NDArray[numpy.floating] = (0, 0, 0), "
                     "rotation: collections.abc.Sequence[float] | numpy.typing.NDArray[numpy.floating] = "
                     "(1, 0, 0, 0, 1, 0, 0, 0, 1)) -> None"),
             "kind: \"sphere\", \"capsule\", \"cylinder\", both along z, \"box\", \"ellipsoid\" or \"plane\",\n"
             "which is all below z = 0 of its frame.\n"
             "size: m: the radius of a sphere; radius and half the length of a capsule or a cylinder; half the length "
             "along x, y and z of a box or an ellipsoid; none of a plane.\n"
             "position: m, its middle; of a plane any point of it. rotation: its axes as columns, as of a Pose.");
    m.def("fill_depths", fill_depths, nb::arg("pad"), nb::arg("pose"), nb::arg("body"),
          nb::sig("def fill_depths(pad: Pad, pose: Pose, body: Body) -> numpy.typing.NDArray[numpy.float32]"),
          "Return how deep a body reaches below each cell, along the surface's normal: float32 of the pad's shape, m.\n"
          "A gap is negative, and -1e6 where no part of the body is above or below the cell.");
    m.def("add_depths", add_depths_of, nb::arg("pad"), nb::arg("depth").none(), nb::arg("force"),
          nb::arg("stiffness") = 0.0,
          nb::sig("def add_depths(pad: Pad, depth: dermis._typing.AnyArray, force: float, stiffness: float = 0.0) -> "
                  "ContactReport"),
          "Add a force where depth > 0, in proportion to it. depth: float32 of the pad's shape, m.\n"
          "force: N; stiffness: Pa per m, with which a level is sought that makes the sum the force.");
    m.def("add_taxels", add_taxels_of, nb::arg("pad"), nb::arg("values").none(), nb::kw_only(), nb::arg("width"),
          nb::arg("height"), nb::arg("x") = 0.0, nb::arg("y") = 0.0, nb::arg("unit") = "newton",
          nb::sig("def add_taxels(pad: Pad, values: dermis._typing.AnyArray, *, width: float, height: float, "
                  "x: float = 0.0, y: float = 0.0, unit: dermis._typing.TaxelUnit = \"newton\") -> ContactReport"),
          "Add each reading of a sensor array to the cells below it, by the area that they share; forces are kept.\n"
          "values: float32 of shape (rows, columns), columns along x, >= 0, of a unit \"newton\" or \"pascal\";\n"
          "readings that stand column by column are values.T. width, height: m, of one taxel.\n"
          "x, y: m, outer corner of the first.");
    const auto add_of_ball = [&](const char* name, double (*of)(double, double, double), const char* doc) {
        const auto call = [of](double force, double ball, double modulus) {
            return unlocked([&] { return of(force, ball, modulus); });
        };
        m.def(name, call, nb::arg("force"), nb::arg("ball"), nb::arg("modulus"), doc);
    };
    add_of_ball(
        "foundation_stiffness", contact::foundation_stiffness,
        "Return the stiffness, Pa per m, with which add_depths presses a ball's patch with the radius of Hertz's.");
    add_of_ball("hertz_radius", contact::hertz_radius,
                "Return the radius in m of the patch of a rigid ball. force: N; ball: its radius, m; modulus: Pa.");
    m.def(
        "skin_stiffness", [](const Scene& scene) { return contact::skin_stiffness(scene.material); }, nb::arg("scene"),
        "Return the stiffness of a skin that is held long, Pa per m: the modulus at which its material comes to rest,\n"
        "over the thickness; 0 where it flows, has moduli by cells, or no thickness.");
    m.def(
        "strain_below_punch",
        [](double indentation, double depth, double radius, double poisson) {
            return unlocked([&] { return contact::strain_below_punch(indentation, depth, radius, poisson); });
        },
        nb::arg("indentation"), nb::arg("depth"), nb::arg("radius"), nb::arg("poisson") = 0.4,
        "Return the stress over the modulus at a depth below a flat punch's middle: what an afferent feels there.\n"
        "indentation, depth, radius: m; poisson: Poisson's ratio of the half-space, 0..0.5.");
}

} // namespace dermis::python
