// SPDX-License-Identifier: MIT
// The planner drops and merges elements in series where no output tells the difference, and nowhere else.
#include "tests/oracle/survey.hpp"
#include "tests/support.hpp"

using namespace test;

namespace {

// Sites alone on a chain, with gains that no product of a map and a function of time takes.
Scene sites_on(const std::vector<KelvinVoigt>& elements, double tolerance) {
    Scene s = small_scene(9, 8);
    s.material.elements = elements;
    s.receptors.fa2 = Fa2::step_mean;
    s.receptors.fa2_gains = {1, 0};
    s.time = {0.01, 1};
    s.load.envelope.kind = Envelope::Kind::ramp;
    s.load.envelope.rise = 0.5;
    s.sites = {{Quantity::sa1, {4, 4}}, {Quantity::sa2, {3, 4}}, {Quantity::fa1, {5, 4}}};
    s.output = {{}, {}, {}};
    s.tolerance = tolerance;
    return s;
}

struct Count {
    int springs = 0, elements = 0, dashpots = 0;
    bool operator==(const Count&) const = default;
};

Count count(const std::vector<KelvinVoigt>& chain) {
    Count c;
    for (const KelvinVoigt& e : chain) ++(e.viscosity == 0 ? c.springs : e.modulus == 0 ? c.dashpots : c.elements);
    return c;
}

} // namespace

TEST_CASE("a reduced chain keeps every tolerance and every prediction in 500 random scenes of sites") {
    int shortened = 0, accepted = 0, before = 0, after = 0, framed = 0;
    for (unsigned seed = 1; seed <= 500; ++seed) {
        oracle::Family family(seed);
        const oracle::Case c = family.next_chain_of_sites();
        const oracle::Verdict v = oracle::judge(c);
        CAPTURE(seed);
        CAPTURE(oracle::text(v, c.scene));
        CHECK(v.failure == "");
        accepted += v.accepted;
        if (!v.accepted) continue;
        CHECK(v.kept());
        CHECK(v.below_prediction());
        if (v.reduced == 0) continue;
        ++shortened;
        framed += !c.frames.empty();
        before += int(c.scene.material.elements.size()) + c.scene.material.spring.has_value() +
                  c.scene.material.dashpot.has_value();
        after += int(v.reduced);
    }
    MESSAGE(shortened, " of ", accepted, " accepted scenes with ", after, " of ", before, " elements; under frames ",
            framed);
}
