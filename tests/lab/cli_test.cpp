// SPDX-License-Identifier: MIT
// labels: device threads command
// The command as a user meets it: exit status, messages, files.
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/output.hpp"
#include "host/lab/scenes/key_rows.hpp"
#include "host/lab/scenes/scene.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <thread>
#include <utility>

#include <sys/wait.h>
#include <unistd.h>

using namespace test;
namespace fs = std::filesystem;

TEST_CASE("dermis run writes traces, impulses, fields and a summary") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    for (const char* device : {"cpu", "vulkan"}) {
        const fs::path out = folder / device;
        const Outcome o =
            command(folder, "run " + scene + " --check --verbose --device " + device + " --out " + out.string());
        CHECK(o.status == 0);
        CHECK(o.err.empty());
        CHECK(o.out.find(" 0 different") != std::string::npos);
        CHECK(o.out.find("tau = 0.649351 s, z = dt/tau = 0.0154") != std::string::npos);
        CHECK(o.out.find("greatest SA1 ") == 0); // results first
        CHECK(o.out.find("\ngreatest FA1 ") < o.out.find(" different\n"));
        CHECK(o.out.ends_with("\nopen first: " + (out / "traces.csv").string() + "\nnext: dermis plot " + out.string() +
                              "\n"));
        const Columns traces = read_csv((out / "traces.csv").string());
        CHECK(traces.at("time").size() == 10);
        CHECK(traces.count("strain_mean") + traces.count("fa2_max") + traces.count("sa1_probe0") == 3);
        CHECK(slurp(out / "impulses.csv").find("time,quantity,mean,min,max,probe0\n0,fa2,") == 0);
        CHECK(slurp(out / "sa1_t0.05.npy").substr(0, 6) == "\x93NUMPY");
        CHECK(fs::file_size(out / "curvature_t0.05.npy") == 128 + 20 * 12 * 8);
        CHECK(slurp(out / "summary.json").find("\"different\": 0") != std::string::npos);
        for (const auto& entry : fs::directory_iterator(out)) CHECK(entry.path().extension() != ".part");
    }
    CHECK(slurp(folder / "cpu" / "traces.csv") == slurp(folder / "vulkan" / "traces.csv"));
    const fs::path means = folder / "means";
    CHECK(command(folder, "run " + scene + " --set output.extremes=false --out " + means.string()).status == 0);
    CHECK(slurp(means / "traces.csv").find("time,strain_mean,sa1_mean,sa2_mean,fa1_mean,fa2_mean,strain_probe0,") == 0);
    CHECK(slurp(means / "impulses.csv").find("time,quantity,mean,probe0\n0,fa2,") == 0);
    CHECK(slurp(folder / "cpu" / "sa1_t0.05.npy") == slurp(folder / "vulkan" / "sa1_t0.05.npy"));
}

