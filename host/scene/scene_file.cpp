// SPDX-License-Identifier: MIT
// Scene files: parsing, overriding keys, and the line of the file in every error.
#include "host/scene/refusal.hpp"
#include "host/scene/scene.hpp"
#include "host/scene/scene_tables.hpp"

#include <sstream>

namespace dermis {
namespace {

// Sets one key from "key=value". A value that is not TOML is taken for a text without quotes.
void apply_override(toml::table& file, const std::string& override_) {
    const size_t equals = override_.find('=');
    if (equals == std::string::npos)
        throw Error(Error::Code::bad_input, "--set",
                    "--set " + override_ + "; allowed: key=value, as in time.step=0.001");
    const std::string key = override_.substr(0, equals), text = override_.substr(equals + 1);
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

Scene Scene::from_file(const std::string& path, const std::vector<std::string>& overrides) {
    toml::table file;
    try {
        file = toml::parse_file(path);
    } catch (const toml::parse_error& e) {
        throw Error(Error::Code::bad_input, "", path + line_text(e.source()) + ": " + std::string(e.description()));
    }
    try {
        for (const std::string& o : overrides) apply_override(file, o);
        Scene scene = scene::read_tables(file, std::filesystem::path(path).parent_path());
        scene::validate(scene); // The caller gets the scene without defaults: they depend on what it may still change.
        return scene;
    } catch (const Error& e) {
        throw Error(e.code(), e.parameter(), path + line_of(file, e.parameter()) + ": " + e.what());
    }
}

} // namespace dermis
