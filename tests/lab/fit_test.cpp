// SPDX-License-Identifier: MIT
// labels: command
// Chains from relaxations, and from measured curves.
#include "dermis/fit.hpp"
#include "host/core/base/text.hpp"
#include "host/lab/fit/problem.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <random>

#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

using namespace test;
namespace fs = std::filesystem;

namespace {

using fit::Test;

// A spring, three elements and a dashpot.
const std::vector<KelvinVoigt> five_elements = {{4e6, 0}, {2e6, 8e3}, {1e6, 7e4}, {5e5, 7e5}, {0, 2e7}};
// Pawluk and Howe's three times of the fingerpad's relaxation, in four equal shares.
const Relaxation fingerpad{{2.5e5, 2.5e5, 2.5e5}, {4e-3, 7e-2, 1.4}, 2.5e5};

std::vector<double> log_spaced(double from, double to, int intervals) {
    std::vector<double> t;
    for (int i = 0; i <= intervals; ++i) t.push_back(from * std::pow(to / from, double(i) / intervals));
    return t;
}

// Greatest relative difference of the numbers of two chains; infinite where one has another shape.
double chain_difference(const std::vector<KelvinVoigt>& a, const std::vector<KelvinVoigt>& b) {
    if (a.size() != b.size()) return INFINITY;
    double worst = 0;
    for (size_t k = 0; k < a.size(); ++k)
        for (auto member : {&KelvinVoigt::modulus, &KelvinVoigt::viscosity})
            if (a[k].*member != b[k].*member) worst = std::max(worst, std::abs(a[k].*member / (b[k].*member) - 1));
    return worst;
}

struct Random {
    std::mt19937_64 bits{1};
    double unit() { return double(bits() >> 11) * 0x1p-53; }
    double decades(double low, double high) { return std::pow(10, low + (high - low) * unit()); }
    // Box and Muller's normal deviate.
    double normal() { return std::sqrt(-2 * std::log(1 - unit())) * std::cos(6.283185307179586 * unit()); }
    void disturb(std::vector<double>& values, double deviation) {
        for (double& v : values) v *= 1 + deviation * normal();
    }
    // Times that are 1.25 to 30 times as long as the one before.
    Relaxation relaxation(int times, bool equilibrium) {
        Relaxation r;
        double time = decades(-4, 0);
        for (int k = 0; k < times; ++k) {
            r.moduli.push_back(decades(3, 6));
            r.times.push_back(time);
            time *= decades(0.1, 1.5);
        }
        if (equilibrium) r.equilibrium = decades(3, 6);
        return r;
    }
};

bool says(const Fit& f, const std::string& words) {
    return std::any_of(f.undetermined.begin(), f.undetermined.end(),
                       [&](const std::string& s) { return s.find(words) != std::string::npos; });
}

// Share of the numbers of a chain that lie within the intervals of its fits to data with 1 % of noise.
double share_inside(const std::vector<KelvinVoigt>& truth, Test test) {
    Random random;
    const std::vector<double> t = log_spaced(1e-3, 20, 150), exact = fit::curve_of(test, truth, t);
    double inside = 0, all = 0;
    for (int i = 0; i < 200; ++i) {
        std::vector<double> noisy = exact;
        random.disturb(noisy, 0.01);
        const Fit f =
            (test == Test::creep ? fit_creep : fit_relaxation)(t, noisy, int(truth.size()), Residual::relative);
        CHECK(f.residual == relative(0.01, 0.25));
        for (size_t k = 0; k < truth.size(); ++k)
            for (auto member : {&KelvinVoigt::modulus, &KelvinVoigt::viscosity}) {
                if (truth[k].*member == 0) continue;
                ++all;
                inside += f.elements.size() == truth.size() &&
                          std::abs(std::log(f.elements[k].*member / truth[k].*member)) <= 2 * f.errors[k].*member;
            }
    }
    return inside / all;
}

} // namespace

