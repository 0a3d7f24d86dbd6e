// SPDX-License-Identifier: MIT
// Scene files: TOML to Scene. Knows keys, types and places; ranges are validated() 's.
#include "host/scene/scene.hpp"

#include <filesystem>
#include <map>
#include <set>

#include <toml++/toml.h>

namespace dermis {
namespace {

using Code = Error::Code;

std::string shown(const toml::node& node) {
    std::ostringstream text;
    node.visit([&](auto& n) { text << n; });
    return text.str();
}

// One table of the file. Every key is asked for by name; what is left at the end is unknown.
class Section {
  public:
    Section(const toml::table* table, std::string path) : table_(table), path_(std::move(path)) {}

    template <class T> void number(const char* key, T& value) {
        if (auto* node = find(key)) value = as_number(*node, path_ + key);
    }
    template <class T> void whole(const char* key, T& value) {
        if (auto* node = find(key)) value = as_whole(*node, path_ + key);
    }
    void boolean(const char* key, bool& value) {
        if (auto* node = find(key)) {
            if (!node->is_boolean()) refuse(*node, path_ + key, "true or false");
            value = **node->as_boolean();
        }
    }
    void cell(const char* key, std::optional<Cell>& value) {
        if (auto* node = find(key)) value = as_cell(*node, path_ + key);
    }
    std::optional<std::string> text(const char* key) {
        auto* node = find(key);
        if (!node) return {};
        if (!node->is_string()) refuse(*node, path_ + key, "a text in quotes");
        return **node->as_string();
    }
    template <class T, class Kind> void choice(const char* key, T& value, const std::map<std::string, Kind>& allowed) {
        if (auto* node = find(key)) value = as_choice(*node, path_ + key, allowed);
    }
    template <class F> void list(const char* key, F&& each) {
        if (auto* node = find(key)) {
            if (!node->is_array()) refuse(*node, path_ + key, "a list in [ ]");
            for (const toml::node& item : *node->as_array()) each(item, path_ + key);
        }
    }
    Section section(const char* key) {
        const toml::node* node = find(key);
        if (node && !node->is_table()) refuse(*node, path_ + key, "a table");
        return Section(node ? node->as_table() : nullptr, path_ + key + ".");
    }
    bool is_text(const char* key) const { return has(key) && table_->get(key)->is_string(); }
    bool has(const char* key) const { return table_ && table_->contains(key); }
    [[noreturn]] void misplaced(const char* key, const char* allowed) const {
        refuse(*table_->get(key), path_ + key, allowed);
    }

    void finish() const {
        if (!table_) return;
        std::string known;
        for (const std::string& key : asked_) known += (known.empty() ? "" : ", ") + key;
        for (auto&& [key, node] : *table_)
            if (!asked_.count(std::string(key.str())))
                refuse(node, path_ + std::string(key.str()), "no such key here; known: " + known);
    }

    [[noreturn]] static void refuse(const toml::node& node, const std::string& parameter, const std::string& allowed) {
        throw Error(Code::bad_input, parameter, parameter + " = " + shown(node) + "; allowed: " + allowed);
    }
    static double as_number(const toml::node& node, const std::string& parameter) {
        if (node.is_integer()) return double(**node.as_integer());
        if (node.is_floating_point()) return **node.as_floating_point();
        refuse(node, parameter, "a number");
    }
    static int as_whole(const toml::node& node, const std::string& parameter) {
        if (!node.is_integer() || std::abs(double(**node.as_integer())) > 1e9)
            refuse(node, parameter, "a whole number");
        return int(**node.as_integer());
    }
    static Cell as_cell(const toml::node& node, const std::string& parameter) {
        const toml::array* a = node.as_array();
        if (!a || a->size() != 2) refuse(node, parameter, "[x, y] in whole cells");
        return {as_whole((*a)[0], parameter), as_whole((*a)[1], parameter)};
    }
    template <class Kind>
    static Kind as_choice(const toml::node& node, const std::string& parameter,
                          const std::map<std::string, Kind>& allowed) {
        std::string names;
        for (auto& [text, kind] : allowed) {
            if (node.is_string() && **node.as_string() == text) return kind;
            names += (names.empty() ? "\"" : ", \"") + text + "\"";
        }
        refuse(node, parameter, names);
    }