TEST_CASE("bad input: one line that says what, exit status 2, no output left behind") {
    const Folder folder;
    const std::string good = folder.write("good.toml", small), bad = folder.write("bad.toml", "[time]\nstep = 0\n");
    const fs::path out = folder / "out";
    const std::pair<std::string, const char*> calls[] = {
        {"run " + bad, "bad.toml:2: time.step = 0; allowed: a finite number > 0"},
        {"run " + (folder / "none.toml").string(), "none.toml"},
        {"run " + good + " --set time.step=-1", "time.step = -1"},
        {"run " + good + " --set time", "key=value"},
        {"run " + good + " --set surface.kind=bumpy", "bumpy"},
        {"run " + good + " --device voodoo", "voodoo"},
        {"run " + good + " --device vulkan --precision f64", "f64"},
        {"run " + good + " --precision f16", "f16"},
        {"run " + good + " --colour red", "--colour"},
        {"run " + good + " --devise cpu",
         "\"--devise\" is no option of run; allowed: --help, --out, --device, "
         "--precision, --check, --resume, --verbose, --json, --set, --keys; did you mean "
         "--device?\n"},
        {"plan --precison=f32 " + good, "did you mean --precision?"},
        {"run " + good + " --tolerence 1e-3", "did you mean --set tolerance=VALUE?"},
        {"run " + good + " --material.modulus=2", "did you mean --set material.modulus=VALUE?"},
        {"--versoin", "\"--versoin\" is no option of dermis; allowed: --help, --version; did you mean --version?"},
        {"walk", "\"walk\" is no subcommand; allowed: run, plot, plan, bench, fit, devices, check\n"},
        {"rnu", "did you mean run?"},
        {"run " + good + " --set load.radius=3 --set load.radius=4", "--set load.radius=4; allowed: load.radius once"},
        {"run " + good + " --set load.radius=3 time.step=0.1 load.radius=4", "load.radius once"},
        {"run " + good + " --set load.radius=", "--set load.radius=; allowed: a value"},
        {"run " + good + " --set load.radius=1,,2", "--set load.radius=1,,2; allowed: a value"},
        {"run " + good + " --set 'output.probes=[[1,2]'", "brackets and quotes that are closed"},
        {"run " + good + " --set material.modulus=1:2:0.5", "first:last:count"},
        {"run " + good + " --set material.modulus=1:2", "first:last:count"},
        {"run " + good + " --set material.modulus=0:2:3:log", "first:last:count:log with first and last > 0"},
        {"run " + good + " --set material.modulus=2:log", "first:last:count"},
        {"run " + good + " --set material.modulus=1:2:1000 load.intensity=1:2:1000", "at most 100000 runs"},
        {"run " + good + " --set load.radius=2147483647", "load.radius = 2147483647; allowed: whole cells, 1..65536"},
        {"run", "scene is required"},
        {"run " + good + " more.toml", "more.toml"},
        {"fit " + good + " --elements many", "many"},
        {"run /dev/zero", "/dev/zero: is a device"},
        {"run /tmp", "/tmp: is a directory"},
    };
    for (const auto& [call, says] : calls) {
        CAPTURE(call);
        const Outcome o = command(folder, call + " --out " + out.string());
        CHECK(o.status == 2);
        CHECK_MESSAGE(o.err.find(says) != std::string::npos, o.err);
        CHECK(o.err.find("dermis: ") == 0);
        CHECK(o.err.find('\n') == o.err.size() - 1);
        CHECK_FALSE(fs::exists(out));
    }
}

TEST_CASE(
    "a driver's file that is not JSON is found by what the error says; auto uses the CPU; devices tell the uuid") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small), broken = folder.write("icd.json", "no JSON"),
                      icds = "VK_DRIVER_FILES=" + broken + " VK_ICD_FILENAMES=" + broken;
    const std::string cause = "VK_LOADER_DEBUG=error names"; // loaders differ: a call that failed, or no driver
    const Outcome devices = command(folder, "devices", icds);
    CHECK(devices.status == 0);
    CHECK(devices.out.find(cause) != std::string::npos);
    const Outcome automatic =
        command(folder, "run " + scene + " --precision f32 --out " + (folder / "a").string(), icds);
    CHECK(automatic.status == 0);
    CHECK(automatic.out.find(cause) != std::string::npos);
    const std::string uuid = Device::open("vulkan").info().uuid;
    REQUIRE(uuid.size() == 36);
    CHECK(command(folder, "devices").out.find(", " + uuid) != std::string::npos);
    CHECK(command(folder, "run " + scene + " --device " + uuid + " --out " + (folder / "b").string()).status == 0);
    CHECK(slurp(folder / "b" / "summary.json").find("\"uuid\": \"" + uuid + "\"") != std::string::npos);
}

