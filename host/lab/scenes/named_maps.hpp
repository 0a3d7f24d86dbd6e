// SPDX-License-Identifier: MIT
// The tables of a scene file, and the maps and other files that they name.
#pragma once

#include "host/lab/scenes/read_rows.hpp"

namespace dermis::scene {

// The folder that paths in a scene file are relative to, maps in memory, maps that have been read, and the files that
// have been named so far.
struct PathBase {
    std::filesystem::path path;
    const NamedMaps& maps;
    FileMaps& read;
    std::vector<std::string>& files;
    // Returns the path from the working directory, or the name of a map in memory; of "" the folder, which is no file.
    std::string file(const std::string& name) const {
        return maps.count(name) ? name : files.emplace_back((path / (name.empty() ? "." : name)).string());
    }
    // Returns the map of such a path or name. grid: what its shape must be; null: any.
    FileMap map(const std::string& file, const Grid* grid, const std::string& parameter) const {
        const auto fits = [grid](const FileMap& m) {
            return !grid || (m.width == grid->width && m.height == grid->height);
        };
        if (const auto in_memory = maps.find(file); in_memory != maps.end()) {
            const FileMap& found = in_memory->second;
            if (!fits(found))
                refuse(parameter, "array of shape " + shape_text(found.height, found.width),
                       "shape (height, width) = " + shape_text(grid->height, grid->width));
            return found;
        }
        FileMap& found = read[file];
        if (found.values.empty() || !fits(found))
            found = grid ? read_map(file, grid->width, grid->height, parameter) : read_map(file, 0, 0, parameter);
        return found;
    }
    static std::string shape_text(int rows, int columns) {
        return "(" + std::to_string(rows) + ", " + std::to_string(columns) + ")";
    }
};

// Reads the key `path` of a table, which is required with the kinds named in `kinds` and refused with any other.
// Returns the path from the working directory; empty where there is none.
inline std::string path_in(Section& table, bool required, const std::string& kinds, const PathBase& folder) {
    const auto path = table.text("path");
    if (required != path.has_value())
        refuse(table.parameter("path"), path ? "\"" + *path + "\"" : "(not given)",
               "the path of a file, with " + table.parameter("kind") + " = " + kinds + " and only then");
    return path ? folder.file(*path) : "";
}

// Reads the map of a table's path, and where it is a picture the key `high`. Without a file it returns no map.
inline FileMap map_in(Section& table, const std::string& file, const Grid* grid, const PathBase& folder) {
    std::optional<High> high;
    read_value(table, "high", "", high, nullptr);
    FileMap map;
    if (!file.empty()) map = folder.map(file, grid, table.parameter("path"));
    table.permit("high", map.picture, "only where path is a picture, a PNG");
    if (map.picture && !high)
        refuse(table.parameter("high"), "(not given)",
               "high = \"white\" or high = \"black\", the grey of the picture that is 1; ridges are black in a scanned "
               "print");
    if (high == High::black)
        for (double& v : map.values.edit()) v = 1 - v;
    return map;
}

// Reads a Scene from the tables of a scene file. Paths in the file are relative to `folder`, unless they are names in
// `maps`, and are appended to `files`; a map that is in `read` is not read again. Checks keys and types; validate()
// checks ranges and fills in the defaults. Throws Error::bad_input.
Scene read_tables(const toml::table& file, const std::filesystem::path& folder, const NamedMaps& maps, FileMaps& read,
                  std::vector<std::string>& files);

} // namespace dermis::scene
