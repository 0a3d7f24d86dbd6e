// SPDX-License-Identifier: MIT
// Writes a scene by the rows of its tables: the counterpart of read_rows.hpp and scene_tables.cpp.
//
// A Sink says what a value becomes. It has the type Value, and makes one of a bool, an int, a double and a std::string
// by value(..), of Values by list(..), of the keys of a struct by table(struct, Pairs), and of a map, under the dotted
// name of its key, by map(name, Map, width, height).
#pragma once

#include "host/lab/scenes/keys.hpp"

namespace dermis::scene {

// The keys of a table that are given, in the order of the rows.
template <class Sink> using Pairs = std::vector<std::pair<std::string, typename Sink::Value>>;

template <class Sink> class RowWriter {
  public:
    using Value = typename Sink::Value;
    RowWriter(Sink& to, const Grid& grid) : to_(to), grid_(grid) {}

    // Adds the keys of a table. prefix: its dotted name, as in "load."; empty: the top of a file.
    template <class Rows, class T> void add(Pairs<Sink>& pairs, const std::string& prefix, const T& of) {
        each_row<Rows>([&]<class Member>(const Key<Member>& key) {
            const std::string name = prefix + key.name;
            if constexpr (std::is_same_v<Member, Special>) {
                if (std::optional<Value> value = special(name, key.name, of)) pairs.emplace_back(key.name, *value);
            } else {
                const auto& value = of.*key.member;
                using Of = typename ClassOf<Member>::type;
                if (key.only.holds && !key.only.holds(static_cast<const Of&>(of))) return;
                if constexpr (Held<std::remove_cvref_t<decltype(value)>>::optional) {
                    if (value) pairs.emplace_back(key.name, written(name, *value));
                } else pairs.emplace_back(key.name, written(name, value));
            }
        });
    }
    template <class Rows, class T> Pairs<Sink> pairs_of(const std::string& prefix, const T& of) {
        Pairs<Sink> pairs;
        add<Rows>(pairs, prefix, of);
        return pairs;
    }

    template <class T> Value written(const std::string& name, const T& value) {
        if constexpr (std::is_arithmetic_v<T>) return to_.value(value);
        else if constexpr (std::is_enum_v<T>) return to_.value(std::string(text_of(value)));
        else if constexpr (std::is_same_v<T, Cell>) return to_.list({to_.value(value.x), to_.value(value.y)});
        else if constexpr (std::is_same_v<T, Site>)
            return to_.list(
                {to_.value(std::string(text_of(value.type))), to_.value(value.cell.x), to_.value(value.cell.y)});
        else if constexpr (requires { typename T::value_type; }) {
            std::vector<Value> items;
            for (const auto& item : value)
                items.push_back(written(name + "[" + std::to_string(items.size()) + "]", item));
            return to_.list(items);
        } else return to_.table(value, pairs_of<T>(name + ".", value));
    }

  private:
    Value map(const std::string& name, const Map& map) { return to_.map(name, map, grid_.width, grid_.height); }

    // The keys without a member. Nothing where they are not given, or stand in another form in the scene.
    template <class T> std::optional<Value> special(const std::string&, std::string_view, const T&) { return {}; }
    std::optional<Value> special(const std::string& name, std::string_view key, const Surface& s) {
        if (key == "path" && !s.map.empty()) return map(name, s.map);
        return {};
    }
    // An element has its numbers as double, a material as optional.
    template <class T>
    requires std::is_same_v<T, Material> || std::is_same_v<T, KelvinVoigt> std::optional<Value>
    special(const std::string& name, std::string_view key, const T& m) {
        if constexpr (std::is_same_v<T, Material>)
            if (key == "elements" && !m.elements.empty()) return written(name, m.elements);
        if (key != "modulus" && key != "viscosity") return {};
        const bool modulus = key == "modulus";
        const Map& numbers = modulus ? m.modulus_map : m.viscosity_map;
        if (!numbers.empty()) return map(name, numbers);
        const std::optional<double> number = modulus ? m.modulus : m.viscosity;
        return number ? std::optional(to_.value(*number)) : std::nullopt;
    }
    std::optional<Value> special(const std::string& name, std::string_view key, const Load& l) {
        if (key == "path" && l.kind == Load::Kind::map) return map(name, l.map);
        if (key == "path" && l.kind == Load::Kind::sequence) return to_.value(l.path);
        if (key == "intensity") return to_.value(l.intensity);
        if (key == "texture" && l.texture) return written(name, *l.texture);
        if (key == "taxels" && l.taxels) return written(name, *l.taxels);
        return {};
    }
    std::optional<Value> special(const std::string& name, std::string_view key, const Texture& t) {
        if (key == "path") return to_.map(name, t.map, t.width, t.height);
        return {};
    }
    std::optional<Value> special(const std::string&, std::string_view key, const Taxels& t) {
        if (key == "unit" && t.unit) return to_.value(*t.unit);
        if (key == "offset" && t.first_at_rest) return to_.value(std::string("first"));
        if (key == "offset" && t.offset) return to_.value(*t.offset);
        return {};
    }
    std::optional<Value> special(const std::string& name, std::string_view key, const AfferentModel& m) {
        if (key == "sensitivity") return to_.value(m.sensitivity);
        return key == "gains" ? written(name, m.gains) : written(name, m.after);
    }

    Sink& to_;
    const Grid& grid_;
};

// Returns the tables of a scene in the order of a file. The first has no name: it has the keys at the top. A table that
// may be a list stands here once for each item.
template <class Sink> std::vector<std::pair<std::string, Pairs<Sink>>> tables_of(Sink& to, const Scene& scene) {
    RowWriter<Sink> writer(to, scene.grid);
    std::vector<std::pair<std::string, Pairs<Sink>>> tables;
    const auto add = [&]<class Rows, class T>(Table<Rows>, const std::string& name, const T& of) {
        tables.emplace_back(name, writer.template pairs_of<Rows>(name.empty() ? "" : name + ".", of));
    };
    add(Table<Scene>(), "", scene);
    if (!scene.sites.empty()) tables[0].second.emplace_back("sites", writer.written("sites", scene.sites));
    add(Table<Grid>(), "grid", scene.grid);
    add(Table<Surface>(), "surface", scene.surface);
    add(Table<Material>(), "material", scene.material);
    for (size_t i = 0; i <= scene.more_loads.size(); ++i) {
        const Load& load = i ? scene.more_loads[i - 1] : scene.load;
        const std::string prefix = scene.more_loads.empty() ? "load." : "load[" + std::to_string(i) + "].";
        tables.emplace_back("load", writer.template pairs_of<Load>(prefix, load));
        writer.template add<Envelope>(tables.back().second, prefix, load.envelope);
    }
    add(Table<Time>(), "time", scene.time);
    add(Table<CurvatureTable>(), "curvature", scene);
    add(Table<Receptors>(), "receptors", scene.receptors);
    add(Table<Output>(), "output", scene.output);
    for (const Afferents& fibres : scene.afferents) {
        add(Table<Afferents>(), "afferents", fibres);
        if (fibres.model) writer.template add<AfferentModel>(tables.back().second, "afferents.", *fibres.model);
    }
    return tables;
}

} // namespace dermis::scene
