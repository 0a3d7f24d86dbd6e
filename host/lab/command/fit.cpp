// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

#include "fit_script.h"
#include "plot_script.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace dermis::cli {
namespace {

// Returns what fit.py reads.
std::string request(const FitArguments& a, const scene::Curves& curves) {
    output::Json list = output::Json::array();
    for (const scene::Curve& curve : curves.list) list.push_back({curve.times, curve.strains, curve.values});
    return output::text_of({{"title", fmt::format("{}", fmt::join(a.data, " "))},
                            {"kind", curves.kind},
                            {"residual", curves.residual},
                            {"elements", a.elements},
                            {"out", a.out.empty() ? "" : std::filesystem::absolute(a.out).string()},
                            {"curves", list}});
}

} // namespace

int fit_data(const FitArguments& a) {
    const scene::Curves curves = scene::read_curves(a.data, a.options);
    const output::Path out = a.out;
    std::optional<output::Folder> folder;
    if (!a.out.empty()) {
        output::need_inputs_kept(a.data, {out / "fit.csv", out / "fit.png", out / "material.toml"});
        folder.emplace(out);
    }
    const output::Python python = output::python_with("scipy");
    if (python.path.empty())
        throw Error(Error::Code::io, "",
                    "fit needs SciPy, and " + python.why_not +
                        "; pip install dermis[fit], or on Debian apt-get install python3-scipy, installs it");
    if (const int status = output::run(python, fit_script, {}, request(a, curves)); status || a.out.empty())
        return status;
    const std::string why_not = output::draw(plot_script, out, {"fit"});
    if (why_not.empty()) fmt::print("# open first: {}\n", (out / "fit.png").string());
    else fmt::print("# no picture: {}\n", why_not);
    fmt::print("# next: put the table [material] of {} into a scene\n", (out / "material.toml").string());
    return 0;
}

} // namespace dermis::cli