  private:
    const toml::node* find(const char* key) {
        asked_.insert(key);
        return table_ ? table_->get(key) : nullptr;
    }

    const toml::table* table_;
    std::string path_;
    std::set<std::string> asked_;
};

const std::map<std::string, Quantity> quantities = {{"strain", Quantity::strain},
                                                    {"sa1", Quantity::sa1},
                                                    {"sa2", Quantity::sa2},
                                                    {"fa1", Quantity::fa1},
                                                    {"fa2", Quantity::fa2},
                                                    {"curvature", Quantity::curvature},
                                                    {"deformation", Quantity::deformation}};

// The `path` of a section, which must be there for some kinds and must not for others; empty without.
std::string path_in(Section& section, const std::string& name, bool wanted, const char* kinds,
                    const std::filesystem::path& folder) {
    const auto path = section.text("path");
    if (wanted != path.has_value())
        throw Error(Code::bad_input, name + ".path",
                    name + ".path = " + (path ? "\"" + *path + "\"" : "(not given)") + "; allowed: a .npy file, with " +
                        name + ".kind = " + kinds + " and only then");
    return path ? (folder / *path).string() : "";
}

Scene read(const toml::table& file, const std::filesystem::path& folder) {
    Scene s;
    Section top(&file, "");
    std::map<std::string, Method> methods;
    for (Method m = Method::exact; m <= Method::published; m = Method(int(m) + 1)) methods[name(m)] = m;
    top.choice("method", s.method, methods);
    std::map<std::string, Model> models;
    for (Model m = Model::moments; m <= Model::march; m = Model(int(m) + 1)) models[name(m)] = m;
    top.choice("model", s.model, models);
    std::map<std::string, Precision> precisions;
    for (Precision p : {Precision::f32, Precision::f32_compensated, Precision::f64}) precisions[name(p)] = p;
    top.choice("precision", s.precision, precisions);
    top.number("tolerance", s.tolerance);
    top.boolean("allow_unstable", s.allow_unstable);

    Section grid = top.section("grid");
    grid.whole("width", s.grid.width);
    grid.whole("height", s.grid.height);
    grid.number("spacing", s.grid.spacing);
    grid.finish();
    for (auto [key, cells] : {std::pair{"grid.width", s.grid.width}, {"grid.height", s.grid.height}})
        if (cells < 1 || cells > 16384) // before a map of this size is read
            throw Error(Code::bad_input, key,
                        std::string(key) + " = " + std::to_string(cells) + "; allowed: whole cells, 1..16384");

    Section surface = top.section("surface");
    using SurfaceKind = Surface::Kind;
    surface.choice("kind", s.surface.kind,
                   std::map<std::string, SurfaceKind>{{"flat", SurfaceKind::flat},
                                                      {"wave", SurfaceKind::wave},
                                                      {"spiral", SurfaceKind::spiral},
                                                      {"file", SurfaceKind::map}});
    const bool relief = s.surface.kind == SurfaceKind::map;
    const std::string relief_path = path_in(surface, "surface", relief, "\"file\"", folder);
    if (relief) s.surface.map = scene::read_npy(relief_path, s.grid.width, s.grid.height, "surface.path");
    surface.number("ridges", s.surface.ridges);
    surface.number("noise", s.surface.noise);
    surface.number("noise_length", s.surface.noise_length);
    surface.number("relief", s.surface.relief);
    surface.finish();

    Section material = top.section("material");
    const auto number_or_map = [&](const char* key, double& value, Map& map) {
        if (!material.is_text(key)) return material.number(key, value);
        const std::string path = (folder / *material.text(key)).string();
        map = scene::read_npy(path, s.grid.width, s.grid.height, std::string("material.") + key);
    };
    number_or_map("modulus", s.material.modulus, s.material.modulus_map);
    number_or_map("viscosity", s.material.viscosity, s.material.viscosity_map);
    material.number("thickness", s.material.thickness);
    material.number("curvature_length", s.material.curvature_length);
    material.finish();

    Section load = top.section("load");
    using LoadKind = Load::Kind;
    load.choice("kind", s.load.kind,
                std::map<std::string, LoadKind>{{"circular", LoadKind::circular},
                                                {"point", LoadKind::point},
                                                {"linear", LoadKind::linear},
                                                {"file", LoadKind::map},
                                                {"sequence", LoadKind::sequence}});
    const bool map = s.load.kind == LoadKind::map, sequence = s.load.kind == LoadKind::sequence;
    s.load.path = path_in(load, "load", map || sequence, "\"file\" or \"sequence\"", folder);
    if (map) s.load.map = scene::read_npy(s.load.path, s.grid.width, s.grid.height, "load.path");
    load.number("interval", s.load.interval);
    load.cell("center", s.load.center);
    load.whole("radius", s.load.radius);
    load.number("intensity", s.load.intensity);
    Envelope& e = s.load.envelope;
    using Kind = Envelope::Kind;
    load.choice("envelope", e.kind,
                std::map<std::string, Kind>{{"step", Kind::step},
                                            {"ramp", Kind::ramp},
                                            {"sine", Kind::sine},
                                            {"pulse", Kind::pulse},
                                            {"table", Kind::table}});
    const auto only = [&](const char* key, bool fits) {
        if (load.has(key) && !fits) load.misplaced(key, "only with another load.envelope");
    };
    only("start", e.kind == Kind::step || e.kind == Kind::ramp || e.kind == Kind::pulse);
    load.number("start", e.start);
    for (auto [key, value, kind] : {std::tuple{"rise", &e.rise, Kind::ramp},
                                    {"frequency", &e.frequency, Kind::sine},
                                    {"phase", &e.phase, Kind::sine},
                                    {"mean", &e.mean, Kind::sine},
                                    {"amplitude", &e.amplitude, Kind::sine},
                                    {"length", &e.length, Kind::pulse},
                                    {"period", &e.period, Kind::pulse}}) {
        only(key, e.kind == kind);
        load.number(key, *value);
    }
    for (auto [key, list] : {std::pair{"times", &e.times}, {"values", &e.values}}) {
        only(key, e.kind == Kind::table);
        load.list(key, [list = list](auto& node, const std::string& parameter) {
            list->push_back(Section::as_number(node, parameter));
        });
    }
    load.finish();

    Section time = top.section("time");
    time.number("step", s.time.step);
    time.number("duration", s.time.duration);
    time.finish();

    Section curvature = top.section("curvature");
    curvature.choice("stencil", s.stencil,
                     std::map<std::string, Stencil>{{"five-point", Stencil::five_point},
                                                    {"fourth-order", Stencil::fourth_order},
                                                    {"published", Stencil::published}});
    curvature.choice("edges", s.edges,
                     std::map<std::string, Edges>{
                         {"mirror", Edges::mirror}, {"periodic", Edges::periodic}, {"published", Edges::published}});
    curvature.finish();

    Section receptors = top.section("receptors");
    receptors.number("sa2_adaptation", s.receptors.sa2_adaptation);
    receptors.choice("fa2", s.receptors.fa2,
                     std::map<std::string, Fa2>{{"point", Fa2::point}, {"step-mean", Fa2::step_mean}});
    std::vector<double> gains;
    receptors.list("fa2_gains", [&](auto& node, const std::string& parameter) {
        gains.push_back(Section::as_number(node, parameter));
    });
    if (receptors.has("fa2_gains")) {
        if (gains.size() != 2)
            throw Error(Code::bad_input, "receptors.fa2_gains",
                        "receptors.fa2_gains has " + std::to_string(gains.size()) +
                            " numbers; allowed: two, [k_plus, k_minus]");
        s.receptors.fa2_gains = {gains[0], gains[1]};
    }
    receptors.finish();

    Section sites = top.section("sites");
    const bool drawn = sites.has("density") || sites.has("seed");
    if (const auto path = sites.text("path")) {
        if (drawn) sites.misplaced("path", "either path, or density and seed");
        s.sites = scene::read_sites((folder / *path).string());
    }
    Section density = sites.section("density");
    Density d;
    for (auto [key, value] : {std::pair{"sa1", &d.sa1}, {"sa2", &d.sa2}, {"fa1", &d.fa1}, {"fa2", &d.fa2}})
        density.number(key, *value);
    density.finish();
    int seed = 1;
    sites.whole("seed", seed);
    sites.finish();
    if (drawn) s.sites = population(s.grid, d, static_cast<unsigned long long>(seed));

    Section output = top.section("output");
    if (output.has("traces")) s.output.traces.clear();
    output.list("traces", [&](auto& node, const std::string& parameter) {
        s.output.traces.push_back(Section::as_choice(node, parameter, quantities));
    });
    output.boolean("extremes", s.output.extremes);
    output.list("probes", [&](auto& node, const std::string& parameter) {
        s.output.probes.push_back(Section::as_cell(node, parameter));
    });
    output.list("fields", [&](const toml::node& node, const std::string& parameter) {
        if (!node.is_table()) Section::refuse(node, parameter, "tables { at = seconds, what = [...] }");
        Section request(node.as_table(), parameter + ".");
        FieldRequest f;
        request.number("at", f.at);
        request.list("what", [&](auto& item, const std::string& key) {
            f.what.push_back(Section::as_choice(item, key, quantities));
        });
        request.finish();
        if (!request.has("at") || f.what.empty()) Section::refuse(node, parameter, "both at and what");
        s.output.fields.push_back(f);
    });
    output.finish();
    top.finish();
    return s;
}

// Where in the file a parameter stands: its own place, or the nearest table around it.
std::string place(const toml::table& file, const std::string& parameter) {
    const toml::node* node = &file;
    std::string key;
    for (std::istringstream parts(parameter.substr(0, parameter.find('['))); std::getline(parts, key, '.');) {
        const toml::node* inner = node->is_table() ? node->as_table()->get(key) : nullptr;
        if (!inner) break;
        node = inner;
    }
    const auto line = node->source().begin.line;
    return node != &file && line ? ":" + std::to_string(line) : "";
}

void replace(toml::table& file, const std::string& override_) {
    const size_t equals = override_.find('=');
    if (equals == std::string::npos)
        throw Error(Code::bad_input, "--set", "--set " + override_ + "; allowed: key=value, as in time.step=0.001");
    const std::string key = override_.substr(0, equals);
    toml::table value;
    try {
        value = toml::parse("value = " + override_.substr(equals + 1));
    } catch (const toml::parse_error&) { // a bare word is a text
        value = toml::table{{"value", override_.substr(equals + 1)}};
    }
    toml::table* table = &file;
    std::istringstream parts(key);
    std::string part, next;
    std::getline(parts, part, '.');
    for (; std::getline(parts, next, '.'); part = next) {
        if (!table->contains(part)) table->insert(part, toml::table{});
        if (!table->get(part)->is_table())
            throw Error(Code::bad_input, key, "--set " + override_ + ": " + part + " is not a table");
        table = table->get(part)->as_table();
    }
    table->insert_or_assign(part, *value.get("value"));
}

} // namespace

Scene Scene::from_file(const std::string& path, const std::vector<std::string>& overrides) {
    toml::table file;
    try {
        file = toml::parse_file(path);
    } catch (const toml::parse_error& e) {
        const auto line = e.source().begin.line;
        throw Error(Code::bad_input, "",
                    path + (line ? ":" + std::to_string(line) : "") + ": " + std::string(e.description()));
    }
    try {
        for (const std::string& o : overrides) replace(file, o);
        Scene s = read(file, std::filesystem::path(path).parent_path());
        scene::validated(s);
        return s;
    } catch (const Error& e) {
        throw Error(e.code(), e.parameter(), path + place(file, e.parameter()) + ": " + e.what());
    }
}

} // namespace dermis
