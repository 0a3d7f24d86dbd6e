// SPDX-License-Identifier: MIT
// labels: threads
// Bad input: one clear error that names parameter, value and allowed range.
#include "tests/support.hpp"

#include <filesystem>
#include <fstream>

#include <sys/stat.h>

using namespace test;

namespace {

std::filesystem::path folder() {
    const auto path = temporary("scene");
    std::filesystem::create_directories(path);
    return path;
}

std::string write(const std::string& name, const std::string& content) {
    const auto path = folder() / name;
    std::ofstream(path, std::ios::binary) << content;
    return path.string();
}

std::string npy(const std::string& descr, const std::string& shape, size_t bytes, const std::string& order = "False") {
    return npy_header(descr, shape, order) + std::string(bytes, '\0');
}

// Returns why a scene file is refused; the same text as a string must be refused alike, without the file's name.
std::string why_refused(const std::string& toml, const std::vector<std::string>& overrides = {}) {
    const std::string file = write("scene.toml", toml);
    const std::string why = refusal(Error::Code::bad_input, [&] { Scene::from_file(file, overrides); });
    const std::string text =
        refusal(Error::Code::bad_input, [&] { Scene::from_string(toml, overrides, folder().string()); });
    CHECK(why.rfind(file + ":", 0) == 0);
    CHECK(text == "scene" + why.substr(std::min(file.size(), why.size())));
    return why;
}

} // namespace

TEST_CASE(
    "a scene, map or list that is no regular file is refused at once, and a misspelt scene has its neighbour named") {
    write("first.toml", "");
    std::filesystem::create_directory(folder() / "folder.toml");
    REQUIRE(mkfifo((folder() / "pipe").c_str(), 0600) == 0);
    std::ofstream(folder() / "huge.toml").close();
    std::filesystem::resize_file(folder() / "huge.toml", (64 << 20) + 1); // has no blocks on the disk
    const auto why = [](const std::string& path) {
        return refusal(Error::Code::bad_input, [&] { Scene::from_file(path); });
    };
    const std::string in = folder().string() + "/";
    for (auto [path, says] : {std::pair{in + "frist.toml", "cannot be read (No such file or directory)"},
                              {in + "folder.toml", "is a directory"},
                              {in + "huge.toml", "has 67108865 bytes"},
                              {in + "pipe", "is a device, pipe or socket"},
                              {"/dev/zero", "is a device, pipe or socket"}}) {
        const std::string message = why(path);
        CAPTURE(message);
        CHECK(message.find(path + ": " + says + "; allowed: a scene file (TOML), a regular file of at most 64 MiB") ==
              0);
    }
    CHECK(why(in + "frist.toml").find("did you mean first.toml?") != std::string::npos);
    CHECK(why(in + "other.toml").find("did you mean") == std::string::npos);
    for (auto [file, says] : {std::pair{"/dev/zero", "is a device, pipe or socket"},
                              {"pipe", "is a device, pipe or socket"},
                              {"folder.toml", "is a directory"}}) {
        const std::string path = std::string("path = \"") + file + "\"\n";
        for (const std::string& scene : {"[load]\nkind = \"file\"\n" + path, "[sites]\n" + path}) {
            const std::string message = why(write("scene.toml", scene));
            CAPTURE(message);
            CHECK(message.find(".path = ") != std::string::npos);
            CHECK(message.find(says) != std::string::npos);
        }
    }
    std::filesystem::remove_all(folder());
}

TEST_CASE(
    "with a spacing a place may be a length: the cell that it lies in; and a radius, the nearest number of cells") {
    const std::string top = "preset = \"fingertip\"\n[grid]\nwidth = 90\nheight = 70\nspacing = \"0.1 mm\"\n";
    const Scene s = Scene::from_string(top + R"(
[load]
kind = "punch"
control = "depth"
intensity = "0.1 mm"
center = ["3 mm", 20]
radius = "0.74 mm"
radius_y = "0.76 mm"
[output]
probes = [["0.3 mm", "0.69999 mm"], [4, "6.95 mm"], ["0 mm", "0.7 mm"]]
[[afferents]]
type = "fa1"
cells = [["8.99 mm", "10 um"]]
)");
    CHECK(s.load.center->x == 30); // on the border of cells 29 and 30
    CHECK(s.load.center->y == 20);
    CHECK(*s.load.radius == 7);
    CHECK(*s.load.radius_y == 8);
    const std::vector<std::pair<int, int>> expected = {{3, 6}, {4, 69}, {0, 7}};
    REQUIRE(s.output.probes.size() == expected.size());
    for (size_t i = 0; i < expected.size(); ++i)
        CHECK(std::pair(s.output.probes[i].x, s.output.probes[i].y) == expected[i]);
    CHECK(s.afferents.at(0).cells.at(0).x == 89);
    CHECK(s.afferents.at(0).cells.at(0).y == 0);
    for (int cell = 0; cell < 90; ++cell) { // every border, whatever its decimal number is rounded to
        const std::string place = "[[\"" + std::to_string(100 * cell) + " um\", 0]]";
        CHECK(Scene::from_string(top, {"output.probes=" + place}).output.probes[0].x == cell);
    }
    refuses([&] { Scene::from_string(top + "[load]\ncenter = [\"9 mm\", 0]"); },
            "load.center = [90, 0]; allowed: [x, y] with x in 0..89");
}

