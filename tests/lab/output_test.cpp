// SPDX-License-Identifier: MIT
// labels: threads command
// The files of a run and its warnings.
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/output.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <fstream>

#include <sys/resource.h>
#include <sys/wait.h>

using namespace test;
namespace fs = std::filesystem;

TEST_CASE("a folder used again holds the files of the last run or sweep alone, and those that are not dermis's") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const fs::path out = folder / "out";
    const auto run = [&](const std::string& arguments) {
        CHECK(command(folder, "run " + scene + " --device cpu --out " + out.string() + arguments).status == 0);
        std::string names;
        std::vector<fs::path> paths(fs::directory_iterator(out), {});
        std::sort(paths.begin(), paths.end());
        for (const fs::path& path : paths) names += path.filename().string() + " ";
        return names;
    };
    const std::string plain = "impulses.csv summary.json traces.csv ", none = " --set 'output.fields=[]'";
    CHECK(run("") == "curvature_t0.05.npy impulses.csv sa1_t0.05.npy summary.json traces.csv ");
    CHECK(run(none) == plain);
    std::ofstream(out / "notes.npy") << "mine";
    std::ofstream(out / "sa1_table.npy") << "mine";
    CHECK(run(none + " material.modulus=1,2,3") == "1 2 3 notes.npy runs.csv sa1_table.npy ");
    std::ofstream(out / "3/notes.txt") << "mine";
    CHECK(run(none + " material.modulus=1,2") == "1 2 3 notes.npy runs.csv sa1_table.npy ");
    CHECK_FALSE(fs::exists(out / "3/traces.csv"));
    CHECK(fs::exists(out / "3/notes.txt"));
    fs::remove_all(out / "3");
    CHECK(run(none) == "impulses.csv notes.npy sa1_table.npy summary.json traces.csv ");
    // without a summary of dermis nothing shows whose the files are
    std::ofstream(out / "summary.json") << "{}";
    std::ofstream(out / "sa1_t1.npy") << "mine";
    CHECK(run(none) == "impulses.csv notes.npy sa1_t1.npy sa1_table.npy summary.json traces.csv ");
}

TEST_CASE("plot draws a run and a sweep, and what comes into their folder next removes the pictures") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const fs::path out = folder / "out";
    const std::string run = "run " + scene + " --device cpu --out " + out.string(), plot = "plot " + out.string();
    const auto draw = [&] {
        const Outcome o = command(folder, plot);
        CHECK_MESSAGE(o.status == 0, o.err);
        CHECK(o.out == "next: xdg-open " + (out / "report.html").string() + "\n");
        const std::string page = slurp(out / "report.html");
        CHECK(page.find("http") == page.npos);
        CHECK(page.find("<img") != page.npos);
    };
    REQUIRE(command(folder, run).status == 0);
    draw();
    const std::string files = "curvature_t0.05.npy impulses.csv ", more = "sa1_t0.05.npy summary.json ";
    CHECK(names_in(out) == files + "maps.png maps.svg report.html " + more + "traces.csv traces.png traces.svg ");
    CHECK(command(folder, run + " --resume").out.find("1 of 1 runs were done before") == 0);
    REQUIRE(command(folder, run + " --set load.intensity=2").status == 0);
    CHECK(names_in(out) == files + more + "traces.csv ");
    draw();
    REQUIRE(command(folder, run + " --set load.intensity=2,3").status == 0);
    CHECK(names_in(out) == "1 2 runs.csv ");
    draw();
    CHECK(names_in(out) == "1 2 report.html runs.csv sweep.png sweep.svg ");
    REQUIRE(command(folder, run).status == 0);
    CHECK(names_in(out) == files + more + "traces.csv ");
}

