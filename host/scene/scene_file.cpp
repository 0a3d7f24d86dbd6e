// SPDX-License-Identifier: MIT
// Scene files: parsing, overriding keys, and the line of the file in every error.
#include "host/scene/float_environment.hpp"
#include "host/scene/input_file.hpp"
#include "host/scene/nearest.hpp"
#include "host/scene/refusal.hpp"
#include "host/scene/scene.hpp"
#include "host/scene/scene_tables.hpp"

#include <cerrno>
#include <cstring>
#include <sstream>

namespace dermis {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse_override(const std::string& override_, const std::string& allowed) {
    throw Error(Error::Code::bad_input, "--set", "--set " + override_ + "; allowed: " + allowed);
}

std::string trimmed(const std::string& text) {
    const size_t first = text.find_first_not_of(' ');
    return first == text.npos ? "" : text.substr(first, text.find_last_not_of(' ') + 1 - first);
}

constexpr size_t most_bytes = 64 << 20; // of a scene file, or of a text in its place
constexpr int most_levels = 32;         // of tables and lists; a scene has four

// Goes past a string that begins at text[at], and returns the place behind it, or that of the line's end which cuts it
// short.
size_t after_string(const std::string& text, size_t at) {
    const char quote = text[at];
    const bool basic = quote == '"'; // has escapes
    const std::string three(3, quote);
    const bool lines = text.compare(at, 3, three) == 0;
    for (size_t i = at + (lines ? 3 : 1); i < text.size(); ++i) {
        if (basic && text[i] == '\\') ++i;
        else if (lines ? text.compare(i, 3, three) == 0 : text[i] == quote) {
            if (!lines) return i + 1;
            for (i += 3; i < text.size() && text[i] == quote;) ++i; // up to two more are in the string
            return i;
        } else if (!lines && text[i] == '\n') return i;
    }
    return text.size();
}

// Returns the number of the first line whose brackets, or the parts of whose dotted key, are more than `most_levels`
// deep; 0 if there is none. The parser and the tables that it makes recurse, so that such a text exhausts the stack.
int line_too_deep(const std::string& text) {
    int line = 1, brackets = 0, dots = 0;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '"' || c == '\'') {
            const size_t behind = after_string(text, i);
            line += int(std::count(text.begin() + std::ptrdiff_t(i), text.begin() + std::ptrdiff_t(behind), '\n'));
            i = behind - 1;
            continue;
        }
        if (c == '#') i = std::min(text.find('\n', i), text.size()) - 1;
        if (c == '[' || c == '{') ++brackets;
        if (c == ']' || c == '}') --brackets;
        dots = c == '.' ? dots + 1 : std::strchr("\n=,[]{}", c) && c ? 0 : dots;
        if (brackets > most_levels || dots >= most_levels) return line;
        line += c == '\n';
    }
    return 0;
}

// Sets one key from "key=value". A value that is not TOML is taken for a text without quotes.
void apply_override(toml::table& file, const std::string& override_) {
    const size_t equals = override_.find('=');
    if (equals == std::string::npos) refuse_override(override_, "key=value, as in time.step=0.001");
    if (override_.find('\n') != std::string::npos) refuse_override(override_, "one line");
    if (line_too_deep(override_))
        throw Error(Error::Code::bad_input, "--set",
                    "--set " + override_.substr(0, 40) +
                        "..: tables and lists are too deep; allowed: " + std::to_string(most_levels) + " levels");
    const std::string key = trimmed(override_.substr(0, equals)), text = override_.substr(equals + 1);
    toml::table value;
    try {
        value = toml::parse("value = " + text);
    } catch (const toml::parse_error&) {
        value = toml::table{{"value", text}};
    }
    toml::table* table = &file;
    std::istringstream parts(key);
    std::string part, next;
    std::getline(parts, part, '.');
    for (; std::getline(parts, next, '.'); part = next) {
        if (!table->contains(part)) table->insert(part, toml::table{});
        if (!table->get(part)->is_table())
            throw Error(Error::Code::bad_input, key, "--set " + override_ + ": " + part + " is not a table");
        table = table->get(part)->as_table();
    }
    table->insert_or_assign(part, *value.get("value"));
}

