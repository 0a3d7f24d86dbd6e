// SPDX-License-Identifier: MIT
// Error against step and time on a stiff chain of elements, 4 ms beside 1.4 s, under a load that is held and under a
// smooth one that is known by frames.
#include "bench/bench.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <type_traits>

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

constexpr double end = 2.56, longest_step = 0.64, fastest = 0.004; // s
constexpr double peer_interval = 0.01;                             // s between outputs of a peer with steps of its own
constexpr double smooth_frequency = 5;                             // Hz
constexpr int width = 16, cells = width * width;

// Retardation times of 4 ms, 70 ms and 1.4 s.
std::vector<KelvinVoigt> chain() { return {{2e6, 8e3}, {1e6, 7e4}, {5e5, 7e5}}; }

std::vector<double> pressure() {
    std::vector<double> p;
    for (int i = 0; i < cells; ++i) p.push_back(1e4 * (0.5 + 0.5 * i / cells));
    return p;
}

// Every cell has a receptor of its strain and one of its rate: without a curvature length, SA1 and FA1 are these.
Scene scene_of(Method method, double step, double frequency) {
    Scene s;
    s.grid = {width, width, 1e-3};
    s.surface.kind = Surface::Kind::flat;
    s.surface.relief = 5e-5;
    s.material.elements = chain();
    s.material.thickness = 1e-3;
    s.material.curvature_length = 0;
    s.load.kind = Load::Kind::map;
    s.load.map = pressure();
    if (frequency > 0) {
        s.load.envelope.kind = Envelope::Kind::sine;
        s.load.envelope.frequency = frequency;
        s.load.envelope.mean = 1;
    }
    s.time = {step, end + step / 2}; // the last output is at the end
    for (int i = 0; i < cells; ++i)
        for (Quantity q : {Quantity::sa1, Quantity::fa1}) s.sites.push_back({q, {i % width, i / width}});
    s.output.traces.clear();
    s.model = Model::sites;
    s.method = method;
    return s;
}

// Strain and rate at a time under a pressure of 1 + sin(2*pi*frequency*t), 1 Pa.
std::array<long double, 2> exact_at(long double t, double frequency) {
    const long double w = 2 * std::numbers::pi_v<long double> * frequency;
    std::array<long double, 2> exact{};
    for (const KelvinVoigt& e : chain()) {
        const long double k = (long double)(e.modulus) / e.viscosity, both = (k * k + w * w) * e.viscosity;
        const long double decay = std::exp(-k * t), sine = std::sin(w * t), cosine = std::cos(w * t);
        exact[0] += -std::expm1(-k * t) / e.modulus + (k * sine - w * cosine + w * decay) / both;
        exact[1] += decay / e.viscosity + (k * w * cosine + w * w * sine - k * w * decay) / both;
    }
    return exact;
}

// The greatest error over cells and outputs by the greatest value of strain and FA1, against the closed form.
// responses: strain and rate of each cell at each output, the first at time 0.
std::array<double, 6> errors_of(const std::vector<double>& responses, double interval, double frequency) {
    const std::vector<double> p = pressure();
    std::array<long double, 2> worst{}, largest{};
    for (size_t n = 1; n * 2 * cells < responses.size(); ++n) {
        const std::array<long double, 2> exact = exact_at((long double)(n)*interval, frequency);
        for (size_t i = 0; i < cells; ++i)
            for (size_t q = 0; q < 2; ++q) {
                const long double off = responses[(n * cells + i) * 2 + q] - p[i] * exact[q];
                worst[q] = std::isfinite(off) ? std::max(worst[q], std::abs(off)) : INFINITY;
                largest[q] = std::max(largest[q], std::abs(p[i] * exact[q]));
            }
    }
    std::array<double, 6> errors{NAN, NAN, NAN, NAN, NAN, NAN};
    errors[size_t(Quantity::strain)] = double(worst[0] / largest[0]);
    errors[size_t(Quantity::fa1)] = double(worst[1] / largest[1]);
    return errors;
}

Measurement row(const Bench& bench, const char* model, double frequency, long long steps) {
    Measurement r = row_of(bench.cpu(frequency > 0 ? "smooth" : "stiff", width, 1), model, "f64", steps);
    r.method = r.stencil = "";
    r.receptors = 2 * cells;
    return r;
}

// One thread takes all cells, as the peers do.
Contender of_scene(const Bench& bench, const char* model, Scene s, double frequency) {
    const Device cpu = Device::cpu(1);
    const double step = s.time.step;
    Measurement r = row(bench, model, frequency, std::llround(end / step));
    r.method = name(s.method);
    r.dt_over_tau = step / fastest;
    try {
        r.errors = errors_of(run(s, cpu).responses, step, frequency);
    } catch (const Error&) { // refused as unstable: its error is charted all the same
        r.status = "unstable";
        s.allow_unstable = true;
        r.errors = errors_of(run(s, cpu).responses, step, frequency);
    }
    return {r, [s, cpu] { return run(s, cpu).seconds; }};
}

