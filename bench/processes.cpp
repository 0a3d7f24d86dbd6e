// SPDX-License-Identifier: MIT
// Costs of processes: memory, the first frame, the command as a whole; and of making a skin.
#include "bench/bench.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace bench {

using namespace dermis;

namespace {

rusage usage_of(pid_t child, int& status) {
    rusage usage{};
    if (wait4(child, &status, 0, &usage) != child) status = -1;
    return usage;
}

// The seconds that work returns in a process of its own, and the peak memory of that process, in bytes.
std::pair<double, double> alone(const std::function<double()>& work) {
    auto* const seconds =
        static_cast<double*>(mmap(nullptr, sizeof(double), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
    const pid_t child = fork();
    if (child == 0) *seconds = work(), _exit(0);
    int status = 0;
    const double peak = double(usage_of(child, status).ru_maxrss) * 1024, taken = status ? NAN : *seconds;
    munmap(seconds, sizeof(double));
    return {taken, peak};
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
    std::vector<double> all;
    double peak = 0;
    for (int i = 0; i < runs; ++i) {
        const auto [seconds, bytes] = alone([&] { return run(scene_of(c, n, steps), Device::cpu()).seconds; });
        all.push_back(seconds);
        peak = bytes;
    }
    Measurement r = row_of(bench.cpu(c.workload, n, bench.cores), name(c.model), name(c.precision), steps);
    r.wall = timing_of(all);
    r.limit = planned_bytes;
    r.limit_GBs = alone([&] {
                      const Explanation e = plan(scene_of(c, n, steps), Device::cpu());
                      return e.candidates[e.chosen].bytes;
                  }).first /
                  1e9;
    r.of_limit = peak / 1e9 / r.limit_GBs;
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
    const rusage usage = status == 0 ? usage_of(child, status) : rusage{};
    if (status != 0) throw std::runtime_error(fmt::format("{} failed: {}", fmt::join(words, " "), status));
    const double wall = now() - start;
    const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
    processor = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    return wall;
}

void add_command(Bench& bench, Measurement r, const std::string& what, std::vector<std::string> words) {
    r.workload = "process-" + what;
    r.model = "process";
    r.method = r.stencil = r.precision = "";
    std::vector<double> wall;
    double processor = 0, busy = INFINITY;
    seconds_of_process(words, processor); // warms caches on disk
    for (int i = 0; i < (bench.quick ? 7 : 15); ++i) {
        wall.push_back(seconds_of_process(words, processor));
        busy = std::min(busy, processor);
    }
    r.wall = timing_of(wall);
    r.wall.busy = busy;
    bench.add(r);
}

} // namespace

// The command as a whole, from its start to its end, with the files that it writes.
void processes(Bench& bench) {
    const fs::path command = fs::read_symlink("/proc/self/exe").parent_path() / "dermis",
                   folder = fs::temp_directory_path() / fmt::format("dermis_bench_{}", getpid());
    if (!fs::exists(command)) {
        fmt::print(stderr, "dermis-bench: no rows of whole processes: {} does not exist\n", command.string());
        return;
    }
    fs::create_directories(folder);
    const std::shared_ptr<void> last(nullptr, [&](void*) { fs::remove_all(folder); });
    std::ofstream(folder / "smallest.toml") << "[grid]\nwidth = 1\nheight = 1\n[time]\nduration = 0.01\n";
    std::ofstream(folder / "study.toml") << "[surface]\nkind = \"spiral\"\n[load]\nkind = \"circular\"\n[output]\n"
                                            "probes = [[75, 75], [85, 85], [60, 80], [37, 37], [112, 112]]\n";
    const auto add = [&](Measurement r, const char* scene, const std::string& name, const std::string& device) {
        r.steps = scene == std::string("study") ? 999 : 0;
        add_command(bench, r, fmt::format("{}-{}", scene, name),
                    {command.string(), "run", (folder / scene).string() + ".toml", "--out",
                     (folder / "results").string(), "--device", device});
    };
    add_command(bench, bench.cpu("", 0, 1), "help", {command.string(), "--help"});
    for (const char* device : {"cpu", "auto"}) {
        add(bench.cpu("", 1, bench.cores), "smallest", device, device);
        add(bench.cpu("", 150, bench.cores), "study", device, device);
    }
    if (bench.vulkan) add(bench.on(*bench.vulkan, "", 1), "smallest", "vulkan", bench.vulkan->info().name);
}

} // namespace bench
