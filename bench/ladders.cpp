// SPDX-License-Identifier: MIT
// Error against step and time: on a smooth scene by methods, precisions and models, and on a stiff chain of elements,
// 4 ms beside 1.4 s, under a load that is held and under a smooth one that is known by frames.
#include "bench/bench.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <stdexcept>

#include <unistd.h>

#ifdef DERMIS_BENCH_CVODE
#include <cvode/cvode.h>
#include <cvode/cvode_diag.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>

#ifndef SUN_COMM_NULL // before version 7 "no communicator" is a null pointer
#define SUN_COMM_NULL nullptr
#endif
#endif

namespace bench {

using namespace dermis;

namespace {

constexpr double end = 2.56, longest_step = 0.64; // s

// A run whose errors are taken first. errors: of a scene, from its results. whole: times maps too.
template <class Errors>
Contender taken(Measurement r, Scene s, const Device& cpu, double fastest, bool whole, const Errors& errors) {
    r.method = name(s.method);
    r.dt_over_tau = s.time.step / fastest;
    r.steps = std::llround(end / s.time.step);
    try {
        r.errors = errors(s);
    } catch (const Error&) { // refused as unstable: its error is charted all the same
        r.status = "unstable";
        s.allow_unstable = true;
        r.errors = errors(s);
    }
    return {r, [s, cpu, whole] {
                double seconds = 0;
                const double all = seconds_of([&] { seconds = run(s, cpu).seconds; });
                return whole ? all : seconds;
            }};
}

// A smooth and periodic scene with a known Laplacian of the continuum: waves of 16 cells along each axis.
constexpr double waves = 2 * std::numbers::pi / 16;
double smooth_surface(int x, int y) { return std::sin(waves * x) * std::sin(waves * y); }
double smooth_pressure(int x, int y) { return 1 + 0.5 * std::cos(waves * x) * std::cos(waves * y); }

Scene smooth_scene(int n) {
    Scene s;
    s.grid = {n, n, {}};
    s.edges = Edges::periodic;
    s.surface.kind = Surface::Kind::map;
    s.load.kind = Load::Kind::map;
    std::vector<double> surface, pressure;
    for (int i = 0; i < n * n; ++i) {
        surface.push_back(smooth_surface(i % n, i / n));
        pressure.push_back(smooth_pressure(i % n, i / n));
    }
    s.surface.map = surface;
    s.load.map = pressure;
    s.material.modulus = 1.54;
    s.material.viscosity = 0.25; // dt/tau goes up to 3.9, where some methods are unstable
    s.time.duration = end;
    return s;
}

// The greatest error over cells and three instants, divided by the greatest value. Strain and responses are compared
// with closed forms in time on the scene's own grid, curvature with the continuum's.
std::array<double, 6> smooth_errors(Scene s, const Device& device) {
    const double E = *s.material.modulus, eta = *s.material.viscosity;
    for (double t : {end / 4, end / 2, 3 * end / 4})
        s.output.fields.push_back(
            {t, {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2, Quantity::curvature}});
    if (s.model == Model::moments) s.model = Model::maps;
    const Result r = run(s, device);
    Scene unit = s; // its rest curvature is L(p), by the same stencil
    unit.surface.map = s.load.map;
    const SceneMaps m = maps(s);
    const Map Lp = maps(unit).rest_curvature;
    std::array<double, 6> worst{}, largest{};
    for (const Field& f : r.fields) {
        const double decay = std::exp(-E / eta * f.at), g = -std::expm1(-E / eta * f.at) / E, k2 = 2 * waves * waves;
        const double scalar[] = {g, g, (f.at - eta * g) / E, decay / eta, -E / eta * decay / eta};
        const auto q = size_t(f.quantity);
        for (size_t i = 0; i < m.pressure.size(); ++i) {
            const int x = int(i) % s.grid.width, y = int(i) / s.grid.width;
            const double C = m.rest_curvature[i] - g * Lp[i];
            const double exact = f.quantity == Quantity::curvature
                                     ? -k2 * smooth_surface(x, y) + g * k2 * (smooth_pressure(x, y) - 1)
                                     : m.pressure[i] * scalar[q] * (f.quantity == Quantity::strain ? 1 : 1 + C);
            worst[q] = std::max(worst[q], std::abs(f.values[i] - exact));
            largest[q] = std::max(largest[q], std::abs(exact));
        }
    }
    for (size_t q = 0; q < 6; ++q) worst[q] /= largest[q];
    return worst;
}

} // namespace

void accuracy(Bench& bench) {
    const double least = bench.quick ? 0.02 : 0.0025; // s
    const Device cpu = Device::cpu();
    Scene scene = smooth_scene(bench.quick ? 64 : 192);
    const auto add = [&](Model model, Precision precision, Method method, Stencil stencil, double least) {
        scene.model = model, scene.precision = precision, scene.method = method, scene.stencil = stencil;
        for (double step = longest_step; step >= least; step /= 2) {
            scene.time.step = step;
            Measurement r = row_of(bench.on(cpu, "accuracy", scene.grid.width), name(model), name(precision), 0);
            if (stencil == Stencil::fourth_order) r.stencil = "fourth-order";
            bench.measure({taken(r, scene, cpu, *scene.material.viscosity / *scene.material.modulus, true,
                                 [&](const Scene& s) { return smooth_errors(s, cpu); })},
                          std::min(bench.runs, 5));
        }
    };
    for (Method m : {Method::euler, Method::crank_nicolson, Method::rk4, Method::exact})
        for (Precision p : {Precision::f32, Precision::f64}) add(Model::march, p, m, Stencil::five_point, least);
    add(Model::march, Precision::f32_compensated, Method::exact, Stencil::five_point, least);
    add(Model::march, Precision::f32, Method::exact, Stencil::fourth_order, longest_step);
    add(Model::moments, Precision::f64, Method::exact, Stencil::five_point, least);
}

namespace {

constexpr double fastest = 0.004;      // s
constexpr double peer_interval = 0.01; // s between outputs of a peer with steps of its own
constexpr double smooth_frequency = 5; // Hz
constexpr int width = 16, cells = width * width;
const KelvinVoigt chain[] = {{2e6, 8e3}, {1e6, 7e4}, {5e5, 7e5}}; // retardation times of 4 ms, 70 ms and 1.4 s

const std::vector<double> pressure = [] { // Pa, of each cell
    std::vector<double> p;
    for (int i = 0; i < cells; ++i) p.push_back(1e4 * (0.5 + 0.5 * i / cells));
    return p;
}();

// Every cell has a receptor of its strain and one of its rate: without a curvature length, SA1 and FA1 are these.
Scene stiff_scene(Method method, double step, double frequency) {
    Scene s;
    s.grid = {width, width, 1e-3};
    s.surface.kind = Surface::Kind::flat;
    s.surface.relief = 5e-5;
    s.material.elements = {std::begin(chain), std::end(chain)};
    s.material.thickness = 1e-3;
    s.material.curvature_length = 0;
    s.load.kind = Load::Kind::map;
    s.load.map = pressure;
    for (int i = 0; i < cells; ++i)
        for (Quantity q : {Quantity::sa1, Quantity::fa1}) s.sites.push_back({q, {i % width, i / width}});
    if (frequency > 0) {
        s.load.envelope.kind = Envelope::Kind::sine;
        s.load.envelope.frequency = frequency;
        s.load.envelope.mean = 1;
    }
    s.time = {step, end + step / 2}; // the last output is at the end
    s.output.traces.clear();
    s.model = Model::sites;
    s.precision = Precision::f64;
    s.method = method;
    return s;
}

// Strain and rate at a time under a pressure of 1 + sin(2*pi*frequency*t), 1 Pa.
std::array<long double, 2> exact_at(long double t, double frequency) {
    const long double w = 2 * std::numbers::pi_v<long double> * frequency;
    std::array<long double, 2> exact{};
    for (const KelvinVoigt& e : chain) {
        const long double k = (long double)(e.modulus) / e.viscosity, both = (k * k + w * w) * e.viscosity;
        const long double decay = std::exp(-k * t), sine = std::sin(w * t), cosine = std::cos(w * t);
        exact[0] += -std::expm1(-k * t) / e.modulus + (k * sine - w * cosine + w * decay) / both;
        exact[1] += decay / e.viscosity + (k * w * cosine + w * w * sine - k * w * decay) / both;
    }
    return exact;
}

// The greatest error over cells and outputs by the greatest value of strain and FA1, against the closed form.
// responses: strain and rate of each cell at each output, the first at time 0.
std::array<double, 6> stiff_errors(const std::vector<double>& responses, double interval, double frequency) {
    std::array<long double, 2> worst{}, largest{};
    for (size_t n = 1; n * 2 * cells < responses.size(); ++n) {
        const std::array<long double, 2> exact = exact_at((long double)(n)*interval, frequency);
        for (size_t i = 0; i < cells; ++i)
            for (size_t q = 0; q < 2; ++q) {
                const long double truth = pressure[i] * exact[q], off = responses[(n * cells + i) * 2 + q] - truth;
                worst[q] = std::isfinite(off) ? std::max(worst[q], std::abs(off)) : INFINITY;
                largest[q] = std::max(largest[q], std::abs(truth));
            }
    }
    std::array<double, 6> errors{NAN, NAN, NAN, NAN, NAN, NAN};
    errors[size_t(Quantity::strain)] = double(worst[0] / largest[0]);
    errors[size_t(Quantity::fa1)] = double(worst[1] / largest[1]);
    return errors;
}

Measurement stiff_row(const Bench& bench, const char* model, double frequency) {
    Measurement r = row_of(bench.cpu(frequency > 0 ? "smooth" : "stiff", width, 1), model, "f64", 0);
    r.method = r.stencil = "";
    r.receptors = 2 * cells;
    return r;
}

// One thread takes all cells, as the peer does.
Contender of_scene(const Bench& bench, const char* model, const Scene& s, double frequency) {
    const Device cpu = Device::cpu(1);
    return taken(stiff_row(bench, model, frequency), s, cpu, fastest, false,
                 [&](const Scene& scene) { return stiff_errors(run(scene, cpu).responses, s.time.step, frequency); });
}

double smooth_at(int k, double interval) {
    return 1 + std::sin(2 * std::numbers::pi * smooth_frequency * k * interval);
}

// The smooth load known by frames alone, with the pressure linear between them.
Contender of_frames(const Bench& bench, double interval) {
    Scene s = stiff_scene(Method::exact, interval, 0);
    Envelope& e = s.load.envelope;
    e.kind = Envelope::Kind::table;
    for (int i = 0; i * interval < end + 2 * interval; ++i) {
        e.times.push_back(i * interval);
        e.values.push_back(smooth_at(i, interval));
    }
    return of_scene(bench, "frames-linear", s, smooth_frequency);
}

// The same from a file of frames, with the pressure along parabolas: every cell is stepped, where a table steps one.
Contender of_parabolas(const Bench& bench, double interval) {
    const std::string name = fmt::format("dermis_bench_{}_{}.npy", getpid(), interval),
                      path = (std::filesystem::temp_directory_path() / name).string();
    const std::shared_ptr<void> file(nullptr, [path](void*) { std::filesystem::remove(path); });
    const int frames = int(std::lround(end / interval)) + 2;
    std::ofstream out(path, std::ios::binary);
    out << std::string("\x93NUMPY\x01\x00\x76\x00", 10)
        << fmt::format("{:117}\n", fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}, {}), }}",
                                               frames, width, width));
    for (int k = 0; k < frames; ++k)
        for (double p : pressure) {
            p *= smooth_at(k, interval);
            out.write(reinterpret_cast<const char*>(&p), sizeof p);
        }
    out.close();
    Scene s = stiff_scene(Method::exact, interval, 0);
    s.load = {};
    s.load.kind = Load::Kind::sequence;
    s.load.path = path;
    s.load.interval = interval;
    s.load.hold = Hold::parabolic;
    Contender c = of_scene(bench, "frames-parabolic", s, smooth_frequency);
    c.work = [file, work = c.work] { return work(); };
    return c;
}

