// SPDX-License-Identifier: MIT
// What each choice costs in time and in error, on the study's wave under the circular load.
#include "host/cli/study.hpp"

#include "host/scene/text.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace dermis::cli {
namespace {

// Greatest error of the most strained cell over all outputs, against the closed form, over its largest value.
struct Errors {
    double strain = 0, rate = 0;
};

Errors errors(const Result& r, const Material& m) {
    Errors e;
    for (size_t n = 1; n < r.time.size(); ++n) {
        const double decay = std::exp(-r.time[n] * m.modulus / m.viscosity);
        const double strain = -std::expm1(-r.time[n] * m.modulus / m.viscosity) / m.modulus;
        e.strain = std::max(e.strain, std::abs(r.trace(Quantity::strain).max[n] - strain) * m.modulus);
        e.rate = std::max(e.rate, std::abs(r.trace(Quantity::fa1).max[n] - decay / m.viscosity) * m.viscosity);
    }
    return e;
}

} // namespace

std::string error_against_time(const Device* vulkan) {
    std::string csv = "method,precision,device,step,steps,error_strain,error_fa1,ns_per_cell_step,ns_per_cell_second\n";
    const Device cpu = Device::cpu(1);
    for (Method method : {Method::euler, Method::exact})
        for (const auto& [device, precision] :
             {std::pair{&cpu, Precision::f32}, {&cpu, Precision::f64}, {vulkan, Precision::f32}})
            for (double step = 0.64; device && step > 0.009; step /= 2) {
                // curvature gain 0: FA1 is the bare rate, which has a closed form; the kernels do the same work
                Scene s = study_scene(Surface::Kind::wave, Load::Kind::circular, method);
                s.grid.spacing = s.surface.relief = s.material.thickness = 1;
                s.material.curvature_length = 0;
                s.time = {step, 2.56};
                s.output = {{Quantity::strain, Quantity::fa1}, {}, {}};
                RunOptions options;
                options.precision = precision;
                std::vector<double> seconds;
                Result r;
                for (int i = 0; i < 3; ++i) { // the first one also warms up
                    r = run(s, *device, options);
                    seconds.push_back(r.seconds);
                }
                std::sort(seconds.begin(), seconds.end());
                const double cells = 22500, median = seconds[1] * 1e9 / cells;
                const Errors e = errors(r, s.material);
                csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", name(method), name(precision),
                                   device == &cpu ? "cpu" : "vulkan", shortest(step), r.steps, shortest(e.strain),
                                   shortest(e.rate), shortest(median / double(r.steps)),
                                   shortest(median / s.time.duration));
            }
    return csv;
}

} // namespace dermis::cli