TEST_CASE(
    "plot draws spikes and the pattern that moves beside foreign files, and the next run removes these pictures") {
    const Folder folder;
    const std::string scene = folder.write(
        "scene.toml", "preset = \"fingertip\"\nsites = [[\"sa1\", 10, 10]]\nafferents = { type = \"sa1\" }\n"
                      "grid = { width = 20, height = 20 }\ntime = { step = 1e-3, duration = 0.1 }\n"
                      "output = { traces = [] }\n[load]\nkind = \"linear\"\nintensity = \"30 kPa\"\n"
                      "grating = { wavelength = \"1 mm\", velocity = \"40 mm/s\" }\n");
    const std::string out = (folder / "out").string(), run = "run " + scene + " --device cpu --out " + out;
    REQUIRE(command(folder, run).status == 0);
    const std::string files = names_in(out);
    const auto loads = output::Json::parse(slurp(fs::path(out) / "summary.json"))["loads"];
    CHECK(loads.dump() == R"([{"kind":"linear","control":"pressure","intensity":30000.0,"envelope":"step",)"
                          R"("center":null,"radius":null,"radius_y":null}])");
    for (const char* foreign : {"out/fine_texture.npy", "out/runs.csv", "out/strain_t2.npy"})
        folder.write(foreign, "-");
    REQUIRE(command(folder, "plot " + out).status == 0);
    CHECK_FALSE(fs::exists(fs::path(out) / "maps.png"));
    for (const char* picture : {"events.png", "events.svg", "receptors.png", "skin.svg", "spikes.png"})
        CHECK(fs::exists(fs::path(out) / picture));
    REQUIRE(command(folder, run).status == 0);
    fs::remove(folder / "out/fine_texture.npy"), fs::remove(folder / "out/runs.csv");
    CHECK(names_in(out) == files);
}

TEST_CASE("plot refuses a folder that dermis did not write, and one of a run that was stopped") {
    const Folder folder;
    folder.write("summary.json", "{}");
    const Outcome foreign = command(folder, "plot " + (folder / "").string());
    CHECK(foreign.status == 2);
    CHECK_MESSAGE(foreign.err.find("has neither summary.json nor runs.csv of dermis; allowed: the folder") !=
                      std::string::npos,
                  foreign.err);
    folder.write("summary.json", output::made_by_dermis + "\n  \"unfinished\": true\n}\n");
    const Outcome stopped = command(folder, "plot " + (folder / "").string());
    CHECK(stopped.status == 1);
    CHECK_MESSAGE(stopped.err.find("its files are those of a run that was stopped") != std::string::npos, stopped.err);
    CHECK(command(folder, "plot").status == 2);
    CHECK_FALSE(fs::exists(folder / "report.html"));
}