TEST_CASE("without a driver auto says so in one line and uses the CPU; vulkan names what is missing") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small),
                      none = "VK_DRIVER_FILES=/dev/null VK_ICD_FILENAMES=/dev/null";
    const std::string call = "run " + scene + " --verbose --out " + (folder / "a").string();
    const Outcome automatic = command(folder, call + " --precision f32", none);
    CHECK(automatic.status == 0);
    CHECK(automatic.out.find("no Vulkan device used: the Vulkan loader finds no driver") != std::string::npos);
    CHECK(automatic.out.find("march, f32 on cpu") != std::string::npos);
    const Outcome maps = command(folder, call, none); // needs no device, so none is looked for
    CHECK(maps.out.find("maps, f64 on cpu") != std::string::npos);
    CHECK(maps.out.find("Vulkan") == std::string::npos);
    const Outcome vulkan = command(folder, "run " + scene + " --device vulkan --out " + (folder / "b").string(), none);
    CHECK(vulkan.status == 1);
    CHECK(vulkan.err.find("finds no driver (on Debian: mesa-vulkan-drivers)") != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "b"));
    CHECK(command(folder, "devices", none).out.find("no Vulkan device") != std::string::npos);
}

TEST_CASE(
    "bench says how long a press of the scene's skin takes, by threads and on a device; bad input gets status 2") {
    const Folder folder;
    const std::string pad = folder.write("pad.toml", "preset = \"fingertip\"\n[grid]\nwidth = 4\nheight = 6\n"
                                                     "[time]\nstep = 0.002\n"),
                      refused = folder.write("refused.toml", "[time]\nstep = 0\n");
    const auto begins = [](const std::string& text, const std::string& with) { return text.find(with) == 0; };
    for (const char* device : {"cpu", "vulkan"}) {
        const Outcome o = command(folder, "bench " + pad + " --count 12 --device " + device);
        CHECK(o.status == 0);
        CHECK(o.err.empty());
        CHECK_MESSAGE(begins(o.out, "12 pads of 4 x 6: "), o.out);
        CHECK(o.out.find(" us per press on 1 thread, ") != o.out.npos);
        CHECK(o.out.find(" % of a step of 2 ms") != o.out.npos);
        CHECK((o.out.find(Device::list()[0].name) != o.out.npos) == (device == std::string("vulkan")));
        CHECK(o.out.substr(o.out.find('\n') + 1) == "next: dermis plan " + pad + "\n");
    }
    CHECK(begins(command(folder, "bench " + pad + " --device cpu").out, "4 x 6: "));
    for (const auto& [call, says] : {std::pair{"bench " + pad + " --count 0", "count = 0; allowed: 1..1048576"},
                                     {"bench " + pad + " --count many", "many"},
                                     {"bench " + pad + " --device voodoo", "voodoo"},
                                     {"bench " + refused, "time.step = 0"},
                                     {std::string("bench"), "scene is required"}}) {
        const Outcome o = command(folder, call);
        CHECK(o.status == 2);
        CHECK_MESSAGE(o.err.find(says) != o.err.npos, o.err);
        CHECK(o.out.empty());
    }
}

// A change that means to change bits changes these hashes, and says so in CHANGELOG.md.
TEST_CASE("dermis devices lists, dermis check compares every kernel and a run of touch, and prints these hashes") {
    const Folder folder;
    const Outcome devices = command(folder, "devices");
    CHECK(devices.status == 0);
    CHECK(devices.out.find("cpu: ") == 0);
    CHECK(devices.out.find(Device::list()[0].name) != std::string::npos);
    for (const char* device : {"check", "check --device cpu"}) {
        const Outcome check = command(folder, device);
        CHECK(check.status == 0);
        for (const char* part :
             {": press 5686e7a42263fab5 0 of ", "; reduce f84ebb9b8c99e937 0 of ", "; sites 0111ea184e96e0b7 0 of ",
              "; touch 170eb93f5238f415 0 of ", " differ; exact\n", "\nnext: dermis run "})
            CHECK_MESSAGE(check.out.find(part) != std::string::npos, check.out);
    }
}

