// SPDX-License-Identifier: MIT
// Elements in series. The suite `planner` draws chains against closed forms, which `closed_form` holds to numbers in 50
// digits, and the suites `ways` and `backends` compare their bits.
#include "tests/support.hpp"

#include <filesystem>
#include <fstream>

using namespace test;

namespace {

Scene read(const std::string& text) {
    const std::string path = temporary("chain.toml").string();
    std::ofstream(path) << text;
    const auto remove = [](const std::string* file) { std::filesystem::remove(*file); };
    const std::unique_ptr<const std::string, decltype(remove)> removed(&path, remove);
    return Scene::from_file(path);
}

} // namespace

TEST_CASE("a chain of one element is that element; two equal ones are one of half the modulus and viscosity") {
    Scene one = small_scene(20, 15), chain = one, two = one;
    one.material.modulus = 1.54, one.material.viscosity = 0.7;
    chain.material.elements = {{1.54, 0.7}};
    two.material.elements = {{3.08, 1.4}, {3.08, 1.4}};
    const Result a = run(one, Device::cpu()), b = run(chain, Device::cpu()), c = run(two, Device::cpu());
    for (size_t t = 0; t < a.traces.size(); ++t) {
        CHECK(b.traces[t].mean == a.traces[t].mean);
        CHECK(b.traces[t].max == a.traces[t].max);
        CHECK(c.traces[t].mean == a.traces[t].mean); // halves are exact
    }
}

TEST_CASE("a scene file's relaxation is the chain that relaxes so") {
    const std::string mean = "[receptors]\nfa2 = \"step-mean\"\n",
                      relaxation =
                          "[material]\nrelaxation = { moduli = [2.5e5, 2.5e5, 2.5e5], times = [4e-3, 7e-2, 1.4], "
                          "equilibrium = 2.5e5 }\n";
    const std::vector<KelvinVoigt> chain = read(relaxation + mean).material.elements;
    // by partial fractions in 50 digits
    const KelvinVoigt expected[] = {
        {1e6, 0}, {3174817.74533, 16814.8578792}, {1583300.75266, 165143.474228}, {486990.215745, 1382273.21823}};
    REQUIRE(chain.size() == 4);
    for (size_t k = 0; k < 4; ++k) {
        CHECK(chain[k].modulus == relative(expected[k].modulus, 1e-11));
        CHECK(chain[k].viscosity == relative(expected[k].viscosity, 1e-11));
    }
}
