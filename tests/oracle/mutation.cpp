// SPDX-License-Identifier: MIT
#include "tests/oracle/mutation.hpp"

#include <algorithm>

namespace oracle {

using namespace dermis;

namespace {

// The numbers that describe a scene, but for its times.
std::vector<double*> numbers_of(Scene& s) {
    std::vector<double*> all = {&s.load.intensity, &s.receptors.fa2_gains[0], &s.receptors.fa2_gains[1]};
    Material& m = s.material;
    for (std::optional<double>* given :
         {&s.tolerance, &s.grid.spacing, &s.surface.relief, &m.modulus, &m.viscosity, &m.thickness, &m.curvature_length,
          &m.spring, &m.dashpot, &s.receptors.sa2_adaptation})
        if (*given) all.push_back(&**given);
    for (KelvinVoigt& e : m.elements) all.insert(all.end(), {&e.modulus, &e.viscosity});
    Envelope& e = s.load.envelope;
    if (e.kind == Envelope::Kind::sine) all.insert(all.end(), {&e.frequency, &e.phase, &e.mean, &e.amplitude});
    if (e.kind == Envelope::Kind::table)
        for (double& v : e.values) all.push_back(&v);
    return all;
}

// The times that a load and its fields have.
std::vector<double*> times_of(Scene& s) {
    std::vector<double*> all;
    Envelope& e = s.load.envelope;
    if (s.load.interval) all.push_back(&*s.load.interval);
    else if (e.kind == Envelope::Kind::table)
        for (double& t : e.times) all.push_back(&t);
    else if (e.kind != Envelope::Kind::sine) all.push_back(&e.start);
    if (e.kind == Envelope::Kind::ramp) all.push_back(&e.rise);
    if (e.kind == Envelope::Kind::pulse) all.insert(all.end(), {&e.length, &e.period});
    for (FieldRequest& f : s.output.fields) all.push_back(&f.at);
    return all;
}

// Calls with the numbers of each map and frame.
template <class Take> void each_map(Case& c, Take take) {
    Material& m = c.scene.material;
    std::vector<Map*> maps = {&c.scene.surface.map, &c.scene.load.map, &m.modulus_map, &m.viscosity_map};
    for (KelvinVoigt& e : m.elements) maps.insert(maps.end(), {&e.modulus_map, &e.viscosity_map});
    for (Map* map : maps)
        if (!map->empty()) take(map->edit());
    for (std::vector<double>& frame : c.frames) take(frame);
}

int rows_of(const Scene& s) { return int(std::ceil(s.time.duration / s.time.step - 1e-9)); }

// Makes frames of the map, each the map times a level, or a map of the first frame.
void take_frames(Case& c, const std::vector<double>& levels) {
    Load& load = c.scene.load;
    for (double level : levels) {
        c.frames.push_back(load.map);
        for (double& p : c.frames.back()) p *= level;
    }
    load.kind = Load::Kind::sequence;
    load.map = {};
    load.envelope = {};
}
void leave_frames(Case& c) {
    Load& load = c.scene.load;
    load.kind = Load::Kind::map;
    load.map = c.frames.front();
    load.interval.reset();
    load.hold = Hold::linear;
    c.frames.clear();
}

} // namespace

void crop(Case& c, int width, int height) {
    Scene& s = c.scene;
    const int before = s.grid.width;
    each_map(c, [&](std::vector<double>& map) {
        std::vector<double> part;
        for (int y = 0; y < height; ++y)
            part.insert(part.end(), map.begin() + y * before, map.begin() + y * before + width);
        map = std::move(part);
    });
    s.grid.width = width;
    s.grid.height = height;
    const auto beyond = [&](Cell cell) { return cell.x >= width || cell.y >= height; };
    std::erase_if(s.output.probes, beyond);
    std::erase_if(s.sites, [&](const Site& site) { return beyond(site.cell); });
}

double Mutation::changed(double v) {
    switch (below(7)) {
    case 0: return v * decades(-1, 1);
    case 1: return v * (1 + decades(-16, -1) * (one_in(2) ? -1 : 1));
    case 2: return std::nextafter(v, one_in(2) ? -HUGE_VAL : HUGE_VAL);
    case 3: return -v;
    case 4: return v == 0 ? 1 : std::copysign(std::ldexp(1, std::ilogb(v)), v);
    case 5: return double(float(v));
    default: return v * (1 + real(-0.3, 0.3));
    }
}

// On a row's time, some ulp beside it, or anywhere.
double Mutation::beside_row(const Scene& s) {
    const double t = s.time.step * below(rows_of(s) + 1);
    if (one_in(3)) return t;
    if (one_in(2)) return std::abs(t + s.time.step * real(-1, 1));
    return std::abs(t + (one_in(2) ? -1 : 1) * t * 0x1p-52 * (8 + decades(0, 6)));
}

void Mutation::change_number(Scene& s) {
    const std::vector<double*> all = numbers_of(s);
    double& v = *all[size_t(below(int(all.size())))];
    v = changed(v);
}

void Mutation::change_map(Case& c) {
    int maps = 0;
    each_map(c, [&](auto&) { ++maps; });
    const int chosen = below(maps), what = below(6);
    int index = 0;
    each_map(c, [&](std::vector<double>& map) {
        if (index++ != chosen) return;
        double &one = map[random_() % map.size()], other = map[random_() % map.size()];
        if (what == 0) std::fill(map.begin(), map.end(), one);
        else if (what == 1) one = other;
        else if (what == 2) one = 0;
        else one = changed(one);
    });
}

// Less of the map, or more of it by repetition; fewer or more rows.
void Mutation::change_size(Case& c) {
    Scene& s = c.scene;
    if (one_in(2)) {
        s.time.duration = s.time.step * (1 + below(most_rows));
        return;
    }
    if (!one_in(4)) return crop(c, 1 + below(s.grid.width), 1 + below(s.grid.height));
    const int times = 1 << (1 + below(10));
    if (s.grid.width * times > 16384 || cells_of(s) * size_t(times * rows_of(s)) > 100000) return;
    const int before = s.grid.width;
    each_map(c, [&](std::vector<double>& map) {
        std::vector<double> repeated;
        for (auto row = map.begin(); row != map.end(); row += before)
            for (int i = 0; i < times; ++i) repeated.insert(repeated.end(), row, row + before);
        map = std::move(repeated);
    });
    s.grid.width *= times;
}

// Pressure and resistance together, pressure alone, or time in other units.
void Mutation::change_units(Scene& s) {
    const double factor = one_in(2) ? std::ldexp(1, below(200) - 100) : decades(-40, 40);
    s.load.intensity *= factor;
    if (one_in(2)) return;
    Material& m = s.material;
    for (std::optional<double>* given : {&m.modulus, &m.viscosity, &m.spring, &m.dashpot})
        if (*given) **given *= factor;
    for (KelvinVoigt& e : m.elements) e.modulus *= factor, e.viscosity *= factor;
    for (Map* map : {&m.modulus_map, &m.viscosity_map})
        if (!map->empty())
            for (double& v : map->edit()) v *= factor;
}

void Mutation::change_envelope(Scene& s) {
    Envelope& e = s.load.envelope;
    e.kind = Envelope::Kind(below(5));
    e.start = beside_row(s);
    e.rise = s.time.step * decades(-3, 1.5);
    e.frequency = decades(-2, 2) / s.time.step;
    e.phase = real(-4, 4);
    e.period = std::max(s.time.step * decades(-0.5, 1), s.time.duration / 100);
    e.length = e.period * real(0.1, 0.9);
    e.times = {beside_row(s), beside_row(s), beside_row(s)};
    std::sort(e.times.begin(), e.times.end());
    if (one_in(2)) e.times[1] = e.times[0]; // a jump
    e.values = {real(-1, 1), real(-1, 1), one_in(2) ? 0 : real(-1, 1)};
}

void Mutation::change_time(Scene& s) {
    const std::vector<double*> all = times_of(s);
    if (!all.empty() && !one_in(3)) {
        *all[size_t(below(int(all.size())))] = beside_row(s);
        return;
    }
    const double rows = rows_of(s);
    s.time.step = std::abs(changed(s.time.step));
    s.time.duration = s.time.step * rows;
}

void Mutation::change_frames(Case& c) {
    const Scene& s = c.scene;
    if (c.frames.empty()) {
        std::vector<double> levels;
        for (int i = 1 + below(6); i > 0; --i) levels.push_back(one_in(4) ? 0 : real(-1, 1));
        take_frames(c, levels);
        c.scene.load.interval = s.time.step * (one_in(2) ? 1 + below(5) : real(0.2, 5));
        c.scene.load.hold = Hold(below(2));
        return;
    }
    std::vector<double>& frame = c.frames[size_t(below(int(c.frames.size())))];
    const double level = one_in(3) ? 0 : real(-2, 2);
    switch (below(4)) {
    case 0: leave_frames(c); break;
    case 1: c.frames.pop_back(); break;
    case 2: c.frames.push_back(frame); break;
    default:
        for (double& p : frame) p *= level;
    }
    if (c.scene.load.kind == Load::Kind::sequence && c.frames.empty()) c.frames.emplace_back(cells_of(s), 1.0);
}

void Mutation::change_material(Scene& s) {
    Material& m = s.material;
    const double E = m.modulus.value_or(m.elements.empty() ? 1 : m.elements[0].modulus);
    const auto flipped = [&](std::optional<double>& given, double value) {
        if (given) given.reset();
        else given = value;
    };
    if (m.elements.empty()) { // becomes one of a chain
        if (!m.modulus_map.empty()) m.modulus_map = m.viscosity_map = {};
        else if (one_in(3)) {
            for (size_t i = 0; i < cells_of(s); ++i) {
                m.modulus_map.edit().push_back(E * decades(-0.3, 0.3));
                m.viscosity_map.edit().push_back(m.viscosity.value_or(1) * decades(-0.3, 0.3));
            }
        } else {
            m.elements.push_back({E, m.viscosity.value_or(1)});
            m.modulus.reset();
            m.viscosity.reset();
        }
        return;
    }
    KelvinVoigt& one = m.elements[size_t(below(int(m.elements.size())))];
    switch (below(6)) {
    case 0: m.elements.push_back({one.modulus * decades(-1, 1), one.viscosity * decades(-2, 2)}); break;
    case 1: m.elements.push_back({one.modulus, one.viscosity * (1 + decades(-15, -1))}); break;
    case 2: m.elements.pop_back(); break;
    case 3: flipped(m.spring, E * decades(-1, 1)); break;
    case 4: flipped(m.dashpot, E * s.time.duration * decades(-2, 2)); break;
    default: (one_in(2) ? one.modulus : one.viscosity) = 0;
    }
}

std::vector<Quantity> Mutation::some() {
    std::vector<Quantity> list;
    for (int q = 0; q < 5; ++q)
        if (one_in(2)) list.push_back(Quantity(q));
    if (list.empty()) list.push_back(Quantity(below(5)));
    return list;
}

void Mutation::change_output(Scene& s) {
    Output& o = s.output;
    const Cell cell{below(s.grid.width), below(s.grid.height)};
    switch (below(6)) {
    case 0: o.traces = some(); break;
    case 1: o.traces = one_in(2) ? std::vector<Quantity>() : std::vector{Quantity(below(5))}; break;
    case 2: o.extremes = !o.extremes; break;
    case 3: o.probes = {cell}; break;
    case 4:
        o.fields = {{beside_row(s), {Quantity(below(7))}}};
        if (one_in(2)) o.fields.clear();
        break;
    default: s.sites.push_back({Quantity(1 + below(4)), cell});
    }
}

void Mutation::change_receptors(Scene& s) {
    Receptors& r = s.receptors;
    const std::array<double, 2> gains[] = {{1, -1}, {1, 0}, {1, 1}, {0, 0}, {real(-2, 2), real(-2, 2)}};
    switch (below(4)) {
    case 0: r.fa2_gains = gains[below(5)]; break;
    case 1: r.fa2 = Fa2(below(2)); break;
    case 2:
        if (r.sa2_adaptation) r.sa2_adaptation.reset();
        else r.sa2_adaptation = s.time.step * decades(-2, 3);
        break;
    default: s.stencil = Stencil(below(3)); s.edges = Edges(below(*s.stencil == published_stencil ? 3 : 2));
    }
}

void Mutation::change_one(Case& c) {
    Scene& s = c.scene;
    switch (below(16)) {
    case 0: return change_size(c);
    case 1: return change_units(s);
    case 2: return change_envelope(s);
    case 3: return change_frames(c);
    case 4: return change_material(s);
    case 5: return change_output(s);
    case 6: return change_receptors(s);
    case 7:
        if (s.tolerance) s.tolerance.reset();
        else s.tolerance = decades(-14, -2);
        return;
    case 8:
    case 9: return change_time(s);
    case 10:
    case 11:
    case 12: return change_map(c);
    default: return change_number(s);
    }
}

void Mutation::change(Case& c) {
    do change_one(c);
    while (one_in(3));
}

std::vector<Case> simpler(const Case& c) {
    std::vector<Case> all;
    const auto with = [&](auto change) {
        Case less = c;
        change(less.scene);
        all.push_back(less);
    };
    const Scene& s = c.scene;
    if (s.time.duration > 1.5 * s.time.step) {
        with([&](Scene& x) { x.time.duration = x.time.step * std::ceil(rows_of(s) / 2.0); });
        with([&](Scene& x) { x.time.duration = x.time.step * (rows_of(s) - 1); });
    }
    for (const auto& [width, height] : {std::pair{(s.grid.width + 1) / 2, s.grid.height},
                                        {s.grid.width, (s.grid.height + 1) / 2},
                                        {s.grid.width - 1, s.grid.height},
                                        {s.grid.width, s.grid.height - 1}})
        if (width > 0 && height > 0 && width * height < s.grid.width * s.grid.height) {
            all.push_back(c);
            crop(all.back(), width, height);
        }
    for (size_t i = 0; i < s.output.traces.size(); ++i)
        with([&](Scene& x) { x.output.traces.erase(x.output.traces.begin() + long(i)); });
    for (size_t i = 0; i < s.output.fields.size(); ++i)
        with([&](Scene& x) { x.output.fields.erase(x.output.fields.begin() + long(i)); });
    for (size_t i = 0; i < s.sites.size(); ++i) with([&](Scene& x) { x.sites.erase(x.sites.begin() + long(i)); });
    for (size_t i = 0; i < s.material.elements.size(); ++i)
        with([&](Scene& x) { x.material.elements.erase(x.material.elements.begin() + long(i)); });
    if (!s.output.probes.empty()) with([](Scene& x) { x.output.probes.clear(); });
    if (s.output.extremes) with([](Scene& x) { x.output.extremes = false; });
    if (!s.material.modulus_map.empty()) with([](Scene& x) { x.material.modulus_map = x.material.viscosity_map = {}; });
    if (s.tolerance) with([](Scene& x) { x.tolerance.reset(); });
    if (s.receptors.sa2_adaptation) with([](Scene& x) { x.receptors.sa2_adaptation.reset(); });
    if (s.material.dashpot) with([](Scene& x) { x.material.dashpot.reset(); });
    if (s.material.spring) with([](Scene& x) { x.material.spring.reset(); });
    if (c.frames.size() > 1) {
        all.push_back(c);
        all.back().frames.pop_back();
    }
    return all;
}

} // namespace oracle