TEST_CASE("a number may have a unit: it is the double nearest to the decimal number, as without the unit") {
    const Scene s = Scene::from_string(R"(
[grid]
spacing = "60 um"
[surface]
kind = "wave"
ridge_period = "0.4 mm"
relief = "1.1e2 nm"
[material]
elements = [{ modulus = "20 kPa", viscosity = "3.5kPa*s" }, { modulus = "+1e-3 GPa", viscosity = "2 mPa.s" }]
spring = "0.3 MPa"
thickness = "0.2 cm"
curvature_length = "7 \u00b5m"
[load]
intensity = "0.1 kPa"
envelope = "table"
times = ["0.1 ms", 0.5, "  3 s "]
values = [0, 1, 1]
[time]
step = "0.3 ms"
duration = "4000 us"
[receptors]
sa2_adaptation = "1.7 s"
depth.sa1 = "0.3 mm"
[output]
fields = [{ at = "0.9 ms", what = ["sa1"] }]
)");
    CHECK(s.grid.spacing == 60e-6);
    CHECK(s.surface.ridge_period == 0.4e-3);
    CHECK(s.surface.relief == 1.1e-7);
    REQUIRE(s.material.elements.size() == 2);
    CHECK(s.material.elements[0].modulus == 20e3);
    CHECK(s.material.elements[0].viscosity == 3.5e3);
    CHECK(s.material.elements[1].modulus == 1e6);
    CHECK(s.material.elements[1].viscosity == 2e-3);
    CHECK(s.material.spring == 0.3e6);
    CHECK(s.material.thickness == 0.2e-2);
    CHECK(s.material.curvature_length == 7e-6);
    CHECK(s.load.intensity == 0.1e3);
    CHECK(s.load.envelope.times == std::vector<double>{0.1e-3, 0.5, 3});
    CHECK(s.time.step == 0.3e-3);
    CHECK(s.time.duration == 4000e-6);
    CHECK(s.receptors.sa2_adaptation == 1.7);
    CHECK(s.receptors.depth.sa1 == 0.3e-3);
    REQUIRE(s.output.fields.size() == 1);
    CHECK(s.output.fields[0].at == 0.9e-3);
    CHECK(Scene::from_string("[load]\nenvelope = \"sine\"\nfrequency = \"0.25 kHz\"\nphase = \"5 mrad\"")
              .load.envelope.frequency == 250);
    const Scene zero = Scene::from_string("[load]\nintensity = \"0e9223372036854775807 kPa\""); // 0 has any exponent
    CHECK(zero.load.intensity == 0);
}

TEST_CASE("an override is one key and one value on one line, with or without blanks") {
    const std::string file = write("scene.toml", "");
    CHECK(Scene::from_file(file, {" time.step = 0.25 "}).time.step == 0.25);
    const auto why = [&](const std::string& override_) {
        return refusal(Error::Code::bad_input, [&] { Scene::from_file(file, {override_}); });
    };
    CHECK(why("time.step=1\n[load]").find("one line") != std::string::npos);
    CHECK(why("time").find("key=value") != std::string::npos);
    CHECK(why("materials.modulus=2").find("the nearest is [material]") != std::string::npos);
    CHECK(why_refused("tolerance = 1", {"tolerance.x=1"}).find(":1: --set tolerance.x=1: tolerance is not a table") !=
          std::string::npos);
    CHECK(Scene::from_file(file, {"material.modulus=100 kPa"}).material.modulus == 1e5);
    std::filesystem::remove_all(folder());
}

