// SPDX-License-Identifier: MIT
// labels: threads
// Every refusal of a scene's text, word for word: the key, its value and what is allowed. The texts are those of
// refused.txt; numbers outside a key's range and words that it does not have follow from the list of keys
// (keys_test.cpp).
#include "host/lab/scenes/scene.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <filesystem>
#include <fstream>

using namespace test;

namespace {

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    for (size_t at = 0; (at = text.find(what, at)) != text.npos; at += by.size()) text.replace(at, what.size(), by);
    return text;
}

// Whether a message is this one; "..." stands for any words of it.
bool is(const std::string& message, const std::string& says) {
    size_t at = 0, from = 0;
    for (size_t gap; (gap = says.find("...", from)) != says.npos; from = gap + 3) {
        const std::string part = says.substr(from, gap - from);
        const size_t found = message.find(part, at);
        if (found == message.npos || (from == 0 && found != 0)) return false;
        at = found + part.size();
    }
    const std::string end = says.substr(from);
    return from == 0 ? message == says : message.size() >= at + end.size() && message.ends_with(end);
}

// Files that the scenes name.
void write_files(const Folder& folder) {
    const auto map = [&](const std::string& name, const std::vector<double>& values, const std::string& shape) {
        const std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
        folder.write(name, npy_header("<f8", shape) + bytes);
    };
    const auto zeros = [&](const std::string& name, const std::string& descr, const std::string& shape, size_t bytes,
                           const std::string& order = "False") {
        folder.write(name, npy_header(descr, shape, order) + std::string(bytes, '\0'));
    };
    map("map.npy", {0, 0, 0, 0}, "(2, 2)");
    map("pull.npy", {1, 1, 1, -1}, "(2, 2)");
    map("stiff.npy", {1, 1, 1, 1e5}, "(2, 2)");
    map("nan.npy", {0, 0, 0, NAN}, "(2, 2)");
    map("frames.npy", std::vector<double>(12, 0), "(3, 2, 2)");
    map("bad_frames.npy", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, NAN, 0}, "(3, 2, 2)");
    zeros("short.npy", "<f8", "(2, 2)", 31);
    zeros("long.npy", "<f8", "(2, 2)", 33);
    zeros("wide.npy", "<f8", "(2, 3)", 48);
    zeros("complex.npy", "<c8", "(2, 2)", 16);
    zeros("shape.npy", "<f8", "2, 2", 32);
    // contradictory headers: readers differ in which one they take
    zeros("types.npy", "<f8', 'descr': '<f4", "(2, 2)", 32);
    zeros("orders.npy", "<f8", "(2, 2)", 32, "True, 'fortran_order': False");
    zeros("shapes.npy", "<f8", "(2, 2), \"shape\": (4, 1)", 32);
    folder.write("fields.npy", replaced(npy_header("X", "(2, 2)"), "'X'", "[('p', '<f8')]") + std::string(32, '\0'));
    folder.write("head.npy", std::string("\x93NUMPY\1\0\xff\xff", 10));
    folder.write("text.npy", "hello");
}

} // namespace

TEST_CASE("what a scene cannot be is refused word for word, from a file and from a string") {
    const Folder folder;
    write_files(folder);
    std::ifstream list(data("refused.txt"));
    std::map<std::string, std::string> names;
    size_t asked = 0;
    for (std::string line; std::getline(list, line);) {
        if (line.empty() || line[0] == '#') continue;
        if (const size_t at = line.find(" := "); at != line.npos) {
            names["@" + line.substr(0, at) + ";"] = line.substr(at + 4);
            continue;
        }
        CAPTURE(line);
        const size_t arrow = line.find(" => ");
        REQUIRE(arrow != line.npos);
        std::string text = line.substr(0, arrow), says = replaced(line.substr(arrow + 4), "{}", (folder / "").string());
        for (const auto& [name, stands_for] : names) text = replaced(text, name, stands_for);
        text = replaced(text, " | ", "\n");
        const auto refused = [&](auto&& scene) {
            const std::string why = refusal(Error::Code::bad_input, [&] { run(scene()); });
            CHECK_MESSAGE(is(why, says), why);
        };
        refused([&] { return Scene::from_string(text, {}, (folder / "").string()); });
        const std::string file = folder.write("scene.toml", text);
        if (says.rfind("scene:", 0) == 0) says = file + says.substr(5);
        refused([&] { return Scene::from_file(file); });
        ++asked;
    }
    CHECK(asked > 200);
}

TEST_CASE("what no file can say is refused word for word in a Scene made by hand") {
    const auto why = [](auto&& change) {
        Scene s = small_scene(4, 3);
        change(s);
        return refusal(Error::Code::bad_input, [&] { run(s, Device::cpu(1)); });
    };
    CHECK(why([](Scene& s) {
              s.surface.kind = Surface::Kind::map;
              s.surface.map.edit().assign(11, 0);
          }) == "surface.path = 11; allowed: width*height = 12 cells, row 0 first");
    CHECK(why([](Scene& s) { s.material.viscosity_map.edit().assign(13, 1); }) ==
          "material.viscosity = 13; allowed: width*height = 12 cells, row 0 first");
    CHECK(why([](Scene& s) {
              s.sites = {{Quantity::strain, {1, 1}}};
          }) == "sites[0] = \"strain\"; allowed: sa1, sa2, fa1, fa2");
    const auto in_series = [](Scene& s) {
        s.material.modulus = s.material.viscosity = {};
        s.material.elements = {{1, 1}};
    };
    CHECK(why([&](Scene& s) { in_series(s), s.material.modulus = 2; }) ==
          "material.modulus = 2; allowed: not beside material.elements");
    CHECK(why([&](Scene& s) { in_series(s), s.material.viscosity = 2; }) ==
          "material.viscosity = 2; allowed: not beside material.elements");
    CHECK(why([&](Scene& s) { in_series(s), s.material.modulus_map.edit().assign(12, 1); }) ==
          "material.modulus = (a map); allowed: not beside material.elements, which take maps of their own");
    CHECK(why([&](Scene& s) { in_series(s), s.material.elements[0].modulus_map.edit().assign(11, 1); }) ==
          "material.elements[0].modulus = 11; allowed: width*height = 12 cells, row 0 first");
    CHECK(why([&](Scene& s) { in_series(s), s.material.elements[0].viscosity_map.edit().assign(11, 1); }) ==
          "material.elements[0].viscosity = 11; allowed: width*height = 12 cells, row 0 first");
}

TEST_CASE("a sequence that becomes shorter while it is read is refused word for word") {
    const Folder folder;
    write_files(folder);
    const std::string path = (folder / "frames.npy").string();
    scene::NpyFile file(path, 2, 2, true, "load.path");
    std::vector<double> values;
    file.read(2, values);
    CHECK(values == std::vector<double>(4, 0));
    std::filesystem::resize_file(path, 100);
    CHECK(refusal(Error::Code::bad_input, [&] { file.read(2, values); }) ==
          "load.path = \"" + path + "\": is cut short; allowed: a .npy file of numbers, shape (frames, 2, 2)");
}
