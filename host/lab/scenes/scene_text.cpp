// SPDX-License-Identifier: MIT
// A scene as a text of TOML, from which read_scene() reads an equal scene.
#include "host/lab/scenes/toml_section.hpp"
#include "host/lab/scenes/write_rows.hpp"

#include <algorithm>

namespace dermis::scene {
namespace {

std::string quoted(const std::string& text) {
    auto out = throwing(std::ostringstream());
    out << toml::value<std::string>(text);
    return out.str();
}

struct TomlSink {
    using Value = std::string;
    NamedMaps maps{};

    Value value(bool b) { return b ? "true" : "false"; }
    Value value(int n) { return std::to_string(n); }
    // With a point or an exponent, because an integer has no -0.
    Value value(double x) {
        const std::string text = shortest(x);
        return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
    }
    Value value(const std::string& text) { return quoted(text); }
    Value list(const std::vector<Value>& items) {
        std::string all;
        for (const Value& item : items) all += (all.empty() ? "" : ", ") + item;
        return "[" + all + "]";
    }
    template <class T> Value table(const T&, const Pairs<TomlSink>& pairs) {
        std::string all;
        for (const auto& [key, value] : pairs) all += (all.empty() ? " " : ", ") + key + " = " + value;
        return "{" + all + " }";
    }
    Value map(const std::string& name, const Map& map, int width, int height) {
        const std::string file = name + ".npy";
        maps[file] = {.values = map, .width = width, .height = height};
        return quoted(file);
    }
};

// Refuses what a scene can have, and no key says.
void need_keys(const Scene& scene) {
    if (!scene.surface.curvature.empty())
        refuse("surface.path", "heights that were read with surface.spacing",
               "in a text: heights of one number for each cell; keep the file from which the scene was read");
    if (unreadable("path = " + quoted(scene.load.path)).line)
        refuse("load.path", "bytes that are not UTF-8", "in a text: a path in UTF-8");
    for (size_t i = 0; i < scene.afferents.size(); ++i) {
        const Afferents& a = scene.afferents[i];
        if (a.model && !a.model->frequency && a.type == Quantity::fa2)
            refuse("afferents[" + std::to_string(i) + "].frequency", "(not given)",
                   "in a text: a number for fa2, whose model has one where the text gives none");
    }
}

} // namespace

WrittenScene written(const Scene& scene) {
    need_keys(scene);
    TomlSink sink;
    const auto tables = tables_of(sink, scene);
    std::string text;
    for (const auto& [table, pairs] : tables) {
        const bool in_list = std::ranges::count(tables, table, [](const auto& each) { return each.first; }) > 1;
        if (!table.empty()) text += in_list ? "\n[[" + table + "]]\n" : "\n[" + table + "]\n";
        for (const auto& [key, value] : pairs) text += key + " = " + value + "\n";
    }
    return {text, std::move(sink.maps)};
}

} // namespace dermis::scene
