// SPDX-License-Identifier: MIT
// Scene files: parsing, overriding keys, and the line of the file in every error.
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/named_maps.hpp"

#include <cstdio>
#include <mutex>
#include <sstream>

namespace dermis {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse_override(const std::string& override_, const std::string& allowed) {
    throw Error(Error::Code::bad_input, "--set", "--set " + override_ + "; allowed: " + allowed);
}

constexpr size_t most_scene_bytes = 64 << 20; // of a scene file, or of a text in its place

// The item of a list that a name with an index means, as load[1]; null if there is none.
toml::node* item_of(toml::table& table, const std::string& name) {
    const size_t bracket = name.find('[');
    toml::node* list = bracket == name.npos ? nullptr : table.get(name.substr(0, bracket));
    if (!list || !list->is_array()) return nullptr;
    const std::string index = name.substr(bracket);
    for (size_t i = 0; i < list->as_array()->size(); ++i)
        if (index == "[" + std::to_string(i) + "]") return list->as_array()->get(i);
    return nullptr;
}

// Sets one key from "key=value". A value that is not TOML is taken for a text without quotes.
void apply_override(toml::table& file, const std::string& override_) {
    const size_t equals = override_.find('=');
    if (equals == std::string::npos) refuse_override(override_, "key=value, as in time.step=0.001");
    if (override_.find('\n') != std::string::npos) refuse_override(override_, "one line");
    const std::string key = scene::trimmed(override_.substr(0, equals)), text = override_.substr(equals + 1),
                      toml = "value = " + text;
    const scene::Unreadable found = scene::unreadable(toml);
    if (found.deep || size_t(std::count(key.begin(), key.end(), '.')) >= scene::most_levels)
        throw Error(Error::Code::bad_input, "--set", "--set " + beginning_of(override_, 40) + ": " + scene::too_deep);
    toml::table value{{"value", text}}; // kept if it is not TOML
    if (!found.line)
        if (toml::parse_result parsed = toml::parse(toml)) value = std::move(parsed).table();
    toml::table* table = &file;
    auto parts = scene::throwing(std::istringstream(key));
    std::string part, next;
    std::getline(parts, part, '.');
    for (; std::getline(parts, next, '.'); part = next) {
        if (toml::node* item = item_of(*table, part); item && item->is_table()) {
            table = item->as_table();
            continue;
        }
        if (!table->contains(part)) table->insert(part, toml::table{});
        if (!table->get(part)->is_table())
            throw Error(Error::Code::bad_input, key,
                        "--set " + override_ + ": " + part + " is not a table" +
                            (table->get(part)->is_array() ? "; a table of the list is " + part + "[0], .." : ""));
        table = table->get(part)->as_table();
    }
    table->insert_or_assign(part, *value.get("value"));
}

void say_once(const char* sentence) {
    static std::once_flag said;
    std::call_once(said, [&] { std::fprintf(stderr, "dermis: %s\n", sentence); });
}

// Puts the words of today in place of old ones.
void renew(toml::table& file) {
    bool found = false;
    const auto renew_fibres = [&](toml::node& node) {
        toml::table* fibres = node.as_table();
        if (!fibres || !fibres->contains("class") || fibres->contains("type")) return;
        fibres->insert("type", *fibres->get("class"));
        fibres->erase("class");
        found = true;
    };
    toml::node* fibres = file.get("afferents");
    if (fibres && fibres->is_array())
        for (toml::node& each : *fibres->as_array()) renew_fibres(each);
    else if (fibres) renew_fibres(*fibres);
    if (found) scene::old_word_found("afferents.class is called afferents.type; class is read until 1.0");
}

std::string line_text(const toml::source_region& source) {
    return source.begin.line ? ":" + std::to_string(source.begin.line) : "";
}

// Returns what the parser said of a text, with the key and the line that it stopped at, and what helps if it is known.
std::string parser_said(const std::string& text, const toml::parse_error& error) {
    std::string line, table;
    auto lines = scene::throwing(std::istringstream(text));
    for (toml::source_index i = 0; i < error.source().begin.line && std::getline(lines, line); ++i)
        if (const size_t end = line.find(']'); line.starts_with('[') && end != line.npos)
            table = line.substr(line.find_first_not_of('['), end - line.find_first_not_of('[')) + ".";
    line = scene::trimmed(line, " \t\r");
    const std::string key = scene::trimmed(line.substr(0, line.find('=')));
    const bool assigns = line.find('=') != line.npos,
               number = error.description().find("representable") != std::string_view::npos;
    return (assigns ? table + key + ": " : "") + std::string(error.description()) +
           "; the line: " + beginning_of(line, 100) +
           (number ? "; a number beyond 64 bits needs a decimal point or an exponent, as 1e20"
            : line.find('\\') != line.npos
                ? "; a backslash in \" \" begins an escape: use single quotes, as 'C:\\data', or two backslashes"
                : "");
}

// Names the scene file in the same folder that is nearest to a missing one; returns nothing if none is near.
std::string nearest_file(const fs::path& missing) {
    std::vector<std::string> files;
    std::error_code none;
    if (fs::exists(missing, none)) return "";
    const fs::path folder = missing.has_parent_path() ? missing.parent_path() : ".";
    for (fs::directory_iterator i(folder, none), end; !none && i != end; i.increment(none))
        if (i->path().extension() == ".toml") files.push_back(i->path().stem().string());
    const std::string meant = scene::nearest(missing.stem().string(), files);
    return meant.empty() ? "" : "; did you mean " + meant + ".toml?";
}

// Reads a scene file. It must be a regular file: a pipe or a device may never end.
std::string read_scene_file(const std::string& path) {
    const char* allowed = "; allowed: a scene file (TOML), a regular file of at most 64 MiB";
    std::string text;
    if (const std::string why = scene::read_file(path, text, most_scene_bytes); !why.empty())
        throw Error(Error::Code::bad_input, "", path + ": " + why + allowed + nearest_file(path));
    return text;
}

// Returns the line of a parameter as ":line": the line of its key, or of the nearest table around it that the file has.
// Empty if the file has no such table.
std::string line_of(toml::table& file, const std::string& parameter) {
    toml::node* node = &file;
    std::string key;
    auto parts = scene::throwing(std::istringstream(parameter));
    while (node->is_table() && std::getline(parts, key, '.')) {
        toml::table& table = *node->as_table();
        toml::node *item = item_of(table, key), *inner = item ? item : table.get(key.substr(0, key.find('[')));
        if (!inner) break;
        node = inner;
    }
    return node != &file ? line_text(node->source()) : "";
}

} // namespace