TEST_CASE("a chain and its relaxation agree with 50 digits of arithmetic") {
    const std::vector<KelvinVoigt> chain = {{1e6, 0},
                                            {3174817.74532560457, 16814.8578791916804},
                                            {1583300.7526575128, 165143.474228069861},
                                            {486990.215745320704, 1382273.21822502554}};
    CHECK(chain_difference(chain_of(fingerpad), chain) < 1e-15);
    const Relaxation r = relaxation_of(five_elements);
    const double moduli[] = {2809265.76353478033, 658392.18692464394, 271102.810968512332, 261239.238572063403},
                 times[] = {0.00125956990066177306, 0.0306467999824878831, 0.670100516001200712, 75.7719931141156496};
    REQUIRE(r.times.size() == 4);
    CHECK(r.equilibrium == 0);
    for (size_t k = 0; k < 4; ++k) {
        CHECK(r.moduli[k] == relative(moduli[k], 1e-15));
        CHECK(r.times[k] == relative(times[k], 1e-15));
    }
    const std::vector<double> t = {0.001, 0.01, 0.1, 1, 10},
                              strain = {3.762618274578382e-7, 8.5681441607596831e-7, 1.6532234041432347e-6,
                                        2.8209160560111428e-6, 4.2484190193537601e-6};
    CHECK(difference(fit::curve_of(Test::creep, five_elements, t), strain) < 1e-15);
}

TEST_CASE("chains and relaxations go there and back within 1e-12") {
    Random random;
    double worst_relaxation = 0, worst_chain = 0;
    for (int i = 0; i < 4000; ++i) {
        const int times = i % 8;
        const Relaxation r = random.relaxation(times, times == 0 || i % 16 < 8);
        const std::vector<KelvinVoigt> chain = chain_of(r);
        CHECK(chain.size() == size_t(times) + 1);
        const Relaxation back = relaxation_of(chain);
        REQUIRE(back.times.size() == r.times.size());
        for (size_t k = 0; k < r.times.size(); ++k)
            worst_relaxation = std::max({worst_relaxation, std::abs(back.times[k] / r.times[k] - 1),
                                         std::abs(back.moduli[k] / r.moduli[k] - 1)});
        CHECK(back.equilibrium == relative(r.equilibrium, 1e-12));
        worst_chain = std::max(worst_chain, chain_difference(chain_of(back), chain));
    }
    CHECK(worst_relaxation < 1e-12);
    CHECK(worst_chain < 1e-12);
}

TEST_CASE("modulus times compliance is 1 at every rate: s*E(s) * s*J(s) = 1 of the Laplace transforms") {
    Random random;
    double worst = 0;
    for (int i = 0; i < 800; ++i) {
        const Relaxation r = random.relaxation(i % 8, i % 8 == 0 || i % 16 < 8);
        const std::vector<KelvinVoigt> chain = chain_of(r);
        for (double s : {1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6}) {
            double modulus = r.equilibrium, compliance = 0;
            for (size_t k = 0; k < r.times.size(); ++k) modulus += r.moduli[k] * s * r.times[k] / (1 + s * r.times[k]);
            for (const KelvinVoigt& e : chain) compliance += 1 / (e.modulus + e.viscosity * s);
            worst = std::max(worst, std::abs(modulus * compliance - 1));
        }
    }
    CHECK(worst < 1e-13);
}

TEST_CASE("equal times, springs and dashpots add up; a step of strain gives the sum of the moduli") {
    const Relaxation split{{1e5, 1.5e5, 2.5e5, 2.5e5}, {4e-3, 4e-3, 1.4, 7e-2}, 2.5e5};
    CHECK(chain_difference(chain_of(split), chain_of(fingerpad)) < 1e-15);
    const std::vector<KelvinVoigt> parts = {{1e6, 7e4},  {8e6, 0},   {0, 4e7}, {8e6, 0},
                                            {4e6, 16e3}, {5e5, 7e5}, {0, 4e7}, {4e6, 16e3}};
    const Relaxation a = relaxation_of(parts), b = relaxation_of(five_elements);
    CHECK(difference(a.times, b.times) < 1e-14);
    CHECK(difference(a.moduli, b.moduli) < 1e-14);
    CHECK(a.moduli[0] + a.moduli[1] + a.moduli[2] + a.moduli[3] == relative(4e6, 1e-14));
    CHECK(relaxation_of({{3, 0}}).equilibrium == 3);
    CHECK(chain_difference(chain_of({{}, {}, 3}), {{3, 0}}) == 0);
    CHECK(chain_difference(chain_of({{2}, {5}, 0}), {{2, 0}, {0, 10}}) < 1e-15);
}