TEST_CASE("a scene in a string is that of a file, with the same overrides and a folder for its paths") {
    const std::string text = "[grid]\nwidth = 2\nheight = 2\n[load]\nkind = \"file\"\npath = \"load.npy\"\n";
    write("load.npy", npy("<f8", "(2, 2)", 32));
    const Scene file = Scene::from_file(write("scene.toml", text), {"time.step=0.25", "output.probes=[[1, 0]]"});
    const Scene string = Scene::from_string(text, {"time.step=0.25", "output.probes=[[1, 0]]"}, folder().string());
    CHECK(string.grid.width == 2);
    CHECK(string.load.map.values() == file.load.map.values());
    CHECK(string.load.path == file.load.path);
    CHECK(string.time.step == 0.25);
    CHECK(run(string).trace(Quantity::fa1).probes == run(file).trace(Quantity::fa1).probes);
    CHECK(Scene::from_string("").grid.width == 150);
    // without a folder from the working directory
    CHECK(refusal(Error::Code::bad_input, [&] { Scene::from_string(text); }).find("scene:6: load.path = ") == 0);
    for (const std::string table : {"load", "surface"}) // no path is no file, in the working directory too
        CHECK(refusal(Error::Code::bad_input, [&] {
                  Scene::from_string("[" + table + "]\nkind = \"file\"\npath = \"\"\n");
              }).find("scene:3: " + table + ".path = \".\": is a directory; allowed: a .npy file") == 0);
    const auto huge = [] { Scene::from_string(std::string((64 << 20) + 1, '\n')); };
    CHECK(refusal(Error::Code::bad_input, huge) == "scene: has 67108865 bytes; allowed: at most 64 MiB");
    std::filesystem::remove_all(folder());
}

TEST_CASE("text of Windows is told what helps: a backslash in quotes, and UTF-16") {
    const std::string message =
        why_refused("method = \"exact\"\r\n[load]\r\nkind = \"file\"\r\n  path = \"C:\\Users\\x\\map.npy\"\r\n");
    for (const char* part :
         {"scene.toml:4:", ": load.path: ",
          "; the line: path = \"C:\\Users\\x\\map.npy\"; a backslash in \" \" begins an escape: use single quotes, as "
          "'C:\\data', or two backslashes"})
        CHECK_MESSAGE(message.find(part) != std::string::npos, message);
    for (const std::string& bytes :
         {std::string("\xff\xfe[\0g\0", 6), std::string("\xfe\xff\0[\0g", 6), std::string("[\0g\0", 4)}) {
        const std::string file = write("wide.toml", bytes);
        CHECK(refusal(Error::Code::bad_input, [&] { Scene::from_file(file); }) ==
              file + ": is text in UTF-16; allowed: UTF-8, so save it as UTF-8");
    }
    std::filesystem::remove_all(folder());
}

TEST_CASE("too many loads are counted before any of them is checked") {
    std::string loads = "[[load]]\n[[load]]\nenvelope = \"ramp\"\nrise = -1\n";
    for (int i = 0; i < 63; ++i) loads += "[[load]]\n";
    CHECK(why_refused(loads).find("load = 65; allowed: at most 64 products of a map and an envelope in all") !=
          std::string::npos);
    std::filesystem::remove_all(folder());
}

TEST_CASE("tables and lists that are too deep for the stack are refused before they are parsed") {
    const auto repeated = [](const std::string& part, int times) {
        std::string text;
        for (int i = 0; i < times; ++i) text += part;
        return text;
    };
    const std::string too_deep = "scene.toml:3: tables and lists are too deep; allowed: 32 levels",
                      key = repeated("a.", 1000000) + "a", quoted = repeated("\"a\" . ", 1000000) + "a",
                      start = "# [[[ \"\"\"\n\n";
    for (const std::string& deep :
         {key + " = 1", quoted + " = 1", "[" + key + "]", "[[" + key + "]]", "x = { " + key + " = 1 }",
          "x = " + repeated("[", 1000000), "x = " + repeated("{ y = ", 1000000),
          "x = ['''a'''', " + repeated("[", 1000000), "x = [\"\\\"\", " + repeated("[", 1000000)}) {
        const std::string message = why_refused(start + deep);
        CHECK_MESSAGE(message.find(too_deep) != std::string::npos, message.substr(0, 200));
    }
    const std::string key_too_deep = why_refused("", {key + "=1"});
    CHECK(key_too_deep.find("--set a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a...: tables and lists are too deep") !=
          std::string::npos);
    CHECK(key_too_deep.size() < 1000);
    CHECK(why_refused("", {"x=" + repeated("[", 1000000)}).find("too deep; allowed: 32 levels") != std::string::npos);
    CHECK(why_refused("", {"\"" + key + "\"=1"}).find("too deep; allowed: 32 levels") != std::string::npos);
    CHECK(why_refused("", {"\u00e9." + key + "=1"}).find("too deep; allowed: 32 levels") != std::string::npos);
    // a scene's own depth, and dots and brackets in strings and comments
    CHECK(why_refused("x = " + repeated("[", 32) + repeated("]", 32)).find("no such key") != std::string::npos);
    CHECK(why_refused("x = \"" + key + repeated("[", 99) + "\" # " + key).find("no such key") != std::string::npos);
    CHECK(why_refused("x = '''\n" + key + repeated("{", 99) + "'''").find("no such key") != std::string::npos);
    CHECK(why_refused(repeated("a.", 31) + "a = 1").find("no such table") != std::string::npos);
    std::filesystem::remove_all(folder());
}

