// SPDX-License-Identifier: MIT
// The list of keys: what follows from a row.
#include "host/lab/scenes/key_rows.hpp"
#include "host/lab/scenes/read_rows.hpp"
#include "tests/support.hpp"

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
    CHECK(refused(length + "kind = \"rough\"\ncount = 0") == "probe.count = 0; allowed: 1..16384");
    CHECK(refused(length + "times = [1, -2]") == "probe.times = -2; allowed: a finite number >= 0");
    CHECK(refused(length + "pair = [1]") == "probe.pair = 1 numbers; allowed: two, [ , ]");
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

// What a key needs beside it, so that its range alone decides.
std::string context_of(const std::string& table, const std::string& name) {
    for (auto [keys, text] : {std::pair{" rise ", "envelope = \"ramp\"\n"},
                              {" frequency phase mean amplitude ", "envelope = \"sine\"\n"},
                              {" length period ", "envelope = \"pulse\"\n"},
                              {" contact_share contact_length ", "contact = \"crests\"\n"},
                              {" radius_y ", "kind = \"punch\"\ncontrol = \"depth\"\nintensity = 1e-5\n"},
                              {" ball_radius ", "kind = \"ball\"\ncontrol = \"depth\"\nintensity = 1e-5\n"}})
        if (table == "load." && std::string_view(keys).find(" " + name + " ") != std::string_view::npos) return text;
    if (table == "receptors.") return "kernel = \"strain\"\n";
    return table == "surface." ? "kind = \"wave\"\n" : "";
}

TEST_CASE("a number outside a key's range is refused by the key's name, and by nothing else") {
    int asked = 0;
    for (const scene::KeyRow& row : scene::key_rows()) {
        const std::string name = row.table + row.name;
        // a key whose words are a range of one number, in a table that can stand alone
        if (row.table.find('.') + 1 != row.table.size() ||
            row.type.find("NumberWithUnit") + row.type.find("float") + row.type.find("CellOrPlace") ==
                3 * std::string::npos)
            continue;
        const std::string range = row.allowed.substr(0, row.allowed.find(';'));
        std::vector<std::string> bad;
        if (range == "a finite number > 0") bad = {"0", "-1", "nan", "inf"};
        else if (range == "a finite number >= 0") bad = {"-1", "nan", "inf"};
        else if (range == "whole cells, 1..65536") bad = {"0", "65537", "1.5"};
        else if (range == "> 0, at most 1") bad = {"0", "1.5", "nan"};
        else if (range == "0..0.5") bad = {"-0.1", "0.6", "nan"};
        else if (range == "a finite number") bad = {"nan", "inf"};
        if (name == "load.interval" || name == "load.taxels" || row.table == "afferents.") continue;
        for (const std::string& value : bad) {
            std::string toml = "preset = \"fingertip\"\n[surface]\nkind = \"wave\"\n[load]\n";
            if (row.table == "load.") toml += context_of(row.table, row.name);
            CAPTURE(name);
            CAPTURE(value);
            std::vector<std::string> set = {name + "=" + value};
            if (name == "receptors.poisson") set.push_back("receptors.kernel=strain");
            if (name == "material.spring" || name == "material.dashpot") set.push_back("material.spring=1e4");
            if (set.size() > 1 && set[1].starts_with(name)) set.pop_back();
            const std::string why = refusal(Error::Code::bad_input, [&] { Scene::from_string(toml, set); });
            CHECK_MESSAGE(why.find(name + " = ") != std::string::npos, why);
            ++asked;
        }
    }
    CHECK(asked > 60);
}