TEST_CASE("a fit to exact data finds the chain within 1e-6, and nothing undetermined") {
    const std::vector<double> t = log_spaced(1e-3, 10, 80);
    const Fit creep = fit_creep(t, fit::curve_of(Test::creep, five_elements, t), 5);
    CHECK(chain_difference(creep.elements, five_elements) < 1e-6);
    CHECK(creep.residual < 1e-12);
    CHECK(creep.undetermined.empty());
    CHECK(difference(creep.model, fit::curve_of(Test::creep, five_elements, t)) < 1e-12);
    const std::vector<KelvinVoigt> chain = chain_of(fingerpad);
    const Fit relaxation = fit_relaxation(t, fit::curve_of(Test::relaxation, chain, t), 4);
    CHECK(chain_difference(relaxation.elements, chain) < 1e-6);
    CHECK(relaxation.residual < 1e-12);
    CHECK(relaxation.undetermined.empty());
}

TEST_CASE("each shape of a chain is told from the others: with and without spring and dashpot") {
    const std::vector<double> t = log_spaced(1e-3, 10, 80);
    const std::vector<KelvinVoigt> chains[] = {{{4e6, 0}},
                                               {{0, 2e7}},
                                               {{1e6, 7e4}},
                                               {{4e6, 0}, {0, 2e6}},
                                               {{4e6, 0}, {1e6, 7e4}},
                                               {{1e6, 7e4}, {0, 2e6}},
                                               {{2e6, 8e3}, {5e5, 7e5}},
                                               {{2e6, 8e3}, {1e6, 7e4}, {5e5, 7e5}}};
    for (const std::vector<KelvinVoigt>& chain : chains) {
        CAPTURE(chain.size());
        const Fit f = fit_creep(t, fit::curve_of(Test::creep, chain, t), int(chain.size()));
        CHECK(chain_difference(f.elements, chain) < 1e-6);
        CHECK(f.undetermined.empty());
    }
    for (const std::vector<KelvinVoigt>& chain :
         {std::vector<KelvinVoigt>{{4e6, 0}}, {{4e6, 0}, {0, 2e7}}, {{4e6, 0}, {1e6, 7e4}}, five_elements}) {
        CAPTURE(chain.size());
        const Fit f = fit_relaxation(t, fit::curve_of(Test::relaxation, chain, t), int(chain.size()));
        CHECK(chain_difference(f.elements, chain) < 1e-6);
        CHECK(f.undetermined.empty());
    }
}

TEST_CASE("under 1 % of noise the chain is within the stated intervals in some 95 of 100 fits") {
    for (double share : {share_inside(chain_of(fingerpad), Test::relaxation),
                         share_inside({{4e6, 0}, {2e6, 8e3}, {5e5, 7e5}}, Test::creep)}) {
        CHECK(share > 0.92);
        CHECK(share < 0.985);
    }
}

TEST_CASE("a fit with too many elements says so") {
    const std::vector<double> t = log_spaced(1e-3, 10, 80);
    const std::vector<double> exact = fit::curve_of(Test::relaxation, chain_of(fingerpad), t);
    const Fit reduced = fit_relaxation(t, exact, 6);
    CHECK(chain_difference(reduced.elements, chain_of(fingerpad)) < 1e-6);
    CHECK(says(reduced, "the data take 4 of 6 elements"));

    Random random;
    std::vector<double> noisy = exact;
    random.disturb(noisy, 0.01);
    const Fit enough = fit_relaxation(t, noisy, 4);
    CHECK(enough.undetermined.empty());
    for (int n : {5, 6, 7, 8}) {
        CAPTURE(n);
        const Fit f = fit_relaxation(t, noisy, n);
        CHECK((says(f, "a chain of 4 describes the data as well") ||
               (f.elements.size() == 4 && says(f, "the data take 4"))));
        CHECK(f.residual <= enough.residual);
        if (f.elements.size() > 4) CHECK(says(f, "the data hardly fix element"));
    }
    // Two times that differ by a tenth are one to such data.
    const std::vector<KelvinVoigt> near = {{4e6, 0}, {1e6, 7e4}, {1e6, 7.7e4}};
    std::vector<double> creep = fit::curve_of(Test::creep, near, t);
    random.disturb(creep, 0.01);
    const Fit f = fit_creep(t, creep, 3);
    CHECK((says(f, "the data take 2 of 3 elements") || says(f, "a chain of 2 describes the data as well")));
}