TEST_CASE("what the parser does not expect is refused before it is parsed, and quoted texts and comments may be in any "
          "script") {
    const std::string nameless = "scene.toml:2: a table begins without a name; allowed: letters, digits, - and _, or a "
                                 "text in quotes",
                      script = "scene.toml:2: a character that is not ASCII; allowed: in a text in quotes, and in a "
                               "comment";
    const auto refused = [](const std::string& text, const std::string& why) {
        const std::string message = why_refused(text);
        CHECK_MESSAGE(message.find(why) != std::string::npos, message);
    };
    for (const char* name : {"[.", "[ =", "[[\t.a]]", "[#", "[[ [a]]]", "[\\", "[\u00e9]"})
        refused(std::string("\n") + name, nameless);
    refused(std::string("\n[\0", 3), nameless);
    refused("\xef\xbb\xbf# first\n[.", nameless);
    for (const char* text : {"\u00e9 = 1", "x = \u00e9", "[a]\u00a0", "x = [1,\u2003 2]"})
        refused(std::string("\n") + text, script);
    for (const char* text : {"x\"\u00e9\" = 1", "'a''\u00e9' = 1", "x = 'a' \"\"\"\u00e9\"\"\""})
        refused(std::string("\n") + text,
                "scene.toml:2: a quote where no text begins; allowed: behind =, [, {, a comma");
    for (const char* text : {"\"\"\"\\\n\u00e9\"\"\"", "\"\"\"\n\\ \n\"\"\"", "\"\"\"\\\u00e9\"\"\"", "\"\\\u00a0\""})
        refused(std::string("\nx = ") + text, "scene.toml:2: a backslash in a text stands before a space");
    // no escape, or an escaped backslash
    for (const char* text : {"'''\\\n\u00e9'''", "\"\\\\\u00e9\\n\"", "\"\"\"\\\\\n\u00e9\"\"\""})
        refused(std::string("\nx = ") + text, "no such key here");
    refused("\nx = [1, }", "scene.toml:2: } closes another bracket");
    refused("\nx = { y = [] ]", "scene.toml:2: ] closes another bracket");
    for (const char* word : {"1979-05-27T07:32:00", "07:32:00", "0x1p3", "0b12", "1__0", "2'2\u00e9'", "0[\"\u00e9\"",
                             "true{'\u00e9'", "_1", "1.", ".5", "1e", "spiral", "-", "tru"}) {
        refused(std::string("\nx = ") + word, std::string("scene.toml:2: ") + word + " without quotes; allowed: ");
        refused(std::string("\nx = { y = [1,\n ") + word + "] }", std::string("scene.toml:3: ") + word + " without");
    }
    for (const char* word : {"1_000", "+1.5e-3", "-inf", "nan", "0xFf_0", "0o17", "0b10", "true", "0", "1E+05"})
        refused(std::string("x = [") + word + ", " + word + "]", "no such key here");
    // lists in several lines, and scripts where they are allowed
    refused("x = [\n[1],\n[ [] ]\n] # \u00e9\n\"\u00e9\" = '\u00e9'", "no such key here");
    CHECK(why_refused("", {"load.path=\u00e9.npy", "load.kind=file"}).find("/\u00e9.npy\": cannot be read") !=
          std::string::npos);
    std::filesystem::remove_all(folder());
}

TEST_CASE("a message is one line, whatever it quotes") {
    for (const std::string& message :
         {why_refused("\"a\\nb\" = 1"), why_refused("x = 'a'", {"a\tb=1"}), why_refused("x = \"\"\"\na\nb\"\"\"")})
        for (char c : message) CHECK(static_cast<unsigned char>(c) >= 32);
    CHECK(std::string(Error(Error::Code::io, "", "a\r\n\tb\x01").what()) == "a   b ");
    std::filesystem::remove_all(folder());
}

