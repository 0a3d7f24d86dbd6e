// SPDX-License-Identifier: MIT
// The list of keys: what follows from a row.
#include "host/lab/scenes/key_rows.hpp"
#include "host/lab/scenes/read_rows.hpp"
#include "tests/support.hpp"

#include <map>
#include <set>

using namespace test;

// A table that no scene has: members and rows alone.
namespace {
enum class Kind { plain, rough };
struct Part {
    double share = 0.5;
};
struct Probe {
    Kind kind = Kind::plain;
    double length = 1;
    std::optional<int> count;
    std::vector<double> times;
    std::array<double, 2> pair = {1, 2};
    std::optional<Part> inner;
};
} // namespace
namespace dermis::scene {
template <> struct Names<Kind> {
    static constexpr Name<Kind> all[] = {{Kind::plain, "plain"}, {Kind::rough, "rough"}};
};
template <> inline constexpr auto rows<Part> = std::tuple{Key{"share", &Part::share, "", share, "", "of a whole"}};
inline constexpr Only<Probe> if_rough{"only with probe.kind = \"rough\"",
                                      [](const Probe& p) { return p.kind == Kind::rough; }};
template <>
inline constexpr auto rows<Probe> = std::tuple{Key{"kind", &Probe::kind, "", no_range, "", "of it"},
                                               Key{"length", &Probe::length, "m", positive, "required", "of it"},
                                               Key{"count", &Probe::count, "", counts, "none", "of it", if_rough},
                                               Key{"times", &Probe::times, "s", not_negative, "", "of it"},
                                               Key{"pair", &Probe::pair, "", number, "", "of it"},
                                               Key{"inner", &Probe::inner, "", no_range, "none", "of it"}};
} // namespace dermis::scene

namespace {

Probe read(const std::string& text, const Grid& grid = {}) {
    const toml::parse_result parsed = toml::parse(text);
    REQUIRE(parsed);
    scene::Section table(&parsed.table(), "probe.");
    Probe probe;
    scene::read_rows<Probe>(table, probe, &grid);
    table.finish();
    scene::check_rows("probe.", probe);
    return probe;
}

std::string refused(const std::string& text, const Grid& grid = {}) {
    return refusal(Error::Code::bad_input, [&] { read(text, grid); });
}

} // namespace

TEST_CASE("a struct with rows is read and checked by them alone") {
    const Probe p =
        read("kind = \"rough\"\nlength = \"2 mm\"\ncount = 3\ntimes = [1, 2.5]\npair = [3, 4]\ninner = { share = 1 }",
             {.spacing = 1e-3});
    CHECK(p.kind == Kind::rough);
    CHECK(p.length == 0.002);
    CHECK(p.count == 3);
    CHECK(p.times == std::vector<double>{1, 2.5});
    CHECK(p.pair == std::array<double, 2>{3, 4});
    CHECK(p.inner.value().share == 1);
    const std::string length = "length = 1\n";
    CHECK(refused("") == "probe.length = (not given); allowed: a finite number > 0");
    CHECK(refused("length = 0") == "probe.length = 0; allowed: a finite number > 0");
    CHECK(refused("length = \"2 mm\"") == "probe.length = '2 mm'; allowed: a number of cells: the grid has no spacing");
    CHECK(refused(length + "count = 3") == "probe.count = 3; allowed: only with probe.kind = \"rough\"");
    CHECK(refused(length + "kind = \"rough\"\ncount = 0") == "probe.count = 0; allowed: a whole number, 1..16384");
    CHECK(refused(length + "kind = \"rough\"\ncount = 2.5") == "probe.count = 2.5; allowed: a whole number, 1..16384");
    CHECK(refused(length + "times = [1, -2]") == "probe.times = -2; allowed: a finite number >= 0");
    CHECK(refused(length + "pair = [1]") == "probe.pair = [ 1 ]; allowed: two numbers, as [0.5, 1]");
    CHECK(refused(length + "kind = \"rouh\"") ==
          "probe.kind = 'rouh'; allowed: \"plain\", \"rough\"; did you mean rough?");
    CHECK(refused(length + "sahre = 1").find("probe.sahre = 1; no such key here; known: count, inner, kind") == 0);
}

