// SPDX-License-Identifier: MIT
#include "tests/oracle/family.hpp"

#include "tests/oracle/scene_files.hpp"

#include <algorithm>
#include <cmath>

#include <unistd.h>

namespace oracle {

using namespace dermis;

namespace {

// The envelopes of all loads.
std::vector<Envelope> envelopes_of(const Scene& s) {
    std::vector<Envelope> all = {s.load.envelope};
    for (const Load& load : s.more_loads) all.push_back(load.envelope);
    return all;
}

// Whether breakpoints stand closer than 1e-4 of a step.
bool crowded(const Envelope& e, double step) {
    const double least = 1e-4 * step;
    if (e.kind == Envelope::Kind::ramp) return e.rise < least;
    if (e.kind == Envelope::Kind::pulse) return e.length < least || e.period - e.length < least;
    for (size_t i = 1; i < e.times.size(); ++i)
        if (e.times[i] != e.times[i - 1] && e.times[i] - e.times[i - 1] < least) return true;
    return e.window &&
           ((e.window->rise > 0 && e.window->rise < least) || (e.window->fall > 0 && e.window->fall < least));
}
bool crowded(const Scene& s) {
    return std::ranges::any_of(envelopes_of(s), [&](const Envelope& e) { return crowded(e, s.time.step); });
}

bool is_mapped(const Material& m) {
    return !m.modulus_map.empty() || std::any_of(m.elements.begin(), m.elements.end(), [](const KelvinVoigt& e) {
        return !e.modulus_map.empty() || !e.viscosity_map.empty();
    });
}

} // namespace

bool undecided(const Scene& s) {
    std::vector<long double> times;
    for (const FieldRequest& f : s.output.fields) times.push_back(f.at);
    for (const Envelope& e : envelopes_of(s)) {
        times.insert(times.end(), {(long double)e.start, (long double)e.start + e.rise});
        times.insert(times.end(), e.times.begin(), e.times.end());
        if (const auto& w = e.window)
            times.insert(times.end(), {(long double)w->start, (long double)w->start + w->rise,
                                       (long double)w->until.value_or(0), (long double)w->until.value_or(0) + w->fall});
        if (e.kind == Envelope::Kind::pulse)
            for (long double t = e.start; t <= s.time.duration; t += e.period) {
                times.push_back(t);
                times.push_back(t + e.length);
            }
    }
    for (long double t = 0; s.load.interval && t <= s.time.duration; t += *s.load.interval) times.push_back(t);
    for (long double t : times) {
        const long double off = std::abs(t - std::round(t / s.time.step) * s.time.step) / (t * 0x1p-52L);
        if (off > 2 && off < 8) return true;
    }
    return false;
}

Family::Family(unsigned seed)
    : Draw(seed), path_(std::filesystem::temp_directory_path() /
                        ("dermis_family_" + std::to_string(getpid()) + "_" + std::to_string(seed) + ".npy")) {}

Family::~Family() { std::filesystem::remove(path_); }

Case Family::next() {
    Case c;
    do {
        c.scene = scene();
        c.frames.clear();
        const bool free = c.scene.method == Method::exact && c.scene.sites.empty();
        if (free && below(100) < 15 && kind_ != std::string_view("late")) c.frames = frames(c.scene);
    } while (undecided(c.scene) || crowded(c.scene));
    if (c.scene.material.modulus_map.empty() && one_in(4)) {
        take_chain(c.scene);
        if (one_in(4)) take_chain_maps(c.scene);
        else if (c.frames.empty() && c.scene.method == Method::exact && may_be_chain(c.scene) && one_in(2)) {
            take_wide_chain(c.scene);
            if (one_in(2)) take_sites_on_chain(c);
        }
    }
    if (one_in(3)) take_depths(c.scene);
    if (one_in(4)) take_more_loads(c);
    if (c.scene.more_loads.empty() && one_in(10)) take_control(c.scene);
    return c;
}

Case Family::next_sparse() {
    Case c;
    Scene& s = c.scene;
    do {
        do s = scene();
        while (s.grid.width > 12 || s.grid.height > 12 || kind_ == std::string_view("late"));
        s.time.duration = std::min(s.time.duration, s.time.step * (5 + below(10)));
        s.output.fields.clear();
        c.frames.clear();
        if (s.method == Method::exact && one_in(8)) s.time.duration = s.time.step; // one output, before the load acts
        if (!one_in(3)) take_surroundings(s);
        if (s.method == Method::exact && one_in(3)) {
            c.frames = frames(s);
            const int still = 1 + below(std::min(3, int(c.frames.size())));
            for (int i = 0; i < still; ++i) std::ranges::fill(c.frames[size_t(i)], 0);
            s.time.duration = std::max(s.time.duration, *s.load.interval * (still + 1));
            write_frames(path_, s.grid, c.frames);
        } else if (one_in(4)) {
            take_baseline(s);
        }
        const int rows = int(std::ceil(s.time.duration / s.time.step - 1e-9));
        const bool sites_alone = !s.sites.empty() && s.output.traces.empty();
        if (!sites_alone)
            s.output.fields.push_back({s.time.step * below(rows), {Quantity::curvature, Quantity::deformation}});
        if (!sites_alone && one_in(2))
            s.output.fields.push_back(
                {s.method == Method::exact ? s.time.duration * real(0, 1) : s.time.step * below(rows),
                 {Quantity::strain, Quantity::fa1}});
    } while (undecided(s) || crowded(s));
    const std::string_view kind = kind_;
    if (one_in(3)) take_depths(s);
    if (one_in(3)) take_more_loads(c);
    if (kind == kind_) kind_ = c.frames.empty() ? "sparse" : "sparse frames";
    return c;
}

Scene Family::scene() {
    Scene s;
    const int draw = below(1000);
    kind_ = draw < 340   ? "mild"
            : draw < 690 ? "wild"
            : draw < 770 ? "sites"
            : draw < 810 ? "long"
            : draw < 860 ? "many"
            : draw < 865 ? "patch"
            : draw < 905 ? "late"
            : draw < 955 ? "units"
                         : "baseline";
    const std::string_view kind = kind_;
    const bool many = kind == "many", patch = kind == "patch";
    take_grid(s, {patch || (kind == "mild" && one_in(60)) ? 60
                  : many                                  ? -14
                                                          : 12,
                  kind == "long"  ? 2500
                  : many || patch ? 40
                                  : 150});
    s.time.step = decades(-4, 0);
    const bool wild = kind == "wild" || (kind == "sites" && one_in(2));
    take_material(s, wild ? decades(-8, 6) : decades(-4, 1.477));
    take_surface(s);
    take_load(s);
    take_envelope(s);
    if (kind == "late") take_late(s);
    if (one_in(8)) take_window(s);
    if (!s.load.envelope.window && one_in(3)) move_breakpoint(s);
    take_receptors(s);
    if (patch) take_patch(s);
    else if (many || one_in(4)) take_material_maps(s);
    take_output(s);
    if (kind == "sites") take_sites(s);
    s.tolerance = decades(-13, -2);
    const int precision = below(20);
    if (precision >= 12) s.precision = Precision((precision - 12) % 3);
    else if (precision == 11 && kind != "sites") s.model = Model::march;
    if (kind == "baseline") take_baseline(s);
    return s;
}

// A negative size is that of a grid which is at least 10 cells in each direction.
void Family::take_grid(Scene& s, Size size) {
    const int n = std::abs(size.grid), least = size.grid < 0 ? 10 : size.grid == 60 ? 60 : 1;
    s.grid = {least + below(n - least + 1), least + below(n - least + 1), {}};
    const int outputs = size.outputs == 2500 ? 1000 + below(1500) : 5 + below(size.outputs);
    s.time.duration = outputs; // steps, until the step is known
}

void Family::take_material(Scene& s, double z) {
    s.time.duration *= s.time.step;
    double E = decades(-2, 2);
    const bool units = kind_ == std::string_view("units");
    if (units) E = one_in(2) ? decades(5, 7) : decades(-1, 1);
    s.material.modulus = E;
    s.material.viscosity = E * s.time.step / z;
    if (one_in(40)) s.material.modulus = 0;
    else if (one_in(40)) s.material.viscosity = 0;
    if (!units && one_in(2)) return;
    const bool micrometres = units && one_in(2);
    s.grid.spacing = micrometres ? 1e-6 * real(10, 100) : decades(-5, -3);
    const double spacing = *s.grid.spacing;
    s.surface.relief = spacing * decades(-2, 0.5);
    s.material.thickness = spacing * decades(-1, 2);
    s.material.curvature_length = spacing * decades(-2, 0.5) * (one_in(3) ? -1 : 1);
}

void Family::take_surface(Scene& s) {
    s.surface.kind = Surface::Kind::map;
    const double waves = real(0.1, 2), noise = one_in(2) ? 0 : real(0, 0.5),
                 offset = one_in(4) ? (one_in(2) ? 1e4 : decades(0, 6)) : 0;
    const bool flat = one_in(5);
    std::vector<double>& map = s.surface.map.edit();
    for (int y = 0; y < s.grid.height; ++y)
        for (int x = 0; x < s.grid.width; ++x)
            map.push_back(offset +
                          (flat ? 0.5 : 0.5 + 0.5 * std::sin(waves * x + 0.3 * std::sin(y)) + noise * real(-1, 1)));
    s.stencil = Stencil(below(3));
    s.edges = Edges(below(2));
    if (*s.stencil == published_stencil && s.grid.width > 1 && s.grid.height > 1 && one_in(2))
        s.edges = published_edges;
}

void Family::take_load(Scene& s) {
    s.load.kind = Load::Kind::map;
    const double cx = real(0, s.grid.width), cy = real(0, s.grid.height), radius = real(1, 8);
    const int shape = below(3);
    std::vector<double>& map = s.load.map.edit();
    for (int y = 0; y < s.grid.height; ++y)
        for (int x = 0; x < s.grid.width; ++x) {
            const double r = std::hypot(x - cx, y - cy) / radius;
            map.push_back(shape == 0 ? std::max(0.0, 1 - r) : shape == 1 ? std::exp(-r * r) : real(-1, 1));
        }
    const double E = s.material.elements.empty() ? *s.material.modulus : s.material.elements[0].modulus,
                 eta = s.material.elements.empty() ? *s.material.viscosity : s.material.elements[0].viscosity,
                 stiffness = E > 0 ? E : eta / s.time.duration;
    s.load.intensity = decades(-3, 1) * stiffness * (one_in(2) ? 0.01 : -0.01);
    if (kind_ == std::string_view("units")) s.load.intensity = one_in(2) ? 1e-11 : s.load.intensity;
}

void Family::take_envelope(Scene& s) {
    Envelope& e = s.load.envelope;
    const double T = s.time.duration;
    e.kind = Envelope::Kind(below(5));
    switch (e.kind) {
    case Envelope::Kind::step: e.start = one_in(2) ? 0 : real(0, 0.6) * T; break;
    case Envelope::Kind::ramp:
        e.start = one_in(2) ? 0 : real(0, 0.4) * T;
        e.rise = one_in(4) ? s.time.step * decades(-2, 1) : real(0.1, 1) * T;
        break;
    case Envelope::Kind::sine:
        e.frequency = one_in(4) ? decades(0, 2) / s.time.step : real(0.5, 10) / T;
        e.phase = one_in(4) ? 0 : real(-6, 6);
        e.mean = below(2);
        e.amplitude = real(-1, 1);
        break;
    case Envelope::Kind::pulse:
        e.start = one_in(8) ? 2 * T : one_in(2) ? 0 : real(0, 0.4) * T;
        e.period = one_in(4) ? s.time.step * real(0.3, 3) : real(0.05, 0.4) * T;
        e.length = e.period * real(0.1, 0.9);
        break;
    case Envelope::Kind::table: take_table(s); break;
    }
}

// A telegraph, or straight lines up and down.
void Family::take_table(Scene& s) {
    Envelope& e = s.load.envelope;
    const double T = s.time.duration;
    const bool jumps = one_in(2);
    double sign = 1;
    for (double t = one_in(2) ? 0 : real(0, 0.1) * T; t < T; t += real(0.05, 0.2) * T, sign = -sign) {
        if (jumps && !e.times.empty()) e.times.push_back(t), e.values.push_back(e.values.back());
        e.times.push_back(t);
        e.values.push_back(sign * real(0.5, 1));
    }
}

// The first breakpoint goes beside an output.
void Family::move_breakpoint(Scene& s) {
    Envelope& e = s.load.envelope;
    const double n = 1 + below(std::max(1, int(s.time.duration / s.time.step) / 2)),
                 t = n * s.time.step + s.time.step * decades(-15, -3) * (one_in(2) ? -1 : 1);
    if (e.kind != Envelope::Kind::sine && e.kind != Envelope::Kind::table) e.start = t;
    if (e.kind != Envelope::Kind::table) return;
    for (double& time : e.times) time += t;
}

void Family::take_receptors(Scene& s) {
    Receptors& r = s.receptors;
    const double tau = *s.material.modulus > 0 ? *s.material.viscosity / *s.material.modulus : 0;
    r.fa2 = Fa2(below(2));
    if (s.material.viscosity == 0) r.fa2 = Fa2::step_mean;
    if (one_in(3)) r.sa2_adaptation = one_in(10) && tau > 0 ? tau : s.time.duration * decades(-2.5, 2);
    if (one_in(3)) r.fa2_gains = {real(-2, 2), real(-2, 2)};
    else if (one_in(4)) r.fa2_gains = {1, double(below(2))};
}

// Classes of three, or each cell its own; in a third of the scenes with one retardation time, but for odd cells, and in
// half of these as maps in float have it.
void Family::take_material_maps(Scene& s) {
    const double E = *s.material.modulus, eta = *s.material.viscosity, spread = real(0, 1.5), share = real(0, 1);
    const bool classes = kind_ != std::string_view("many") && one_in(2);
    const bool elastic = E > 0 && s.receptors.fa2 == Fa2::step_mean && one_in(10), creeping = eta > 0 && one_in(10);
    const int kinds = 2 + below(30);
    const double slope = kinds % 3 == 0 ? 1 : -share; // of viscosity over modulus, in logarithms
    std::vector<double> rank;
    for (int i = 0; i < kinds; ++i) rank.push_back(real(-1, 1));
    for (size_t i = 0; i < cells_of(s); ++i) {
        const double r = spread * (classes                             ? int(i % 3) - 1.0
                                   : kind_ == std::string_view("many") ? real(-1, 1)
                                                                       : rank[i % rank.size()]);
        const bool odd = i % 7 == 3;
        const auto stored = [&](double x) { return kinds % 6 == 0 ? double(float(x)) : x; };
        s.material.modulus_map.edit().push_back(odd && creeping ? 0 : stored(E * std::pow(10, r)));
        s.material.viscosity_map.edit().push_back(odd && elastic && !creeping ? 0
                                                                              : stored(eta * std::pow(10, r * slope)));
    }
    if (kind_ == std::string_view("many") && one_in(3)) { // one soft cell, of the same tau as many others
        const size_t soft = random_() % cells_of(s);
        const double factor = decades(-6, -1);
        s.material.modulus_map.edit()[soft] *= factor;
        s.material.viscosity_map.edit()[soft] *= factor;
    }
}

// 3,600 nearly equal cells, and a few a hundred times softer.
void Family::take_patch(Scene& s) {
    if (s.material.modulus == 0 || s.material.viscosity == 0) s.material.modulus = s.material.viscosity = 1;
    const int size = 1 + below(4), left = below(s.grid.width - size), top = below(s.grid.height - size);
    for (int y = 0; y < s.grid.height; ++y)
        for (int x = 0; x < s.grid.width; ++x) {
            const bool inside = x >= left && x < left + size && y >= top && y < top + size;
            const double E = std::exp(0.2 * real(-1, 1)) * (inside ? 0.01 : 1), near = 1 + 1e-3 * real(-1, 1);
            s.material.modulus_map.edit().push_back(*s.material.modulus * E);
            s.material.viscosity_map.edit().push_back(*s.material.viscosity * E * near);
        }
}

// Puts the load in one place of a larger grid, whose other cells nothing presses. All other maps repeat.
void Family::take_surroundings(Scene& s) {
    const Grid before = s.grid;
    s.grid.width = one_in(2) ? 64 << below(3) : before.width + below(40);
    s.grid.height += below(8);
    const int left = below(s.grid.width - before.width + 1), top = below(s.grid.height - before.height + 1);
    const auto enlarge = [&](Map& map, bool repeats) {
        if (map.empty()) return;
        std::vector<double> large;
        for (int y = 0; y < s.grid.height; ++y)
            for (int x = 0; x < s.grid.width; ++x) {
                const bool inside = x >= left && x < left + before.width && y >= top && y < top + before.height;
                const size_t row = size_t((y - top + s.grid.height * before.height) % before.height),
                             column = size_t((x - left + s.grid.width * before.width) % before.width);
                large.push_back(inside || repeats ? map[row * size_t(before.width) + column] : 0);
            }
        map = large;
    };
    enlarge(s.load.map, false);
    for (Map* map : {&s.surface.map, &s.material.modulus_map, &s.material.viscosity_map}) enlarge(*map, true);
}

void Family::take_output(Scene& s) {
    const Quantity all[] = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    const auto some = [&] {
        std::vector<Quantity> list;
        for (Quantity q : all)
            if (one_in(2)) list.push_back(q);
        if (list.empty()) list.push_back(all[below(5)]);
        return list;
    };
    if (one_in(2)) s.output.traces = some();
    s.output.extremes = !one_in(5);
    for (int i = below(4); i > 0; --i) s.output.probes.push_back({below(s.grid.width), below(s.grid.height)});
    if (kind_ == std::string_view("baseline")) return;
    for (int i = one_in(3) ? 1 + below(2) : 0; i > 0; --i) {
        const double at = one_in(3) ? s.time.step * (1 + below(5)) : real(0, 1) * s.time.duration;
        const FieldRequest field{std::min(at, s.time.duration), some()};
        if (s.output.fields.empty() || s.output.fields[0].at != field.at) s.output.fields.push_back(field);
    }
}

void Family::take_sites(Scene& s) {
    const Quantity classes[] = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    for (int i = 1 + below(20); i > 0; --i)
        s.sites.push_back({classes[below(4)], {below(s.grid.width), below(s.grid.height)}});
    if (!one_in(3)) s.output = {{}, {}, {}, s.output.extremes}; // sites alone
}

// A vibration, or pulses, that go on for long.
void Family::take_late(Scene& s) {
    Envelope& e = s.load.envelope;
    const double tau = *s.material.modulus > 0 ? *s.material.viscosity / *s.material.modulus : 1;
    s.time.step = real(0.5, 2);
    s.time.duration = s.time.step * (50 + below(950));
    if (s.material.modulus > 0) s.material.viscosity = *s.material.modulus * std::max(tau, 1e-4);
    e = {};
    e.kind = one_in(3) ? Envelope::Kind::pulse : Envelope::Kind::sine;
    e.frequency = 250 * decades(-1, 1);
    e.phase = real(-6, 6);
    e.start = e.kind == Envelope::Kind::pulse ? real(0, 1) * s.time.step : 0;
    e.period = s.time.step * real(0.1, 1);
    e.length = e.period * real(0.1, 0.9);
}

// Receptors of some classes at a depth, where the scene may have them. A march spreads to them within 1e-3 of the
// greatest signal, which may be any multiple of the greatest response: its tolerance is none.
void Family::take_depths(Scene& s) {
    const Precision precision = s.precision.value_or(Precision::f64);
    const bool sites_alone = !s.sites.empty() && s.output.traces.empty() && s.output.fields.empty();
    const bool product = s.load.kind != Load::Kind::sequence && s.receptors.fa2_gains[0] == -s.receptors.fa2_gains[1];
    const bool marches = s.model == Model::march || precision != Precision::f64 || !(sites_alone || product);
    if (!s.grid.spacing || s.edges == Edges::periodic || s.method == Method::published || is_mapped(s.material)) return;
    kind_ = marches ? "spread" : "depth";
    if (!marches) s.tolerance = std::max(*s.tolerance, 1e-10); // the bound of a transform's roundings is no better
    else s.tolerance = 1e9;
    const bool strain = one_in(3), displacement = strain && one_in(2);
    Depths& z = s.receptors.depth;
    DepthKernels& k = s.receptors.kernel;
    for (auto [depth, kernel] : {std::pair{&z.sa1, &k.sa1}, {&z.sa2, &k.sa2}, {&z.fa1, &k.fa1}, {&z.fa2, &k.fa2}}) {
        if (one_in(3)) continue;
        *depth = *s.grid.spacing * decades(-0.5, 1.5);
        if (strain) *kernel = displacement && kernel == &k.fa2 ? DepthKernel::displacement : DepthKernel::strain;
        if (strain && one_in(2)) s.receptors.poisson = real(0, 0.5);
    }
}

// A window within the scene, mostly with flanks.
void Family::take_window(Scene& s) {
    Envelope& e = s.load.envelope;
    if (e.kind != Envelope::Kind::sine && e.kind != Envelope::Kind::step) return;
    const double T = s.time.duration;
    Envelope::Window w;
    e.start = 0;
    w.start = one_in(2) ? 0 : real(0, 0.4) * T;
    w.rise = one_in(4) ? 0 : one_in(4) ? s.time.step * decades(-2, 1) : real(0.05, 0.4) * T;
    if (!one_in(3)) w.until = w.start + w.rise + real(0.01, 0.3) * T;
    if (w.until && !one_in(3)) w.fall = real(0.01, 0.5) * T;
    e.window = w;
}

// More products of a map and an envelope, where the scene may be a sum of them.
void Family::take_more_loads(Case& c) {
    const Scene before = c.scene;
    Scene& s = c.scene;
    if (!c.frames.empty() || s.load.kind != Load::Kind::map || s.method != Method::exact || s.model == Model::march ||
        s.precision.value_or(Precision::f64) != Precision::f64 || is_mapped(s.material) ||
        s.receptors.fa2_gains[0] != -s.receptors.fa2_gains[1])
        return;
    do {
        s = before;
        s.more_loads.clear();
        for (int i = 1 + below(3); i > 0; --i) {
            Scene other = before;
            other.load = {};
            take_load(other);
            take_envelope(other);
            if (one_in(2)) take_window(other);
            s.more_loads.push_back(other.load);
        }
        if (one_in(3)) take_window(s);
    } while (undecided(s) || crowded(s));
    kind_ = "sum";
}

// Depths of each cell in place of pressures, where the scene may have them. Frames then have no FA2.
void Family::take_control(Scene& s) {
    if (!s.grid.spacing || is_mapped(s.material) || s.method != Method::exact || s.load.hold != Hold::linear) return;
    kind_ = "depth of cells";
    s.load.control = Control::depth;
    s.receptors.fa2 = Fa2::step_mean;
    Envelope& e = s.load.envelope;
    e.mean = std::max(e.mean, std::abs(e.amplitude));
    for (double& v : e.values) v = std::abs(v);
    if (s.load.kind != Load::Kind::sequence) return;
    std::erase_if(s.sites, [](const Site& site) { return site.type == Quantity::fa2; });
    std::erase(s.output.traces, Quantity::fa2);
    for (FieldRequest& f : s.output.fields)
        if (std::erase(f.what, Quantity::fa2) && f.what.empty()) f.what = {Quantity::sa1};
    if (!s.output.traces.empty() || !s.sites.empty()) return;
    s.output.traces = {Quantity::sa1};
    s.receptors.depth = {}; // its tolerance is that of sites alone
}

// Whether a chain may be served by a model of which every one is exact: the strain is a product of a map and a function
// of time, or only sites are asked for.
bool Family::may_be_chain(const Scene& s) const {
    const auto& gains = s.receptors.fa2_gains;
    const bool sites_alone = !s.sites.empty() && s.output.traces.empty() && s.output.fields.empty();
    return s.material.modulus_map.empty() && s.model != Model::march &&
           s.precision.value_or(Precision::f64) == Precision::f64 && (gains[0] == -gains[1] || sites_alone);
}

// Elements in series, whose retardation times are up to four decades apart.
void Family::take_chain(Scene& s) {
    kind_ = "chain";
    Material& m = s.material;
    const double E = *m.modulus > 0 ? *m.modulus : 1, eta = *m.viscosity > 0 ? *m.viscosity : E * s.time.step;
    m.modulus.reset();
    m.viscosity.reset();
    for (int i = 1 + below(5); i > 0; --i) {
        const double factor = decades(-1, 1);
        m.elements.push_back({E * factor, eta * factor * decades(-2, 2)});
    }
    if (s.receptors.fa2 == Fa2::step_mean && s.method == Method::exact && one_in(2)) m.spring = E * decades(-1, 1);
    if (one_in(4)) m.dashpot = eta * decades(0, 2);
}

// Moduli and viscosities that differ from cell to cell, for some of the elements.
void Family::take_chain_maps(Scene& s) {
    kind_ = "chain in maps";
    const size_t cells = size_t(s.grid.width) * size_t(s.grid.height);
    const int kinds = 1 + below(6);
    for (KelvinVoigt& e : s.material.elements)
        for (const auto& [number, map] : {std::pair{e.modulus, &e.modulus_map}, {e.viscosity, &e.viscosity_map}}) {
            if (one_in(2)) continue;
            std::vector<double> factors, values(cells);
            for (int i = 0; i < kinds; ++i) factors.push_back(number * decades(-0.5, 0.5));
            for (double& v : values) v = factors[size_t(below(kinds))];
            *map = values;
        }
}

// Elements in series of which some are much faster than the step, slower than the scene, or nearly alike.
void Family::take_wide_chain(Scene& s) {
    kind_ = "wide chain";
    Material& m = s.material;
    while (m.elements.size() < 8) {
        const KelvinVoigt& last = m.elements.back();
        const double modulus = m.elements.front().modulus * decades(-1, 1);
        const int kind = below(4);
        const double tau = kind == 0   ? s.time.step * decades(-7, 0)
                           : kind == 1 ? s.time.duration * decades(0, 7)
                                       : last.viscosity / last.modulus * (1 + decades(-6, 0));
        m.elements.push_back({modulus, modulus * tau});
        if (kind == 3) break;
    }
    if (one_in(3)) m.dashpot = m.elements.back().viscosity * decades(-2, 2);
}

// Sites alone, with gains of their own, and mostly under frames.
void Family::take_sites_on_chain(Case& c) {
    kind_ = "sites on a wide chain";
    Scene& s = c.scene;
    const Map& map = s.load.map;
    const auto is_fa2 = [](const Site& site) { return site.type == Quantity::fa2; };
    const auto is_unpressed = [&](const Site& site) {
        return map[size_t(site.cell.y) * size_t(s.grid.width) + size_t(site.cell.x)] == 0;
    };
    const int most = int(std::max_element(map.begin(), map.end()) - map.begin());
    const Site first{Quantity::sa1, {most % s.grid.width, most / s.grid.width}};
    s.model.reset();
    s.sites.clear();
    take_sites(s);
    std::erase_if(s.sites, is_unpressed);
    s.sites.push_back(first);
    s.tolerance = decades(-7, -1);
    s.receptors.fa2_gains = {real(0.5, 2), real(-2, 0)};
    if (!one_in(3)) {
        do c.frames = frames(s);
        while (undecided(s));
        if (one_in(2)) std::erase_if(s.sites, is_fa2);
        if (std::any_of(s.sites.begin(), s.sites.end(), is_fa2)) s.material.spring.reset(); // FA2 of frames takes none
    }
    s.output = {{}, {}, {}};
}

void Family::take_baseline(Scene& s) {
    s.method = Method(1 + below(6));
    s.allow_unstable = true;
    s.receptors.sa2_adaptation.reset();
    Material& m = s.material;
    if (m.viscosity == 0) m.viscosity = *m.modulus * s.time.step;
    for (size_t i = 0; i < m.viscosity_map.size(); ++i)
        if (m.viscosity_map[i] == 0) m.viscosity_map.edit()[i] = *m.viscosity;
    s.tolerance = decades(-4, 0);
}

std::vector<std::vector<double>> Family::frames(Scene& s) {
    const int count = 1 + below(15);
    s.load.envelope = {};
    const bool odd = one_in(3);
    s.load.interval = s.time.step * (odd ? real(0.2, 9) : 1 + below(8));
    s.load.hold = Hold(below(2));
    s.load.kind = Load::Kind::sequence;
    s.load.path = path_.string();
    s.receptors.fa2 = odd ? Fa2::point : Fa2(below(2));
    const auto drop_fa2 = [](std::vector<Quantity>& list) {
        std::erase(list, Quantity::fa2);
        if (list.empty()) list.push_back(Quantity::sa1);
    };
    bool elastic = s.material.viscosity == 0;
    for (double v : s.material.viscosity_map) elastic |= v == 0;
    if (elastic) {
        drop_fa2(s.output.traces);
        for (FieldRequest& f : s.output.fields) drop_fa2(f.what);
        for (Site& site : s.sites)
            if (site.type == Quantity::fa2) site.type = Quantity::fa1;
    }
    std::vector<std::vector<double>> all;
    for (int k = 0; k < count; ++k) {
        std::vector<double> frame = s.load.map;
        const bool rest = one_in(6);
        const double level = real(-0.5, 1);
        for (double& p : frame) p *= rest ? 0 : level + 0.2 * real(-1, 1);
        all.push_back(frame);
    }
    write_frames(path_, s.grid, all);
    s.load.map = {};
    return all;
}

} // namespace oracle