void (*scene::old_word_found)(const char* sentence) = say_once;

scene::SceneText scene::text_of_file(const std::string& path) {
    const auto words = [&] { return "the text of " + path; };
    return scene::guarded(words, [&]() -> scene::SceneText {
        return {.text = read_scene_file(path), .name = path, .folder = fs::path(path).parent_path()};
    });
}

scene::SceneText scene::text_of_string(const std::string& text, const std::string& folder) {
    const auto words = [&] { return "a scene of " + bytes_text(double(text.size())); };
    return scene::guarded(words, [&]() -> scene::SceneText {
        if (text.size() > most_scene_bytes)
            throw Error(Error::Code::bad_input, "",
                        "scene: has " + std::to_string(text.size()) + " bytes; allowed: at most 64 MiB");
        return {.text = text, .name = "scene", .folder = folder};
    });
}

scene::SceneWithFiles scene::read_scene(const SceneText& source, const std::vector<std::string>& overrides,
                                        const NamedMaps& maps, FileMaps* shared,
                                        const std::function<void(Scene&)>& complete) {
    const auto words = [&] { return source.name + " has " + bytes_text(double(source.text.size())) + " and its maps"; };
    return scene::guarded(words, [&] {
        const DefaultFloats guard; // the numbers of a text depend on it too
        const auto& [text, name, folder] = source;
        toml::table file;
        if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") || text.find('\0') < 2)
            throw Error(Error::Code::bad_input, "", name + ": is text in UTF-16; allowed: UTF-8, so save it as UTF-8");
        if (const Unreadable found = unreadable(text); found.line)
            throw Error(Error::Code::bad_input, "", name + ":" + std::to_string(found.line) + ": " + found.why);
        // The parser is not told the name: it would copy it in functions from which no exception may escape.
        toml::parse_result parsed = toml::parse(text);
        if (!parsed) {
            const toml::source_region& at = parsed.error().source();
            throw Error(Error::Code::bad_input, "",
                        name + line_text(at) + ":" + std::to_string(at.begin.column) + ": " +
                            parser_said(text, parsed.error()));
        }
        file = std::move(parsed).table();
        try {
            for (const std::string& o : overrides) apply_override(file, o);
            renew(file);
            SceneWithFiles read;
            FileMaps own;
            read.scene = read_tables(file, folder, maps, shared ? *shared : own, read.files);
            if (complete) complete(read.scene);
            // The caller gets the scene without defaults: they depend on what it may still change.
            validate(read.scene);
            return read;
        } catch (const Error& e) {
            throw Error(e.code(), e.parameter(), name + line_of(file, e.parameter()) + ": " + e.what());
        }
    });
}

scene::SceneWithFiles scene::read_scene(const std::string& path, const std::vector<std::string>& overrides) {
    const auto words = [&] { return "the files of " + path; };
    return scene::guarded(words, [&] {
        SceneWithFiles read = read_scene(text_of_file(path), overrides);
        read.files.insert(read.files.begin(), path);
        return read;
    });
}

Scene Scene::from_file(const std::string& path, const std::vector<std::string>& overrides) {
    return scene::read_scene(path, overrides).scene;
}

Scene Scene::from_string(const std::string& text, const std::vector<std::string>& overrides,
                         const std::string& folder) {
    return scene::read_scene(scene::text_of_string(text, folder), overrides).scene;
}

} // namespace dermis