#ifdef DERMIS_BENCH_CVODE

template <class Result> Result made(Result result, const char* call) {
    bool failed = false;
    if constexpr (std::is_pointer_v<Result>) failed = !result;
    else failed = result < 0;
    if (failed) throw std::runtime_error(std::string(call) + " failed");
    return result;
}
#define MADE(function, ...) made(function(__VA_ARGS__), #function)

// The rate of each element, (sigma - E*eps)/eta; the elements of one place in the chain lie side by side.
int rates(sunrealtype time, N_Vector strain, N_Vector rate, void* frequency) {
    const double *eps = N_VGetArrayPointer(strain),
                 times = 1 + std::sin(2 * std::numbers::pi * *static_cast<const double*>(frequency) * time);
    double* to = N_VGetArrayPointer(rate);
    for (const KelvinVoigt& e : chain) {
        const double E = e.modulus, fluidity = 1 / e.viscosity;
        for (const double sigma : pressure) *to++ = (sigma * times - E * *eps++) * fluidity;
    }
    return 0;
}

// Runs the chain of all cells as one system, by backward differentiation formulas of order 1 to 5 with a relative
// tolerance. Sets strain and rate of each cell at each output, and returns its number of steps.
long long cvode(double tolerance, double frequency, std::vector<double>& responses) {
    SUNContext context = nullptr;
    MADE(SUNContext_Create, SUN_COMM_NULL, &context);
    const std::shared_ptr<void> last(nullptr, [&](void*) { SUNContext_Free(&context); });
    using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, void (*)(N_Vector)>;
    const Vector strain(MADE(N_VNew_Serial, sunindextype(std::size(chain) * cells), context), N_VDestroy),
        output(MADE(N_VClone, strain.get()), N_VDestroy);
    N_VConst(0, strain.get());
    void* memory = MADE(CVodeCreate, CV_BDF, context);
    const std::shared_ptr<void> first(nullptr, [&](void*) { CVodeFree(&memory); });
    MADE(CVodeInit, memory, rates, 0, strain.get());
    // The final strain of the stiffest element under the greatest pressure: strains below it count as small.
    MADE(CVodeSStolerances, memory, tolerance, tolerance * (pressure.back() / chain[0].modulus));
    MADE(CVodeSetUserData, memory, &frequency);
    MADE(CVodeSetMaxNumSteps, memory, 1000000);
    MADE(CVDiag, memory); // the Jacobian is diagonal
    const int outputs = int(std::lround(end / peer_interval));
    responses.resize(size_t(outputs + 1) * 2 * cells);
    sunrealtype reached = 0;
    for (int n = 1; n <= outputs;) {
        MADE(CVode, memory, outputs * peer_interval, strain.get(), &reached, CV_ONE_STEP);
        for (; n <= outputs && n * peer_interval <= reached; ++n)
            for (int derivative = 0; derivative < 2; ++derivative) { // by the polynomial of the step
                MADE(CVodeGetDky, memory, n * peer_interval, derivative, output.get());
                double* const to = responses.data() + size_t(n) * 2 * cells + derivative;
                const double* of = N_VGetArrayPointer(output.get());
                for (size_t k = 0; k < std::size(chain); ++k)
                    for (int i = 0; i < cells; ++i) to[2 * i] = (k ? to[2 * i] : 0) + *of++;
            }
    }
    long steps = 0;
    MADE(CVodeGetNumSteps, memory, &steps);
    return steps;
}