TEST_CASE("the program needs no Vulkan loader to start, and the CPU path loads none") {
    const Folder folder;
    const std::string run = "run " + folder.write("scene.toml", small) + " --precision f32 --out ",
                      traced = "LD_DEBUG=files LD_DEBUG_OUTPUT=" + (folder / "loaded").string();
    for (const char* device : {"cpu", "vulkan"}) {
        command(folder, run + (folder / device).string() + " --device " + device, traced);
        std::string loaded;
        for (const auto& file : fs::directory_iterator(folder / ""))
            if (file.path().filename().string().find("loaded") == 0) {
                loaded += slurp(file.path());
                fs::remove(file.path());
            }
        CHECK((loaded.find("libvulkan.so.1") != std::string::npos) == (std::string(device) == "vulkan"));
    }
    CHECK(fs::exists(folder / "cpu" / "summary.json"));
    const std::string list = (folder / "needed").string();
    REQUIRE(std::system(("readelf -d " DERMIS_CLI " >" + list).c_str()) == 0);
    CHECK(slurp(list).find("NEEDED") != std::string::npos);
    CHECK(slurp(list).find("vulkan") == std::string::npos);
}

TEST_CASE("work longer than a second shows progress on a terminal; shorter work, and a pipe, see none") {
    const Folder folder;
    for (auto [terminal, seconds] : {std::pair{true, 1.2}, {true, 0.1}, {false, 1.2}}) {
        CAPTURE(terminal);
        CAPTURE(seconds);
        const std::string path = (folder / "progress").string();
        FILE* file = std::fopen(path.c_str(), "w");
        {
            output::Progress progress("marching", terminal, file);
            progress(0.25);
            std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
            progress(0.5);
        }
        std::fclose(file);
        const std::string shown = slurp(path);
        if (terminal && seconds > 1) {
            CHECK(shown.find("marching  50 %, ") != std::string::npos);
            CHECK(shown.find(" s left") != std::string::npos);
            CHECK(shown.find("25 %") == std::string::npos);
            CHECK(shown.substr(shown.size() - 4) == "\r\033[K"); // taken away at the end
        } else {
            CHECK(shown.empty());
        }
    }
    // the command itself, piped
    const std::string call = "run " +
                             folder.write("scene.toml", "[grid]\nwidth = 500\nheight = 500\n[time]\nduration = 10\n") +
                             " --device cpu --precision f64 --out " + (folder / "out").string();
    CHECK(command(folder, call).err.empty());
}

TEST_CASE("several values of a key make a sweep: a folder for each, and a table") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const Outcome o = command(folder, "run " + scene + " --device cpu --out " + (folder / "s").string() +
                                          " --set material.modulus=1,2 --set material.viscosity=0.5,1,2");
    CHECK(o.status == 0);
    CHECK(fs::exists(folder / "s/6/traces.csv"));
    CHECK_FALSE(fs::exists(folder / "s/7"));
    std::ifstream table(folder / "s/runs.csv");
    std::string line, all;
    while (std::getline(table, line)) all += line + "\n";
    CHECK(all.find("6,maps,f64") != std::string::npos);
    CHECK(all.find("material.modulus=2 material.viscosity=0.5") != std::string::npos);
    const Outcome alone = command(folder, "run " + scene + " --device cpu --out " + (folder / "a").string() +
                                              " --set material.modulus=2 --set material.viscosity=0.5");
    CHECK(alone.status == 0);
    const auto text = [&](const char* file) {
        std::ifstream in(folder / file);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    CHECK(text("s/4/traces.csv") == text("a/traces.csv"));
    CHECK(command(folder, "run " + scene + " --out " + (folder / "b").string() + " --set time.step=0.1,-1").status ==
          2);
    CHECK_FALSE(fs::exists(folder / "b"));
}

// The sets of runs.csv, each as it stands there.
std::vector<std::string> sets_of(const fs::path& table) {
    std::vector<std::string> sets;
    std::ifstream in(table);
    static const std::regex last(",\"([a-z_.]+=.*)\"$");
    for (std::string line; std::getline(in, line);)
        if (std::smatch found; std::regex_search(line, found, last)) sets.push_back(found[1]);
    return sets;
}

