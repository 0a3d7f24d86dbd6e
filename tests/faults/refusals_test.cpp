// SPDX-License-Identifier: MIT
// Every refusal of a scene that scene_test.cpp and the list of keys (keys_test.cpp) leave out, word for word: the key,
// its value and what is allowed.
#include "host/lab/scenes/scene.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <filesystem>

using namespace test;

namespace {

struct Refused {
    std::string toml, says; // behind "scene:"
};

const std::string two = "[grid]\nwidth = 2\nheight = 2\n", units = "[grid]\nspacing = 1e-3\n";
const std::string frames = two + "[load]\nkind = \"sequence\"\npath = \"frames.npy\"\n";
const std::string chain = "[material]\nelements = [{ modulus = 1, viscosity = 1 }]\n";
const std::string table = "[load]\nenvelope = \"table\"\n", sine = "[load]\nenvelope = \"sine\"\n";
const std::string wave = "[surface]\nkind = \"wave\"\n", positive = "; allowed: a finite number > 0";
const std::string any_finite = "; allowed: a finite number";

// Files that the scenes name.
void write_files(const Folder& folder) {
    folder.write("frames.npy", npy_header("<f4", "(3, 2, 2)") + std::string(48, '\0'));
    folder.write("map.npy", npy_header("<f8", "(2, 2)") + std::string(32, '\0'));
    folder.write("head.npy", std::string("\x93NUMPY\1\0\xff\xff", 10));
    folder.write("shape.npy", npy_header("<f8", "2, 2"));
    folder.write("outside.csv", "type,x,y\nsa1,1,1\nfa2,2,0\n");
    folder.write("head.csv", "x,y,kind\n");
    folder.write("line.csv", "type,x,y\nsa1,1\n");
    folder.write("none.csv", "type,x,y\n");
}

void check(const Folder& folder, const std::vector<Refused>& all) {
    for (const Refused& r : all) {
        CAPTURE(r.toml);
        const std::string message =
            refusal(Error::Code::bad_input, [&] { Scene::from_string(r.toml, {}, (folder / "").string()); });
        std::string says = "scene:" + r.says;
        const size_t file = says.find("{}");
        if (file != says.npos) says.replace(file, 2, (folder / "").string());
        CHECK(message == says);
    }
}

} // namespace

TEST_CASE("what a sequence, an envelope and a time cannot be is refused word for word") {
    const Folder folder;
    write_files(folder);
    check(
        folder,
        {{frames + "interval = 0.1\nenvelope = \"ramp\"",
          "8: load.envelope = (given); allowed: only without load.kind = \"sequence\", which is all of the load"},
         {"method = \"euler\"\n" + frames + "interval = 0.1",
          "1: method = \"euler\"; allowed: \"exact\" with load.kind = \"sequence\""},
         {frames, "4: load.interval = (not given); allowed: seconds between frames, required with a sequence"},
         {frames + "interval = 0", "7: load.interval = 0" + positive},
         {frames + "interval = 1e-9", "7: load.interval = 1e-09; allowed: at most 1e8 frames within time.duration"},
         {frames + "interval = 0.015",
          "7: load.interval = 0.015; allowed: a whole multiple of time.step = 0.01 s for FA2 as a mean over a step; or "
          "receptors.fa2 = \"point\", or leave fa2 out of [output]"},
         {frames + "interval = 0.1\n[material]\nviscosity = 0",
          "9: material.viscosity = 0; allowed: > 0 for FA2 of a sequence; with viscosity 0 leave fa2 out of [output]"},
         {two + "[load]\nkind = \"file\"\npath = \"map.npy\"\nradius = 2",
          "7: load.radius = 2; allowed: only with load.kind \"circular\", \"point\", \"linear\" or \"punch\""},
         {two + "[load]\nkind = \"file\"\npath = \"head.npy\"",
          "6: load.path = \"{}head.npy\": has a damaged header; allowed: a .npy file of numbers, "
          "shape (2, 2)"},
         {two + "[load]\nkind = \"file\"\npath = \"shape.npy\"",
          "6: load.path = \"{}shape.npy\": has a damaged header; allowed: a .npy file of numbers, "
          "shape (2, 2)"},
         {table + "times = [1, 1, 1]\nvalues = [1, 2, 3]", "3: load.times = 1; allowed: each time at most twice"}});
}