TEST_CASE("each key of the list has a sentence and a type, and is known once") {
    std::set<std::string> names;
    for (const scene::KeyRow& row : scene::key_rows()) {
        const std::string name = row.table + row.name;
        CAPTURE(name);
        CHECK(names.insert(name).second);
        CHECK(!row.says.empty());
        CHECK(!row.type.empty());
        CHECK((row.unit.empty() || row.unit == "cells" || row.unit == "per cm2" || scene::can_be_in(row.unit)));
        CHECK(scene::unit_of_key(name) == row.unit);
    }
    CHECK(names.size() > 100);
    CHECK(scene::unit_of_key("load[3].radius") == "cells");
    CHECK(scene::unit_of_key("afferents[0].after[1].time") == "s");
    CHECK(scene::unit_of_key("load.no_such_key").empty());
}

// A scene in which a key is allowed, so that its own value alone decides, and the key's place in it.
struct Place {
    std::string toml, prefix;
};
Place place_of(const scene::KeyRow& row) {
    const std::string fingertip = "preset = \"fingertip\"\n";
    const auto in = [&](const char* names) {
        return std::string_view(names).find(" " + row.name + " ") != std::string_view::npos;
    };
    if (row.table == "surface.") return {fingertip + "[surface]\nkind = \"wave\"", row.table};
    if (row.table == "material.")
        return {in(" modulus viscosity ") ? "[material]\nmodulus = 1\nviscosity = 1" : fingertip, row.table};
    if (row.table == "material.elements.")
        return {"[material]\nelements = [{ modulus = 1, viscosity = 1 }]", "material.elements[0]."};
    if (row.table == "load.") {
        std::string load;
        for (auto [names, text] :
             {std::pair{" start rise ", "envelope = \"ramp\""},
              {" frequency phase mean amplitude ", "envelope = \"sine\""},
              {" length period ", "envelope = \"pulse\""},
              {" times values ", "envelope = \"table\"\ntimes = [0, 1]\nvalues = [0, 1]"},
              {" contact_share contact_length ", "contact = \"crests\""},
              {" radius_y ", "kind = \"punch\"\ncontrol = \"depth\"\nintensity = 1e-5"},
              {" ball_radius ", "kind = \"ball\"\nball_radius = 1\ncontrol = \"depth\"\nintensity = 1e-5"}})
            if (in(names)) load = text;
        return {fingertip + "[load]\n" + load, row.table};
    }
    if (row.table == "load.window.")
        return {fingertip + "[load]\nenvelope = \"sine\"\nwindow = { until = 9 }", row.table};
    if (row.table == "load.grating.") return {fingertip + "[load.grating]\nwavelength = 1e-3", row.table};
    if (row.table == "receptors.kernel.") return {fingertip + "[receptors.kernel]\nfa1 = \"strain\"", row.table};
    if (row.table == "receptors." || row.table == "receptors.depth.")
        return {fingertip + "[receptors]\nkernel = \"strain\"", row.table};
    if (row.table == "output.fields.")
        return {"[output]\nfields = [{ at = 0, what = [\"sa1\"] }]", "output.fields[0]."};
    const std::string fibres = fingertip + "[[afferents]]\ntype = \"fa2\"\ncells = [[1, 1]]\n"
                                           "after = [{ amplitude = 1, time = 1 }]";
    if (row.table == "afferents.") return {fibres, "afferents[0]."};
    if (row.table == "afferents.after.") return {fibres, "afferents[0].after[0]."};
    return {fingertip, row.table};
}

// What is said of a scene with one key more.
std::string said_of(const Place& place, const std::string& key, const std::string& value) {
    return refusal(Error::Code::bad_input, [&] { Scene::from_string(place.toml, {place.prefix + key + "=" + value}); });
}

// Whether the value of a key is in a file, of a table that needs one.
bool needs_file(const scene::KeyRow& row) {
    return row.table == "load.texture." || row.table == "load.taxels." ||
           (row.table == "surface." && row.name == "spacing") || (row.table == "load." && row.name == "interval");
}

