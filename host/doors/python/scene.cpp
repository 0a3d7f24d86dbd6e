// SPDX-License-Identifier: MIT
// Scenes from texts, files, and maps and sites in memory.
#include "host/lab/scenes/scene.hpp"
#include "host/doors/python/pickle.hpp"
#include "host/lab/scenes/key_rows.hpp"
#include "host/lab/scenes/units.hpp"
#include "host/lab/scenes/write_rows.hpp"

#include <nanobind/stl/array.h>

namespace dermis::python {
namespace {

using MapArray = nb::ndarray<nb::ro, double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using NamedSite = std::tuple<const char*, int, int>; // type, x, y
using NamedMaps = nb::typed<nb::dict, nb::str, MapArray>;
using Fibres = Sequence<Afferents>;

// The text is one that the package made: its lines mean nothing to a user.
Scene scene_of(string_view text, const NamedMaps& named, const std::optional<Fibres>& fibres,
               const std::vector<std::string>& overrides) {
    scene::NamedMaps maps;
    for (const auto [name, array] : named) {
        const auto map = nb::cast<MapArray>(array);
        maps.emplace(nb::cast<string_view>(name),
                     scene::FileMap{.values = std::vector<double>(map.data(), map.data() + map.size()),
                                    .width = int(map.shape(1)),
                                    .height = int(map.shape(0))});
    }
    try {
        return scene::read_scene(scene::text_of_string(std::string(text), ""), overrides, maps, nullptr,
                                 [&](Scene& scene) {
                                     if (fibres) scene.afferents = afferents_in(*fibres);
                                 })
            .scene;
    } catch (const Error& e) {
        const std::string what = e.what(), place = what.substr(0, what.find(": "));
        throw Error(e.code(), e.parameter(),
                    place == "scene" || place.starts_with("scene:") ? what.substr(place.size() + 2) : what);
    }
}

std::vector<NamedSite> sites_of(const Scene& scene) {
    std::vector<NamedSite> named;
    for (const Site& site : scene.sites) named.emplace_back(name(site.type), site.cell.x, site.cell.y);
    return named;
}

// Tables of a scene as Python's objects. Maps are views of numbers that live as long as the view.
struct ObjectSink {
    using Value = nb::object;
    template <class T> Value value(const T& x) { return nb::cast(x); }
    Value value(const std::string& text) { // maybe a path
        return nb::steal(PyUnicode_DecodeFSDefaultAndSize(text.data(), Py_ssize_t(text.size())));
    }
    Value list(const std::vector<Value>& items) {
        nb::list all;
        for (const Value& item : items) all.append(item);
        return all;
    }
    template <class T> Value table(const T& of, const scene::Pairs<ObjectSink>& pairs) {
        if constexpr (std::is_same_v<T, KelvinVoigt>)
            if (of.modulus_map.empty() && of.viscosity_map.empty()) return nb::cast(of);
        return dict_of(pairs);
    }
    Value map(const std::string&, const Map& map, int width, int height) {
        const nb::capsule owner(new Map(map), [](void* p) noexcept { delete static_cast<Map*>(p); });
        return nb::cast(view(map.data(), {size_t(height), size_t(width)}, owner));
    }
    static nb::dict dict_of(const scene::Pairs<ObjectSink>& pairs) {
        nb::dict dict;
        for (const auto& [key, value] : pairs) dict[key.c_str()] = value;
        return dict;
    }
};

// The tables of a scene that Python has as objects, but sites and afferents, which it has as lists.
constexpr const char* tables[] = {"grid", "surface", "material", "load", "time", "curvature", "receptors", "output"};

// Returns a table as its class in the package, which has the table's name as a title; of several loads a list.
nb::object table_of(const Scene& scene, const std::string& name) {
    std::string title = name;
    title[0] = char(title[0] - 'a' + 'A');
    const nb::object made = nb::module_::import_("dermis._tables").attr(title.c_str());
    nb::list all;
    ObjectSink sink;
    for (const auto& [table, pairs] : scene::tables_of(sink, scene))
        if (table == name) all.append(made(**ObjectSink::dict_of(pairs)));
    return all.size() == 1 ? nb::object(all[0]) : all;
}

std::string toml_of(const Scene& scene, nb::handle folder) {
    const auto& [text, maps] = scene::written(scene);
    ObjectSink sink;
    for (const auto& [name, map] : maps) {
        if (folder.is_none())
            scene::refuse(name.substr(0, name.rfind('.')), "a map in memory",
                          "in a text: the name of a file; to_toml(folder) writes each map into a folder");
        const nb::object path = nb::module_::import_("os.path").attr("join")(folder, name.c_str());
        nb::module_::import_("numpy").attr("save")(path, sink.map(name, map.values, map.width, map.height));
    }
    return text;
}

// A scene that means the same in another folder and in another process, which both need the file of a sequence.
Scene movable(Scene scene) {
    if (!scene.load.path.empty()) scene.load.path = std::filesystem::absolute(scene.load.path).string();
    return scene;
}

// Bytes, because a path need not be UTF-8.
std::string path_of(const nb::bytes& path) { return {path.c_str(), path.size()}; }

std::vector<std::string> texts_in(const Sequence<nb::str>& overrides) {
    const auto views = items_of<string_view>(overrides, "overrides", "texts");
    return {views.begin(), views.end()};
}

} // namespace

void bind_scene(nb::module_& m) {
    scene::old_word_found = [](const char* sentence) {
        const nb::gil_scoped_acquire lock;
        if (PyErr_WarnEx(PyExc_FutureWarning, sentence, 1) != 0) nb::raise_python_error();
    };
    nb::class_<Scene> type(m, "Scene", "A checked scene.");
    const auto bytes_of = [](const Scene& scene) {
        Writer writer;
        writer(scene);
        return writer.bytes();
    };
    type.def(Pickled())
        .def(
            "__eq__", [=](const Scene& a, const Scene& b) { return bytes_of(a) == bytes_of(b); }, nb::is_operator(),
            nb::sig("def __eq__(self, other: object, /) -> bool"))
        .def("__hash__", [=](const Scene& scene) { return std::hash<std::string>()(bytes_of(scene)); })
        .def(
            "__init__",
            [](Scene* self, string_view text, const nb::bytes& folder, const Sequence<nb::str>& overrides) {
                new (self) Scene(movable(Scene::from_string(std::string(text), texts_in(overrides), path_of(folder))));
            },
            nb::arg("text"), nb::arg("folder"), nb::arg("overrides"))
        .def(
            "__init__",
            [](Scene* self, string_view text, const NamedMaps& maps, const std::optional<Fibres>& afferents,
               const Sequence<nb::str>& overrides) {
                new (self) Scene(movable(scene_of(text, maps, afferents, texts_in(overrides))));
            },
            nb::arg("text"), nb::arg("maps"), nb::arg("afferents").none(), nb::arg("overrides"))
        .def(
            "__init__",
            [](Scene* self, const nb::bytes& path, const Sequence<nb::str>& overrides) {
                new (self) Scene(movable(Scene::from_file(path_of(path), texts_in(overrides))));
            },
            nb::arg("path"), nb::arg("overrides"))
        .def_prop_ro(
            "width", [](const Scene& s) { return s.grid.width; }, "Cells along x.")
        .def_prop_ro(
            "height", [](const Scene& s) { return s.grid.height; }, "Rows of cells.")
        .def_prop_ro(
            "spacing", [](const Scene& s) { return s.grid.spacing; },
            "Metres between cells; None in a scene without dimensions.")
        .def_prop_ro("sites", sites_of,
                     nb::sig("def sites(self) -> list[tuple[dermis._typing.ReceptorType, int, int]]"),
                     "The sites as (type, x, y), in the order of their responses.")
        .def_prop_ro("_moving_pattern",
                     [](const Scene& s) {
                         std::optional<std::tuple<std::array<double, 2>, std::array<double, 2>>> moving;
                         if (const auto pattern = moving_pattern(s)) moving.emplace(pattern->velocity, pattern->repeat);
                         return moving;
                     })
        .def_prop_ro(
            "afferents", [](const Scene& s) { return s.afferents; }, "The nerve fibres, a list of Afferents.");
    for (const std::string name : tables) {
        const std::string title = char(name[0] - 'a' + 'A') + name.substr(1), module = "dermis._tables.";
        const std::string made = module + title + (name == "load" ? " | list[" + module + title + "]" : "");
        type.def_prop_ro(
            name.c_str(), [name](const Scene& scene) { return table_of(scene, name); },
            nb::sig(("def " + name + "(self) -> " + made).c_str()), ("The table [" + name + "].").c_str());
    }
    type.def(
        "to_toml", toml_of, nb::arg("folder").none() = nb::none(),
        nb::sig("def to_toml(self, folder: str | os.PathLike[str] | None = None) -> str"),
        "Return the scene as a text of TOML, from which Scene.from_string(text, folder=folder) reads an equal one.\n\n"
        "folder: one that exists, where each map is written as a file of NumPy, under the name that the text gives it; "
        "a file of that\n"
        "name is replaced. None: a scene with a map is refused. So is what no text says: heights that were read with a "
        "spacing of their own.");
    m.def(
        "unit_of_key", [](string_view key) { return scene::unit_of_key(std::string(key)); }, nb::arg("key"));
    m.def(
        "key_rows",
        [] {
            using Text = std::string;
            std::vector<std::tuple<Text, Text, Text, Text, Text, Text, Text>> rows;
            for (const auto& [table, name, unit, by_default, allowed, says, type] : scene::key_rows())
                rows.emplace_back(table, name, unit, by_default, allowed, says, type);
            return rows;
        },
        "Return the keys of a scene file: table, name, unit, default, range, sentence and type of each.");
}

} // namespace dermis::python