TEST_CASE("one --set takes several keys, ranges, lists and texts, before the scene and after it") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small), out = (folder / "s").string();
    const auto run = [&](const std::string& arguments) {
        const Outcome o = command(folder, "run --device cpu --out " + out + " " + arguments);
        CHECK_MESSAGE(o.status == 0, o.err);
        return sets_of(folder / "s/runs.csv");
    };
    const auto same = [](const std::vector<std::string>& a, const std::vector<std::string>& b) { return a == b; };
    CHECK(same(run("--set material.modulus=0.1:1:4 time.step=0.02 " + scene),
               {"material.modulus=0.1 time.step=0.02", "material.modulus=0.4 time.step=0.02",
                "material.modulus=0.7 time.step=0.02", "material.modulus=1 time.step=0.02"}));
    CHECK(same(run("--set material.modulus=0.1:1000:5:log " + scene),
               {"material.modulus=0.1", "material.modulus=1", "material.modulus=10", "material.modulus=100",
                "material.modulus=1000"}));
    CHECK(same(run(scene + " --set=load.radius=3:1:3 material.viscosity=1"),
               {"load.radius=3 material.viscosity=1", "load.radius=2 material.viscosity=1",
                "load.radius=1 material.viscosity=1"}));
    CHECK(same(
        run(scene + " --set load.radius=2,4:6:2 --set material.modulus=1"),
        {"load.radius=2 material.modulus=1", "load.radius=4 material.modulus=1", "load.radius=6 material.modulus=1"}));
    CHECK(same(
        run(scene + " --set 'output.traces=[\"strain\",\"sa1\"],[]' 'surface.kind=\"flat\"'"),
        {R"(output.traces=[""strain"",""sa1""] surface.kind=""flat"")", R"(output.traces=[] surface.kind=""flat"")"}));
    CHECK(slurp(folder / "s/1/traces.csv").find("time,strain_mean,strain_min,strain_max,sa1_mean") == 0);
    CHECK(same(run(scene + " --set surface.kind=flat,\"'spiral'\""), {"surface.kind=flat", "surface.kind='spiral'"}));
    CHECK(command(folder, "run --help").out.find("first:last:count") != std::string::npos);
    const Outcome plans = command(folder, "plan --device cpu " + scene + " --set material.modulus=1,2");
    CHECK(plans.out.find("material.modulus=1\n") == 0);
    CHECK(plans.out.find("\nmaterial.modulus=2\n") != std::string::npos);
    CHECK(command(folder, "").err ==
          "dermis: a subcommand is required; allowed: run, plot, plan, bench, fit, devices, check\n");
}

TEST_CASE("a standard output that cannot be written is an error") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    for (const std::string& call :
         {"run " + scene + " --device cpu --out " + (folder / "out").string(), "plan " + scene + " --device cpu",
          std::string("check --device cpu"), std::string("devices"), std::string("--help")}) {
        CAPTURE(call);
        const std::string err = (folder / "err").string();
        const int status = std::system((DERMIS_CLI " " + call + " >/dev/full 2>" + err).c_str());
        CHECK(WEXITSTATUS(status) == 1);
        CHECK(slurp(err) == "dermis: standard output cannot be written (No space left on device)\n");
    }
}

