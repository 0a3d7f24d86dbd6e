// SPDX-License-Identifier: MIT
#include "bench/cvode.hpp"

#ifdef DERMIS_BENCH_CVODE

#include "bench/limits.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <type_traits>

#include <cvode/cvode.h>
#include <cvode/cvode_diag.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>

#ifndef SUN_COMM_NULL // before version 7 "no communicator" is a null pointer
#define SUN_COMM_NULL nullptr
#endif

namespace bench {
namespace {

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
    for (const dermis::KelvinVoigt& e : problem.chain) {
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
        for (const dermis::KelvinVoigt& e : problem_.chain) stiffest = std::max(stiffest, e.modulus);
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

} // namespace

std::optional<CvodeRun> cvode(const CreepProblem& problem, double tolerance) {
    CreepProblem own = problem; // its address is handed over as one that may be written to
    return Solver(own, tolerance).run();
}

std::string cvode_version() {
    char text[32] = "";
    SUNDIALSGetVersion(text, sizeof text);
    return text;
}

} // namespace bench

#else

namespace bench {

std::optional<CvodeRun> cvode(const CreepProblem&, double) { return {}; }
std::string cvode_version() { return ""; }

} // namespace bench

#endif
