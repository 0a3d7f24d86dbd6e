// SPDX-License-Identifier: MIT
#include "host/lab/scenes/scene_tables.hpp"
#include "host/lab/scenes/named_maps.hpp"

namespace dermis::scene {
namespace {

void read_grid(Section table, Grid& grid) {
    table.whole_number("width", grid.width);
    table.whole_number("height", grid.height);
    table.number("spacing", grid.spacing);
    table.finish();
    // The size is checked here because the tables that follow may name maps of this size.
    for (auto [key, cells] : {std::pair{"width", grid.width}, {"height", grid.height}})
        if (cells < 1 || cells > 16384) refuse(table.parameter(key), std::to_string(cells), "whole cells, 1..16384");
}

// Reads a length, which has no unit where the grid has no spacing.
template <class Number> void read_length(Section& table, const char* key, const Grid& grid, Number& value) {
    table.permit(key, grid.spacing || !table.has_text(key), "a number of cells: the grid has no spacing");
    table.number(key, value);
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
    table.choice("kind", surface.kind);
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
    table.number("ridges", surface.ridges);
    read_length(table, "ridge_period", grid, surface.ridge_period);
    table.number("noise", surface.noise);
    table.number("noise_length", surface.noise_length);
    read_length(table, "relief", grid, surface.relief);
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
    if (const auto file = table.text("relaxation_file"))
        refuse(table.parameter("relaxation_file"), "\"" + *file + "\"",
               "none; dermis fit " + *file + " prints the table [material] of this curve, to stand here");
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
    const bool relaxes = table.has("relaxation");
    Section relaxation = table.section("relaxation");
    Relaxation measured;
    relaxation.list("moduli", measured.moduli, number_in);
    relaxation.list("times", measured.times, number_in);
    relaxation.number("equilibrium", measured.equilibrium);
    relaxation.finish();
    table.number("spring", material.spring);
    table.number("dashpot", material.dashpot);
    for (const char* key : {"modulus", "viscosity"})
        table.permit(key, !is_chain(material) && !relaxes, "not beside material.elements or material.relaxation");
    for (const char* key : {"elements", "spring", "dashpot"})
        table.permit(key, !relaxes, "not beside material.relaxation, which gives the elements");
    if (relaxes) material.elements = dermis::chain_of(measured);
    read_length(table, "thickness", grid, material.thickness);
    read_length(table, "curvature_length", grid, material.curvature_length);
    table.finish();
}

// Reads the envelope's keys of the table [load], each of which belongs to one kind of envelope or to some.
void read_envelope(Section& table, Envelope& e) {
    using Kind = Envelope::Kind;
    table.choice("envelope", e.kind);
    const auto permit = [&](const char* key, bool permitted) {
        table.permit(key, permitted, "only with another load.envelope");
    };
    permit("start", e.kind == Kind::step || e.kind == Kind::ramp || e.kind == Kind::pulse);
    table.number("start", e.start);
    for (auto [key, value, kind] : {std::tuple{"rise", &e.rise, Kind::ramp},
                                    {"frequency", &e.frequency, Kind::sine},
                                    {"phase", &e.phase, Kind::sine},
                                    {"mean", &e.mean, Kind::sine},
                                    {"amplitude", &e.amplitude, Kind::sine},
                                    {"length", &e.length, Kind::pulse},
                                    {"period", &e.period, Kind::pulse}}) {
        permit(key, e.kind == kind);
        table.number(key, *value);
    }
    for (auto [key, values] : {std::pair{"times", &e.times}, {"values", &e.values}}) {
        permit(key, e.kind == Kind::table);
        table.list(key, *values, number_in);
    }
}

void read_window(Section window, bool given, std::optional<Envelope::Window>& of) {
    Envelope::Window w;
    window.number("start", w.start);
    window.number("rise", w.rise);
    window.number("until", w.until);
    window.number("fall", w.fall);
    window.finish();
    if (given) of = w;
}

void read_grating(Section table, bool given, const Grid& grid, std::optional<Grating>& grating) {
    Grating g;
    read_length(table, "wavelength", grid, g.wavelength);
    table.number("direction", g.direction);
    table.number("velocity", g.velocity);
    table.list("amplitudes", g.amplitudes, number_in);
    table.list("phases", g.phases, number_in);
    table.finish();
    if (given && !table.has("wavelength")) refuse(table.parameter("wavelength"), "(not given)", "a length > 0");
    if (given) grating = g;
}

void read_texture(Section& table, bool given, const Grid& grid, const PathBase& folder,
                  std::optional<Texture>& texture) {
    Texture t;
    const auto path = table.text("path");
    if (given && !path) refuse(table.parameter("path"), "(not given)", "a .npy file of two dimensions");
    const FileMap file = map_in(table, path ? folder.file(*path) : "", nullptr, folder);
    t.map = file.values, t.width = file.width, t.height = file.height;
    read_length(table, "spacing", grid, t.spacing);
    std::vector<double> velocity = {t.velocity[0], t.velocity[1]};
    table.list("velocity", velocity, number_in);
    if (velocity.size() != 2)
        refuse(table.parameter("velocity"), std::to_string(velocity.size()) + " numbers", "two, [vx, vy]");
    t.velocity = {velocity[0], velocity[1]};
    table.finish();
    if (given) texture = t;
}

std::array<double, 2> lengths_in(Section& table, const char* key, const Grid& grid,
                                 const std::array<double, 2>& by_default) {
    std::vector<double> pair(by_default.begin(), by_default.end());
    table.list(key, pair, [&](const toml::node& node, const std::string& parameter) {
        const auto* text = node.as_string();
        const std::optional<double> length = text && grid.spacing ? length_with_unit(**text) : std::nullopt;
        return length ? *length : number_in(node, parameter);
    });
    if (pair.size() != 2) refuse(table.parameter(key), std::to_string(pair.size()) + " numbers", "two, [x, y]");
    return {pair[0], pair[1]};
}

// Reads what 1 in a recording is: a unit, or a number with its unit, of pressure, force or depth.
void read_unit(Section& table, const Grid& grid, const Load& load, Taxels& t) {
    if (!table.has_text("unit")) return table.number("unit", t.unit);
    const std::string text = *table.text("unit"), one = begins_as_number(text) ? text : "1 " + text;
    const bool depth = load.control == Load::Control::depth;
    t.unit = number_with_unit(depth ? "load.depth" : "load.intensity", one);
    if (!t.unit && !depth && grid.spacing)
        if (const auto force = number_with_unit("load.force", one)) t.unit = *force / (t.spacing * t.spacing);
    if (!t.unit) refuse(table.parameter("unit"), "\"" + text + "\"", allowed_unit);
}

void read_offset(Section& table, Taxels& t) {
    if (!table.has_text("offset")) return table.number("offset", t.offset);
    const std::string text = *table.text("offset");
    t.first_at_rest = text == "first";
    if (!t.first_at_rest) refuse(table.parameter("offset"), "\"" + text + "\"", "a number, or \"first\"");
}

void read_taxels(Section table, bool given, const Grid& grid, Load& load) {
    Taxels t;
    read_length(table, "spacing", grid, t.spacing);
    t.origin = lengths_in(table, "origin", grid, t.origin);
    table.choice("spread", t.spread);
    table.whole_number("columns", t.columns);
    table.whole_number("rows", t.rows);
    table.whole_number("skip", t.skip);
    read_unit(table, grid, load, t);
    read_offset(table, t);
    std::optional<double> rate;
    table.number("sampling_rate", rate);
    table.permit("sampling_rate", !load.interval, "not beside load.interval");
    table.finish();
    if (!given) return;
    if (!table.has("spacing")) refuse(table.parameter("spacing"), "(not given)", "a length > 0");
    if (rate && !(*rate > 0 && finite(1 / *rate)))
        refuse(table.parameter("sampling_rate"), shortest(*rate), "a finite number > 0");
    if (rate) load.interval = 1 / *rate;
    load.taxels = t;
}

// Reads the intensity, whose unit is that of a depth where the load gives one.
void read_intensity(Section& table, Load& load) {
    if (load.control != Load::Control::depth || !table.has_text("intensity"))
        return table.number("intensity", load.intensity);
    const std::string text = *table.text("intensity");
    const std::optional<double> depth = number_with_unit("load.depth", text);
    if (!depth) refuse(table.parameter("intensity"), "\"" + text + "\"", allowed_number("load.depth"));
    load.intensity = *depth;
}

void read_load(Section table, const Grid& grid, const PathBase& folder, Load& load) {
    table.choice("kind", load.kind);
    const bool map = load.kind == Load::Kind::map, sequence = load.kind == Load::Kind::sequence;
    load.path = path_in(table, map || sequence, "\"file\" or \"sequence\"", folder);
    load.map = map_in(table, map ? load.path : "", &grid, folder).values;
    table.number("interval", load.interval);
    table.choice("hold", load.hold);
    table.cell("center", grid, load.center);
    table.cells("radius", grid, load.radius);
    table.cells("radius_y", grid, load.radius_y);
    table.number("ball_radius", load.ball_radius);
    table.choice("control", load.control);
    read_intensity(table, load);
    table.choice("contact", load.contact);
    table.number("contact_share", load.contact_share);
    read_length(table, "contact_length", grid, load.contact_length);
    read_envelope(table, load.envelope);
    const bool recorded = table.has("taxels");
    read_taxels(table.section("taxels"), recorded, grid, load);
    const bool slides = table.has("texture");
    Section texture = table.section("texture");
    read_texture(texture, slides, grid, folder, load.texture);
    const bool window = table.has("window"), grating = table.has("grating");
    read_window(table.section("window"), window, load.envelope.window);
    read_grating(table.section("grating"), grating, grid, load.grating);
    table.finish();
}

void read_time(Section table, Time& time) {
    table.number("step", time.step);
    table.number("duration", time.duration);
    table.finish();
}

void read_curvature(Section table, Scene& scene) {
    table.choice("stencil", scene.stencil);
    table.choice("edges", scene.edges);
    table.finish();
}

void read_receptors(Section table, Receptors& receptors) {
    table.number("sa2_adaptation", receptors.sa2_adaptation);
    table.choice("fa2", receptors.fa2);
    std::vector<double> gains = {receptors.fa2_gains[0], receptors.fa2_gains[1]};
    table.list("fa2_gains", gains, number_in);
    if (gains.size() != 2) {
        const std::string key = table.parameter("fa2_gains");
        throw Error(Error::Code::bad_input, key,
                    key + " has " + std::to_string(gains.size()) + " numbers; allowed: two, [k_plus, k_minus]");
    }
    receptors.fa2_gains = {gains[0], gains[1]};
    Section depths = table.section("depth");
    for (const ReceptorClass& c : receptor_classes) depths.number(name(c.type), receptors.depth.*c.depth);
    depths.finish();
    Section follow = table.section("follow");
    follow.choice("sa1", receptors.follow.sa1);
    follow.choice("sa2", receptors.follow.sa2);
    follow.finish();
    table.choice("kernel", receptors.kernel);
    table.number("poisson", receptors.poisson);
    table.finish();
}

std::vector<Site> sites_in(Section table, const Grid& grid, const PathBase& folder) {
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
    for (const ReceptorClass& c : receptor_classes) densities.number(name(c.type), density.*c.density);
    densities.finish();
    int seed = 1;
    table.whole_number("seed", seed);
    table.finish();
    return by_density ? population(grid, density, static_cast<unsigned long long>(seed)) : listed;
}

std::array<double, 2> pair_in(const toml::node& node, const std::string& parameter) {
    const toml::array* pair = node.as_array();
    if (!pair || pair->size() != 2) refuse(parameter, node, "a pair, [for positive values, for negative values]");
    return {number_in((*pair)[0], parameter), number_in((*pair)[1], parameter)};
}

AfterCurrent after_current_in(const toml::node& node, const std::string& parameter) {
    if (!node.is_table()) refuse(parameter, node, "tables { amplitude = a number, time = seconds }");
    Section table(node.as_table(), parameter + ".");
    AfterCurrent current;
    table.number("amplitude", current.amplitude);
    table.number("time", current.time);
    table.finish();
    return current;
}

// Replaces the first entries by those of a list, and the others by `rest`.
template <class T, size_t n, class ReadItem>
void read_up_to(Section& table, const char* key, std::array<T, n>& values, const T& rest, ReadItem&& read_item) {
    std::vector<T> given;
    table.list(key, given, read_item);
    if (given.size() > n)
        refuse(table.parameter(key), std::to_string(given.size()) + " items", "at most " + std::to_string(n));
    if (!table.has(key)) return;
    values.fill(rest);
    std::ranges::copy(given, values.begin());
}

// Keys of the model replace the numbers of the class. drawn: the sites are drawn by density.
Afferents afferents_in(Section table, const Grid& grid, bool drawn) {
    Afferents a;
    table.choice("class", a.type);
    table.cells("cells", grid, a.cells);
    table.choice("follow", a.follow);
    table.whole_number("endings", a.endings);
    if (a.endings != 1 && drawn && !table.has("cells"))
        refuse(table.parameter("endings"), std::to_string(a.endings),
               "1 with sites.density, which draws receptors anywhere on the pad; or give the receptors that belong "
               "together by cells or sites.path");
    AfferentModel m;
    if (a.type == Quantity::sa1 || a.type == Quantity::fa1 || a.type == Quantity::fa2) m = afferent_model(a.type);
    table.list("time_constants", m.time_constants, number_in);
    for (auto [key, value] : {std::pair{"frequency", &m.frequency}, {"quality", &m.quality}}) table.number(key, *value);
    for (auto [key, value] : {std::pair{"value", &m.value},
                              {"rate", &m.rate},
                              {"membrane_time", &m.membrane_time},
                              {"refractory_time", &m.refractory_time},
                              {"reset", &m.reset}})
        table.number(key, *value);
    read_up_to(table, "gains", m.gains, {0, 0}, pair_in);
    read_up_to(table, "after", m.after, AfterCurrent(), after_current_in);
    table.finish();
    const bool given = std::ranges::any_of(std::array{"time_constants", "frequency", "quality", "value", "rate",
                                                      "membrane_time", "refractory_time", "reset", "gains", "after"},
                                           [&](const char* key) { return table.has(key); });
    if (given) a.model = m;
    return a;
}

FieldRequest field_in(const toml::node& node, const std::string& parameter) {
    if (!node.is_table()) refuse(parameter, node, "tables { at = seconds, what = [...] }");
    Section table(node.as_table(), parameter + ".");
    FieldRequest request;
    table.number("at", request.at);
    table.list("what", request.what, choice_in<Quantity>);
    table.finish();
    if (!table.has("at") || request.what.empty()) refuse(parameter, node, "both at and what");
    return request;
}

void read_output(Section table, const Grid& grid, Output& output) {
    table.list("traces", output.traces, choice_in<Quantity>);
    table.boolean("extremes", output.extremes);
    table.cells("probes", grid, output.probes);
    table.list("fields", output.fields, field_in);
    table.finish();
}

// Returns the scene with which the file's keys begin: a preset, or the defaults.
Scene preset_in(Section& top) {
    const auto preset = top.text("preset");
    if (!preset) return {};
    if (*preset != "fingertip") refuse(top.parameter("preset"), "\"" + *preset + "\"", "\"fingertip\"");
    return fingertip();
}

Scene read_all(Section top, const PathBase& folder) {
    Scene scene = preset_in(top);
    top.choice("method", scene.method);
    top.choice("model", scene.model);
    top.choice("precision", scene.precision);
    top.number("tolerance", scene.tolerance);
    top.boolean("allow_unstable", scene.allow_unstable);
    Section grid = top.section("grid"), surface = top.section("surface"), material = top.section("material");
    std::vector<Section> loads = top.sections("load");
    Section time = top.section("time"), curvature = top.section("curvature"), receptors = top.section("receptors"),
            sites = top.section("sites"), output = top.section("output");
    const bool fibres = top.has("afferents");
    std::vector<Section> afferents = top.sections("afferents");
    top.finish(); // first of all: a misspelt table is then reported, and not the keys that it should have held
    read_grid(grid, scene.grid);
    read_surface(surface, scene.grid, folder, scene.surface);
    read_material(material, scene.grid, folder, scene.material);
    read_load(loads.front(), scene.grid, folder, scene.load);
    for (size_t i = 1; i < loads.size(); ++i) read_load(loads[i], scene.grid, folder, scene.more_loads.emplace_back());
    read_time(time, scene.time);
    read_curvature(curvature, scene);
    read_receptors(receptors, scene.receptors);
    scene.sites = sites_in(sites, scene.grid, folder);
    read_output(output, scene.grid, scene.output);
    const bool drawn = sites.has("density") || sites.has("seed");
    for (Section& table : afferents) scene.afferents.push_back(afferents_in(std::move(table), scene.grid, drawn));
    if (!fibres) scene.afferents.clear(); // of no table
    return scene;
}

} // namespace

Scene read_tables(const toml::table& file, const std::filesystem::path& folder, const NamedMaps& maps, FileMaps& read,
                  std::vector<std::string>& files) {
    return read_all(Section(&file, ""), {folder, maps, read, files});
}

std::vector<std::string> known_keys() {
    std::vector<std::string> keys, no_files;
    FileMaps no_maps;
    read_all(Section(nullptr, "", &keys),
             {"", {}, no_maps, no_files}); // the readers ask for every key, whatever a file has
    return keys;
}

} // namespace dermis::scene
