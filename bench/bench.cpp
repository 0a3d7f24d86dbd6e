// SPDX-License-Identifier: MIT
// Measures speed and error in the same row of a table. Results are verified before they are timed; ratios hold within
// one run of this program.
#include "bench/bench.hpp"

#include <algorithm>
#include <ctime>
#include <fstream>

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

std::vector<Device> Bench::cpus() const {
    std::vector<Device> all = {Device::cpu(1)};
    if (cores > 1) all.push_back(Device::cpu(cores));
    return all;
}

std::vector<Device> Bench::devices() const {
    std::vector<Device> all;
    const std::vector<DeviceInfo> listed = vulkan ? Device::list() : std::vector<DeviceInfo>();
    for (size_t i = 0; i < listed.size(); ++i)
        if (listed[i].refused.empty()) all.push_back(Device::open(std::to_string(i)));
    return all;
}

Measurement Bench::on(const Device& device, const std::string& workload, long long n) const {
    const DeviceInfo& info = device.info();
    Measurement r = cpu(workload, n, info.vulkan ? 0 : device.impl().backend->threads());
    if (!info.vulkan) return r;
    r.backend = "vulkan";
    r.device = info.name;
    r.driver = info.driver.substr(0, info.driver.find(' '));
    r.driver_version = info.driver.substr(std::min(info.driver.find(' ') + 1, info.driver.size()));
    r.device_uuid = vulkan::context_of(*device.impl().backend)->physical().info.uuid;
    r.exact = info.exact;
    r.model = "march";
    r.precision = "f32";
    return r;
}

std::vector<Contender> Bench::of_peers(const std::string& work, const Measurement& like, int count,
                                       const std::vector<size_t>& errors) const {
    std::vector<Contender> all;
    for (const Peers::Peer& peer : peers->prepare(work)) {
        Contender& c = all.emplace_back(Contender{like, {}});
        c.row.threads = peer.threads ? peer.threads : cores;
        c.row.backend = c.row.driver = peer.name;
        c.row.driver_version = peer.version == "-" ? "" : peer.version;
        c.row.method = peer.method;
        c.row.exact = false;
        if (peer.method.empty()) c.row.status = not_installed;
        else c.work = [this, peer, count] { return peers->seconds(peer, count); };
        if (!c.row.steps) c.row.steps = peer.steps;
        for (size_t i = 0; i < std::min(errors.size(), peer.errors.size()); ++i)
            c.row.errors[errors[i]] = peer.errors[i];
    }
    return all;
}

void Bench::add(const Measurement& r) {
    rows.push_back(r);
    if (r.status == not_installed) {
        fmt::print("{:20} {:12} {}\n", r.workload, r.backend, r.status);
        return;
    }
    const double cells = double(r.width * r.height * std::max(r.steps, 1LL));
    fmt::print("{:20} {:12} {}T {:>6} {:8} {:16} {:6} {:10.4g} s  {:8.4g} ns per cell and step{}{}\n", r.workload,
               r.backend, r.threads, r.width, r.model, r.precision, r.method, r.wall.median,
               r.wall.median / cells * 1e9,
               std::isnan(r.of_limit) ? "" : fmt::format("  {:.2f} of {}", r.of_limit, r.limit),
               r.status == "ok" ? "" : "  " + r.status);
    std::fflush(stdout);
}

namespace {

// Seconds for which all threads of this process have run.
double processor_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

} // namespace

void Bench::time(std::vector<Contender>& all, int times) const {
    std::vector<std::vector<double>> seconds(all.size());
    std::vector<double> busy(all.size(), INFINITY);
    for (int i = -1; i < times; ++i)
        for (size_t k = 0; k < all.size(); ++k) {
            if (!all[k].work) continue;
            const double start = processor_seconds(), taken = all[k].work();
            if (i < 0) continue; // warms up
            seconds[k].push_back(taken);
            busy[k] = std::min(busy[k], processor_seconds() - start);
        }
    for (size_t k = 0; k < all.size(); ++k) {
        if (seconds[k].empty()) continue;
        all[k].row.wall = timing_of(seconds[k]);
        all[k].row.wall.busy = busy[k];
    }
    for (Contender& c : all)
        if (!c.ratio_to.empty()) c.row.relative_to(c.ratio_to, all[c.reference].row.wall, all[c.reference].row.bytes());
}

