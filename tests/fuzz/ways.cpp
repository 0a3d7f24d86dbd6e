// SPDX-License-Identifier: MIT
// Computes scenes in every way there is and compares: for each line of the standard input, which names a scene file, a
// line that says how two ways differ, or an empty one. differential.py draws the scenes.
#include "dermis/dermis.hpp"

#include <cmath>
#include <cstring>
#include <iostream>
#include <map>

using namespace dermis;

namespace {

constexpr double tolerance = 1e-6;
// A value below 2^-340 is stored as 0, and an output that is nowhere greater counts as exact (kernels/NUMERICS.md). A
// gain of FA2, at most 2 here, comes after.
constexpr double unstored = 0x1p-337;

// The numbers of a result by what they are; those of one quantity have one scale.
using Numbers = std::map<std::string, std::vector<double>>;

Numbers numbers_of(const Result& r) {
    Numbers all;
    const auto add = [&](const std::string& name, const std::vector<double>& values) {
        std::vector<double>& to = all[name];
        to.insert(to.end(), values.begin(), values.end());
    };
    for (const Trace& t : r.traces) {
        for (const std::vector<double>* values : {&t.mean, &t.min, &t.max}) add(name(t.quantity), *values);
        for (const std::vector<double>& probe : t.probes) add(name(t.quantity), probe);
    }
    for (const Field& f : r.fields) add(std::string("field of ") + name(f.quantity), f.values);
    add("responses", r.responses);
    for (const Impulse& i : r.impulses) {
        add("impulses", {i.time, i.mean, i.min, i.max});
        add("impulses", i.probes);
    }
    return all;
}

// A run gave numbers, or refused the scene.
struct Outcome {
    bool done = false;
    Numbers numbers;
    std::string refusal;
};

// Errors of other kinds go to the caller.
Outcome outcome(Scene scene, const Device& device, Model model, Precision precision, bool keeps_tolerance) {
    scene.model = model;
    if (keeps_tolerance) scene.tolerance = tolerance;
    RunOptions options;
    options.precision = precision;
    try {
        return {.done = true, .numbers = numbers_of(run(scene, device, options)), .refusal = {}};
    } catch (const Error& e) {
        if (e.code() != Error::Code::bad_input) throw;
        return {.done = false, .numbers = {}, .refusal = e.what()};
    }
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
    if (a.size() != b.size()) return false;
    for (size_t i = 0; i < a.size(); ++i)
        if (std::memcmp(&a[i], &b[i], sizeof a[i]) != 0 && !(std::isnan(a[i]) && std::isnan(b[i]))) return false;
    return true;
}

// A march in float on all devices, the first of which is the CPU path on one thread.
std::string difference_in_bits(const Scene& scene, const std::vector<Device>& devices) {
    for (Precision precision : {Precision::f32, Precision::f32_compensated}) {
        const Outcome right = outcome(scene, devices[0], Model::march, precision, false);
        for (const Device& device : devices) {
            const std::string where = std::string(name(precision)) + " on " + device.info().name + ": ";
            Outcome other = outcome(scene, device, Model::march, precision, false);
            if (other.done != right.done) return where + "only one refuses: " + right.refusal + other.refusal;
            for (const auto& [what, values] : right.numbers)
                if (!same_bits(values, other.numbers[what])) return where + what + " has other bits than on the CPU";
        }
    }
    return "";
}

// Every model in double that keeps the tolerance; impulses alone are no part of it.
std::string difference_of_models(const Scene& scene, const Device& cpu) {
    std::vector<std::pair<Model, Numbers>> done;
    for (Model model : {Model::march, Model::maps, Model::moments, Model::sites}) {
        Outcome o = outcome(scene, cpu, model, Precision::f64, true);
        if (o.done) done.emplace_back(model, std::move(o.numbers));
    }
    for (size_t m = 1; m < done.size(); ++m)
        for (const auto& [what, right] : done[0].second) {
            const std::string where = std::string(name(done[m].first)) + " and " + name(done[0].first) + ": " + what;
            if (what == "impulses") continue;
            const std::vector<double>& other = done[m].second[what];
            double scale = 0, off = 0;
            if (other.size() != right.size()) return where + " has another number of values";
            for (size_t i = 0; i < right.size(); ++i) {
                scale = std::fmax(scale, std::fabs(right[i]));
                off = std::fmax(off, std::isfinite(other[i]) ? std::fabs(other[i] - right[i]) : HUGE_VAL);
            }
            // The tolerance of responses and fields is relative to the greatest value of all cells, which is not here.
            const bool whole = what != "responses" && what.find("field") != 0;
            if (whole && off > 2 * tolerance * scale + unstored)
                return where + " differs by " + std::to_string(off / scale);
        }
    return "";
}

} // namespace

int main() {
    std::vector<Device> devices = {Device::cpu(1), Device::cpu(3)};
    try {
        const std::vector<DeviceInfo> listed = Device::list();
        for (size_t i = 0; i < listed.size(); ++i)
            if (listed[i].refused.empty()) devices.push_back(Device::open(std::to_string(i)));
    } catch (const Error& e) {
        std::cerr << e.what() << "\n"; // the CPU path alone, on one thread and on three
    }
    std::string ready;
    for (const Device& device : devices) ready += (ready.empty() ? "" : ", ") + device.info().name;
    std::cout << ready << std::endl;
    for (std::string path; std::getline(std::cin, path);) {
        std::string how;
        try {
            const Scene scene = Scene::from_file(path);
            how = difference_in_bits(scene, devices);
            if (how.empty()) how = difference_of_models(scene, devices[0]);
        } catch (const Error& e) {
            if (e.code() != Error::Code::bad_input) how = e.what();
        }
        std::cout << how << std::endl;
    }
}