TEST_CASE("a summary says what is not known, and how long a check took") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", std::string(small) + "[sites]\npath = \"sites.csv\"\n");
    folder.write("sites.csv", "type,x,y\nsa1,3,4\n");
    const fs::path out = folder / "out";
    const auto summary = [&](const std::string& arguments) {
        const Outcome o = command(folder, "run " + scene + " --device cpu --out " + out.string() + arguments);
        CHECK_MESSAGE(o.status == 0, o.err);
        CHECK(o.out.find("warning: |l*C|") ==
              (arguments.find("fields") != std::string::npos ? std::string::npos : o.out.find("warning: ")));
        return slurp(out / "summary.json");
    };
    const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
    const std::string whole = summary("");
    CHECK(has(whole, "\"greatest_gain\": 1.2"));
    CHECK(has(whole, "\"kinks\": 5,\n  \"pressed_cells\": 25"));
    CHECK(has(whole, "\"warnings\": [\n    \"|l*C| reaches 1.25: above 1 responses change sign"));
    const std::string sites = summary(" --set 'output.traces=[]' 'output.fields=[]'");
    CHECK(has(sites, "\"model\": \"sites\""));
    CHECK(has(sites, "\"greatest_gain\": null,\n  \"greatest_curvature\": null,\n  \"stencil_estimate\": null"));
    CHECK(has(sites, "\"kinks\": null,\n  \"pressed_cells\": null"));
    const Outcome checked = command(folder, "run " + scene + " --check --verbose --device cpu --out " + out.string());
    CHECK_FALSE(has(slurp(out / "summary.json"), "\"seconds\": 0,"));
    CHECK(has(checked.out, " s with the other backend and the comparison\n"));
}

TEST_CASE("a table of runs has a column for each key, and where each trace ends and peaks") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const std::string set = " --set 'surface.kind=\"wave\",flat' 'output.traces=[\"sa1\",\"fa2\"],[\"fa1\"]' "
                            "'output.probes=[[3,4]]' precision=f64";
    REQUIRE(command(folder, "run " + scene + " --device cpu --out " + (folder / "s").string() + set).status == 0);
    const auto rows_of = [&](const std::string& file) {
        std::vector<std::vector<std::string>> rows;
        std::ifstream in(folder / file);
        for (std::string line; std::getline(in, line);) {
            rows.emplace_back();
            bool quoted = false;
            std::string cell;
            for (const char c : line + ",")
                if (c == ',' && !quoted) rows.back().push_back(std::exchange(cell, ""));
                else if (c == '"') quoted = !quoted;
                else cell += c;
        }
        return rows;
    };
    const auto table = rows_of("s/runs.csv");
    REQUIRE(table.size() == 5);
    const auto value = [&](size_t run, const std::string& column) {
        const auto at = std::ranges::find(table[0], column);
        REQUIRE_MESSAGE(at != table[0].end(), column);
        return table[run].at(size_t(at - table[0].begin()));
    };
    CHECK(value(1, "surface.kind") == "wave");
    CHECK(value(3, "surface.kind") == "flat");
    CHECK(value(2, "output.traces") == "[fa1]"); // quotes are doubled in it
    CHECK(std::ranges::count(table[0], "precision") == 1);
    size_t compared = 0;
    for (size_t run = 1; run < table.size(); ++run) {
        const auto traces = rows_of("s/" + std::to_string(run) + "/traces.csv");
        for (size_t c = 1; c < traces[0].size(); ++c) {
            size_t peak = 1;
            for (size_t n = 1; n < traces.size(); ++n)
                if (std::abs(std::stod(traces[n][c])) > std::abs(std::stod(traces[peak][c]))) peak = n;
            CHECK(value(run, traces[0][c] + "_final") == traces.back()[c]);
            CHECK(value(run, traces[0][c] + "_peak") == traces[peak][c]);
            CHECK(value(run, traces[0][c] + "_peak_time") == traces[peak][0]);
            ++compared;
        }
    }
    CHECK(compared == 2 * (2 + 1) * 4);
    CHECK(value(1, "fa1_mean_peak").empty()); // of a trace that the run has not
}

TEST_CASE("--keys prints the keys that begin so, with unit, default, range and meaning") {
    const Folder folder;
    const Outcome one = command(folder, "run --keys load.ri");
    CHECK(one.status == 0);
    CHECK(one.out ==
          "[load]\n\n| key | unit | default | allowed | meaning |\n|---|---|---|---|---|\n"
          "| `rise` | s | 1 | a finite number > 0; only with load.envelope = \"ramp\" | time of a ramp from 0 "
          "to 1 |\n");
    const Outcome all = command(folder, "run --keys all");
    for (const scene::KeyRow& row : scene::key_rows())
        CHECK_MESSAGE(all.out.find("\n| `" + row.name + "` | " + row.unit + " | ") != std::string::npos, row.name);
    const Outcome none = command(folder, "run --keys lod");
    CHECK(none.status == 2);
    CHECK(none.err ==
          "dermis: --keys lod: no such table or key; allowed: all, or the beginning of a key, as load.radius\n");
}

