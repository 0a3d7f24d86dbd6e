// SPDX-License-Identifier: MIT
// The Kelvin-Voigt element: what a cell's material is made of, and how it answers a stress. Only this file, the checks
// of a material and the coefficients of a step read the members of an element.
#pragma once

#include "dermis/description.hpp"

#include <algorithm>
#include <cmath>
#include <compare>

namespace dermis::scene {

// A spring beside a dashpot.
struct Element {
    double modulus, viscosity; // Pa, Pa s; >= 0, not both 0
    auto operator<=>(const Element&) const = default;
};

inline bool is_elastic(const Element& m) { return m.viscosity == 0; }
// dt/tau, where tau is the retardation time viscosity/modulus; infinity where the element is elastic.
inline double z_of(const Element& m, double dt) { return is_elastic(m) ? INFINITY : m.modulus * dt / m.viscosity; }
// Returns the strain that a constant stress leads to in the end; infinity without a spring.
inline double final_strain(const Element& m, double stress) { return stress / m.modulus; }
// The modulus at which elements in series come to rest; 0 with a dashpot.
template <class Elements> double modulus_at_rest(const Elements& in_series) {
    double compliance = 0;
    for (const Element& e : in_series) compliance += final_strain(e, 1);
    return 1 / compliance;
}
// Returns the rate of the strain at a stress and a strain; the element has a dashpot.
inline double strain_rate(const Element& m, double stress, double strain = 0) {
    return (stress - m.modulus * strain) / m.viscosity;
}

// Whether an element is a dashpot alone.
inline bool is_viscous(const Element& m) { return m.modulus == 0; }

// Returns the strain after T seconds of a constant stress.
inline double strain_after(const Element& m, double stress, double T) {
    if (is_viscous(m)) return strain_rate(m, stress) * T;
    return is_elastic(m) ? final_strain(m, stress) : final_strain(m, -std::expm1(-z_of(m, T)) * stress);
}

// The published study's element, which a material in a scene without units has by default.
inline constexpr Element study_element{.modulus = 1.54, .viscosity = 1};

// Returns the number to which an element's strain is inversely proportional at a given retardation time: its modulus,
// or, where the modulus is 0, its viscosity.
inline double resistance(const Element& m) { return m.modulus > 0 ? m.modulus : m.viscosity; }

constexpr size_t most_in_series = 10; // elements of a cell, spring and dashpot included

// Whether a material is elements in series.
inline bool is_chain(const Material& m) { return !m.elements.empty() || m.spring || m.dashpot; }

inline double at(const Map& map, double otherwise, size_t cell) { return map.empty() ? otherwise : map[cell]; }

inline Element element_at(const KelvinVoigt& e, size_t cell) {
    return {.modulus = at(e.modulus_map, e.modulus, cell), .viscosity = at(e.viscosity_map, e.viscosity, cell)};
}

// The elements of a chain as a material lists them.
inline std::vector<KelvinVoigt> listed(const std::vector<Element>& chain) {
    std::vector<KelvinVoigt> elements;
    for (const Element& m : chain) elements.push_back({.modulus = m.modulus, .viscosity = m.viscosity});
    return elements;
}

// Gives `to` these elements in series. The first one without a viscosity becomes the spring, the first one without a
// modulus the dashpot.
inline void take_chain(Material& to, const std::vector<KelvinVoigt>& chain) {
    to.elements.clear();
    to.spring.reset();
    to.dashpot.reset();
    for (const KelvinVoigt& e : chain) {
        if (e.viscosity == 0 && !to.spring) to.spring = e.modulus;
        else if (e.modulus == 0 && !to.dashpot) to.dashpot = e.viscosity;
        else to.elements.push_back(e);
    }
}

// The element of a cell of a material that is no chain.
inline Element element_at(const Material& m, size_t cell) {
    return {.modulus = at(m.modulus_map, m.modulus.value_or(study_element.modulus), cell),
            .viscosity = at(m.viscosity_map, m.viscosity.value_or(study_element.viscosity), cell)};
}

inline bool is_uniform(const KelvinVoigt& e) { return e.modulus_map.empty() && e.viscosity_map.empty(); }

// Whether every cell is made of the same elements.
inline bool is_uniform(const Material& m) {
    return m.modulus_map.empty() && m.viscosity_map.empty() &&
           std::all_of(m.elements.begin(), m.elements.end(), [](const KelvinVoigt& e) { return is_uniform(e); });
}

// The elements of one cell in series: first the elements that have a dashpot in some cell of the skin, then one spring
// in place of all others; its compliance is the sum of theirs.
struct Series {
    std::array<Element, most_in_series> elements;
    size_t length = 0;
    bool ends_in_spring = false; // the last element is this spring, behind others
};

inline Series series_at(const Material& m, size_t cell) {
    Series s;
    if (!is_chain(m)) {
        s.elements[s.length++] = element_at(m, cell);
        return s;
    }
    long double compliance = m.spring ? 1 / (long double)*m.spring : 0; // of all springs: their modulus is rounded once
    for (const KelvinVoigt& e : m.elements) {
        const Element of = element_at(e, cell);
        if (e.viscosity > 0 || !e.viscosity_map.empty()) s.elements[s.length++] = of;
        else compliance += 1 / (long double)of.modulus;
    }
    if (m.dashpot) s.elements[s.length++] = {.modulus = 0, .viscosity = *m.dashpot};
    s.ends_in_spring = compliance > 0 && s.length > 0;
    if (compliance > 0) s.elements[s.length++] = {.modulus = double(1 / compliance), .viscosity = 0};
    return s;
}

// The elements in series of a uniform material.
inline std::vector<Element> chain_of(const Material& m) {
    const Series s = series_at(m, 0);
    std::vector<Element> chain(s.length);
    std::copy_n(s.elements.begin(), s.length, chain.begin());
    return chain;
}

// Whether a uniform material has an element without viscosity.
inline bool has_spring(const Material& m) {
    const std::vector<Element> chain = chain_of(m);
    return std::any_of(chain.begin(), chain.end(), is_elastic);
}

// Gives `to` the elements of another material; its thickness and curvature length stay.
inline void take_elements(Material& to, Material from) {
    from.thickness = to.thickness;
    from.curvature_length = to.curvature_length;
    to = std::move(from);
}

inline void drop_maps(Material& m) {
    m.modulus_map = m.viscosity_map = {};
    for (KelvinVoigt& e : m.elements) e.modulus_map = e.viscosity_map = {};
}

// Seconds.
struct TauRange {
    double min, max;
};

// Returns the least and the greatest retardation time; infinity where there is no spring.
inline TauRange tau_range(const std::vector<Element>& elements) {
    TauRange tau{.min = INFINITY, .max = 0};
    for (const Element& m : elements) {
        tau.min = std::min(tau.min, m.viscosity / m.modulus);
        tau.max = std::max(tau.max, m.viscosity / m.modulus);
    }
    return tau;
}

// Returns the modulus, Pa, which a kernel multiplies strains by.
inline double stiffness(const Element& m) { return m.modulus; }

} // namespace dermis::scene
