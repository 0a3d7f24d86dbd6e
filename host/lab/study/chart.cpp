// SPDX-License-Identifier: MIT
// This chart shows what each choice costs in time and in error, on the study's wave under the circular load.
#include "host/lab/study/study.hpp"

#include "host/core/base/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace dermis::study {
namespace {

// An error is the greatest one of the most strained cell over all outputs, divided by the largest value of the closed
// form. rate: the error of the strain's rate.
struct Errors {
    double strain = 0, rate = 0;
};

Errors errors(const Result& r, const Material& m) {
    Errors e;
    const double E = *m.modulus, eta = *m.viscosity;
    for (size_t n = 1; n < r.time.size(); ++n) {
        const double decay = std::exp(-r.time[n] * E / eta);
        const double strain = -std::expm1(-r.time[n] * E / eta) / E;
        e.strain = std::max(e.strain, std::abs(r.trace(Quantity::strain).max[n] - strain) * E);
        e.rate = std::max(e.rate, std::abs(r.trace(Quantity::fa1).max[n] - decay / eta) * eta);
    }
    return e;
}

// Returns the strain of one cell after 0, 1 .. `steps` steps at z = dt/tau, in units of pressure/modulus.
std::vector<double> relaxation(Method method, double z, int steps, Precision precision) {
    Scene s;
    s.grid = {1, 1, {}};
    s.load.kind = Load::Kind::map;
    s.load.map = {1.0};
    s.material = {1, 1, {}, {}};
    s.model = Model::march;
    s.method = method;
    s.allow_unstable = true;
    s.time = {z, z * (steps + 1)};
    s.output.traces = {Quantity::strain};
    return run(s, Device::cpu(1), {.precision = precision}).trace(Quantity::strain).mean;
}

// Makes the study's wave with a curvature gain of 0: FA1 is then the bare rate, which has a closed form. The kernels do
// the same work as with another gain.
Scene closed_form_scene(Method method, double step) {
    Scene s = study_scene(Surface::Kind::wave, Load::Kind::circular, method);
    s.model = Model::march;
    s.grid.spacing = s.surface.relief = s.material.thickness = 1;
    s.material.modulus = 1.54;
    s.material.viscosity = 1;
    s.material.curvature_length = 0;
    s.time = {step, 2.56};
    s.output = {{Quantity::strain, Quantity::fa1}, {}, {}};
    return s;
}

// Runs the scene three times, the first time also to warm up, and returns the fastest run.
Result fastest_of_three(const Scene& scene, const Device& device, Precision precision) {
    std::array<Result, 3> runs;
    for (Result& r : runs) r = run(scene, device, {.precision = precision});
    return *std::ranges::min_element(runs, {}, &Result::seconds);
}

} // namespace

std::string error_against_time(const Device* vulkan) {
    std::string csv = "method,precision,device,step,steps,error_strain,error_fa1,ns_per_cell_step,ns_per_cell_second\n";
    const Device cpu = Device::cpu(1);
    for (Method method : {Method::euler, Method::exact})
        for (const auto& [device, precision] :
             {std::pair{&cpu, Precision::f32}, {&cpu, Precision::f64}, {vulkan, Precision::f32}})
            for (double step = 0.64; device && step > 0.009; step /= 2) {
                const Scene s = closed_form_scene(method, step);
                const Result r = fastest_of_three(s, *device, precision);
                const double cell_ns = r.seconds * 1e9 / (1.0 * s.grid.width * s.grid.height);
                const Errors e = errors(r, s.material);
                csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", name(method), name(precision),
                                   device == &cpu ? "cpu" : "vulkan", shortest(step), r.steps, shortest(e.strain),
                                   shortest(e.rate), shortest(cell_ns / double(r.steps)),
                                   shortest(cell_ns / s.time.duration));
            }
    return csv;
}

std::string stability_map() {
    std::string csv = "method,precision,z,steps,error\n";
    for (Method method : {Method::euler, Method::rk2, Method::rk4, Method::backward_euler, Method::crank_nicolson,
                          Method::sdirk2, Method::exact})
        for (Precision precision : {Precision::f32, Precision::f64})
            for (int i = -30; i <= 30; ++i) {
                if (precision == Precision::f32 && method != Method::exact) continue;
                const double z = std::pow(10, i / 5.0), steps = std::clamp(std::ceil(3 / z), 50.0, 3000.0);
                const std::vector<double> strain = relaxation(method, z, int(steps), precision);
                double error = 0;
                for (size_t n = 0; n < strain.size(); ++n)
                    error = std::max(error, std::abs(strain[n] + std::expm1(-z * double(n))));
                csv += fmt::format("{},{},{},{},{}\n", name(method), name(precision), shortest(z), steps,
                                   std::isfinite(error) ? shortest(error) : "inf");
            }
    return csv;
}

std::string failing_courses() {
    std::string csv = "method,z,step,strain\n";
    for (auto [method, z] : {std::pair{Method::euler, 2.1},
                             {Method::rk2, 2.1},
                             {Method::crank_nicolson, 20.0},
                             {Method::sdirk2, 8.24},
                             {Method::backward_euler, 8.24},
                             {Method::exact, 8.24}}) {
        const std::vector<double> strain = relaxation(method, z, 12, Precision::f64);
        for (size_t n = 0; n < strain.size(); ++n)
            csv += fmt::format("{},{},{},{}\n", name(method), shortest(z), n, shortest(strain[n]));
    }
    return csv;
}

} // namespace dermis::study
