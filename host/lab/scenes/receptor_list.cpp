// SPDX-License-Identifier: MIT
// A list of receptors in a file.
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/scene_names.hpp"

#include <sstream>

namespace dermis::scene {

std::vector<Site> read_sites(const std::string& path) {
    const auto fail = [&](const std::string& what) -> Error {
        return Error(Error::Code::bad_input, "sites.path",
                     "sites.path = \"" + path + "\": " + what +
                         "; allowed: a first line type,x,y, then lines such as sa1,12,40 (" + receptor_class_names() +
                         "; cells)");
    };
    std::string content;
    if (const std::string why = read_file(path, content); !why.empty()) throw fail(why);
    std::vector<Site> sites;
    std::string line;
    auto in = throwing(std::istringstream(content));
    for (int number = 1; std::getline(in, line); ++number) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (number == 1) {
            if (line != "type,x,y") throw fail("begins with " + line);
            continue;
        }
        auto parts = throwing(std::istringstream(line));
        std::string type;
        Site site;
        char comma = 0;
        std::getline(parts, type, ',');
        const std::optional<Quantity> known = value_of<Quantity>(type);
        if (!known || !is_receptor_class(*known) || !(parts >> site.cell.x >> comma >> site.cell.y) || comma != ',' ||
            parts.peek() != std::istringstream::traits_type::eof())
            throw fail("line " + std::to_string(number) + " is " + line);
        site.type = *known;
        sites.push_back(site);
    }
    if (sites.empty()) throw fail("holds no receptor");
    return sites;
}

} // namespace dermis::scene
