// SPDX-License-Identifier: MIT
// The checks of afferents.
#include "host/core/base/refusal.hpp"
#include "host/core/description/description.hpp"
#include "host/core/description/skin_keys.hpp"

#include <algorithm>

namespace dermis::scene {
namespace {

void check_filter(const std::string& at, const AfferentModel& m) {
    const std::string times = at + ".time_constants", frequency = at + ".frequency", quality = at + ".quality";
    if (m.frequency.has_value() != m.quality.has_value())
        refuse(m.frequency ? quality : frequency, "(not given)", "a number > 0: frequency and quality belong together");
    const size_t poles = m.time_constants.size() + (m.frequency ? 2 : 0);
    if (poles < 1 || poles > 3)
        refuse(times, std::to_string(m.time_constants.size()) + " numbers",
               "1 to 3 poles: one for each time constant, two for a frequency");
    for (size_t j = poles; j < m.gains.size(); ++j)
        for (double gain : m.gains[j])
            need(gain == 0, (at + ".gains[" + std::to_string(j) + "]").c_str(), gain,
                 "0: a filter of " + std::to_string(poles) + " poles has a continuous derivative of order " +
                     std::to_string(poles - 1) + " at most");
}

void check_model(const std::string& at, const AfferentModel& m) {
    check_rows(at + ".", m);
    check_filter(at, m);
    for (const auto& pair : m.gains)
        for (double gain : pair) need_finite((at + ".gains").c_str(), gain);
    for (const AfterCurrent& current : m.after) check_rows(at + ".after.", current);
}

// Fills in the cells of the class's sites, or checks the cells given.
void take_cells(const std::string& at, const SkinDescription& d, Afferents& a) {
    const auto index = [&](Cell c) { return size_t(c.y) * size_t(d.grid.width) + size_t(c.x); };
    std::vector<size_t> held;
    for (const Site& s : d.sites) held.push_back(index(s.cell));
    std::ranges::sort(held);
    for (size_t i = 0; i < a.cells.size(); ++i) {
        const std::string cell = at + ".cells[" + std::to_string(i) + "]";
        need_inside(cell, a.cells[i], d.grid);
        if (!d.sites.empty() && !std::ranges::binary_search(held, index(a.cells[i])))
            refuse(cell, text_of(a.cells[i]), "cells of the description's sites");
    }
    if (!a.cells.empty()) return;
    for (const Site& s : d.sites)
        if (s.type == a.type) a.cells.push_back(s.cell);
    if (a.cells.empty())
        refuse(at + ".cells", "(none)", std::string("some cells, or sites of ") + name(a.type) + " in the description");
}

} // namespace

std::vector<Afferents> validated_afferents(const SkinDescription& d, std::vector<Afferents> all) {
    for (size_t i = 0; i < all.size(); ++i) {
        Afferents& a = all[i];
        const std::string at = "afferents[" + std::to_string(i) + "]";
        if (!is_receptor_class(a.type))
            refuse(at + ".type", std::string("\"") + name(a.type) + "\"", receptor_class_names());
        if (!a.model) a.model = afferent_model(a.type);
        check_model(at, *a.model);
        take_cells(at, d, a);
        const std::string endings = at + ".endings";
        check_rows(at + ".", a);
        need(a.cells.size() % size_t(a.endings) == 0, endings.c_str(), a.endings,
             "a divisor of the number of cells, " + std::to_string(a.cells.size()));
    }
    return all;
}

} // namespace dermis::scene

namespace dermis {

// From bench/evidence/afferents.csv, which has their standard errors.
AfferentModel afferent_model(Quantity type) {
    AfferentModel m;
    m.value = 0;
    m.rate = 1;
    switch (type) {
    case Quantity::sa1:
        m.time_constants = {8.499e-3, 2.905e-4};
        m.value = 18.12;
        m.gains[0] = {0.1059, 0.01015};
        m.membrane_time = 5.472e-3;
        m.refractory_time = 2.843e-3;
        return m;
    case Quantity::fa1:
        m.time_constants = {1.127e-3, 3.423e-4};
        m.gains[0] = {0.2183, 0.002216};
        m.membrane_time = 8.445e-3;
        m.refractory_time = 2.559e-3;
        return m;
    case Quantity::fa2:
        m.time_constants = {3.371e-4};
        m.frequency = 264.6;
        m.quality = 1.157;
        m.gains = {{{0, 0}, {4.341e-3, 5.5e-7}, {0, 0}}};
        m.membrane_time = 1.241e-3;
        m.refractory_time = 3.16e-3;
        return m;
    default:
        scene::refuse("afferents.type", std::string("\"") + name(type) + "\"",
                      "sa1, fa1, fa2, which have parameters; give a model for sa2");
    }
}

} // namespace dermis
