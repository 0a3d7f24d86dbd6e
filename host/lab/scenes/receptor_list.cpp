// SPDX-License-Identifier: MIT
// A list of receptors in a file.
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/scene_names.hpp"
#include "host/lab/scenes/units.hpp"

#include <sstream>

namespace dermis::scene {
namespace {

// Reads the cell behind the class in a line.
bool read_cell(std::istream& in, Cell& cell) {
    char comma = 0;
    return in >> cell.x >> comma >> cell.y && comma == ',';
}
bool read_place(std::istream& in, const Grid& grid, Cell& cell) {
    double x = 0, y = 0;
    char comma = 0;
    if (!(in >> x >> comma >> y) || comma != ',') return false;
    const std::optional<int> column = cell_at(x, grid), row = cell_at(y, grid);
    if (column && row) cell = {*column, *row};
    return column && row;
}

} // namespace

std::vector<Site> read_sites(const std::string& path, const Grid& grid) {
    const auto fail = [&](const std::string& what) -> Error {
        return Error(Error::Code::bad_input, "sites.path",
                     "sites.path = \"" + path + "\": " + what +
                         "; allowed: a first line type,x,y, then lines such as sa1,12,40 (" + receptor_class_names() +
                         "; cells), or with grid.spacing type,x_m,y_m and places in m");
    };
    std::string content;
    if (const std::string why = read_file(path, content); !why.empty()) throw fail(why);
    std::vector<Site> sites;
    std::string line;
    bool in_metres = false;
    auto in = throwing(std::istringstream(content));
    for (int number = 1; std::getline(in, line); ++number) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (number == 1) {
            in_metres = line == "type,x_m,y_m" && grid.spacing;
            if (line != "type,x,y" && !in_metres) throw fail("begins with " + line);
            continue;
        }
        auto parts = throwing(std::istringstream(line));
        std::string type;
        Site site;
        std::getline(parts, type, ',');
        const std::optional<Quantity> known = value_of<Quantity>(type);
        const bool read = in_metres ? read_place(parts, grid, site.cell) : read_cell(parts, site.cell);
        if (!known || !is_receptor_class(*known) || !read || parts.peek() != std::istringstream::traits_type::eof())
            throw fail("line " + std::to_string(number) + " is " + line);
        site.type = *known;
        sites.push_back(site);
    }
    if (sites.empty()) throw fail("holds no receptor");
    return sites;
}

} // namespace dermis::scene
