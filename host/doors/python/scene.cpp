// SPDX-License-Identifier: MIT
// Scenes from texts, files, and maps and sites in memory.
#include "host/lab/scenes/scene.hpp"
#include "host/doors/python/pickle.hpp"
#include "host/lab/run/maps.hpp"
#include "host/lab/scenes/key_rows.hpp"
#include "host/lab/scenes/units.hpp"
#include <nanobind/stl/variant.h>

namespace dermis::python {
namespace {

using MapArray = nb::ndarray<nb::ro, double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using MapArrays = std::map<std::string, MapArray>;
using NamedSite = std::tuple<const char*, int, int>; // type, x, y
using NamedMaps = nb::typed<nb::dict, nb::str, MapArray>;
using Place = std::variant<int, string_view>; // a cell, or a length with its unit
using NamedSites = Sequence<nb::typed<nb::tuple, nb::str, Place, Place>>;
using Fibres = Sequence<Afferents>;

int cell_of(const Place& place, const Grid& grid) {
    if (const int* cell = std::get_if<int>(&place)) return *cell;
    const std::string text(std::get<string_view>(place));
    return scene::cells_of(text, "sites", "\"" + text + "\"", grid, scene::cell_at);
}

std::vector<Site> sites_named(const NamedSites& named, const Grid& grid) {
    std::vector<Site> sites;
    const char* allowed = "a list of (type, x, y), as in [(\"sa1\", 12, 40)]";
    for (const auto& [type, x, y] : items_of<std::tuple<string_view, Place, Place>>(named, "sites", allowed))
        sites.push_back({value_named<Quantity>("sites", type), {cell_of(x, grid), cell_of(y, grid)}});
    return sites;
}

MapArrays arrays_of(const NamedMaps& named) {
    MapArrays arrays;
    for (const auto [name, array] : named) arrays.emplace(nb::cast<string_view>(name), nb::cast<MapArray>(array));
    return arrays;
}

// The text is one that the package made: its lines mean nothing to a user.
Scene scene_of(string_view text, const NamedMaps& named, const std::optional<NamedSites>& sites,
               const std::optional<Fibres>& fibres, const std::vector<std::string>& overrides) {
    const MapArrays arrays = arrays_of(named);
    scene::NamedMaps maps;
    for (const auto& [name, map] : arrays)
        maps.emplace(name, scene::FileMap{.values = std::vector<double>(map.data(), map.data() + map.size()),
                                          .width = int(map.shape(1)),
                                          .height = int(map.shape(0))});
    try {
        return scene::read_scene(scene::text_of_string(std::string(text), ""), overrides, maps, nullptr,
                                 [&](Scene& scene) {
                                     if (sites) scene.sites = sites_named(*sites, scene.grid);
                                     if (fibres) scene.afferents = afferents_in(*fibres);
                                 })
            .scene;
    } catch (const Error& e) {
        const std::string what = e.what(), place = what.substr(0, what.find(": "));
        throw Error(e.code(), e.parameter(),
                    place == "scene" || place.starts_with("scene:") ? what.substr(place.size() + 2) : what);
    }
}

View<double> map_view(const Map& map, const Scene& scene, nb::handle owner) {
    return view(map.data(), {size_t(scene.grid.height), size_t(scene.grid.width)}, owner);
}

// Returns the maps of a scene by name, each as a view of numbers that nobody else has.
nb::typed<nb::dict, nb::str, View<double>> maps_of(const Scene& scene) {
    std::unique_ptr<SceneMaps> made;
    {
        const Computing computing(nullptr);
        made = std::make_unique<SceneMaps>(maps(scene));
    }
    const nb::capsule owner(made.get(), [](void* p) noexcept { delete static_cast<SceneMaps*>(p); });
    const SceneMaps* kept = made.release();
    nb::typed<nb::dict, nb::str, View<double>> views;
    views["surface"] = map_view(kept->surface, scene, owner);
    views["rest_curvature"] = map_view(kept->rest_curvature, scene, owner);
    views["pressure"] = map_view(kept->pressure, scene, owner);
    return views;
}

std::vector<NamedSite> sites_of(const Scene& scene) {
    std::vector<NamedSite> named;
    for (const Site& site : scene.sites) named.emplace_back(name(site.type), site.cell.x, site.cell.y);
    return named;
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
            [](Scene* self, string_view text, const NamedMaps& maps, const std::optional<NamedSites>& sites,
               const std::optional<Fibres>& afferents, const Sequence<nb::str>& overrides) {
                new (self) Scene(movable(scene_of(text, maps, sites, afferents, texts_in(overrides))));
            },
            nb::arg("text"), nb::arg("maps"), nb::arg("sites").none(), nb::arg("afferents").none(),
            nb::arg("overrides"))
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
        .def_prop_ro("sites", sites_of, "The receptors as (type, x, y), in the order of their responses.")
        .def_prop_ro(
            "afferents", [](const Scene& s) { return s.afferents; }, "The nerve fibres, a list of Afferents.");
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
    m.def("maps", maps_of, nb::arg("scene"),
          "Return the maps that a scene is made of, float64 of shape (height, width) each: \"surface\" (m with a\n"
          "spacing), \"rest_curvature\" (1/m) and \"pressure\" (Pa, where the envelope is 1).");
}

} // namespace dermis::python
