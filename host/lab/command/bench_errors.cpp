// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

#include "dermis/dermis.hpp"
#include "host/core/base/hash.hpp"
#include "host/core/base/text.hpp"
#include "host/lab/output/python.hpp"
#include "host/lab/scenes/scene_names.hpp"
#include "plot_script.h"

#include <algorithm>
#include <map>

namespace dermis::cli {
namespace {

constexpr int divisors[] = {1, 2, 4}; // of the step

// A way to compute a scene, and what it took.
struct Way {
    Method method;
    std::string model, precision, device; // as names
    double step;
    std::vector<double> seconds = {}; // of runs, ascending
    double error = std::nan(""), bound = std::nan(""), bytes = std::nan("");
    std::string worst = {}; // the output with this error; empty where there is no error
    uint64_t hash = 0;
    std::string refused = {}; // the reason why it cannot be run

    bool broken() const { return error > bound; }
};

// The numbers of an output of a run: of a quantity's traces and fields, or of the sites of a class.
std::map<std::string, std::vector<double>> outputs_of(const Scene& scene, const Result& r) {
    std::map<std::string, std::vector<double>> all;
    for (const TraceColumn& column : trace_columns(r)) {
        std::vector<double>& numbers = all[column.name.substr(0, column.name.find('_'))];
        numbers.insert(numbers.end(), column.values->begin(), column.values->end());
    }
    for (const Field& f : r.fields) {
        std::vector<double>& numbers = all[name(f.quantity)];
        numbers.insert(numbers.end(), f.values.begin(), f.values.end());
    }
    for (size_t i = 0; i < r.responses.size(); ++i)
        all["site " + std::string(name(scene.sites[i % scene.sites.size()].type))].push_back(r.responses[i]);
    return all;
}

// The exact outputs of a scene, and the greatest exact value of each quantity over all cells and times.
struct Truth {
    std::map<std::string, std::vector<double>> outputs;
    std::map<std::string, double> greatest;

