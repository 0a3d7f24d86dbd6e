// SPDX-License-Identifier: MIT
#include "host/lab/command/fit.hpp"
#include "host/core/base/refusal.hpp"
#include "host/lab/output/drawing.hpp"
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/folder.hpp"
#include "host/lab/scenes/curve_file.hpp"

#include "plot_script.h"

#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace dermis::cli {
namespace {

using scene::Curve;
using Kind = Curve::Kind;

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

const char* called(Kind kind) {
    return kind == Kind::creep ? "creep" : kind == Kind::relaxation ? "relaxation" : "a history";
}

void print_fit(const FitArguments& a, const std::vector<Curve>& curves, Residual residual, const Fit& fit) {
    const Kind kind = curves[0].kind;
    fmt::print("# {}: {} points of {}; elements: {}; residual {:.3g} (root mean square, {})\n", fmt::join(a.data, " "),
               fit.model.size(), called(kind), fit.elements.size(), fit.residual,
               residual == Residual::relative ? "relative to each value" : "relative to the greatest value");
    if (!fit.choice.empty()) fmt::print("# {}\n", fit.choice);
    const bool relaxes = kind != Kind::creep || fit.elements.front().viscosity == 0; // it has a spring
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

// With several curves the first column is the number of the curve.
std::string fit_csv(const std::vector<Curve>& curves, const Fit& fit) {
    const Kind kind = curves[0].kind;
    const bool several = curves.size() > 1, history = kind == Kind::history;
    std::string text = several ? "curve,time," : "time,";
    text += history ? "strain,stress,model\n" : kind == Kind::creep ? "compliance,model\n" : "modulus,model\n";
    size_t point = 0;
    for (size_t k = 0; k < curves.size(); ++k)
        for (size_t i = 0; i < curves[k].times.size(); ++i, ++point) {
            if (several) text += std::to_string(k + 1) + ",";
            append_shortest(text, curves[k].times[i]);
            if (history) append_shortest(text += ',', curves[k].strains[i]);
            for (double x : {curves[k].values[i], fit.model[point]}) append_shortest(text += ',', x);
            text += '\n';
        }
    return text;
}

} // namespace

int fit_data(const FitArguments& a) {
    scene::CurveOptions options{.kind = {}, .stress = a.stress, .residual = {}};
    if (a.stress) scene::need_positive("--stress", *a.stress);
    if (!a.kind.empty()) options.kind = a.kind == "creep" ? Kind::creep : Kind::relaxation;
    if (!a.residual.empty()) options.residual = a.residual == "absolute" ? Residual::absolute : Residual::relative;
    std::vector<Curve> curves;
    for (const std::string& path : a.data) {
        curves.push_back(scene::read_curve(path, options));
        if (curves.back().kind != curves[0].kind)
            throw Error(Error::Code::bad_input, "data",
                        fmt::format("{}: is {}; allowed: curves of one kind, and {} is {}", path,
                                    called(curves.back().kind), a.data[0], called(curves[0].kind)));
    }
    const Residual residual = scene::residual_of(curves[0].kind, options);
    const output::Path out = a.out;
    if (!a.out.empty()) output::need_inputs_kept(out, 0, {"fit.csv", "fit.png"}, a.data);
    const Fit fit = scene::fit_curves(curves, a.elements, residual);
    print_fit(a, curves, residual, fit);
    if (a.out.empty()) return 0;
    const output::Folder folder(out);
    output::write_file(out / "fit.csv", fit_csv(curves, fit));
    fmt::print("# {}\n", (out / "fit.csv").string());
    std::fflush(stdout); // before a message of the script
    const std::string why_not = output::draw(plot_script, out, {"fit"});
    if (why_not.empty()) fmt::print("# {}\n", (out / "fit.png").string());
    else fmt::print("# no picture: {}\n", why_not);
    return 0;
}

} // namespace dermis::cli
