// SPDX-License-Identifier: MIT
#include "tests/oracle/scene_files.hpp"

#include "host/lab/scenes/scene.hpp"
#include "tests/maps.hpp"

#include <fstream>
#include <stdexcept>

namespace oracle {

using namespace dermis;

namespace {

std::string shape_of(const Grid& grid) { return std::to_string(grid.height) + ", " + std::to_string(grid.width); }

void write_npy(const std::filesystem::path& path, const std::string& shape,
               const std::vector<std::vector<double>>& maps) {
    std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + shape + "), }";
    header.resize(118, ' ');
    header.back() = '\n';
    std::ofstream out(path, std::ios::binary);
    out << std::string("\x93NUMPY\x01\x00\x76\x00", 10) << header;
    for (const std::vector<double>& map : maps)
        out.write(reinterpret_cast<const char*>(map.data()), std::streamsize(map.size() * sizeof(double)));
    if (!out) throw std::runtime_error(path.string() + ": cannot be written");
}

// The frames that write_frames has written.
std::vector<std::vector<double>> read_frames(const std::string& path, const Grid& grid) {
    std::ifstream in(path, std::ios::binary);
    unsigned char begin[10] = {}; // the header's length stands in the last two
    in.read(reinterpret_cast<char*>(begin), sizeof begin);
    const size_t header = sizeof begin + begin[8] + 256u * begin[9];
    in.seekg(0, std::ios::end);
    const size_t cells = size_t(grid.width) * size_t(grid.height), frame = cells * sizeof(double);
    std::vector<std::vector<double>> frames((size_t(in.tellg()) - header) / frame, std::vector<double>(cells));
    in.seekg(std::streamoff(header));
    for (std::vector<double>& f : frames) in.read(reinterpret_cast<char*>(f.data()), std::streamsize(frame));
    if (!in) throw std::runtime_error(path + ": not frames of double");
    return frames;
}

} // namespace

void write_frames(const std::filesystem::path& path, const Grid& grid, const std::vector<std::vector<double>>& frames) {
    write_npy(path, std::to_string(frames.size()) + ", " + shape_of(grid), frames);
}

void write_case(const Case& c, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    Scene scene = c.scene;
    if (scene.load.kind == Load::Kind::sequence) {
        scene.load.path = "frames.npy";
        write_frames(folder / scene.load.path, scene.grid, c.frames);
    }
    const auto& [text, maps] = scene::written(scene);
    for (const auto& [name, map] : maps)
        write_npy(folder / name, shape_of({map.width, map.height, {}}), {map.values.values()});
    std::ofstream(folder / "scene.toml") << text;
}

Case with_maps(Scene s) {
    const bool sequence = s.load.kind == Load::Kind::sequence;
    const SceneMaps m = maps(s);
    s.surface = {.kind = Surface::Kind::map,
                 .ridges = {},
                 .noise = {},
                 .noise_length = {},
                 .relief = s.grid.spacing ? std::optional<double>(1) : std::nullopt,
                 .map = m.surface,
                 .ridge_period = {}};
    if (sequence) return {s, read_frames(s.load.path, s.grid)};
    s.load.kind = Load::Kind::map;
    s.load.center.reset();
    s.load.radius.reset();
    s.load.intensity = 1;
    s.load.map = m.pressure;
    return {s, {}};
}

Case read_case(const std::filesystem::path& scene) {
    const Scene s = Scene::from_file(scene.string());
    const bool sequence = s.load.kind == Load::Kind::sequence;
    if (s.surface.kind != Surface::Kind::map || (!sequence && s.load.kind != Load::Kind::map)) return with_maps(s);
    return {s, sequence ? read_frames(s.load.path, s.grid) : std::vector<std::vector<double>>()};
}

} // namespace oracle