TEST_CASE("a run that would cost a scene its own input is refused before it removes or writes anything") {
    const Folder folder;
    const fs::path out = folder / "out";
    const std::string to_out = " --device cpu --out " + out.string(),
                      first = folder.write("first.toml", std::string(small) + "[sites]\npath = \"sites.csv\"\n");
    folder.write("sites.csv", "type,x,y\nsa1,3,4\n");
    REQUIRE(command(folder, "run " + first + to_out).status == 0);
    fs::copy_file(folder / "sites.csv", out / "receptors.csv", fs::copy_options::overwrite_existing);
    fs::copy_file(out / "sa1_t0.05.npy", out / "height.npy");
    fs::create_symlink(out / "sa1_t0.05.npy", folder / "link.npy");
    fs::create_symlink(out, folder / "door");
    const auto map = [&](const std::string& path) {
        return "[grid]\nwidth = 20\nheight = 12\n[time]\nduration = 0.1\n[load]\nkind = \"file\"\npath = \"" + path +
               "\"\n";
    };
    const std::string field = map("out/sa1_t0.05.npy"), absolute = map((out / "sa1_t0.05.npy").string()),
                      again = field + "[output]\nfields = [{ at = 0.05, what = [\"sa1\"] }]\n",
                      grid = "[grid]\nwidth = 20\nheight = 12\n";
    const std::string before = slurp(out / "traces.csv");
    const auto refused = [&](const std::string& scene, const std::string& file, const std::string& set = "") {
        CAPTURE(scene);
        const Outcome o = command(folder, "run " + scene + to_out + set);
        CHECK(o.status == 2);
        CHECK_MESSAGE(o.err.find("dermis: " + (out / file).string() + ": is read") == 0, o.err);
        CHECK(fs::exists(out / file));
        CHECK(slurp(out / "traces.csv") == before);
    };
    for (const std::string& scene :
         {field, absolute, again, map("link.npy"), map("./door/../out//sa1_t0.05.npy"), map("door/sa1_t0.05.npy")}) {
        refused(folder.write("scene.toml", scene), "sa1_t0.05.npy");
        refused((folder / "scene.toml").string(), "sa1_t0.05.npy", " --set load.intensity=1,2");
    }
    const std::string here = "cd " + (folder / "").string() + " &&"; // a relative path as --out
    const Outcome relative = command(folder, "run scene.toml --device cpu --out ./out", here);
    CHECK(relative.err.find("sa1_t0.05.npy: is read as door/sa1_t0.05.npy") != std::string::npos);
    refused(folder.write("scene.toml", grid + "[sites]\npath = \"out/receptors.csv\"\n"), "receptors.csv");
    // what dermis plot would draw, of a run and of a sweep
    for (const std::string file : {"report.html", "surface.png", "sweep.svg"})
        for (const char* set : {"", " --set load.intensity=1,2"}) refused(folder.write("out/" + file, grid), file, set);
    // a scene that lies in its own folder of results, under the name of one
    refused(folder.write("out/curvature_t1.npy", grid), "curvature_t1.npy");
    refused(folder.write("out/runs.csv", grid), "runs.csv", " --set load.intensity=1,2");
    // a map that only a run of a sweep has, and the folder of another run
    fs::create_directory(out / "2");
    refused(folder.write("scene.toml", map("out/height.npy")), "sa1_t0.05.npy",
            " --set load.path=out/height.npy,out/sa1_t0.05.npy");
    fs::copy_file(folder / "sites.csv", out / "2/responses.npy");
    refused(folder.write("scene.toml", grid + "[sites]\npath = \"out/2/responses.npy\"\n"), "2/responses.npy",
            " --set load.intensity=1,2");
    // NEW/.. is this folder, although it is none before NEW is made
    const Outcome above =
        command(folder, "run " + folder.write("traces.csv", grid) + " --out " + (folder / "new/..").string());
    CHECK_MESSAGE(above.err.find("traces.csv: is read") != std::string::npos, above.err);
    // an input that no run touches stays
    fs::remove(out / "runs.csv");
    CHECK(command(folder, "run " + folder.write("scene.toml", map("out/height.npy")) + to_out).status == 0);
    CHECK(fs::exists(out / "height.npy"));
    CHECK_FALSE(fs::exists(out / "sa1_t0.05.npy"));
}

TEST_CASE("a warning names the figure and what to do, once") {
    Scene s;
    Result r;
    r.tau_min = r.tau_max = 0.5;
    const auto only = [&] {
        const std::vector<std::string> all = output::warnings(s, r);
        CHECK(all.size() == 1);
        return all.empty() ? "" : all[0];
    };
    CHECK(output::warnings(s, r).empty()); // nothing is known of the skin
    r.greatest_gain = 1.5;
    CHECK(only().find("|l*C| reaches 1.5: above 1 responses change sign; ") == 0);
    r.greatest_gain = 0.5;
    r.greatest_curvature = 2;
    r.kinks = 90;
    r.pressed_cells = 450;
    CHECK(only().find("the curvature has a kink in 90 of 22500 cells (0.4 %; 450 cells are pressed): ") == 0);
    r.kinks = 0;
    r.stencil_estimate = 0.5;
    CHECK(only().find("the stencil estimate is 25 % of the greatest |C|: take a finer grid") == 0);
    r.stencil_estimate = 0.1;
    CHECK(output::warnings(s, r).empty());
    r.device.name = "some GPU";
    r.device.exact = false;
    CHECK(only() == "the bits of some GPU differ from the CPU path's");
    r.device.exact = true;
    r.cells_per_ridge = 4;
    CHECK(only().find("4 cells per ridge") == 0);
}