// The smooth load known by frames alone, with the pressure linear between them.
Contender of_frames(const Bench& bench, double interval) {
    Scene s = scene_of(Method::exact, interval, 0);
    Envelope& e = s.load.envelope;
    e.kind = Envelope::Kind::table;
    for (int i = 0; i * interval < end + 2 * interval; ++i) {
        e.times.push_back(i * interval);
        e.values.push_back(1 + std::sin(2 * std::numbers::pi * smooth_frequency * i * interval));
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
        for (double p : pressure()) {
            p *= 1 + std::sin(2 * std::numbers::pi * smooth_frequency * k * interval);
            out.write(reinterpret_cast<const char*>(&p), sizeof p);
        }
    out.close();
    Scene s = scene_of(Method::exact, interval, 0);
    s.load = {};
    s.load.kind = Load::Kind::sequence;
    s.load.path = path;
    s.load.interval = interval;
    s.load.hold = Hold::parabolic;
    Contender c = of_scene(bench, "frames-parabolic", s, smooth_frequency);
    c.work = [file, work = c.work] { return work(); };
    return c;
}

// The cells of a skin at rest that bears a pressure from time 0 on. All elements of all cells are one system of
// ordinary differential equations.
struct CreepProblem {
    std::vector<KelvinVoigt> chain;
    std::vector<double> pressure; // Pa, of each cell
    double frequency = 0;         // Hz: the pressure is multiplied by 1 + sin(2*pi*frequency*t)
    double interval = 0;          // s, between outputs
    int outputs = 0;              // without the one at time 0
};

struct CvodeRun {
    long long steps = 0;           // its own
    double seconds = 0;            // of steps and outputs, without the maps and tables before them
    std::vector<double> responses; // [output, that at 0 included][strain and rate of each cell]
};

#ifdef DERMIS_BENCH_CVODE

void check(int status, const char* call) {
    if (status < 0) throw std::runtime_error(std::string(call) + " failed: " + std::to_string(status));
}

template <class Object> Object* made(Object* object, const char* call) {
    if (!object) throw std::runtime_error(std::string(call) + " failed");
    return object;
}

// The rate of each element, (sigma - E*eps)/eta; the elements of one place in the chain lie side by side.
int rates(sunrealtype time, N_Vector strain, N_Vector rate, void* user_data) {
    const CreepProblem& problem = *static_cast<const CreepProblem*>(user_data);
    const size_t cells = problem.pressure.size();
    const double *eps = N_VGetArrayPointer(strain), *sigma = problem.pressure.data();
    double* to = N_VGetArrayPointer(rate);
    const double times = 1 + std::sin(2 * std::numbers::pi * problem.frequency * time);
    for (const KelvinVoigt& e : problem.chain) {
        const double E = e.modulus, fluidity = 1 / e.viscosity;
        for (size_t i = 0; i < cells; ++i) to[i] = (sigma[i] * times - E * eps[i]) * fluidity;
        eps += cells;
        to += cells;
    }
    return 0;
}

// CVODE on one problem. Vectors and memory belong to the context, which is made first and freed last.
class Solver {
  public:
    Solver(CreepProblem& problem, double tolerance) : problem_(problem) {
        check(SUNContext_Create(SUN_COMM_NULL, &context_), "SUNContext_Create");
        const auto unknowns = sunindextype(problem.chain.size() * problem.pressure.size());
        strain_.reset(made(N_VNew_Serial(unknowns, context_), "N_VNew_Serial"));
        output_.reset(made(N_VClone(strain_.get()), "N_VClone"));
        N_VConst(0, strain_.get());
        memory_ = made(CVodeCreate(CV_BDF, context_), "CVodeCreate");
        check(CVodeInit(memory_, rates, 0, strain_.get()), "CVodeInit");
        check(CVodeSStolerances(memory_, tolerance, tolerance * scale()), "CVodeSStolerances");
        check(CVodeSetUserData(memory_, &problem), "CVodeSetUserData");
        check(CVodeSetMaxNumSteps(memory_, 1000000), "CVodeSetMaxNumSteps");
        check(CVDiag(memory_), "CVDiag"); // the Jacobian is diagonal
    }
    ~Solver() {
        CVodeFree(&memory_);
        output_.reset();
        strain_.reset();
        SUNContext_Free(&context_);
    }
    Solver(const Solver&) = delete;
    Solver& operator=(const Solver&) = delete;

    CvodeRun run() {
        const size_t columns = 2 * problem_.pressure.size();
        CvodeRun result;
        result.responses.assign(size_t(problem_.outputs + 1) * columns, 0);
        const double start = now();
        sunrealtype reached = 0;
        for (int n = 1; n <= problem_.outputs;) {
            check(CVode(memory_, problem_.outputs * problem_.interval, strain_.get(), &reached, CV_ONE_STEP), "CVode");
            for (; n <= problem_.outputs && n * problem_.interval <= reached; ++n)
                put(n * problem_.interval, result.responses.data() + size_t(n) * columns);
        }
        result.seconds = now() - start;
        long steps = 0;
        check(CVodeGetNumSteps(memory_, &steps), "CVodeGetNumSteps");
        result.steps = steps;
        return result;
    }

  private:
    struct Destroyed {
        void operator()(N_Vector v) const { N_VDestroy(v); }
    };
    using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, Destroyed>;

    // The final strain of the stiffest element under the greatest pressure: strains below it count as small.
    double scale() const {
        double stiffest = 0;
        for (const KelvinVoigt& e : problem_.chain) stiffest = std::max(stiffest, e.modulus);
        return *std::max_element(problem_.pressure.begin(), problem_.pressure.end()) / stiffest;
    }

    // Puts strain and rate of each cell at a time within the last step: the polynomial of the step and its derivative.
    void put(double time, double* to) {
        for (int derivative = 0; derivative < 2; ++derivative) {
            check(CVodeGetDky(memory_, time, derivative, output_.get()), "CVodeGetDky");
            add_elements(output_.get(), to + derivative);
        }
    }

    void add_elements(N_Vector vector, double* to) const {
        const size_t cells = problem_.pressure.size();
        const double* of = N_VGetArrayPointer(vector);
        for (size_t k = 0; k < problem_.chain.size(); ++k, of += cells)
            for (size_t i = 0; i < cells; ++i) to[2 * i] += of[i];
    }

    CreepProblem& problem_;
    SUNContext context_ = nullptr;
    Vector strain_, output_;
    void* memory_ = nullptr;
};

// Runs the problem by backward differentiation formulas of order 1 to 5 with a relative tolerance.
std::optional<CvodeRun> cvode(CreepProblem problem, double tolerance) { return Solver(problem, tolerance).run(); }

std::string cvode_version() {
    char text[32] = "";
    SUNDIALSGetVersion(text, sizeof text);
    return text;
}

#else

std::optional<CvodeRun> cvode(const CreepProblem&, double) { return {}; }
std::string cvode_version() { return ""; }

#endif

Contender of_cvode(const Bench& bench, double tolerance, double frequency) {
    const CreepProblem problem{.chain = chain(),
                               .pressure = pressure(),
                               .frequency = frequency,
                               .interval = peer_interval,
                               .outputs = int(std::lround(end / peer_interval))};
    Measurement r = row(bench, "bdf", frequency, 0);
    r.backend = r.driver = "cvode";
    r.driver_version = cvode_version();
    r.exact = false;
    const std::optional<CvodeRun> first = cvode(problem, tolerance);
    if (!first) {
        r.status = not_installed;
        return {r, {}};
    }
    r.method = fmt::format("rtol={:g}", tolerance);
    r.steps = first->steps;
    r.dt_over_tau = end / double(first->steps) / fastest;
    r.errors = errors_of(first->responses, peer_interval, frequency);
    return {r, [problem, tolerance] { return cvode(problem, tolerance)->seconds; }};
}

// CVODE, which chooses its own steps.
void add_solvers(const Bench& bench, double frequency, std::vector<Contender>& all) {
    for (double tolerance = 1e-2; tolerance > 3e-13; tolerance /= 10) {
        all.push_back(of_cvode(bench, tolerance, frequency));
        if (!all.back().work) break; // one row says so
    }
}

std::vector<Contender> held_load(const Bench& bench) {
    const double least = bench.quick ? 0.002 : 0.0003;
    std::vector<Contender> all;
    for (Method m : {Method::exact, Method::euler, Method::rk2, Method::rk4, Method::backward_euler,
                     Method::crank_nicolson, Method::sdirk2})
        for (double step = longest_step; step >= least; step /= 2)
            all.push_back(of_scene(bench, "sites", scene_of(m, step, 0), 0));
    add_solvers(bench, 0, all);
    return all;
}

std::vector<Contender> smooth_load(const Bench& bench) {
    std::vector<Contender> all = {
        of_scene(bench, "sine", scene_of(Method::exact, peer_interval, smooth_frequency), smooth_frequency)};
    for (int of_interval = 1; of_interval <= 16; of_interval *= 2)
        for (auto of : {of_frames, of_parabolas}) all.push_back(of(bench, peer_interval / of_interval));
    add_solvers(bench, smooth_frequency, all);
    return all;
}

} // namespace

void stiff(Bench& bench) {
    bench.measure(held_load(bench), bench.runs);
    bench.measure(smooth_load(bench), bench.runs);
}

} // namespace bench
