// SPDX-License-Identifier: MIT
#include "host/doors/c/handles.hpp"

#include <string_view>

using namespace dermis::c;

namespace {

using dermis::scene::NamedMaps, dermis::scene::SceneText;

dermis_scene* scene_of(SceneText text) {
    dermis::Scene scene = dermis::scene::read_scene(text, {}).scene;
    return new dermis_scene{std::move(text), {}, {}, std::move(scene)};
}

// Adds "key=value" in place of an earlier value of the key.
void add_override(std::vector<std::string>& overrides, const std::string& key, const std::string& value) {
    std::erase_if(overrides, [&](const std::string& o) { return o.starts_with(key + "="); });
    overrides.push_back(key + "=" + value);
}

// Reads the scene anew, and keeps overrides and maps where that succeeds.
void reread(dermis_scene& scene, std::vector<std::string> overrides, NamedMaps maps) {
    scene.scene = dermis::scene::read_scene(scene.text, overrides, maps).scene;
    scene.overrides = std::move(overrides);
    scene.maps = std::move(maps);
}

} // namespace

dermis_status dermis_scene_from_file(const char* path, dermis_scene** scene) {
    return guarded([&] {
        need_output(scene, "scene");
        need_pointer(path, "path");
        *scene = scene_of(dermis::scene::text_of_file(path));
    });
}

dermis_status dermis_scene_from_string(const char* text, const char* folder, dermis_scene** scene) {
    return guarded([&] {
        need_output(scene, "scene");
        need_pointer(text, "text");
        *scene = scene_of(dermis::scene::text_of_string(text, folder ? folder : ""));
    });
}

dermis_status dermis_scene_fingertip(dermis_scene** scene) {
    return dermis_scene_from_string("preset = \"fingertip\"", nullptr, scene);
}

dermis_status dermis_scene_set(dermis_scene* scene, const char* key, const char* value) {
    return guarded([&] {
        need_pointer(scene, "scene");
        need_pointer(key, "key");
        need_pointer(value, "value");
        if (std::string_view(key).find_first_of("=\n") != std::string_view::npos)
            dermis::scene::refuse("key", "\"" + std::string(key) + "\"", "a dotted name, as in time.step");
        std::vector<std::string> overrides = scene->overrides;
        add_override(overrides, key, value);
        reread(*scene, std::move(overrides), scene->maps);
    });
}

dermis_status dermis_scene_set_map(dermis_scene* scene, const char* key, const double* values, size_t count) {
    return guarded([&] {
        need_pointer(scene, "scene");
        need_pointer(key, "key");
        need_pointer(values, "values");
        const std::string_view name = key;
        const bool path = name == "surface.path" || name == "load.path";
        if (!path && name != "material.modulus" && name != "material.viscosity")
            dermis::scene::refuse("key", "\"" + std::string(key) + "\"",
                                  "surface.path, load.path, material.modulus, material.viscosity");
        const dermis::Grid& grid = scene->scene.grid;
        const size_t cells = size_t(grid.width) * size_t(grid.height);
        if (count != cells) // before any value is read
            dermis::scene::refuse(key, std::to_string(count) + " cells",
                                  "width*height = " + std::to_string(cells) + ", row 0 first");
        std::vector<std::string> overrides = scene->overrides;
        NamedMaps maps = scene->maps;
        if (path) add_override(overrides, std::string(name.substr(0, name.find('.'))) + ".kind", "file");
        add_override(overrides, key, key); // The map's name is its key.
        maps.insert_or_assign(key, dermis::scene::FileMap{.values = std::vector<double>(values, values + count),
                                                          .width = scene->scene.grid.width,
                                                          .height = scene->scene.grid.height});
        reread(*scene, std::move(overrides), std::move(maps));
    });
}

dermis_status dermis_scene_get_size(const dermis_scene* scene, int32_t* width, int32_t* height) {
    return guarded([&] {
        need_output(width, "width");
        need_output(height, "height");
        need_pointer(scene, "scene");
        *width = scene->scene.grid.width;
        *height = scene->scene.grid.height;
    });
}

void dermis_scene_destroy(dermis_scene* scene) { delete scene; }