#endif

// CVODE, which chooses its own steps.
void add_cvode(const Bench& bench, double frequency, std::vector<Contender>& all) {
    Measurement r = stiff_row(bench, "bdf", frequency);
    r.backend = r.driver = "cvode";
    r.exact = false;
#ifdef DERMIS_BENCH_CVODE
    char version[32] = "";
    SUNDIALSGetVersion(version, sizeof version);
    r.driver_version = version;
    for (double tolerance = 1e-2; tolerance > 3e-13; tolerance /= 10) {
        std::vector<double> responses;
        r.method = fmt::format("rtol={:g}", tolerance);
        r.steps = cvode(tolerance, frequency, responses);
        r.dt_over_tau = end / double(r.steps) / fastest;
        r.errors = stiff_errors(responses, peer_interval, frequency);
        all.push_back({r, [tolerance, frequency, responses]() mutable {
                           return seconds_of([&] { cvode(tolerance, frequency, responses); });
                       }});
    }
#else
    r.status = not_installed;
    all.push_back({r, {}});
#endif
}

} // namespace

void stiff(Bench& bench) {
    std::vector<Contender> held, smooth;
    for (Method m : {Method::exact, Method::euler, Method::rk2, Method::rk4, Method::backward_euler,
                     Method::crank_nicolson, Method::sdirk2})
        for (double step = longest_step; step >= (bench.quick ? 0.002 : 0.0003); step /= 2)
            held.push_back(of_scene(bench, "sites", stiff_scene(m, step, 0), 0));
    add_cvode(bench, 0, held);
    bench.measure(std::move(held), bench.runs);
    smooth.push_back(
        of_scene(bench, "sine", stiff_scene(Method::exact, peer_interval, smooth_frequency), smooth_frequency));
    for (int of_interval = 1; of_interval <= 16; of_interval *= 2)
        for (auto of : {of_frames, of_parabolas}) smooth.push_back(of(bench, peer_interval / of_interval));
    add_cvode(bench, smooth_frequency, smooth);
    bench.measure(std::move(smooth), bench.runs);
}

} // namespace bench