TEST_CASE("what a surface, its lengths and its material cannot be is refused word for word") {
    const Folder folder;
    write_files(folder);
    const std::string element = "{ modulus = 1, viscosity = 1 }, ";
    std::string nine;
    for (int i = 0; i < 9; ++i) nine += element;
    check(
        folder,
        {{units + "[surface]\nrelief = 1\n[material]\nthickness = 1\ncurvature_length = 1",
          "5: material.modulus = (not given); allowed: material.modulus in Pa and material.viscosity in Pa s, required "
          "with grid.spacing; or material.elements, material.relaxation, or preset = \"fingertip\""},
         {wave + "ridge_period = 1", "3: surface.ridge_period = 1; allowed: only with grid.spacing"},
         {units + wave + "ridges = 2\nridge_period = 1",
          "5: surface.ridges = 2; allowed: not beside surface.ridge_period"},
         {"[grid]\nspacing = 1e300\n" + wave + "ridge_period = 1e-300",
          "5: surface.ridge_period = 1e-300; allowed: a period whose ridges can be counted"},
         {"[material]\nelements = [" + element + "{ modulus = 0, viscosity = 0 }]",
          "2: material.elements[1].viscosity = 0; allowed: > 0 where its modulus is 0"},
         {"[material]\nelements = [" + nine + "]", "2: material.elements = (9 elements); allowed: 1 to 8, with "
                                                   "material.spring and material.dashpot beside them"},
         {"[material]\nelements = []", "2: material.elements = []; allowed: 1 to 8, with material.spring and "
                                       "material.dashpot beside them"},
         {"method = \"euler\"\n" + chain + "spring = 2",
          "4: material.spring = 2; allowed: no spring but with method = \"exact\""},
         {"method = \"euler\"\n[material]\nelements = [" + element + "{ modulus = 1, viscosity = 0 }]",
          "3: material.elements = (one of viscosity 0); allowed: no spring but with method = \"exact\""},
         {"[receptors]\nfa2 = \"point\"\n" + chain + "spring = 2",
          "5: material.spring = 2; allowed: no spring for FA2 as a density, because a jump makes it infinite twice; "
          "with a "
          "spring set receptors.fa2 = \"step-mean\" or leave fa2 out of [output]"},
         {"method = \"published\"\n" + chain, "1: method = \"published\"; allowed: another one with material.elements"},
         {"method = \"published\"\n" + two + "[material]\nmodulus = \"map.npy\"\nviscosity = 1",
          "6: material.modulus = (a map); allowed: one number with method = \"published\""},
         {"method = \"published\"\n" + two + "[material]\nviscosity = \"map.npy\"\nmodulus = 1",
          "6: material.viscosity = (a map); allowed: one number with method = \"published\""},
         {"method = \"published\"\n[curvature]\nedges = \"mirror\"",
          "3: curvature.edges = (given); allowed: not beside method = \"published\", which sets it"},
         {"method = \"published\"\n[grid]\nheight = 1",
          "3: grid.height = 1; allowed: at least 2 with the published edges"}});
}

