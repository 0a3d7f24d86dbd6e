// SPDX-License-Identifier: MIT
// labels: command
// Chains from relaxations, and the command that fits them to measured curves.
#include "dermis/scene.hpp"
#include "host/core/base/text.hpp"
#include "host/lab/scenes/toml.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <random>

using namespace test;
namespace fs = std::filesystem;

namespace {

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

// The strain of a chain under a step of 1 Pa.
std::vector<double> creep_of(const std::vector<KelvinVoigt>& chain, const std::vector<double>& times) {
    std::vector<double> strain(times.size());
    for (const KelvinVoigt& e : chain)
        for (size_t i = 0; i < times.size(); ++i)
            strain[i] += e.modulus == 0     ? times[i] / e.viscosity
                         : e.viscosity == 0 ? 1 / e.modulus
                                            : -std::expm1(-times[i] * e.modulus / e.viscosity) / e.modulus;
    return strain;
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

TEST_CASE("conversions refuse what is no chain and no relaxation") {
    const auto from_relaxation = [](const Relaxation& r) {
        return refusal(Error::Code::bad_input, [&] { chain_of(r); });
    };
    CHECK(from_relaxation({{1, 0}, {1, 2}, 1}) == "relaxation.moduli[1] = 0; allowed: a finite number > 0");
    CHECK(from_relaxation({{1}, {-1}, 1}) == "relaxation.times[0] = -1; allowed: a finite number > 0");
    CHECK(from_relaxation({{1}, {1}, -1}) == "relaxation.equilibrium = -1; allowed: a finite number >= 0");
    CHECK(from_relaxation({}) == "relaxation.equilibrium = 0; allowed: > 0 where there are no times");
    CHECK(from_relaxation({{1, 1}, {1}, 1}) == "relaxation.moduli = 2 numbers; allowed: 1, one for each time");
    CHECK(from_relaxation({std::vector<double>(8, 1), std::vector<double>(8, 1), 1}) ==
          "relaxation.times = 8 numbers; allowed: at most 7: a chain has at most 8 elements");
    CHECK(from_relaxation({{1e308, 1e308}, {1, 2}, 1}).find("modulus of the spring = inf; allowed: ") == 0);
    const auto from_chain = [](const std::vector<KelvinVoigt>& c) {
        return refusal(Error::Code::bad_input, [&] { relaxation_of(c); });
    };
    CHECK(from_chain({}) == "elements = 0 elements; allowed: 1 to 8");
    CHECK(from_chain(std::vector<KelvinVoigt>(9, {1, 1})) == "elements = 9 elements; allowed: 1 to 8");
    CHECK(from_chain({{1, 0}, {0, 0}}) == "elements[1].modulus = 0; allowed: > 0 where the viscosity is 0");
    CHECK(from_chain({{1, 0}, {1, NAN}}) == "elements[1].viscosity = nan; allowed: a finite number >= 0");
    CHECK(from_chain({{1, 2}, {0, 1}}) == "elements = a chain without a spring; allowed: at least one element of "
                                          "viscosity 0: without it a step of strain takes an infinite stress");
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
        const toml::parse_result parsed = toml::parse(o.out);
        REQUIRE(parsed);
        const toml::array* elements = parsed.table()["material"]["elements"].as_array();
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
        CHECK(o.out.find(drawn ? "fit.png" : "no picture: ") != std::string::npos);
        CHECK(o.out.find(slurp(out / "material.toml")) == 0);
        CHECK(o.out.find("\n# next: put the table [material] of ") != std::string::npos);
    }
}

TEST_CASE("dermis fit reads strain under a stress, and warns of elements that the data leave open") {
    const Folder folder;
    const std::vector<double> t = log_spaced(1e-3, 10, 60);
    std::string csv = "\xef\xbb\xbf# of a creep test\r\ntime, strain\r\n";
    const std::vector<double> creep = creep_of({{4e6, 0}, {5e5, 7e5}}, t);
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
    for (const char* spring : {"time,compliance\n0,3\n1,3\n2,3\n", "time,modulus\n0,3\n1,3\n2,3\n",
                               "time,strain,stress\n0,1,3\n1,2,6\n2,1,3\n"}) {
        const Outcome one = command(folder, "fit " + folder.write("spring.csv", spring));
        CHECK_MESSAGE((one.out.find("# 1: spring") != std::string::npos && one.err.empty()), one.err);
    }
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
        {"time,strain\n1,2\n", "", "second column = \"strain\"; allowed: strain with --stress, the stress in Pa"},
        {"time,modulus\n1,2\n", "--stress 2", "second column = \"modulus\"; allowed: strain with --stress"},
        {"time,strain\n1,2\n", "--stress -1", "stress = -1; allowed: a finite number > 0"},
        {"time,strain,stress\n1,1,1\n2,1,1\n1.5,1,1\n", "",
         "bad.csv:4: time = 1.5; allowed: no time before the one before it"},
        {"time,modulus\n1,2\n2,1\n", "", "bad.csv: times = 2 numbers; allowed: at least 5 for 2 elements"},
        {"time,modulus\n", "", "bad.csv: holds no numbers; allowed: a line of names"},
        {"time;modulus\n1,5;2,0\n", "", "bad.csv:1: line = \"time;modulus\"; allowed: 2 columns with commas between"},
        {"time,modulus\n1,2\n", "--elements 9", "--elements"},
        {"time,modulus\n1,2\n", "--kind flow", "kind = \"flow\"; allowed: \"creep\", \"relaxation\"\n"},
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
    CHECK_MESSAGE(mixed.err.find("c.csv: is a curve of creep; allowed: curves of one kind, and ") != std::string::npos,
                  mixed.err);
    CHECK(command(folder, "fit " + a + " --kind creep").err.find("two columns with --stress, --strain or --kind") !=
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
    if (o.out.find("no picture: ") != std::string::npos) return;
    CHECK(o.status == 1);
    CHECK_MESSAGE(o.err.find("dermis: drawing the figures failed; its message stands above\n") != std::string::npos,
                  o.err);
}

TEST_CASE("dermis fit takes the Python of its environment, else that of DERMIS_PYTHON, and names what has SciPy") {
    const Folder folder;
    const std::string fit = "fit " DERMIS_TEST_DATA "/../../host/examples/fingerpad_relaxation.csv";
    const Outcome named = command(folder, fit, "DERMIS_PYTHON=/bin/false");
    CHECK(named.status == 1);
    for (const char* says : {"fit needs SciPy, and /bin/false says", "pip install dermis[fit]", "python3-scipy"})
        CHECK_MESSAGE(named.err.find(says) != std::string::npos, named.err);
    fs::create_directory(folder / "bin");
    fs::copy_file(DERMIS_CLI, folder / "bin/dermis");
    folder.write("pyvenv.cfg", "");
    folder.write("bin/python3", "#!/bin/sh\necho its own\nexit 1\n");
    fs::permissions(folder / "bin/python3", fs::perms::owner_all);
    const std::string own = (folder / "bin/").string(), said = (folder / "said").string();
    CHECK(std::system(("DERMIS_PYTHON=/bin/false '" + own + "dermis' " + fit + " 2>'" + said + "'").c_str()) != 0);
    CHECK_MESSAGE(slurp(said).find(own + "python3 says: its own; pip install") != std::string::npos, slurp(said));
}
