// SPDX-License-Identifier: MIT
// The command as a user meets it: exit status, messages, files.
#include "host/output/output.hpp"
#include "tests/support.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

using namespace test;
namespace fs = std::filesystem;

namespace {

class Folder {
  public:
    Folder() : path_(fs::temp_directory_path() / ("dermis_cli_test_" + std::to_string(getpid()))) {
        fs::remove_all(path_);
        fs::create_directories(path_);
    }
    ~Folder() { fs::remove_all(path_); }
    fs::path operator/(const std::string& name) const { return path_ / name; }
    std::string write(const std::string& name, const std::string& content) const {
        std::ofstream(path_ / name) << content;
        return (path_ / name).string();
    }

  private:
    fs::path path_;
};

std::string slurp(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

struct Outcome {
    int status;
    std::string out, err;
};

// `before` goes before the command: variables, limits, a terminal.
Outcome command(const Folder& folder, const std::string& arguments, const std::string& before = "") {
    const std::string out = (folder / "stdout").string(), err = (folder / "stderr").string();
    const int status = std::system((before + " " DERMIS_CLI " " + arguments + " >" + out + " 2>" + err).c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(out), slurp(err)};
}

constexpr const char* small =
    "[grid]\nwidth = 20\nheight = 12\n[surface]\nkind = \"wave\"\n[time]\nduration = 0.1\n"
    "[output]\nprobes = [[3, 4]]\nfields = [{ at = 0.05, what = [\"sa1\", \"curvature\"] }]\n";

} // namespace

TEST_CASE("dermis run writes traces, impulses, fields and a summary") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    for (const char* device : {"cpu", "vulkan"}) {
        const fs::path out = folder / device;
        const Outcome o = command(folder, "run " + scene + " --check --device " + device + " --out " + out.string());
        CHECK(o.status == 0);
        CHECK(o.err.empty());
        CHECK(o.out.find(" 0 different") != std::string::npos);
        CHECK(o.out.find("tau = 0.649351 s, z = dt/tau = 0.0154") != std::string::npos);
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

TEST_CASE("a map written by one run is read by the next") {
    const Folder folder;
    CHECK(command(folder, "run " + folder.write("a.toml", small) + " --device cpu --out " + (folder / "a").string())
              .status == 0);
    const std::string scene = folder.write(
        "b.toml",
        "[grid]\nwidth = 20\nheight = 12\n[load]\nkind = \"file\"\npath = \"a/sa1_t0.05.npy\"\nintensity = 2\n");
    CHECK(command(folder, "run " + scene + " --device cpu --precision f64 --out " + (folder / "b").string()).status ==
          0);
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
        {"walk", "subcommand"},
    };
    for (const auto& [call, says] : calls) {
        CAPTURE(call);
        const Outcome o = command(folder, call + " --out " + out.string());
        CHECK(o.status == 2);
        CHECK_MESSAGE(o.err.find(says) != std::string::npos, o.err);
        CHECK_FALSE(fs::exists(out));
    }
}

TEST_CASE("without a driver auto says so in one line and uses the CPU; vulkan names what is missing") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small),
                      none = "VK_DRIVER_FILES=/dev/null VK_ICD_FILENAMES=/dev/null";
    const Outcome automatic = command(folder, "run " + scene + " --out " + (folder / "a").string(), none);
    CHECK(automatic.status == 0);
    CHECK(automatic.out.find("no Vulkan device used: the Vulkan loader finds no driver") == 0);
    CHECK(automatic.out.find("maps, f64 on cpu") != std::string::npos);
    const Outcome vulkan = command(folder, "run " + scene + " --device vulkan --out " + (folder / "b").string(), none);
    CHECK(vulkan.status == 1);
    CHECK(vulkan.err.find("finds no driver (on Debian: mesa-vulkan-drivers)") != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "b"));
    CHECK(command(folder, "devices", none).out.find("no Vulkan device") != std::string::npos);
}

TEST_CASE("dermis devices lists, dermis check compares every kernel") {
    const Folder folder;
    const Outcome devices = command(folder, "devices");
    CHECK(devices.status == 0);
    CHECK(devices.out.find("cpu: ") == 0);
    CHECK(devices.out.find("llvmpipe") != std::string::npos);
    const Outcome check = command(folder, "check");
    CHECK(check.status == 0);
    for (const char* kernel : {"press ", "fields ", "reduce ", " exact\n"})
        CHECK(check.out.find(kernel) != std::string::npos);
}

TEST_CASE("the program does not need a Vulkan loader to start") {
    const Folder folder;
    const std::string list = (folder / "needed").string();
    REQUIRE(std::system(("readelf -d " DERMIS_CLI " >" + list).c_str()) == 0);
    CHECK(slurp(list).find("NEEDED") != std::string::npos);
    CHECK(slurp(list).find("vulkan") == std::string::npos);
}

TEST_CASE("a full disk is an error that names the file, and leaves none half written") {
    const Folder folder;
    const fs::path out = folder / "out";
    const Outcome o =
        command(folder, "run " + folder.write("scene.toml", std::string(small)) + " --device cpu --out " + out.string(),
                "ulimit -f 2;");
    CHECK(o.status == 1);
    CHECK(o.err.find((out / "traces.csv").string()) != std::string::npos);
    CHECK_FALSE(fs::exists(out / "traces.csv"));
    CHECK_FALSE(fs::exists(out / "traces.csv.part"));
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
            CHECK(shown.find("marching  50 %") != std::string::npos);
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

TEST_CASE("plan says what a run would take, and why not the rest") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const Outcome o = command(folder, "plan " + scene + " --device cpu");
    CHECK(o.status == 0);
    for (const char* says : {"-> maps in f64 on cpu", "error at most", "not taken: fields are asked for",
                             "not taken: there are no sites", "march in f32-compensated"})
        CHECK_MESSAGE(o.out.find(says) != std::string::npos, o.out);
    const Outcome no = command(folder, "plan " + scene + " --device cpu --precision f32 --set tolerance=1e-9");
    CHECK(no.status == 2);
    CHECK(no.err.find("attainable here") != std::string::npos);
}