TEST_CASE("what receptors and outputs cannot be, and values of another kind, are refused word for word") {
    const Folder folder;
    write_files(folder);
    const std::string sites = two + "[sites]\npath = ";
    check(
        folder,
        {{sites + "\"outside.csv\"", "5: sites.path = \"{}outside.csv\":3: x = 2; allowed: a cell of the grid, a whole "
                                     "number in 0..1; the line: \"fa2,2,0\""},
         {sites + "\"head.csv\"",
          "5: sites.path = \"{}head.csv\":1: line = \"x,y,kind\"; allowed: names of columns, type,x,y, or with "
          "grid.spacing type,x_m,y_m, and id beside them"},
         {sites + "\"line.csv\"",
          "5: sites.path = \"{}line.csv\":2: line = \"sa1,1\"; allowed: 3 columns with commas between them, and "
          "decimals with a point"},
         {sites + "\"none.csv\"",
          "5: sites.path = \"{}none.csv\": holds no site; allowed: lines such as sa1,12,40 below the names"},
         {"[grid]\nspacing = 1\n[sites.density]\nsa1 = 1e9",
          "4: sites.density.sa1 = 1e+09; allowed: at most 1e8 sites of a class"},
         {"[output]\nfields = [{ at = 1, what = [\"indentation\"] }]",
          "2: output.fields.what = \"indentation\"; allowed: strain, sa1, sa2, fa1, fa2, curvature, deformation; "
          "indentation is thickness*strain, and a Skin's response"},
         {"allow_unstable = 3", "1: allow_unstable = 3; allowed: true or false"},
         {"[surface]\npath = 3", "2: surface.path = 3; allowed: a text in quotes"},
         {table + "times = 3", "3: load.times = 3; allowed: a list in [ ]"},
         {"[material]\nelements = [3]", "2: material.elements = 3; allowed: tables { modulus = Pa, viscosity = Pa s }"},
         {"[output]\nfields = [3]", "2: output.fields = 3; allowed: tables { at = .., what = .. }"},
         {"preset = \"thumb\"", "1: preset = \"thumb\"; allowed: \"fingertip\""}});
    CHECK(refusal(Error::Code::bad_input, [] { Scene::from_string("[sites.density]\nsa1 = 3"); }) ==
          "scene: grid.spacing = (not given); allowed: metres, required for sites by density");
    CHECK(refusal(Error::Code::bad_input, [] { Scene::from_string("tolerance = 1", {"tolerance.x=1"}); }) ==
          "scene:1: --set tolerance.x=1: tolerance is not a table");
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

TEST_CASE("what gratings, windows, taxels and textures cannot be is refused word for word") {
    const Folder folder;
    write_files(folder);
    const std::string grating = "[load.grating]\n", window = sine + "[load.window]\n",
                      waves = grating + "wavelength = 9\n", taxels = frames + "interval = 0.1\n[load.taxels]\n",
                      texture = two + "[load.texture]\npath = \"map.npy\"\n",
                      unit =
                          "; allowed: what 1 in the file is, as unit = \"kPa\", \"12 Pa\" for counts of 12 Pa, \"-12 "
                          "Pa\" for counts that fall with pressure, \"mN\" for the forces of taxels in a grid with "
                          "spacing; with load.control = \"depth\" as \"mm\"";
    check(
        folder,
        {{grating + "direction = 1", "1: load.grating.wavelength = (not given); allowed: a finite number > 0"},
         {waves + "velocity = inf",
          "3: load.grating.velocity = inf; allowed: at most 1e9 times load.grating.wavelength within time.duration"},
         {waves + "amplitudes = []", "3: load.grating.amplitudes = 0; allowed: 1 to 16 numbers, one for each harmonic"},
         {waves + "amplitudes = [nan]", "3: load.grating.amplitudes = nan" + any_finite},
         {waves + "phases = [1, 2]",
          "3: load.grating.phases = 2; allowed: as many numbers as load.grating.amplitudes, or none"},
         {waves + "phases = [1e17]", "3: load.grating.phases = 1e+17; allowed: -1e9..1e9"},
         {sine + waves, "2: load.envelope = (given); allowed: a step from t = 0 on with load.grating, which may have a "
                        "window"},
         {frames + "interval = 0.1\n" + waves,
          "8: load.grating = (given); allowed: none with load.kind = \"sequence\", load.texture or load.control = "
          "\"depth\""},
         {"[load]\nenvelope = \"ramp\"\n[load.window]\nstart = 1",
          "3: load.window = (given); allowed: only with load.envelope = \"sine\" or a step from t = 0 on"},
         {window + "fall = 1", "4: load.window.fall = 1; allowed: only with load.window.until"},
         {"[load.taxels]\nspacing = 1", "1: load.taxels = (given); allowed: only with load.kind = \"sequence\""},
         {taxels, "8: load.taxels.spacing = (not given); allowed: a finite number > 0"},
         {taxels + "spacing = 0", "9: load.taxels.spacing = 0" + positive},
         {taxels + "spacing = 1\norigin = [nan, 0]", "10: load.taxels.origin = nan" + any_finite},
         {taxels + "spacing = 1\ncolumns = 0", "10: load.taxels.columns = 0; allowed: 1..16384"},
         {taxels + "spacing = 1\nsampling_rate = 10",
          "10: load.taxels.sampling_rate = 10; allowed: not beside load.interval"},
         {frames + "interval = 0.1\n[load.texture]\npath = \"map.npy\"",
          "8: load.texture = (given); allowed: none with load.kind = \"sequence\""},
         {taxels + "spacing = 1\nrows = 2", "8: load.taxels.columns = (not given); allowed: a number of taxels, as "
                                            "rows = 4 and columns = 4, required with "
                                            "a CSV file"},
         {taxels + "spacing = 1\nskip = 2",
          "10: load.taxels.skip = 2; allowed: columns before the taxels of a CSV file, 0..16384"},
         {taxels + "spacing = 1", "8: load.taxels.unit = (not given)" + unit},
         {taxels + "spacing = 1\nunit = \"kg\"", "10: load.taxels.unit = \"kg\"" + unit},
         {taxels + "spacing = 1\nunit = \"mN\"", "10: load.taxels.unit = \"mN\"" + unit}, // per area of nothing
         {taxels + "spacing = 1\nunit = 0", "10: load.taxels.unit = 0; allowed: a finite number other than 0"},
         {taxels + "spacing = 1\nunit = 1\noffset = \"rest\"",
          "11: load.taxels.offset = \"rest\"; allowed: a number, or \"first\""},
         {taxels + "spacing = 1\nunit = 1\noffset = nan",
          "11: load.taxels.offset = nan; allowed: a finite number, and none beside first_at_rest"},
         {frames + "interval = 0.1\nintensity = 2\n[load.taxels]\nspacing = 1\nunit = 1",
          "8: load.intensity = 2; allowed: 1, or not given, beside load.taxels.unit"},
         {texture + "spacing = 0", "6: load.texture.spacing = 0" + positive},
         {texture + "spacing = 1e-9", "6: load.texture.spacing = 1e-09; allowed: at least 0.0009765625, the spacing of "
                                      "the grid over 1024"},
         {texture + "velocity = [1e300, 0]", "6: load.texture.velocity = 1e+300; allowed: at most 1e9 times "
                                             "load.texture.spacing within time.duration"},
         {texture + "velocity = [0, inf]", "6: load.texture.velocity = inf; allowed: at most 1e9 times "
                                           "load.texture.spacing within time.duration"}});
}

TEST_CASE("what crests, indenters, several loads and nerve fibres cannot be is refused word for word") {
    const Folder folder;
    write_files(folder);
    const std::string other = "[[load]]\n[[load]]\n", fibre = "[afferents]\ncells = [[1, 1]]\n";
    check(folder,
          {{wave + "[load]\ncontact = \"crests\"\ncontact_length = 1000",
            "5: load.contact_length = 1000; allowed: at most the longer side of the grid"},
           {"[load]\ncontrol = \"depth\"",
            "1: load.intensity = 1; allowed: only with grid.spacing where it is a depth in m"},
           {other + "[receptors]\nfollow = { sa1 = \"stress\" }\n" + chain + "spring = 1",
            "4: receptors.follow = \"stress\"; allowed: \"strain\" with several loads"},
           {other + "envelope = \"ramp\"\nrise = 0", "1: load[1].rise = 0" + positive},
           {two + "[[load]]\n[[load]]\nkind = \"sequence\"\npath = \"frames.npy\"\ninterval = 0.1",
            "4: load[1].kind = (frames); allowed: a map times an envelope with several loads"},
           {fibre + "time_constants = [1, 1, 1, 1]",
            "1: afferents[0].time_constants = 4 numbers; allowed: 1 to 3 poles: one for each time constant, two for a "
            "frequency"},
           {fibre + "gains = [[nan, 0]]", "1: afferents[0].gains = nan" + any_finite},
           {fibre + "after = [1]", "3: afferents.after = 1; allowed: tables { amplitude = .., time = .. }"}});
}