TEST_CASE("bench --errors runs every candidate below its bound, and the other methods") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small), out = (folder / "e").string(),
                      call = "bench " + scene + " --device cpu --errors --out " + out;
    const Outcome o = command(folder, call);
    CHECK_MESSAGE(o.status == 0, o.err);
    CHECK(o.out.find("/errors.csv\n") != std::string::npos);
    CHECK(o.out.find(" in fa") != std::string::npos); // the output with the greatest error
    const std::string last = "open first: " + out + "/errors.png\nnext: dermis plan " + scene + "\n";
    CHECK_MESSAGE(o.out.ends_with(last), o.out);
    CHECK(names_in(folder / "e") == "errors.csv errors.png ");
    std::ifstream table(folder / "e/errors.csv");
    std::string line;
    std::getline(table, line);
    CHECK(line == "method,model,precision,device,step,seconds,seconds_low,seconds_high,error,bound,bytes,hash,refused");
    std::map<std::string, std::vector<double>> errors; // of methods, at the step, a half and a quarter of it
    int bounds = 0;
    while (std::getline(table, line)) {
        std::istringstream in(line);
        std::vector<std::string> cells;
        for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
        REQUIRE_MESSAGE(cells.size() == 13, line);
        const double error = std::stod(cells[8]);
        errors[cells[0]].push_back(error);
        CHECK(std::stod(cells[6]) <= std::stod(cells[5]));
        CHECK(std::stod(cells[5]) <= std::stod(cells[7]));
        CHECK(cells[11].size() == 16);
        if (cells[9].empty()) continue;
        CHECK_MESSAGE(error <= std::stod(cells[9]), line);
        ++bounds;
    }
    CHECK(bounds == 4); // maps, and three precisions of march
    CHECK(errors.size() == 7);
    CHECK(command(folder, "bench " + scene + " --errors").status == 2);
    CHECK(command(folder, "bench " + scene + " --out " + out).status == 2);
    const std::string own = folder.write("errors.csv", small);
    CHECK(command(folder, "bench " + own + " --errors --out " + (folder / "").string()).status == 2);
    CHECK(slurp(own) == small);
}

TEST_CASE("--json is all that plan, devices, check and run then print, and says what they say in words") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small), out = (folder / "o").string();
    const auto answer = [&](const std::string& call) {
        const Outcome o = command(folder, call + " --json");
        CHECK_MESSAGE(o.status == 0, o.err);
        CHECK(o.err.empty());
        const std::string file = folder.write("answer.json", o.out);
        const std::string read = "/usr/bin/python3 -c 'import json, sys; print(len(json.load(open(sys.argv[1]))))' ";
        CHECK_MESSAGE(std::system((read + file + " >" + file + ".length").c_str()) == 0, o.out);
        return std::pair(slurp(file + ".length"), output::Json::parse(o.out));
    };
    using output::Json;
    const auto [devices, of_devices] = answer("devices");
    CHECK(devices != "1\n");
    CHECK(of_devices[0].dump() == R"({"name":"cpu","kind":"cpu path","driver":null,"uuid":null,"vulkan":false,)"
                                  R"("refused":null})");
    const auto [plans, of_plans] = answer("plan --device cpu " + scene + " --set material.modulus=1,2");
    CHECK(plans == "2\n");
    CHECK(of_plans[1]["set"] == Json{"material.modulus=2"});
    CHECK(of_plans[1]["width"] == 20);
    CHECK(of_plans[1]["tolerance"] == 1e-4);
    const Json chosen = of_plans[1]["candidates"][of_plans[1].at("chosen").get<size_t>()];
    CHECK(chosen["model"] == "maps");
    CHECK(chosen["error"] < 1e-12);
    CHECK(chosen["refused"].is_null());
    const auto [checks, of_checks] = answer("check --device cpu");
    CHECK(checks == "1\n");
    CHECK(of_checks[0]["exact"] == true);
    CHECK(of_checks[0]["kernels"][0]["name"] == "press");
    CHECK(of_checks[0]["kernels"][0]["different"] == 0);
    const auto [one, of_one] = answer("run --device cpu " + scene + " --out " + out);
    CHECK(one == "1\n");
    CHECK(of_one[0] == Json::parse(slurp(folder / "o/summary.json")));
    const auto [two, of_two] =
        answer("run --resume --device cpu " + scene + " --out " + out + " --set load.radius=2,3");
    CHECK(two == "2\n");
    CHECK(of_two[1]["set"] == Json{"load.radius=3"});
}

