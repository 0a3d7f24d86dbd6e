// SPDX-License-Identifier: MIT
#include "host/lab/command/fit.hpp"
#include "host/core/base/refusal.hpp"
#include "host/lab/command/curve_file.hpp"
#include "host/lab/output/drawing.hpp"
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/folder.hpp"

#include "fit_figure_script.h"

#include <cmath>

#include <fmt/format.h>

namespace dermis::cli {
namespace {

// The interval of 95 % of a number, by the error of its logarithm.
std::string interval(double error) {
    const double factor = std::exp(2 * error);
    if (error < 0.25) return fmt::format("+-{:.2g} %", 200 * error);
    return factor < 1000 ? fmt::format("within a factor of {:.3g}", factor) : "open";
}

std::string described(const KelvinVoigt& e, const KelvinVoigt& error) {
    if (e.viscosity == 0) return "spring, " + interval(error.modulus);
    if (e.modulus == 0) return "dashpot, " + interval(error.viscosity);
    return fmt::format("retardation time {:.4g} s; modulus {}, viscosity {}", e.viscosity / e.modulus,
                       interval(error.modulus), interval(error.viscosity));
}

// The chain as its relaxation, the form in which papers print it.
std::string relaxation_text(const std::vector<KelvinVoigt>& chain) {
    const Relaxation r = relaxation_of(chain);
    std::string text;
    if (r.equilibrium > 0) text = fmt::format("{:.7g}", r.equilibrium);
    for (size_t k = 0; k < r.times.size(); ++k)
        text += fmt::format("{}{:.7g}*e^(-t/{:.7g})", text.empty() ? "" : " + ", r.moduli[k], r.times[k]);
    return text;
}

void print_fit(const FitArguments& a, const Curve& curve, const Fit& fit) {
    const bool creep = curve.test == fit::Test::creep;
    fmt::print("# {}: {} points of {}; elements: {}; residual {:.3g} (root mean square, {})\n", a.data,
               curve.times.size(), creep ? "creep" : "relaxation", fit.elements.size(), fit.residual,
               a.residual == "relative" ? "relative to each value" : "relative to the greatest value");
    const bool relaxes = !creep || fit.elements.front().viscosity == 0; // it has a spring
    if (relaxes) fmt::print("# relaxation E(t) = {} Pa, t in s\n", relaxation_text(fit.elements));
    fmt::print("[material]\nelements = [ # +- and factors: the truth is within in 95 of 100 such data\n");
    for (size_t k = 0; k < fit.elements.size(); ++k) {
        const KelvinVoigt& e = fit.elements[k];
        fmt::print("    {:<52} # {}: {}\n",
                   fmt::format("{{ modulus = {:.7g}, viscosity = {:.7g} }},", e.modulus, e.viscosity), k + 1,
                   described(e, fit.errors[k]));
    }
    fmt::print("]\n");
    for (const std::string& sentence : fit.undetermined) fmt::print("# warning: {}\n", sentence);
}

std::string fit_csv(const Curve& curve, const Fit& fit) {
    std::string text = curve.test == fit::Test::creep ? "time,compliance,model\n" : "time,modulus,model\n";
    for (size_t i = 0; i < curve.times.size(); ++i) {
        append_shortest(text, curve.times[i]);
        for (double x : {curve.values[i], fit.model[i]}) append_shortest(text += ',', x);
        text += '\n';
    }
    return text;
}

} // namespace

int fit_data(const FitArguments& a) {
    CurveOptions options{.stress = a.stress};
    if (a.stress) scene::need_positive("--stress", *a.stress);
    if (!a.kind.empty()) options.test = a.kind == "creep" ? fit::Test::creep : fit::Test::relaxation;
    if (a.residual == "absolute") options.residual = Residual::absolute;
    const Curve curve = read_curve(a.data, options);
    const output::Path out = a.out;
    if (!a.out.empty()) output::need_inputs_kept(out, 0, {"fit.csv", "fit.png"}, {a.data});
    const Fit fit = (curve.test == fit::Test::creep ? fit_creep : fit_relaxation)(curve.times, curve.values, a.elements,
                                                                                  options.residual);
    print_fit(a, curve, fit);
    if (a.out.empty()) return 0;
    const output::Folder folder(out);
    output::write_file(out / "fit.csv", fit_csv(curve, fit));
    fmt::print("# {}\n", (out / "fit.csv").string());
    std::fflush(stdout); // before a message of the script
    if (output::draw(fit_figure_script, out)) fmt::print("# {}\n", (out / "fit.png").string());
    else fmt::print("# no picture: /usr/bin/python3 has no matplotlib (on Debian: python3-matplotlib)\n");
    return 0;
}

} // namespace dermis::cli