void Bench::measure(std::vector<Contender> all, int times) {
    time(all, times);
    for (const Contender& c : all) add(c.row);
}

Measurement row_of(Measurement r, const std::string& model, const std::string& precision, long long steps) {
    r.model = model;
    r.precision = precision;
    r.steps = steps;
    return r;
}

namespace {

struct Arguments {
    std::string device = "vulkan", out = "results.csv", commit = dermis::commit(), peers;
    std::vector<std::string> only;
    bool quick = false;
};

enum class When { first, usually, named };

struct Workload {
    const char* name;
    void (*measure)(Bench&);
    When when = When::usually;
};
constexpr Workload workloads[] = {
    {"growth", growth, When::first}, // these fork, so that they run before any device is opened
    {"memory", memory, When::first},
    {"press", streamed_frames},
    {"cells", by_cells},
    {"options", options},
    {"kinds", kinds},
    {"held-map", constant_map},
    {"study", study},
    {"population", population},
    {"population-frames", streamed_population},
    {"march", marches},
    {"chains", chains},
    {"pads", pads},
    {"materials", materials},
    {"accuracy", accuracy},
    {"stiff", stiff},
    {"spikes", spikes},
    {"touch", touch},
    {"construction", construction},
    {"depth", depth},
    {"processes", processes},
    {"device", device_growth, When::named}}; // takes minutes on a software device

void add_arguments(CLI::App& app, Arguments& a) {
    std::vector<std::string> names;
    for (const Workload& w : workloads) names.push_back(w.name);
    app.add_option("--device", a.device, "cpu, vulkan, a row of `dermis devices` or a part of a name")
        ->capture_default_str();
    app.add_flag("--quick", a.quick, "smaller grids, fewer runs: under three minutes");
    app.add_option("--peers", a.peers,
                   "the command that runs bench/peers.py; without it there are no rows of its peers");
    app.add_option("--out", a.out, "the table")->capture_default_str();
    app.add_option("--only", a.only, "workloads in place of all")->check(CLI::IsMember(names));
    app.add_option("--commit", a.commit, "written into each row")->capture_default_str();
}

// save: called after each workload, so that a run that is cut off leaves the rows before that.
template <class Save> void measure(Bench& bench, const Arguments& a, Save save) {
    const auto take = [&](bool first) {
        for (const Workload& w : workloads) {
            const bool named = std::find(a.only.begin(), a.only.end(), w.name) != a.only.end();
            if ((w.when == When::first) == first && (a.only.empty() ? w.when != When::named : named))
                w.measure(bench), save();
        }
    };
    take(true);
    bench.peers = std::make_unique<Peers>(a.peers);
    if (a.device != "cpu") try {
            bench.vulkan = Device::open(a.device);
        } catch (const Error& e) {
            if (a.device != "vulkan") throw;
            fmt::print(stderr, "dermis-bench: rows of the CPU alone: {}\n", e.what());
        }
    take(false);
}

void run(const Arguments& a) {
    const Machine machine = this_machine();
    Bench bench;
    bench.quick = a.quick;
    bench.runs = a.quick ? 3 : 7;
    bench.cores = machine.cores;
    measure(bench, a, [&] {
        std::ofstream file(a.out);
        if (!(file << csv_of(bench.rows, {a.commit, a.quick ? "quick" : "full", machine})).flush())
            throw std::runtime_error(a.out + " cannot be written");
    });
    fmt::print("{} rows in {}\n", bench.rows.size(), a.out);
}

} // namespace

} // namespace bench

// Exit status: 0 done, 1 failed, 2 bad input.
int main(int argc, char** argv) {
    CLI::App app{"What each choice costs in time and in error"};
    bench::Arguments arguments;
    bench::add_arguments(app, arguments);
    try {
        app.parse(argc, argv);
        bench::run(arguments);
        return 0;
    } catch (const CLI::ParseError& e) {
        return app.exit(e) ? 2 : 0;
    } catch (const std::exception& e) {
        fmt::print(stderr, "dermis-bench: {}\n", e.what());
        return 1;
    }
}