TEST_CASE("bad values in a Scene made by hand are refused alike") {
    Scene s;
    s.load.kind = Load::Kind::map;
    s.load.map.edit().assign(22500, 1);
    s.load.map.edit()[151] = NAN;
    refuses([&] { run(s, Device::cpu()); }, "[1, 1]");
    s.load.map.edit().resize(3);
    refuses([&] { run(s, Device::cpu()); }, "22500");
    s = {};
    s.precision = Precision::f32;
    s.load.intensity = 1e300; // finite, but not in float
    refuses([&] { run(s, Device::cpu()); }, "f64");
    s.load.intensity = 1e30;
    s.material = {1e-20, 1e-20, {}, {}};
    refuses([&] { run(s, Device::cpu()); }, "overflows");
    s = {};
    s.load.intensity = 1e308;
    refuses([&] { run(s, Device::cpu()); }, "overflows");
}

TEST_CASE("a scene file says the same as a Scene made by hand") {
    const std::string file = write("good.toml", R"(
method = "exact"
[grid]
width = 31
height = 17
spacing = 1e-4
[surface]
kind = "spiral"
ridges = 30
noise = 0.25
noise_length = 20
relief = 6e-5
[material]
modulus = 20e3
viscosity = 3
thickness = 1e-3
curvature_length = 2e-5
[load]
kind = "linear"
center = [3, 4]
radius = 9
intensity = 5e3
start = 0.013
[time]
step = 0.001
duration = 0.05
[curvature]
stencil = "fourth-order"
edges = "periodic"
[receptors]
sa2_adaptation = 0.5
fa2 = "step-mean"
fa2_gains = [1, 0.5]
[output]
traces = ["fa2", "strain"]
probes = [[1, 2], [30, 16]]
fields = [{ at = 0.02, what = ["deformation"] }]
)");
    const Scene a = Scene::from_file(file, {"load.radius=8", "time.duration=0.04", "surface.kind=wave"});
    Scene b;
    b.grid = {31, 17, 1e-4};
    b.surface = {Surface::Kind::wave, 30, 0.25, 20, 6e-5, {}};
    b.material = {20e3, 3, 1e-3, 2e-5};
    b.load = {Load::Kind::linear, Cell{3, 4}, 8, 5e3, {}, {Envelope::Kind::step, 0.013}};
    b.time = {0.001, 0.04};
    b.stencil = Stencil::fourth_order;
    b.edges = Edges::periodic;
    b.receptors = {0.5, Fa2::step_mean, {1, 0.5}};
    b.output = {{Quantity::fa2, Quantity::strain}, {{1, 2}, {30, 16}}, {{0.02, {Quantity::deformation}}}};
    const Result x = run(a, Device::cpu()), y = run(b, Device::cpu());
    REQUIRE(x.traces.size() == 2);
    CHECK(x.time.size() == 40);
    CHECK(x.traces[0].quantity == Quantity::fa2);
    for (int i = 0; i < 2; ++i) {
        CHECK(x.traces[i].mean == y.traces[i].mean);
        CHECK(x.traces[i].probes == y.traces[i].probes);
    }
    CHECK(x.fields.at(0).values == y.fields.at(0).values);
    CHECK(x.impulses.at(0).time == relative(0.013, 1e-12));
    std::filesystem::remove_all(folder());
}

TEST_CASE("a scene file takes materials and sequences from files beside it") {
    const auto doubles = [](std::initializer_list<double> values) {
        return std::string(reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(double));
    };
    write("soft.npy", npy("<f8", "(1, 2)", 0) + doubles({1.5, 3}));
    write("frames.npy", npy("<f8", "(2, 1, 2)", 0) + doubles({0, 0, 4, 4}));
    const std::string file = write("files.toml", R"(
[grid]
width = 2
height = 1
[material]
modulus = "soft.npy"
viscosity = 0.01
[load]
kind = "sequence"
path = "frames.npy"
interval = 0.1
intensity = 3
[time]
step = 0.1
duration = 3
[output]
traces = ["strain"]
probes = [[0, 0], [1, 0]]
)");
    const Trace strain = run(Scene::from_file(file), Device::cpu()).trace(Quantity::strain);
    CHECK(strain.probes[0].back() == relative(3 * 4 / 1.5, 1e-12)); // long after: sigma/E
    CHECK(strain.probes[1].back() == relative(3 * 4 / 3.0, 1e-12));
    refuses([&] { Scene::from_file(file, {"grid.height=2"}); }, "material.modulus");
    std::filesystem::remove_all(folder());
}
