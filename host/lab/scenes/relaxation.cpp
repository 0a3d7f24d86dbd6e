// SPDX-License-Identifier: MIT
// Relaxation and retardation spectra, one from the other. The zeros of a compliance lie between its poles, one in each
// gap, and the zeros of a modulus between the modulus's: both are the roots of one secular equation.
#include "dermis/scene.hpp"
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"

#include <algorithm>
#include <cmath>

namespace dermis {
namespace relaxing {
namespace {

using Real = long double;
using scene::need;

constexpr size_t most_elements = 8;

struct Pole {
    Real place, weight; // weight > 0
};
// slope: sum of weight/(place - pole)^2 over all poles.
struct Root {
    Real place, slope;
};

// Returns the root of sum weight/(x - pole) = level that lies between `least` and `most` away from a pole, on the side
// `sign`. Measured from the nearest pole a root keeps its digits however close to it.
Root root_beside(const std::vector<Pole>& poles, size_t nearest, int sign, Real least, Real most, Real level) {
    const Real origin = poles[nearest].place;
    const auto beyond = [&](Real distance) { // whether the root is further away
        Real sum = -level;
        for (const Pole& p : poles) sum += p.weight / (origin - p.place + sign * distance);
        return sum * sign > 0;
    };
    for (int i = 0; i < 200; ++i) { // the ratio of the bounds goes to its root each time
        const Real middle = std::sqrt(least) * std::sqrt(most);
        if (!(middle > least && middle < most)) break;
        (beyond(middle) ? least : most) = middle;
    }
    const Real distance = std::sqrt(least) * std::sqrt(most);
    Root root{.place = origin + sign * distance, .slope = 0};
    for (const Pole& p : poles) {
        const Real away = origin - p.place + sign * distance;
        root.slope += p.weight / away / away;
    }
    return root;
}

// Returns the roots of sum weight/(x - pole) = level: one in each gap of the ascending poles, and if level > 0 one
// beyond the last.
std::vector<Root> secular_roots(const std::vector<Pole>& poles, Real level) {
    std::vector<Root> roots;
    for (size_t i = 0; i + 1 < poles.size(); ++i) {
        const Real half = (poles[i + 1].place - poles[i].place) / 2;
        Real at_middle = -level;
        for (const Pole& p : poles) at_middle += p.weight / (poles[i].place - p.place + half);
        const bool left = at_middle < 0;
        const size_t nearest = left ? i : i + 1;
        Real others = level; // a bound of all terms but the nearest pole's, from there to the middle
        for (size_t k = 0; k < poles.size(); ++k) {
            if (k == nearest) continue;
            const bool ahead = (k > nearest) == left;
            others += poles[k].weight / (std::abs(poles[k].place - poles[nearest].place) - (ahead ? half : 0));
        }
        const Real least = std::min(poles[nearest].weight / others, half);
        roots.push_back(root_beside(poles, nearest, left ? 1 : -1, least, half, level));
    }
    if (level > 0 && !poles.empty()) {
        Real weights = 0;
        for (const Pole& p : poles) weights += p.weight;
        const size_t last = poles.size() - 1;
        roots.push_back(root_beside(poles, last, 1, poles[last].weight / level, weights / level, level));
    }
    return roots;
}

// Sorts poles by place, and adds up the weights of poles at one place.
std::vector<Pole> merged(std::vector<Pole> poles) {
    std::ranges::sort(poles, [](const Pole& a, const Pole& b) { return a.place < b.place; });
    std::vector<Pole> kept;
    for (const Pole& p : poles)
        if (!kept.empty() && double(kept.back().place) == double(p.place)) kept.back().weight += p.weight;
        else kept.push_back(p);
    return kept;
}

std::string indexed(const char* list, size_t k, const char* member = "") {
    return std::string(list) + "[" + std::to_string(k) + "]" + member;
}

void check(const Relaxation& r) {
    const std::string count = std::to_string(r.times.size());
    if (r.moduli.size() != r.times.size())
        scene::refuse("relaxation.moduli", std::to_string(r.moduli.size()) + " numbers", count + ", one for each time");
    if (r.times.size() >= most_elements)
        scene::refuse("relaxation.times", count + " numbers", "at most 7: a chain has at most 8 elements");
    for (size_t k = 0; k < r.times.size(); ++k) {
        scene::need_positive(indexed("relaxation.moduli", k).c_str(), r.moduli[k]);
        scene::need_positive(indexed("relaxation.times", k).c_str(), r.times[k]);
    }
    scene::need_not_negative("relaxation.equilibrium", r.equilibrium);
    need(r.equilibrium > 0 || !r.times.empty(), "relaxation.equilibrium", r.equilibrium,
         "> 0 where there are no times");
}

void check(const std::vector<KelvinVoigt>& chain) {
    if (chain.empty() || chain.size() > most_elements)
        scene::refuse("elements", std::to_string(chain.size()) + " elements", "1 to 8");
    for (size_t k = 0; k < chain.size(); ++k) {
        scene::need_not_negative(indexed("elements", k, ".modulus").c_str(), chain[k].modulus);
        scene::need_not_negative(indexed("elements", k, ".viscosity").c_str(), chain[k].viscosity);
        need(chain[k].modulus > 0 || chain[k].viscosity > 0, indexed("elements", k, ".modulus").c_str(), 0,
             "> 0 where the viscosity is 0");
    }
}

// Refuses a result that a double does not hold.
double representable(const char* result, Real x) {
    need(finite(double(x)) && double(x) > 0, result, double(x),
         "a number in the range of double; other units may help");
    return double(x);
}

} // namespace
} // namespace relaxing

std::vector<KelvinVoigt> chain_of(const Relaxation& r) {
    return scene::guarded("a chain of elements", [&] {
        const DefaultFloats guard;
        relaxing::check(r);
        std::vector<relaxing::Pole> poles;
        relaxing::Real instantaneous = r.equilibrium, viscosity = 0;
        for (size_t k = 0; k < r.times.size(); ++k) {
            poles.push_back({.place = r.times[k], .weight = relaxing::Real(r.moduli[k]) * r.times[k]});
            instantaneous += r.moduli[k];
            viscosity += poles.back().weight;
        }
        std::vector<KelvinVoigt> chain = {{relaxing::representable("modulus of the spring", instantaneous), 0}};
        for (const relaxing::Root& root : relaxing::secular_roots(relaxing::merged(std::move(poles)), r.equilibrium)) {
            const relaxing::Real modulus = root.place * root.slope;
            chain.push_back({relaxing::representable("modulus of an element", modulus),
                             relaxing::representable("viscosity of an element", root.place * modulus)});
        }
        if (r.equilibrium == 0) chain.push_back({0, relaxing::representable("viscosity of the dashpot", viscosity)});
        return chain;
    });
}

Relaxation relaxation_of(const std::vector<KelvinVoigt>& chain) {
    return scene::guarded("a relaxation spectrum", [&] {
        const DefaultFloats guard;
        relaxing::check(chain);
        relaxing::Real spring = 0, dashpot = 0, compliance = 0; // compliance, fluidity, compliance after any time
        std::vector<relaxing::Pole> poles;
        for (const KelvinVoigt& e : chain) {
            if (e.modulus == 0) dashpot += 1 / relaxing::Real(e.viscosity);
            else if (e.viscosity == 0) spring += 1 / relaxing::Real(e.modulus);
            else
                poles.push_back(
                    {.place = relaxing::Real(e.viscosity) / e.modulus, .weight = 1 / relaxing::Real(e.modulus)});
            if (e.modulus > 0) compliance += 1 / relaxing::Real(e.modulus);
        }
        if (spring == 0)
            scene::refuse("elements", "a chain without a spring",
                          "at least one element of viscosity 0: without it a step of strain takes an infinite stress");
        poles.push_back({.place = 0, .weight = spring});
        Relaxation r;
        for (const relaxing::Root& root : relaxing::secular_roots(relaxing::merged(std::move(poles)), dashpot)) {
            r.times.push_back(relaxing::representable("relaxation time", root.place));
            r.moduli.push_back(
                relaxing::representable("relaxation modulus", 1 / (root.place * root.place * root.slope)));
        }
        if (dashpot == 0) r.equilibrium = relaxing::representable("equilibrium modulus", 1 / compliance);
        return r;
    });
}

} // namespace dermis
