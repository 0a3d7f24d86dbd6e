// SPDX-License-Identifier: MIT
// The checks of afferents.
#include "host/core/base/refusal.hpp"
#include "host/core/description/description.hpp"
#include "host/core/description/skin_keys.hpp"

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
    need(finite(m.sensitivity) && sensitivities.holds(m.sensitivity), (at + ".sensitivity").c_str(), m.sensitivity,
         sensitivities.words);
}

// Checks the cells given, or fills in those of the class's sites, or of the endings around these.
void take_cells(const std::string& at, const SkinDescription& d, Afferents& a) {
    for (size_t i = 0; i < a.cells.size(); ++i)
        need_inside(at + ".cells[" + std::to_string(i) + "]", a.cells[i], d.grid);
    if (a.radius && !a.cells.empty())
        refuse(at + ".radius", shortest(*a.radius), "none beside cells, which are endings, not middles of afferents");
    if (!a.cells.empty()) return;
    if (a.endings != 1 && !a.radius)
        refuse(
            at + ".endings", std::to_string(a.endings),
            "1 at sites, unless a line radius = \"1.5 mm\" says how far around their site the endings of an afferent "
            "lie; or the endings that belong together as cells, in a file also by sites.path");
    a.cells = cells_of(a.type, d.sites);
    if (a.cells.empty())
        refuse(at + ".cells", "(none)", std::string("some cells, or sites of ") + name(a.type) + " in the description");
    if (!a.radius) return;
    a.cells = endings_around(a.cells, a, d.grid);
    a.radius.reset();
}

} // namespace

std::vector<Cell> cells_of(Quantity type, const std::vector<Site>& sites) {
    std::vector<Cell> cells;
    for (const Site& s : sites)
        if (s.type == type) cells.push_back(s.cell);
    return cells;
}

std::vector<Afferents> validated_afferents(const SkinDescription& d, std::vector<Afferents> all) {
    for (size_t i = 0; i < all.size(); ++i) {
        Afferents& a = all[i];
        const std::string at = "afferents[" + std::to_string(i) + "]";
        if (!is_receptor_class(a.type))
            refuse(at + ".type", std::string("\"") + name(a.type) + "\"", receptor_class_names());
        if (!a.model) a.model = afferent_model(a.type);
        check_model(at, *a.model);
        check_rows(at + ".", a);
        take_cells(at, d, a);
        const std::string endings = at + ".endings";
        need(a.cells.size() % size_t(a.endings) == 0, endings.c_str(), a.endings,
             "a divisor of the number of cells, " + std::to_string(a.cells.size()));
    }
    return all;
}

} // namespace dermis::scene

namespace dermis {

double scene::threshold_sensitivity(Quantity type) {
    return type == Quantity::sa1 ? 14.66 : type == Quantity::fa1 ? 1.415 : type == Quantity::fa2 ? 23.16 : 1;
}

// From bench/evidence/afferents.csv, which has their standard errors.
AfferentModel afferent_model(Quantity type) {
    AfferentModel m;
    m.value = 0;
    m.rate = 1;
    m.sensitivity = scene::threshold_sensitivity(type);
    switch (type) {
    case Quantity::sa1:
        m.time_constants = {8.499e-3, 2.905e-4};
        m.value = 18.12;
        m.gains[0] = {0.1059, 0.01015};
        m.membrane_time = 5.472e-3;
        m.refractory_time = 2.843e-3;
        m.spread = 0.5768;
        return m;
    case Quantity::fa1:
        m.time_constants = {1.127e-3, 3.423e-4};
        m.gains[0] = {0.2183, 0.002216};
        m.membrane_time = 8.445e-3;
        m.refractory_time = 2.559e-3;
        m.spread = 0.5629;
        return m;
    case Quantity::fa2:
        m.time_constants = {3.371e-4};
        m.frequency = 264.6;
        m.quality = 1.157;
        m.gains = {{{0, 0}, {4.341e-3, 5.5e-7}, {0, 0}}};
        m.membrane_time = 1.241e-3;
        m.refractory_time = 3.16e-3;
        m.spread = 1.275;
        return m;
    default:
        scene::refuse("afferents.type", std::string("\"") + name(type) + "\"",
                      "sa1, fa1, fa2, which have parameters; give a model for sa2");
    }
}

} // namespace dermis