TEST_CASE("of a curvature that no response has nothing is said, and of a measured surface what its border adds") {
    Scene s = Scene::from_file(DERMIS_TEST_DATA "/../../host/examples/held_depth.toml");
    s.time = {.step = 0.1, .duration = 2};
    CHECK(output::warnings(s, run(s)).empty());
    s.output.fields = {{1, {Quantity::curvature}}};
    CHECK_FALSE(output::warnings(s, run(s)).empty());
    s = {};
    s.grid = {20, 20, 1e-4};
    s.surface.kind = Surface::Kind::map;
    s.surface.relief = 2;
    s.surface.map = std::vector<double>(400, 0.0);
    s.surface.curvature = std::vector<double>(400, 10.0);
    s.surface.curvature.edit()[20 * 7 + 18] = -35;
    Result r;
    r.tau_min = r.tau_max = 0.5;
    const std::vector<std::string> all = output::warnings(s, r);
    REQUIRE(all.size() == 1);
    CHECK(all[0].find("the surface is curved by 70/m within two cells of the border and by 20/m further in: ") == 0);
    s.surface.curvature.edit()[20 * 7 + 17] = -35;
    CHECK(output::warnings(s, r).empty());
}

TEST_CASE("units that cannot be meant are said in a sentence") {
    Scene s;
    s.grid = {2, 1, 1e-4};
    s.surface.relief = 60e-6;
    s.material.thickness = 1e-3;
    s.material.curvature_length = 1e-5;
    Result r;
    r.tau_min = r.tau_max = 0.5;
    const auto warned = [&](const char* part) {
        const std::vector<std::string> all = output::warnings(s, r);
        CHECK(all.size() <= 1);
        return !all.empty() && all[0].find(part) != std::string::npos;
    };
    s.surface.kind = Surface::Kind::map;
    s.surface.map = {0.0, 60e-6};
    CHECK(warned("surface.relief = 6e-05 multiplies heights that span 6e-05: together 3.6e-09 m"));
    s.surface.map = {0.0, 1.0};
    CHECK_FALSE(warned(""));
    for (double tau : {1.5e-6, 1540.0}) {
        r.tau_min = r.tau_max = tau;
        CHECK(warned("the retardation time viscosity/modulus is"));
    }
    r.tau_min = 0, r.tau_max = INFINITY; // elastic and viscous cells
    CHECK_FALSE(warned(""));
    r.traces.push_back({.quantity = Quantity::strain, .mean = {0.1}, .min = {-1.5}, .max = {0.5}, .probes = {}});
    CHECK(warned("the indentation reaches 0.0015 m, beyond material.thickness = 0.001 m"));
    s.grid.spacing = {}; // without units there is nothing to compare with
    r.tau_min = r.tau_max = 1e-9;
    CHECK_FALSE(warned(""));
    s.load.kind = Load::Kind::sequence;
    s.load.interval = 1000;
    CHECK(warned("load.interval = 1000 is in seconds from frame to frame, so that a run of 10 s ends before the second "
                 "frame; with 1000 frames a second it is 0.001"));
    s.time.duration = 36000;
    CHECK(warned("a run of 36000 s has 37"));
    s.load.interval = 0.001;
    CHECK_FALSE(warned(""));
}

TEST_CASE("a picture takes nothing from the working directory, the user's matplotlibrc or an ignored SIGCHLD") {
    const Folder folder;
    const auto drawn = [&](const std::string& name, const std::string& surroundings = "") {
        const Outcome o = command(folder,
                                  "fit " DERMIS_TEST_DATA "/../../host/examples/fingerpad_relaxation.csv --elements 2 "
                                  "--out " +
                                      name,
                                  "cd '" + (folder / "").string() + "' && " + surroundings);
        CHECK_MESSAGE(o.status == 0, o.err);
        CHECK(o.out.find(name + "/fit.png") != std::string::npos);
        return slurp(folder / (name + "/fit.png"));
    };
    const std::string before = drawn("before");
    for (const char* module : {"matplotlib.py", "csv.py"})
        folder.write(module, "open('" + (folder / "ran").string() + "', 'w')\n");
    folder.write("matplotlibrc", "axes.facecolor: red\n");
    CHECK(drawn("after") == before);
    fs::create_directory(folder / "user");
    folder.write("user/matplotlibrc", "text.usetex: True\n"); // which wants LaTeX
    CHECK(drawn("usetex", "MPLCONFIGDIR='" + (folder / "user").string() + "'") == before);
    CHECK(drawn("ignored", "trap '' CHLD;") == before); // as a daemon's children inherit it
    CHECK_FALSE(fs::exists(folder / "ran"));
}