TEST_CASE("of a curve that ends early a slow element is a dashpot, or left open") {
    const std::vector<double> t = log_spaced(1e-3, 0.3, 80);
    Random random;
    std::vector<double> noisy = fit::curve_of(Test::creep, {{4e6, 0}, {2e6, 8e3}, {5e5, 7e5}}, t);
    random.disturb(noisy, 0.02);
    const Fit flows = fit_creep(t, noisy, 3);
    REQUIRE(flows.elements.size() == 3);
    CHECK(flows.elements[2].modulus == 0);
    CHECK(flows.undetermined.empty());
    CHECK(says(fit_creep(t, noisy, 4), "the data hardly fix element 3"));
}

TEST_CASE("an absolute residual takes data that begin at 0, in any order and unit") {
    std::vector<double> t = log_spaced(1e-3, 10, 80);
    t.insert(t.begin(), 0);
    const std::vector<KelvinVoigt> chain = {{2e6, 8e3}, {5e5, 7e5}};
    std::vector<double> creep = fit::curve_of(Test::creep, chain, t);
    CHECK(refusal(Error::Code::bad_input, [&] { fit_creep(t, creep, 2); }) ==
          "compliances[0] = 0; allowed: a finite number > 0; any finite number with an absolute residual");
    std::reverse(t.begin(), t.end());
    std::reverse(creep.begin(), creep.end());
    const Fit f = fit_creep(t, creep, 2, Residual::absolute);
    CHECK(chain_difference(f.elements, chain) < 1e-6);
    for (double& x : creep) x *= 1e9;
    std::vector<KelvinVoigt> softer = chain;
    for (KelvinVoigt& e : softer) e = {e.modulus / 1e9, e.viscosity / 1e9};
    CHECK(chain_difference(fit_creep(t, creep, 2, Residual::absolute).elements, softer) < 1e-6);
}

TEST_CASE("dermis fit finds the published constants in the examples, and prints a material to paste") {
    const Folder folder;
    const struct {
        const char* file;
        Relaxation published;
    } examples[] = {{"fingerpad_relaxation.csv", fingerpad}, {"mouse_skin_relaxation.csv", {{0.72}, {0.19}, 0.28}}};
    for (const auto& [file, published] : examples) {
        CAPTURE(file);
        const std::vector<KelvinVoigt> chain = chain_of(published);
        const fs::path out = folder / file;
        const Outcome o = command(folder, "fit " + data("../../host/examples/") + file + " --elements " +
                                              std::to_string(chain.size()) + " --out '" + out.string() + "'");
        CHECK(o.status == 0);
        CHECK(o.err.empty());
        CHECK(o.out.find("warning") == std::string::npos);
        const toml::table table = toml::parse(o.out);
        const toml::array* elements = table["material"]["elements"].as_array();
        REQUIRE(elements);
        std::vector<KelvinVoigt> printed;
        for (const toml::node& e : *elements)
            printed.push_back({e.as_table()->at("modulus").value<double>().value(),
                               e.as_table()->at("viscosity").value<double>().value()});
        CHECK(chain_difference(printed, chain) < 1e-6);
        const Columns written = read_csv((out / "fit.csv").string());
        CHECK(written.at("time").size() > 50);
        CHECK(difference(written.at("model"), written.at("modulus")) < 1e-8);
        const bool drawn = fs::exists(out / "fit.png");
        CHECK(o.out.find(drawn ? "fit.png" : "no picture: /usr/bin/python3 says") != std::string::npos);
    }
}

TEST_CASE("a scene takes the material that dermis fit prints: strain under a step of 1 Pa is its compliance") {
    const Folder folder;
    const Outcome printed =
        command(folder, "fit " + data("../../host/examples/fingerpad_relaxation.csv") + " --elements 4");
    const std::string scene = folder.write(
        "scene.toml", printed.out + "[grid]\nwidth = 9\nheight = 9\n[load]\nkind = \"circular\"\n"
                                    "[time]\nduration = 1\n[output]\ntraces = [\"strain\"]\nprobes = [[4, 4]]\n");
    const Outcome run = command(folder, "run " + scene + " --out " + (folder / "out").string());
    CHECK_MESSAGE(run.status == 0, run.err);
    const Columns traces = read_csv((folder / "out" / "traces.csv").string());
    std::vector<double> time = traces.at("time"), strain = traces.at("strain_probe0");
    time.erase(time.begin()); // before the step
    strain.erase(strain.begin());
    CHECK(difference(strain, fit::curve_of(Test::creep, chain_of(fingerpad), time)) < 1e-6);
}