TEST_CASE("a number outside a key's range is refused by the key's name and the range, and by nothing else") {
    const std::map<std::string, std::vector<const char*>> outside = {
        {"a finite number", {"nan", "inf"}},
        {"a finite number > 0", {"0", "-1", "nan", "inf"}},
        {"a finite number >= 0", {"-1", "nan", "inf"}},
        {"a finite number < 1", {"1", "nan", "-inf"}},
        {"whole cells, 1..16384", {"0", "16385", "100000", "2.5"}},
        {"whole cells, 1..65536", {"0", "65537", "2.5"}},
        {"> 0, at most 1", {"0", "1.5", "nan"}},
        {"0..0.5", {"-0.1", "0.6", "nan"}},
        {"-1e9..1e9", {"-1.1e9", "2e9", "nan"}},
        {"a whole number, 1..16384", {"0", "16385", "2.5"}},
        {"a whole number, 1..64", {"0", "65", "2.5"}},
        {"0 to 5", {"-0.1", "5.5", "nan"}},
        {"a whole number, -1e9..1e9", {"-1000000001", "2000000000", "0.5"}},
        {"a number > 0, at most 1e6; in tables of a scene also \"median\" or \"threshold\"", {"0", "2e6", "nan"}}};
    int asked = 0;
    for (const scene::KeyRow& row : scene::key_rows()) {
        const std::string range = row.allowed.substr(0, row.allowed.find("; only with"));
        if (range.empty() || range[0] == '"' || range.starts_with("only with") || range.starts_with("a list of") ||
            range == "true, false" || needs_file(row) || row.table == "material.relaxation.")
            continue;
        CAPTURE(row.table + row.name);
        REQUIRE(outside.count(range) == 1);
        for (const std::string value : outside.at(range)) {
            const std::string why =
                said_of(place_of(row), row.name, row.type == "Numbers" ? "[1, " + value + "]" : value);
            const bool own = row.name == "at" || row.name == "duration" || row.name == "period"; // a relation says more
            CHECK_MESSAGE(why.find(row.table.substr(0, row.table.find('.'))) != std::string::npos, why);
            CHECK_MESSAGE(why.find(row.name + " = ") != std::string::npos, why);
            CHECK_MESSAGE((own || why.find("allowed: " + range) != std::string::npos), why);
            ++asked;
        }
    }
    CHECK(asked > 200);
}

TEST_CASE("a key beside which another one is missing is refused, and the error says which") {
    int asked = 0;
    for (const scene::KeyRow& row : scene::key_rows()) {
        const size_t at = row.allowed.find("only with");
        if (at == std::string::npos) continue;
        CAPTURE(row.table + row.name);
        Place place{"", row.table};
        if (row.name == "start") place.toml = "[load]\nenvelope = \"sine\"";
        if (row.name == "radius") place.toml = "[load]\nkind = \"ball\"";
        const std::string why = said_of(place, row.name, row.type == "Numbers" ? "[1]" : "1");
        CHECK_MESSAGE(why.find(row.table + row.name + " = ") != std::string::npos, why);
        CHECK_MESSAGE(why.find("allowed: " + row.allowed.substr(at)) != std::string::npos, why);
        ++asked;
    }
    CHECK(asked > 15);
}

TEST_CASE("a word that a key does not have is refused with those that it takes, and a unit with the key's own") {
    int words = 0, units = 0;
    for (const scene::KeyRow& row : scene::key_rows()) {
        CAPTURE(row.table + row.name);
        if (needs_file(row) || row.table == "load.texture." || row.table == "material.relaxation.") continue;
        if (row.type.starts_with("Literal[") && row.allowed.starts_with('"')) {
            const std::string why = said_of(place_of(row), row.name, "\"bumpy\"");
            CHECK_MESSAGE(why.find(row.name + " = 'bumpy'; allowed: " + row.allowed) != std::string::npos, why);
            ++words;
        }
        if (row.allowed.starts_with("a list of ")) {
            const std::string listed = row.allowed.substr(10), why = said_of(place_of(row), row.name, "[\"bumpy\"]");
            CHECK_MESSAGE(why.find(row.name + " = 'bumpy'; allowed: " + listed) != std::string::npos, why);
            CHECK_NOTHROW(
                Scene::from_string(place_of(row).toml, {place_of(row).prefix + row.name + "=[" + listed + "]"}));
            ++words;
        }
        if (!scene::can_be_in(row.unit) || row.type == "Numbers") continue;
        const char* wrong = row.unit == "Pa" ? "\"3 Pa s\"" : "\"3 Pa\"";
        const std::string why = said_of(place_of(row), row.name, wrong);
        CHECK_MESSAGE(why.find(row.name + " = '3 Pa") != std::string::npos, why);
        CHECK_MESSAGE(why.find(scene::allowed_in_unit(row.unit)) != std::string::npos, why);
        ++units;
    }
    CHECK(words > 10);
    CHECK(units > 35);
}