// The exit status of a command, and the most bytes that it took.
static std::pair<int, double> peak_of(const std::string& arguments) {
    int status = 0;
    rusage usage = {};
    wait4(started(DERMIS_CLI " " + arguments), &status, 0, &usage);
    return {WEXITSTATUS(status), 1024.0 * double(usage.ru_maxrss)};
}

TEST_CASE("400 runs over one map of 2 MB are planned in the memory of 2") {
    const Folder folder;
    std::ofstream(folder / "map.npy", std::ios::binary)
        << npy_header("<f8", "(512, 512)") << std::string(size_t(512) * 512 * 8, '\0');
    const std::string scene = folder.write("scene.toml", "[grid]\nwidth = 512\nheight = 512\n[load]\nkind = "
                                                         "\"file\"\npath = \"map.npy\"\n[time]\nduration = 0.02\n");
    // The most bytes of a command that is refused when its runs are planned: its folder lies in a file.
    const auto peak = [&](const char* range) {
        const auto [status, bytes] =
            peak_of("run " + scene + " --device cpu --out " + scene + "/out --set load.intensity=" + range);
        CHECK(status == 1);
        return bytes;
    };
    const double two = peak("1:2:2"), all = peak("1:2:400");
    MESSAGE(two, " and ", all, " bytes");
    CHECK(all < two + 2e7);
}

TEST_CASE("a march of a material in each cell under a sine takes at most 1.15 of the memory that its plan says") {
    const Folder folder;
    {
        std::ofstream file(folder / "modulus.npy", std::ios::binary);
        file << npy_header("<f8", "(1024, 1024)");
        std::vector<double> moduli;
        for (int i = 0; i < 1024 * 1024; ++i) moduli.push_back(1 + i * 1e-6);
        file.write(reinterpret_cast<const char*>(moduli.data()), std::streamsize(moduli.size() * sizeof(double)));
    }
    // A sine that begins with a jump: a step of no length, with coefficients of its own.
    const std::string scene =
        folder.write("scene.toml", "model = \"march\"\nprecision = \"f32\"\n[grid]\nwidth = 1024\nheight = 1024\n"
                                   "[material]\nmodulus = \"modulus.npy\"\n[load]\nenvelope = \"sine\"\n"
                                   "frequency = 5\nmean = 1\namplitude = 1\n[time]\nstep = 0.01\nduration = 0.1\n");
    const Explanation e = plan(Scene::from_file(scene), Device::cpu(1));
    const Candidate& plan = e.candidates.at(e.chosen);
    const auto [status, bytes] = peak_of("run " + scene + " --device cpu --out " + (folder / "out").string());
    CHECK(status == 0);
    MESSAGE(bytes, " bytes, planned ", plan.bytes);
    CHECK(bytes < 1.15 * plan.bytes);
}

TEST_CASE("a run ends with the greatest response of each class and its time, of a receptor with its cell") {
    Scene s;
    Result r;
    r.time = {0, 0.5, 1};
    CHECK(output::greatest_responses(s, r).empty());
    r.traces = {{.quantity = Quantity::strain, .mean = {0, 9, 0}, .min = {0, 9, 0}, .max = {0, 9, 0}},
                {.quantity = Quantity::sa1, .mean = {0, 1, 1}, .min = {0, -3, -1}, .max = {0, 2, 2.5}},
                {.quantity = Quantity::sa2, .mean = {0, 1, 1}}};
    CHECK(output::greatest_responses(s, r) == std::vector<std::string>{"greatest SA1 -3 at 0.5 s"});
    s.sites = {{Quantity::sa2, {3, 4}}, {Quantity::fa2, {5, 6}}, {Quantity::fa2, {7, 8}}};
    r.responses = {0, 0, 0, 0.25, 10, -20, 0.125, 0, 15};
    CHECK(output::greatest_responses(s, r) ==
          std::vector<std::string>{"greatest SA1 -3 at 0.5 s, SA2 0.25 s at 0.5 s in cell [3, 4]",
                                   "greatest FA2 -20 1/s^2 at 0.5 s in cell [7, 8]"});
}
