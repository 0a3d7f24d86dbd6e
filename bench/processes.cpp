// SPDX-License-Identifier: MIT
// Costs of processes: memory, the first frame, the command as a whole; and of making a skin.
#include "bench/bench.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace bench {

using namespace dermis;

namespace {

// The costs of a run in a process of its own: seconds of its steps, peak memory.
struct Alone {
    double seconds = NAN, peak_bytes = NAN;
};

Alone alone(const std::function<double()>& work) {
    int ends[2];
    if (pipe(ends) != 0) return {};
    const pid_t child = fork();
    if (child == 0) {
        const double seconds = work();
        _exit(write(ends[1], &seconds, sizeof seconds) == sizeof seconds ? 0 : 1);
    }
    Alone a;
    close(ends[1]);
    if (read(ends[0], &a.seconds, sizeof a.seconds) != sizeof a.seconds) a.seconds = NAN;
    close(ends[0]);
    rusage usage{};
    int status = 0;
    wait4(child, &status, 0, &usage);
    a.peak_bytes = double(usage.ru_maxrss) * 1024;
    return a;
}

// A scene of so many cells a side; its run's memory is measured.
struct Remembered {
    const char* workload;
    Model model = Model::march;
    Precision precision = Precision::f32;
    bool materials = false; // one per cell, of several retardation times
};

constexpr Remembered remembered[] = {
    {"memory", Model::moments, Precision::f64},     {"memory-fields", Model::maps, Precision::f64},
    {"memory-sites", Model::sites, Precision::f64}, {"memory", Model::march, Precision::f32_compensated},
    {"memory", Model::march, Precision::f64},       {"memory-each", Model::march, Precision::f32, true}};

Scene scene_of(const Remembered& c, int n, int steps) {
    Scene s;
    s.grid = {n, n, {}};
    s.load.kind = Load::Kind::linear;
    s.load.radius = n;
    s.time = {0.01, 0.01 * steps};
    s.model = c.model;
    s.precision = c.precision;
    if (c.model == Model::maps) s.output.fields = {{0.01, {Quantity::sa1, Quantity::fa1}}};
    if (c.model == Model::sites) {
        s.output.traces.clear();
        for (int i = 0; i < n; ++i) s.sites.push_back({Quantity::sa1, {i, i}});
    }
    if (c.materials) {
        std::vector<double>& modulus = s.material.modulus_map.edit();
        for (int i = 0; i < n * n; ++i) modulus.push_back(1 + double(i) / n / n);
    }
    return s;
}

// Runs a scene on the CPU path, each time in a process of its own, and compares the greatest memory with plan()'s.
void add_alone(Bench& bench, const Remembered& c, int n, int steps, int runs) {
    std::vector<double> seconds;
    Alone a;
    for (int i = 0; i < runs; ++i) {
        a = alone([&] { return run(scene_of(c, n, steps), Device::cpu()).seconds; });
        seconds.push_back(a.seconds);
    }
    Measurement r = row_of(bench.cpu(c.workload, n, bench.cores), name(c.model), name(c.precision), steps);
    r.wall = timing_of(seconds);
    const auto planned = [&] {
        const Explanation e = plan(scene_of(c, n, steps), Device::cpu());
        return e.candidates[e.chosen].bytes;
    };
    r.limit = planned_bytes;
    r.limit_GBs = alone(planned).seconds / 1e9;
    r.of_limit = a.peak_bytes / 1e9 / r.limit_GBs;
    bench.add(r);
}

} // namespace

void growth(Bench& bench) {
    for (int n : bench.quick ? std::vector{1024, 2048} : std::vector{1024, 2048, 4096, 8192, 16384})
        add_alone(bench, {.workload = "growth"}, n, 6, n > 8192 ? 1 : 3);
}

void memory(Bench& bench) {
    const int side = bench.quick ? 1024 : 2048;
    for (const Remembered& c : remembered) add_alone(bench, c, c.materials ? side / 2 : side, 3, 1);
}

namespace {

namespace fs = std::filesystem;

// Starts a program, which writes into nothing, and waits for its end. Adds the processor's seconds that it took.
double seconds_of_process(const std::vector<std::string>& words, double& processor) {
    std::vector<char*> arguments;
    for (const std::string& w : words) arguments.push_back(const_cast<char*>(w.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    posix_spawn_file_actions_addopen(&quiet, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    const double start = now();
    pid_t child = 0;
    int status = posix_spawn(&child, arguments[0], &quiet, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&quiet);
    rusage usage{};
    if (status != 0 || wait4(child, &status, 0, &usage) != child || status != 0)
        throw std::runtime_error(fmt::format("{} failed: {}", fmt::join(words, " "), status));
    const double wall = now() - start;
    const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
    processor = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    return wall;
}

// Times the command as a whole, from its start to its end, with the files that it writes.
class Commands {
  public:
    explicit Commands(Bench& bench) : bench_(bench) {
        fs::create_directories(folder_);
        std::ofstream(folder_ / "smallest.toml") << "[grid]\nwidth = 1\nheight = 1\n[time]\nduration = 0.01\n";
        std::ofstream(folder_ / "study.toml") << "[surface]\nkind = \"spiral\"\n[load]\nkind = \"circular\"\n[output]\n"
                                                 "probes = [[75, 75], [85, 85], [60, 80], [37, 37], [112, 112]]\n";
    }
    ~Commands() { fs::remove_all(folder_); }

    static fs::path command() { return fs::read_symlink("/proc/self/exe").parent_path() / "dermis"; }

    void add_run(const std::string& scene, int cells, const std::string& device) {
        const bool vulkan = device == "vulkan";
        Measurement r = vulkan ? bench_.on(*bench_.vulkan, "", cells) : bench_.cpu("", cells, bench_.cores);
        r.steps = scene == "study" ? 999 : 0;
        add(r, scene + "-" + device,
            {"run", (folder_ / (scene + ".toml")).string(), "--out", (folder_ / "results").string(), "--device",
             vulkan ? bench_.vulkan->info().name : device});
    }

    void add(Measurement r, const std::string& what, std::vector<std::string> words) {
        r.workload = "process-" + what;
        r.model = "process";
        r.method = r.stencil = r.precision = "";
        words.insert(words.begin(), command().string());
        std::vector<double> wall;
        double processor = 0, busy = INFINITY;
        seconds_of_process(words, processor); // warms caches on disk
        for (int i = 0; i < (bench_.quick ? 7 : 15); ++i) {
            wall.push_back(seconds_of_process(words, processor));
            busy = std::min(busy, processor);
        }
        r.wall = timing_of(wall);
        r.wall.busy = busy;
        bench_.add(r);
    }

  private:
    Bench& bench_;
    const fs::path folder_ = fs::temp_directory_path() / fmt::format("dermis_bench_{}", getpid());
};

} // namespace

void processes(Bench& bench) {
    if (!fs::exists(Commands::command())) {
        fmt::print(stderr, "dermis-bench: no rows of whole processes: {} does not exist\n",
                   Commands::command().string());
        return;
    }
    Commands commands(bench);
    commands.add(bench.cpu("", 0, 1), "help", {"--help"});
    for (const char* device : {"cpu", "auto"}) {
        commands.add_run("smallest", 1, device);
        commands.add_run("study", 150, device);
    }
    if (bench.vulkan) commands.add_run("smallest", 1, "vulkan");
}

} // namespace bench
