// SPDX-License-Identifier: MIT
// Measures speed and error in the same row of a table. Results are verified before they are timed; ratios hold within
// one run of this program.
#include "bench/bench.hpp"

#include "host/embedding/backend.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace bench {

using namespace dermis;

double seconds_of(const std::function<void()>& work) {
    const double start = now();
    work();
    return now() - start;
}

Scene with_maps(Scene s) {
    const SceneMaps m = maps(s);
    s.surface = {
        .kind = Surface::Kind::map, .relief = s.grid.spacing ? std::optional(1.0) : std::nullopt, .map = m.surface};
    s.load.kind = Load::Kind::map;
    s.load.map = m.pressure;
    s.load.intensity = 1;
    s.load.radius.reset();
    s.load.center.reset();
    return s;
}

Measurement Bench::cpu(const std::string& workload, long long n, int threads) const {
    Measurement r;
    r.backend = std::string("cpu-") + simd::best().name;
    r.workload = workload;
    r.width = r.height = n;
    r.threads = threads;
    r.stencil = "five-point";
    r.method = "exact";
    return r;
}

Measurement Bench::on_vulkan(const std::string& workload, long long n) const {
    Measurement r = cpu(workload, n, 0);
    const DeviceInfo& info = vulkan->info();
    const vulkan::PhysicalDevice& physical = vulkan::context_of(*vulkan->impl().backend)->physical();
    r.backend = "vulkan";
    r.device = info.name;
    r.driver = info.driver.substr(0, info.driver.find(' '));
    r.driver_version = info.driver.substr(std::min(info.driver.find(' ') + 1, info.driver.size()));
    r.device_uuid = physical.uuid;
    r.exact = info.exact;
    r.model = "march";
    r.precision = "f32";
    return r;
}

void Bench::add(const Measurement& r) {
    rows.push_back(r);
    const double cells = double(r.width * r.height * std::max(r.steps, 1LL));
    fmt::print(
        "{:12} {:18} {}T {:>6} {:8} {:16} {:14} {:10.4g} s  {:8.4g} ns per cell and step{}{}\n", r.workload, r.backend,
        r.threads, r.width, r.model, r.precision, r.method, r.wall.median, r.wall.median / cells * 1e9,
        std::isnan(r.of_limit) ? "" : fmt::format("  {:.2f} of {} at {:.1f} GB/s", r.of_limit, r.limit, r.limit_GBs),
        r.status == "ok" ? "" : "  " + r.status);
    std::fflush(stdout);
}

std::vector<Timing> Bench::paired(const std::vector<std::function<double()>>& work, int times) const {
    std::vector<std::vector<double>> seconds(work.size());
    for (const auto& once : work) once();
    for (int i = 0; i < times; ++i)
        for (size_t k = 0; k < work.size(); ++k) seconds[k].push_back(work[k]());
    std::vector<Timing> timings;
    for (const auto& s : seconds) timings.push_back(timing_of(s));
    return timings;
}

void limits(Bench& bench) {
    for (int all = 0; all < 2; ++all) {
        const int threads = all ? bench.cores : 1;
        Limits memory(threads);
        const auto timings =
            bench.paired({[&] { return memory.read(); }, [&] { return memory.copy(); }}, std::max(bench.runs, 5));
        for (int copy = 0; copy < 2; ++copy) {
            Measurement r = bench.cpu("limit", 0, threads);
            r.model = copy ? "copy" : "read";
            r.method = r.stencil = "";
            r.wall = timings[size_t(copy)];
            r.limit = r.model;
            r.limit_GBs = double(Limits::moved()) / r.wall.median / 1e9;
            (copy ? bench.copy_GBs : bench.read_GBs)[all] = r.limit_GBs;
            bench.rows.push_back(r);
            fmt::print("limit: {} with {} threads: {:.1f} GB/s\n", r.model, threads, r.limit_GBs);
        }
    }
}

} // namespace bench

int main(int argc, char** argv) {
    using namespace bench;
    CLI::App app{"What each choice costs in time and in error"};
    Bench bench;
    std::string device = "vulkan", out = "results.csv", compare, commit;
    app.add_option("--device", device, "cpu, vulkan, a row of `dermis devices` or a part of a name")
        ->capture_default_str();
    app.add_flag("--quick", bench.quick, "smaller grids, fewer runs: under two minutes");
    app.add_option("--out", out, "the table")->capture_default_str();
    app.add_option("--compare", compare, "an earlier table: exit status 1 where something has been lost")
        ->check(CLI::ExistingFile);
    app.add_option("--commit", commit, "written into each row");
    CLI11_PARSE(app, argc, argv);
    try {
        bench.runs = bench.quick ? 3 : 7;
        bench.cores = std::max(int(std::thread::hardware_concurrency()), 1);
        growth(bench);
        const std::vector<double> first = device == "cpu" ? std::vector<double>() : first_frames(device, bench.runs);
        if (device != "cpu") try {
                bench.vulkan = dermis::Device::open(device);
            } catch (const dermis::Error& e) {
                if (device != "vulkan") throw;
                fmt::print(stderr, "dermis-bench: rows of the CPU alone: {}\n", e.what());
            }
        if (bench.vulkan && !first.empty()) {
            Measurement r = bench.on_vulkan("first-frame", 150);
            r.steps = 1;
            r.wall = timing_of(first);
            bench.add(r);
        }
        for (auto* workload :
             {limits, streamed_frames, constant_map, study, population, streamed_population, materials, accuracy})
            workload(bench);
        const std::string csv = csv_of(bench.rows, commit);
        std::ofstream(out) << csv;
        fmt::print("{} rows in {}\n", bench.rows.size(), out);
        if (compare.empty()) return 0;
        std::ifstream file(compare);
        const std::string earlier{std::istreambuf_iterator<char>(file), {}};
        const std::vector<std::string> complaints = lost(earlier, csv);
        for (const std::string& line : complaints) fmt::print("{}\n", line);
        return complaints.empty() ? 0 : 1;
    } catch (const std::exception& e) {
        fmt::print(stderr, "dermis-bench: {}\n", e.what());
        return 1;
    }
}