TEST_CASE("dermis fit reads strain under a stress, and warns of elements that the data leave open") {
    const Folder folder;
    const std::vector<double> t = log_spaced(1e-3, 10, 60);
    std::string csv = "\xef\xbb\xbf# of a creep test\r\ntime, strain\r\n";
    const std::vector<double> creep = fit::curve_of(Test::creep, {{4e6, 0}, {5e5, 7e5}}, t);
    for (size_t i = 0; i < t.size(); ++i)
        csv += std::to_string(t[i] * 1e3) + "e-3, " + std::to_string(creep[i] * 2e3 * 1e6) + "e-6\r\n";
    const std::string file = folder.write("creep.csv", csv);
    const Outcome o = command(folder, "fit " + file + " --elements 2 --stress 2000");
    CHECK(o.status == 0);
    CHECK_MESSAGE(o.out.find("61 points of creep; elements: 2; residual ") != std::string::npos, o.out);
    CHECK_MESSAGE(o.out.find("# 1: spring") != std::string::npos, o.out);
    CHECK_MESSAGE(o.out.find("# 2: retardation time 1.4 s") != std::string::npos, o.out);
    CHECK(o.out.find("# relaxation E(t) = ") != std::string::npos);
    const Outcome more = command(folder, "fit " + file + " --elements 5 --stress 2000 --kind creep");
    CHECK(more.out.find("# warning: ") != std::string::npos);
    const Outcome dashpot = command(folder, "fit " + folder.write("flow.csv", "time,compliance\n0,0\n1,2\n2,4\n") +
                                                " --elements 1 --residual absolute");
    CHECK_MESSAGE(dashpot.out.find("{ modulus = 0, viscosity = 0.5 }") != std::string::npos, dashpot.out);
    CHECK(dashpot.out.find("E(t)") == std::string::npos);
}

TEST_CASE("dermis fit refuses bad data with line, value and what is allowed") {
    const Folder folder;
    const fs::path out = folder / "out";
    const struct {
        const char *csv, *options, *says;
    } calls[] = {
        {"time,modulus\n1,2\n2,abc\n", "", "bad.csv:3: modulus = \"abc\"; allowed: a finite number > 0"},
        {"time,modulus\n1,2\n2,0\n", "",
         "bad.csv:3: modulus = 0; allowed: a finite number > 0; any finite number with"},
        {"time,modulus\n1,2\n2,inf\n", "--residual absolute",
         "bad.csv:3: modulus = inf; allowed: a finite number; the line: \"2,inf\"\n"},
        {"time,modulus\n1,2\n-2,1\n", "", "bad.csv:3: time = -2; allowed: a finite number >= 0"},
        {"time,modulus\n1,2,3\n", "",
         "bad.csv:2: line = \"1,2,3\"; allowed: 2 columns with commas between them, and decimals with a point\n"},
        {"1,2\n2,1\n", "", "bad.csv:1: first column = 1; allowed: a line of names that begins with time"},
        {"time,force\n1,2\n", "", "bad.csv:1: second column = \"force\"; allowed: modulus (relaxation), compliance or"},
        {"time,modulus\n1,2\n", "--kind creep",
         "second column = \"modulus\"; allowed: compliance or strain with --kind"},
        {"time,strain\n1,2\n", "", "second column = \"strain\"; allowed: strain with --stress, the stress in Pa"},
        {"time,modulus\n1,2\n", "--stress 2", "second column = \"modulus\"; allowed: strain with --stress"},
        {"time,strain\n1,2\n", "--stress -1", "--stress = -1; allowed: a finite number > 0"},
        {"time,modulus\n", "", "bad.csv: holds no numbers; allowed: a line of names"},
        {"time,modulus\n1,2\n2,1\n", "", "times = 2 numbers; allowed: at least 5 for 2 elements"},
        {"time,modulus\n(s),(Pa)\n1,2\n", "",
         "bad.csv:2: time = \"(s)\"; allowed: a finite number >= 0; names take one line, and units none; the line: "},
        {"time;modulus\n1,5;2,0\n", "", "bad.csv:1: line = \"time;modulus\"; allowed: 2 columns with commas between"},
        {"time,modulus\n1,2\n", "--elements 9", "--elements"},
        {"time,modulus\n1,2\n", "--kind flow", "--kind"},
    };
    for (const auto& call : calls) {
        CAPTURE(call.says);
        const std::string file = folder.write("bad.csv", call.csv), options = call.options;
        const std::string elements = options.find("--elements") == 0 ? "" : " --elements 2";
        const Outcome o = command(folder, "fit " + file + elements + " --out " + out.string() + " " + options);
        CHECK(o.status == 2);
        CHECK_MESSAGE(o.err.find(call.says) != std::string::npos, o.err);
        CHECK_FALSE(fs::exists(out));
    }
    CHECK(command(folder, "fit " + (folder / "none.csv").string() + " --elements 2")
              .err.find("none.csv: cannot be read") != std::string::npos);
    const std::string own = folder.write("fit.csv", "time,modulus\n1,2\n2,1\n3,1\n4,1\n5,1\n");
    const Outcome kept = command(folder, "fit " + own + " --elements 2 --out " + (folder / "").string());
    CHECK(kept.status == 2);
    CHECK_MESSAGE(kept.err.find("fit.csv") != std::string::npos, kept.err);
}