    explicit Truth(Scene scene) {
        scene.method = Method::exact;
        scene.model.reset(), scene.precision = Precision::f64, scene.tolerance.reset();
        outputs = outputs_of(scene, run(scene));
        for (const auto& [output, numbers] : outputs)
            for (double v : numbers) greatest[output] = std::max(greatest[output], std::abs(v));
        if (scene.output.traces.empty() || scene.output.extremes) return;
        scene.output.extremes = true;
        for (const auto& [output, numbers] : outputs_of(scene, run(scene)))
            for (double v : numbers) greatest[output] = std::max(greatest[output], std::abs(v));
    }
};

void compare(Way& way, const Truth& truth, const std::map<std::string, std::vector<double>>& outputs) {
    way.error = 0;
    way.hash = fnv1a_64;
    for (const auto& [output, numbers] : outputs) {
        const std::vector<double>& exact = truth.outputs.at(output);
        for (size_t i = 0; i < numbers.size(); ++i) {
            const double error = std::abs(numbers[i] - exact.at(i));
            if (error > 0 && error / truth.greatest.at(output) > way.error)
                way.error = error / truth.greatest.at(output), way.worst = output;
            for (int byte = 0; byte < 8; ++byte)
                way.hash = fnv1a(way.hash, (std::bit_cast<uint64_t>(numbers[i]) >> 8 * byte) & 255);
        }
    }
}

// Runs a scene again and again for half a second, at least three times and at most nine times.
void measure(Way& way, const Scene& scene, const Device& device, const Truth& truth) {
    const double start = seconds_now();
    try {
        for (int runs = 0; runs < 3 || (runs < 9 && seconds_now() - start < 0.5); ++runs) {
            const double before = seconds_now();
            const Result r = run(scene, device);
            way.seconds.push_back(seconds_now() - before);
            if (runs > 0) continue;
            way.model = name(r.model);
            compare(way, truth, outputs_of(scene, r));
        }
    } catch (const Error& e) {
        if (e.code() != Error::Code::bad_input) throw;
        way.refused = e.what();
    }
    std::ranges::sort(way.seconds);
}

// Every candidate that a plan could take.
void add_candidates(std::vector<Way>& ways, Scene scene, const Device& cpu, const Device& device, const Truth& truth) {
    scene.tolerance.reset();
    for (const Device* at : {&cpu, &device}) {
        const Device& on = *at;
        if (at == &device && !on.info().vulkan) continue; // the CPU path again
        for (const Candidate& c : explain(scene, on).candidates) {
            const bool vulkan = c.device != cpu.info().name;
            if (!c.steps || vulkan != on.info().vulkan) continue; // not in question, or of the other device
            Scene own = scene;
            own.model = c.model, own.precision = c.precision;
            ways.push_back({.method = scene.method,
                            .model = name(c.model),
                            .precision = name(c.precision),
                            .device = c.device,
                            .step = scene.time.step,
                            .bytes = c.bytes});
            const Explanation plan = explain(own, on);
            ways.back().bound = plan.candidates[plan.chosen].error; // of this candidate, even where it was not needed
            measure(ways.back(), own, on, truth);
        }
    }
}

// Every other method. A smaller step has more outputs, and means over shorter steps, so that each has a truth of its
// own.
void add_methods(std::vector<Way>& ways, const Scene& scene, const Device& cpu) {
    for (int divisor : divisors) {
        Scene own = scene;
        own.allow_unstable = true;
        own.model.reset(), own.precision = Precision::f64, own.tolerance.reset();
        own.time.step /= divisor;
        const Truth truth(own);
        for (const scene::Name<Method>& method : scene::Names<Method>::table) {
            if (method.value == Method::exact || method.value == Method::published) continue;
            own.method = method.value;
            ways.push_back({.method = method.value,
                            .model = "march",
                            .precision = name(Precision::f64),
                            .device = cpu.info().name,
                            .step = own.time.step});
            measure(ways.back(), own, cpu, truth);
        }
    }
}

std::string table_of(const std::vector<Way>& ways) {
    std::string text = "method,model,precision,device,step,seconds,seconds_low,seconds_high,error,bound,bytes,hash,"
                       "refused\n";
    const auto number = [](double x) { return std::isfinite(x) ? shortest(x) : std::string(); };
    for (const Way& w : ways) {
        const size_t n = w.seconds.size();
        const auto quartile = [&](size_t quarters) { return n ? number(w.seconds[quarters * (n - 1) / 4]) : ""; };
        text += fmt::format("{},{},{},\"{}\",{},{},{},{},{},{},{},{},\"{}\"\n", name(w.method), w.model, w.precision,
                            w.device, shortest(w.step), quartile(2), quartile(1), quartile(3), number(w.error),
                            number(w.bound), number(w.bytes), n ? fmt::format("{:016x}", w.hash) : "", w.refused);
    }
    return text;
}

void print(const Way& w) {
    fmt::print("{:<14} {:<8} {:<16} {:<24.24} step {:<9.4g} ", name(w.method), w.model, w.precision, w.device, w.step);
    if (w.seconds.empty()) return fmt::print("refused\n");
    fmt::print("{:>9.3g} s  error {:<8.2g}{:<8}", w.seconds[w.seconds.size() / 2], w.error,
               w.worst.empty() ? "" : "in " + w.worst);
    if (std::isfinite(w.bound)) fmt::print(" at most {:.2g}{}", w.bound, w.broken() ? ": BROKEN" : "");
    fmt::print("\n");
}

} // namespace

bool bench_errors(const std::string& path, const std::string& out, const std::string& device) {
    const Scene scene = Scene::from_file(path);
    const Device cpu = Device::cpu(), other = Device::open(device);
    const Truth truth(scene);
    std::vector<Way> ways;
    add_candidates(ways, scene, cpu, other, truth);
    add_methods(ways, scene, cpu);
    for (const Way& w : ways) print(w);
    const output::Folder folder(out);
    output::write_file(folder.path() / "errors.csv", table_of(ways));
    fmt::print("{}\n", (folder.path() / "errors.csv").string());
    std::fflush(stdout);
    if (output::draw(plot_script, folder.path(), {"errors"}).empty())
        fmt::print("{}\n", (folder.path() / "errors.png").string());
    return std::ranges::none_of(ways, &Way::broken);
}

} // namespace dermis::cli