TEST_CASE("a sweep prints the warnings of every run, and its table has their figures") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const auto sweep = [&](const std::string& set) {
        return command(folder, "run " + scene + " --device cpu --out " + (folder / "s").string() + " --set " + set);
    };
    for (const char* set : {"material.modulus=1,2", "surface.kind=wave,spiral"}) {
        const Outcome o = sweep(set);
        for (const char* says : {"run 1: warning: |l*C| reaches 1.25", "run 2: warning: the curvature has a kink in "})
            CHECK_MESSAGE(o.out.find(says) != std::string::npos, o.out);
    }
    CHECK(sweep("material.modulus=0.01,100 material.viscosity=0.01").status == 0);
    const std::string table = slurp(folder / "s/runs.csv");
    CHECK(table.find("run,model,precision,seconds,predicted_error,measured_error,greatest_gain,kinks,cells_compared,"
                     "cells_different,material.modulus,material.viscosity,strain_mean_final,strain_mean_peak,"
                     "strain_mean_peak_time,") == 0);
    std::vector<std::string> gains; // of each run by itself, also where the maps are read once
    for (size_t line = table.find('\n') + 1; line < table.size(); line = table.find('\n', line) + 1) {
        std::istringstream cells(table.substr(line));
        std::string cell;
        for (int column = 0; column < 7; ++column) std::getline(cells, cell, ',');
        gains.push_back(cell);
    }
    REQUIRE(gains.size() == 2);
    CHECK(gains[0] != gains[1]);
    CHECK(output::summary_of(folder / "s/2").at("greatest_gain") == std::stod(gains[1]));
}

TEST_CASE("plan says what a run would take, and why not the rest") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const Outcome o = command(folder, "plan " + scene + " --device cpu");
    CHECK(o.status == 0);
    for (const char* says :
         {"-> maps in f64 on cpu", "error at most", "not taken: fields are asked for", "not taken: there are no sites",
          "march in f32-compensated", "% of the greatest |C| at rest, apart from"})
        CHECK_MESSAGE(o.out.find(says) != std::string::npos, o.out);
    folder.write("modulus.npy",
                 npy_header("<f8", "(1, 2)") + std::string("\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\0\x40", 16)); // 1, 2
    const std::string spring =
        folder.write("spring.toml", "[grid]\nwidth = 2\nheight = 1\n[material]\nmodulus = \"modulus.npy\"\n"
                                    "viscosity = 0\n[output]\ntraces = [\"sa1\"]\n");
    const Outcome same = command(folder, "plan " + spring + " --device cpu");
    for (const char* says :
         {"-> moments in f64 on cpu", "materials differ, but all have tau = 0 s: the strain is pressure over modulus"})
        CHECK_MESSAGE(same.out.find(says) != std::string::npos, same.out);
    const Outcome no = command(folder, "plan " + scene + " --device cpu --precision f32 --set tolerance=1e-9");
    CHECK(no.status == 2);
    CHECK(no.err.find("attainable here") != std::string::npos);
}