std::string line_text(const toml::source_region& source) {
    return source.begin.line ? ":" + std::to_string(source.begin.line) : "";
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

// Reads a scene file, which may be a regular file alone: a pipe or a device may never end.
std::string read_scene_file(const std::string& path) {
    const std::string allowed = "; allowed: a scene file (TOML), a regular file of at most 64 MiB";
    std::string why = scene::why_no_file(path, most_bytes);
    std::ifstream in;
    if (why.empty()) {
        in.open(path, std::ios::binary);
        if (!in) why = std::string("cannot be read (") + std::strerror(errno) + ")";
    }
    if (!why.empty()) throw Error(Error::Code::bad_input, "", path + ": " + why + allowed + nearest_file(path));
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

// Returns the line of a parameter as ":line": the line of its key, or of the nearest table around it that the file has.
// Empty where not even a table of it stands in the file.
std::string line_of(const toml::table& file, const std::string& parameter) {
    const toml::node* node = &file;
    std::string key;
    for (std::istringstream parts(parameter.substr(0, parameter.find('['))); std::getline(parts, key, '.');) {
        const toml::node* inner = node->is_table() ? node->as_table()->get(key) : nullptr;
        if (!inner) break;
        node = inner;
    }
    return node != &file ? line_text(node->source()) : "";
}

} // namespace

scene::SceneText scene::text_of_file(const std::string& path) {
    return {.text = read_scene_file(path), .name = path, .folder = fs::path(path).parent_path()};
}

scene::SceneText scene::text_of_string(const std::string& text, const std::string& folder) {
    if (text.size() > most_bytes)
        throw Error(Error::Code::bad_input, "",
                    "scene: has " + std::to_string(text.size()) + " bytes; allowed: at most 64 MiB");
    return {.text = text, .name = "scene", .folder = folder};
}

scene::SceneWithFiles scene::read_scene(const SceneText& source, const std::vector<std::string>& overrides,
                                        const NamedMaps& maps) {
    const DefaultFloats guard; // what a text's numbers are depends on it too
    const auto& [text, name, folder] = source;
    toml::table file;
    if (const int line = line_too_deep(text))
        throw Error(Error::Code::bad_input, "",
                    name + ":" + std::to_string(line) +
                        ": tables and lists are too deep; allowed: " + std::to_string(most_levels) + " levels");
    try {
        file = toml::parse(text, name);
    } catch (const toml::parse_error& e) {
        const std::string column = ":" + std::to_string(e.source().begin.column);
        throw Error(Error::Code::bad_input, "",
                    name + line_text(e.source()) + column + ": " + std::string(e.description()));
    }
    try {
        for (const std::string& o : overrides) apply_override(file, o);
        SceneWithFiles read;
        read.scene = read_tables(file, folder, maps, read.files);
        // The caller gets the scene without defaults: they depend on what it may still change.
        validate(read.scene);
        return read;
    } catch (const Error& e) {
        throw Error(e.code(), e.parameter(), name + line_of(file, e.parameter()) + ": " + e.what());
    }
}

scene::SceneWithFiles scene::read_scene(const std::string& path, const std::vector<std::string>& overrides) {
    SceneWithFiles read = read_scene(text_of_file(path), overrides);
    read.files.insert(read.files.begin(), path);
    return read;
}

Scene Scene::from_file(const std::string& path, const std::vector<std::string>& overrides) {
    return scene::read_scene(path, overrides).scene;
}

Scene Scene::from_string(const std::string& text, const std::vector<std::string>& overrides,
                         const std::string& folder) {
    return scene::read_scene(scene::text_of_string(text, folder), overrides).scene;
}

} // namespace dermis
