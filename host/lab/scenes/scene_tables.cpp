// SPDX-License-Identifier: MIT
#include "host/lab/scenes/key_rows.hpp"
#include "host/lab/scenes/named_maps.hpp"

namespace dermis::scene {
namespace {

void read_grid(Section table, Grid& grid) {
    read_rows<Grid>(table, grid, nullptr);
    table.finish();
    check_rows("grid.", grid); // here, because the tables that follow may name maps of this size
}

// Refuses heights in metres that would be multiplied by the relief of a preset.
void need_relief_of_heights(const FileMap& file, const Section& table, const Surface& surface) {
    if (file.picture || table.has("relief") || !surface.relief || *surface.relief >= 1e-3) return;
    const auto [least, greatest] = std::minmax_element(file.values.begin(), file.values.end());
    const double span = *greatest - *least;
    if (span > 0 && span < 1e-3)
        refuse(table.parameter("relief"), "(not given)",
               "1 for heights in metres: these span " + shortest(span) + ", which the preset's relief of " +
                   shortest(*surface.relief) + " m would multiply");
}

void take_map(const FileMap& file, std::optional<double> spacing, const Grid& grid, const Section& table,
              Surface& surface) {
    need_relief_of_heights(file, table, surface);
    if (grid.spacing)
        if (const std::optional<double> period = ridge_period_of(file))
            surface.ridge_period = *period * spacing.value_or(*grid.spacing);
    if (!spacing) {
        surface.map = file.values;
        return;
    }
    MeasuredSurface measured = measured_surface(file, *spacing, grid);
    surface.map = std::move(measured.heights);
    surface.curvature = std::move(measured.curvature);
}

void read_surface(Section table, const Grid& grid, const PathBase& folder, Surface& surface) {
    read_value(table, "kind", "", surface.kind, nullptr);
    const bool map = surface.kind == Surface::Kind::map;
    if (map || surface.kind == Surface::Kind::flat) // without the ridges of a preset
        surface = {.kind = surface.kind, .relief = surface.relief};
    if (table.has("ridges")) surface.ridge_period.reset();
    const std::string path = path_in(table, map, "\"file\"", folder);
    std::optional<double> spacing; // of the file
    table.permit("spacing", map && grid.spacing, "only with kind = \"file\" and grid.spacing");
    table.number("spacing", spacing);
    if (spacing && !(*spacing > 0 && finite(*spacing)))
        refuse(table.parameter("spacing"), shortest(*spacing), "a finite number > 0");
    const FileMap file = map_in(table, path, spacing ? nullptr : &grid, folder);
    if (map) take_map(file, spacing, grid, table, surface);
    read_rows<Surface>(table, surface, &grid);
    table.finish();
}

// Reads a number or the name of a file that holds one for each cell.
struct NumberOrMap {
    const Grid& grid;
    const PathBase& folder;
    template <class Number> void operator()(Section& table, const char* key, Number& value, Map& map) const {
        if (!table.has_text(key)) return table.number(key, value);
        const std::string text = *table.text(key);
        if (begins_as_number(text) && !text.ends_with(".npy")) return table.number(key, value);
        const FileMap file = folder.map(folder.file(text), &grid, table.parameter(key));
        if (file.picture) refuse(table.parameter(key), "\"" + text + "\"", "a number, or a .npy file of numbers");
        map = file.values;
    }
};

KelvinVoigt element_in(const toml::node& node, const std::string& parameter, const NumberOrMap& number_or_map) {
    if (!node.is_table()) refuse(parameter, node, "tables { modulus = Pa, viscosity = Pa s }");
    Section table(node.as_table(), parameter + ".");
    KelvinVoigt element;
    number_or_map(table, "modulus", element.modulus, element.modulus_map);
    number_or_map(table, "viscosity", element.viscosity, element.viscosity_map);
    table.finish();
    return element;
}

void read_material(Section table, const Grid& grid, const PathBase& folder, Material& material) {
    table.permit("relaxation_file", false,
                 "none; dermis fit FILE prints the table [material] of the curve, to stand here");
    if (table.has("modulus") || table.has("viscosity") || table.has("elements") || table.has("relaxation")) {
        material.elements.clear(); // a preset's
        material.spring.reset();
        material.dashpot.reset();
    }
    const NumberOrMap number_or_map{grid, folder};
    number_or_map(table, "modulus", material.modulus, material.modulus_map);
    number_or_map(table, "viscosity", material.viscosity, material.viscosity_map);
    table.list("elements", material.elements, [&](const toml::node& node, const std::string& parameter) {
        return element_in(node, parameter, number_or_map);
    });
    table.permit("elements", !material.elements.empty(),
                 "1 to 8, with material.spring and material.dashpot beside them");
    Section relaxation = table.section("relaxation");
    const bool relaxes = relaxation.given();
    Relaxation measured;
    read_rows<Relaxation>(relaxation, measured, &grid);
    relaxation.finish();
    read_rows<Material>(table, material, &grid);
    for (const char* key : {"modulus", "viscosity"})
        table.permit(key, !is_chain(material) && !relaxes, "not beside material.elements or material.relaxation");
    for (const char* key : {"elements", "spring", "dashpot"})
        table.permit(key, !relaxes, "not beside material.relaxation, which gives the elements");
    if (relaxes) try {
            material.elements = dermis::chain_of(measured);
        } catch (const Error& e) {
            throw Error(e.code(), "material." + e.parameter(), "material." + std::string(e.what()));
        }
    table.finish();
}

void read_texture(Section table, const Grid& grid, const PathBase& folder, std::optional<Texture>& texture) {
    Texture t;
    const auto path = table.text("path");
    if (table.given() && !path)
        refuse(table.parameter("path"), "(not given)", "a .npy file of two dimensions, or a PNG");
    const FileMap file = map_in(table, path ? folder.file(*path) : "", nullptr, folder);
    t.map = file.values, t.width = file.width, t.height = file.height;
    read_rows<Texture>(table, t, &grid);
    table.finish();
    if (table.given()) texture = t;
}

// Reads what 1 in a recording is: a unit, or a number with its unit, of pressure, force or depth.
void read_unit(Section& table, const Grid& grid, const Load& load, Taxels& t) {
    if (!table.has_text("unit")) return table.number("unit", t.unit);
    const std::string text = *table.text("unit"), one = begins_as_number(text) ? text : "1 " + text;
    const bool depth = load.control == Load::Control::depth;
    t.unit = number_in_unit(depth ? "m" : "Pa", one);
    if (!t.unit && !depth && grid.spacing)
        if (const auto force = number_in_unit("N", one)) t.unit = *force / (t.spacing * t.spacing);
    if (!t.unit) refuse(table.parameter("unit"), "\"" + text + "\"", allowed_unit);
}

void read_offset(Section& table, Taxels& t) {
    if (!table.has_text("offset")) return table.number("offset", t.offset);
    const std::string text = *table.text("offset");
    t.first_at_rest = text == "first";
    if (!t.first_at_rest) refuse(table.parameter("offset"), "\"" + text + "\"", "a number, or \"first\"");
}

void read_taxels(Section table, const Grid& grid, Load& load) {
    Taxels t;
    read_rows<Taxels>(table, t, &grid);
    read_unit(table, grid, load, t);
    read_offset(table, t);
    std::optional<double> rate;
    table.number("sampling_rate", rate);
    table.permit("sampling_rate", !load.interval, "not beside load.interval");
    table.finish();
    if (!table.given()) return;
    if (rate && !(*rate > 0 && finite(1 / *rate)))
        refuse(table.parameter("sampling_rate"), shortest(*rate), "a finite number > 0");
    if (rate) load.interval = 1 / *rate;
    load.taxels = t;
}

void read_load(Section table, const Grid& grid, const PathBase& folder, Load& load) {
    read_value(table, "kind", "", load.kind, nullptr);
    const bool map = load.kind == Load::Kind::map, sequence = load.kind == Load::Kind::sequence;
    const std::string path = path_in(table, map || sequence, "\"file\" or \"sequence\"", folder);
    if (sequence) load.path = path;
    load.map = map_in(table, map ? path : "", &grid, folder).values;
    read_rows<Load>(table, load, &grid);
    read_rows<Envelope>(table, load.envelope, &grid);
    table.value("intensity", load.intensity, [&](auto& node, const auto& name) {
        return number_in(node, name, load.control == Load::Control::depth ? "m" : "Pa");
    });
    read_taxels(table.section("taxels"), grid, load);
    read_texture(table.section("texture"), grid, folder, load.texture);
    table.finish();
}

// Reads a table that has no key but its rows.
template <class Rows, class T> void read_table(Section table, T& to, const Grid& grid) {
    read_rows<Rows>(table, to, &grid);
    table.finish();
}

Site site_in(const toml::node& node, const std::string& parameter, const Grid& grid) {
    const toml::array* site = node.as_array();
    if (!site || site->size() != 3)
        refuse(parameter, node, "a list of [type, x, y], as in [[\"sa1\", 12, 40]], or a table");
    const auto at = [&](size_t i) { return cells_in((*site)[i], parameter, grid, cell_at); };
    const std::optional<Quantity> type = value_of<Quantity>((*site)[0].value_or(std::string()));
    if (!type || !is_receptor_class(*type)) refuse(parameter, (*site)[0], receptor_class_names());
    return {*type, {at(1), at(2)}};
}

std::vector<Site> sites_in(Section table, const Grid& grid, const PathBase& folder, int& seed) {
    const bool by_density = table.has("density") || table.has("seed");
    std::vector<Site> listed;
    if (const auto path = table.text("path")) {
        table.permit("path", !by_density, "either path, or density and seed");
        listed = read_sites(folder.file(*path), grid);
    }
    Density density;
    Section densities = table.section("density");
    const auto named = [&](const ReceptorClass& c) { return densities.has(name(c.type)); };
    if (std::any_of(std::begin(receptor_classes), std::end(receptor_classes), named)) density = {0, 0, 0, 0};
    read_rows<Density>(densities, density, &grid);
    densities.finish();
    read_value(table, "seed", "", seed, nullptr, seeds);
    table.finish();
    return by_density ? population(grid, density, static_cast<unsigned long long>(seed)) : listed;
}

// Replaces the first entries by those of a list, and the others by `rest`.
template <class T, size_t n> void read_up_to(Section& table, const char* key, std::array<T, n>& values, T rest) {
    std::vector<T> given;
    read_value(table, key, "", given, nullptr);
    if (given.size() > n)
        refuse(table.parameter(key), std::to_string(given.size()) + " items", "at most " + std::to_string(n));
    if (!table.has(key)) return;
    values.fill(rest);
    std::ranges::copy(given, values.begin());
}

// Reads a factor, or the word for one.
void read_sensitivity(Section& table, Quantity type, double& factor) {
    const std::optional<std::string> word = table.has_text("sensitivity") ? table.text("sensitivity") : std::nullopt;
    if (!word) return table.number("sensitivity", factor);
    table.permit("sensitivity", word == "median" || word == "threshold", sensitivities.words);
    factor = word == "median" ? 1 : threshold_sensitivity(type);
}

// Keys of the model replace the numbers of the class. Gains are those of all afferents, if nothing else is said.
// sites: the table of that name, which has a seed; its sites are the scene's.
Afferents afferents_in(Section table, const Scene& scene, const Section& sites, int seed) {
    const Grid& grid = scene.grid;
    Afferents a;
    a.seed = seed;
    read_rows<Afferents>(table, a, &grid);
    table.permit("radius", !sites.has("path"), "none with sites.path, a list of endings");
    if (a.endings != 1 && !a.radius && !table.has("cells") && !sites.has("density") && !sites.has("seed"))
        a.cells = cells_of(a.type, scene.sites); // a list of endings
    AfferentModel m;
    if (a.type == Quantity::sa1 || a.type == Quantity::fa1 || a.type == Quantity::fa2) m = afferent_model(a.type);
    if (table.has("gains")) m.sensitivity = 1, m.spread = 0;
    read_rows<AfferentModel>(table, m, &grid);
    read_sensitivity(table, a.type, m.sensitivity);
    read_up_to(table, "gains", m.gains, {0, 0});
    read_up_to(table, "after", m.after, AfterCurrent());
    table.finish();
    bool given = false;
    each_row<AfferentModel>([&](const auto& key) { given |= table.has(key.name); });
    if (given) a.model = m;
    return a;
}

// Returns the scene with which the file's keys begin: a preset, or the defaults.
Scene preset_in(Section& top) {
    const auto preset = top.text("preset");
    if (!preset) return {};
    if (*preset != "fingertip") refuse(top.parameter("preset"), "\"" + *preset + "\"", "\"fingertip\"");
    return {fingertip()};
}

Scene read_all(Section top, const PathBase& folder) {
    Scene scene = preset_in(top);
    read_rows<Scene>(top, scene, nullptr);
    Section grid = top.section("grid"), surface = top.section("surface"), material = top.section("material");
    std::vector<Section> loads = top.sections("load");
    Section time = top.section("time"), curvature = top.section("curvature"), receptors = top.section("receptors"),
            sites = top.section("sites", true), output = top.section("output");
    const bool fibres = top.has("afferents");
    std::vector<Section> afferents = top.sections("afferents");
    top.finish(); // first of all: a misspelt table is then reported, and not the keys that it should have held
    read_grid(grid, scene.grid);
    read_surface(surface, scene.grid, folder, scene.surface);
    read_material(material, scene.grid, folder, scene.material);
    read_load(loads.front(), scene.grid, folder, scene.load);
    for (size_t i = 1; i < loads.size(); ++i) read_load(loads[i], scene.grid, folder, scene.more_loads.emplace_back());
    read_table<Time>(time, scene.time, scene.grid);
    read_table<CurvatureTable>(curvature, scene, scene.grid);
    read_table<Receptors>(receptors, scene.receptors, scene.grid);
    int seed = 1;
    scene.sites = sites_in(sites, scene.grid, folder, seed);
    if (top.has_list("sites"))
        top.list("sites", scene.sites,
                 [&](const toml::node& node, const auto& name) { return site_in(node, name, scene.grid); });
    read_table<Output>(output, scene.output, scene.grid);
    for (Section& table : afferents) scene.afferents.push_back(afferents_in(std::move(table), scene, sites, seed));
    if (!fibres) scene.afferents.clear(); // of no table
    return scene;
}

} // namespace

Scene read_tables(const toml::table& file, const std::filesystem::path& folder, const NamedMaps& maps, FileMaps& read,
                  std::vector<std::string>& files) {
    return read_all(Section(&file, ""), {folder, maps, read, files});
}

std::vector<std::string> known_keys() {
    std::vector<std::string> keys;
    for (const KeyRow& row : key_rows()) keys.push_back(row.table + row.name);
    return keys;
}

} // namespace dermis::scene
