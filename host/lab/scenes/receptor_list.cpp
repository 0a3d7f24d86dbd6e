// SPDX-License-Identifier: MIT
// A list of sites in a file.
#include "host/core/base/text.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/scene_names.hpp"
#include "host/lab/scenes/table_file.hpp"
#include "host/lab/scenes/units.hpp"

#include <algorithm>

namespace dermis::scene {

std::vector<Site> read_sites(const std::string& path, const Grid& grid) {
    TableFile file(path, "sites.path");
    const std::string allowed =
        "names of columns, each once: type,x,y, or with grid.spacing type,x_m,y_m, and id beside them";
    if (!file.next()) file.refuse_file("is empty; allowed: " + allowed);
    const std::vector<std::string> names(file.words().begin(), file.words().end());
    const auto column = [&](std::string_view name) { return size_t(std::ranges::find(names, name) - names.begin()); };
    const auto known = [&](const std::string& name) {
        return std::ranges::count(names, name) == 1 &&
               std::string_view(" id type x y x_m y_m ").find(" " + name + " ") != std::string::npos;
    };
    const bool places = grid.spacing && column("x_m") < names.size();
    const size_t type = column("type"), columns[] = {column(places ? "x_m" : "x"), column(places ? "y_m" : "y")};
    if (std::max({type, columns[0], columns[1]}) == names.size() || !std::ranges::all_of(names, known))
        file.refuse_line(allowed);
    std::vector<Site> sites;
    while (file.next()) {
        file.need_columns(names.size());
        const std::optional<Quantity> of = value_of<Quantity>(file.words()[type]);
        if (!of || !is_receptor_class(*of)) file.refuse("type", file.words()[type], receptor_class_names());
        int cell[2];
        for (size_t axis = 0; axis < 2; ++axis) {
            const double at = file.number(columns[axis], names[columns[axis]]);
            const std::optional<int> found = cell_at(at, places ? grid : Grid{.spacing = 1});
            const int cells = axis == 0 ? grid.width : grid.height;
            if (!found || *found < 0 || *found >= cells || (!places && at != *found))
                file.refuse(names[columns[axis]], file.words()[columns[axis]],
                            places ? "a place on the grid, from 0 to below " + shortest(cells * *grid.spacing) + " m"
                                   : "a cell of the grid, a whole number in 0.." + std::to_string(cells - 1));
            cell[axis] = *found;
        }
        sites.push_back({*of, {cell[0], cell[1]}});
    }
    if (sites.empty()) file.refuse_file("holds no site; allowed: lines such as sa1,12,40 below the names");
    return sites;
}

} // namespace dermis::scene