TEST_CASE("dermis fit takes several curves, of histories too, and says why it takes so many elements") {
    const Folder folder;
    std::string first = "time,strain,stress\n", second = first, creep = "time,compliance\n1,2\n2,3\n3,4\n";
    for (int i = 1; i <= 60; ++i) { // a ramp, and a ramp of twice the rate, of E(t) = 1 + 2*e^(-t)
        const double t = 0.1 * i, stress = t + 2 * (1 - std::exp(-t));
        first += dermis::shortest(t) + "," + dermis::shortest(t) + "," + dermis::shortest(stress) + "\n";
        second += dermis::shortest(t) + "," + dermis::shortest(2 * t) + "," + dermis::shortest(2 * stress) + "\n";
    }
    const std::string a = folder.write("a.csv", "time,strain,stress\n0,0,0\n" + first.substr(19)),
                      b = folder.write("b.csv", "time,strain,stress\n0,0,0\n" + second.substr(19)),
                      c = folder.write("c.csv", creep);
    const Outcome o = command(folder, "fit " + a + " " + b + " --out " + (folder / "out").string());
    CHECK_MESSAGE(o.status == 0, o.err);
    for (const char* says :
         {"122 points of a history; elements: 2; residual", "# 2 elements, because 1 leaves a residual of ",
          "# relaxation E(t) = 1 + 2*e^(-t/1) Pa", "relative to the greatest value"})
        CHECK_MESSAGE(o.out.find(says) != std::string::npos, o.out);
    const std::string table = slurp(folder / "out/fit.csv");
    CHECK(table.find("curve,time,strain,stress,model\n1,0,0,0,0\n1,0.1,") == 0);
    CHECK(table.find("\n2,6,12,") != std::string::npos);
    CHECK(fs::exists(folder / "out/fit.png"));
    const Outcome mixed = command(folder, "fit " + a + " " + c);
    CHECK(mixed.status == 2);
    CHECK_MESSAGE(mixed.err.find("c.csv: is creep; allowed: curves of one kind, and ") != std::string::npos, mixed.err);
    CHECK(command(folder, "fit " + a + " --kind creep").err.find("two columns with --stress or --kind") !=
          std::string::npos);
    folder.write("d.csv", "time,strain,stress\n0,0,0\n1,2\n");
    CHECK(
        command(folder, "fit " + (folder / "d.csv").string()).err.find("d.csv:3: line = \"1,2\"; allowed: 3 columns") !=
        std::string::npos);
}

TEST_CASE("a picture of dermis fit that cannot be written is an error, and its table stays") {
    const Folder folder;
    fs::create_directories(folder / "out/fit.png");
    const Outcome o =
        command(folder, "fit " DERMIS_TEST_DATA "/../../host/examples/fingerpad_relaxation.csv --elements 2 --out " +
                            (folder / "out").string());
    CHECK(fs::exists(folder / "out/fit.csv"));
    if (o.out.find("no picture: /usr/bin/python3 says") != std::string::npos) return;
    CHECK(o.status == 1);
    CHECK_MESSAGE(o.err.find("dermis: drawing the figures failed; its message stands above\n") != std::string::npos,
                  o.err);
}
