// SPDX-License-Identifier: MIT
// The checks of time, load and output, and the order of all checks of a scene.
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/keys.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/units.hpp"
#include "host/lab/scenes/waveform.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace dermis::scene {
namespace {

constexpr double farthest = 1e9; // in numbers of a texture, waves or rad: what then is left has seven digits

// with: what needs the exact method.
void need_exact(const Scene& s, const std::string& with) {
    if (s.method != Method::exact)
        refuse("method", std::string("\"") + name(s.method) + "\"", "\"exact\" with " + with);
}

void check_sequence(const Scene& s) {
    const Load& l = s.load;
    const std::string allowed = "only without load.kind = \"sequence\", which is all of the load";
    if (l.envelope.kind != Envelope::Kind::step || l.envelope.start != 0) refuse("load.envelope", "(given)", allowed);
    need_exact(s, "load.kind = \"sequence\"");
    if (!l.interval) refuse("load.interval", "(not given)", "seconds between frames, required with a sequence");
    need(s.time.duration / *l.interval <= 1e8, "load.interval", *l.interval, "at most 1e8 frames within time.duration");
}

void check_taxels(const Scene& s) {
    if (!s.load.taxels) return;
    const Taxels& t = *s.load.taxels;
    if (s.load.kind != Load::Kind::sequence) refuse("load.taxels", "(given)", "only with load.kind = \"sequence\"");
    check_rows("load.taxels.", t);
    std::string end = s.load.path.substr(s.load.path.size() - std::min<size_t>(s.load.path.size(), 4));
    std::ranges::transform(end, end.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    const bool is_table = end == ".csv" || end == ".txt";
    for (auto [key, n] : {std::pair{"load.taxels.columns", t.columns}, {"load.taxels.rows", t.rows}}) {
        if (!n && (t.columns || t.rows || is_table))
            refuse(key, "(not given)", "a number of taxels, as rows = 4 and columns = 4, required with a CSV file");
    }
    need(t.skip >= 0 && t.skip <= 16384 && (t.columns || !t.skip), "load.taxels.skip", t.skip,
         "columns before the taxels of a CSV file, 0..16384");
    if (!t.unit) refuse("load.taxels.unit", "(not given)", allowed_unit);
    need(finite(*t.unit) && *t.unit != 0, "load.taxels.unit", *t.unit, "a finite number other than 0");
    need(s.load.intensity == 1, "load.intensity", s.load.intensity, "1, or not given, beside load.taxels.unit");
    need(!t.offset || (finite(*t.offset) && !t.first_at_rest), "load.taxels.offset", t.offset.value_or(0),
         "a finite number, and none beside first_at_rest");
}

// A ball that retreats is another problem, and so is one that goes in beyond its middle.
void check_ball(const Load& l) {
    if (!l.ball_radius) refuse("load.ball_radius", "(not given)", "a number of metres, required with a ball");
    const Envelope& e = l.envelope;
    const bool table = e.kind == Envelope::Kind::table;
    if (e.kind == Envelope::Kind::sine || e.kind == Envelope::Kind::pulse ||
        (table && !std::ranges::is_sorted(e.values)))
        refuse("load.envelope", std::string("\"") + text_of(e.kind) + "\"",
               "\"step\", \"ramp\", or a \"table\" whose values do not fall: a ball only sinks");
    const double deepest = l.intensity * (table ? e.values.back() : 1);
    need(l.intensity >= 0 && deepest <= *l.ball_radius, "load.intensity", l.intensity,
         ">= 0, and a depth of at most load.ball_radius = " + shortest(*l.ball_radius) + " m");
}

// Refuses an envelope that falls below 0. with: the key that allows none, for the error.
void need_pushing(const Envelope& e, const char* with) {
    const bool sine = e.kind == Envelope::Kind::sine, table = e.kind == Envelope::Kind::table;
    if ((sine && e.mean < std::abs(e.amplitude)) || (table && std::ranges::min(e.values) < 0))
        refuse("load.envelope", std::string("\"") + text_of(e.kind) + "\" that falls below 0",
               std::string("one that does not, with ") + with);
}

// Depths of cells by themselves. A map is cut off at 0 once, and times the envelope it has to stay there.
void check_depths(const Scene& s) {
    need_positive("material.thickness", *s.material.thickness);
    need_pushing(s.load.envelope, "load.control = \"depth\"; or a sequence of depths");
}

// Fills in the ratio of Poisson of what is pressed into a half-space.
void check_control(Scene& s) {
    const Load& l = s.load;
    std::optional<double>& poisson = s.receptors.poisson;
    const bool indenter = is_indenter(l), depth = l.control == Control::depth;
    if (indenter && !depth) refuse("load.control", "\"pressure\"", "\"depth\" with load.kind \"punch\" or \"ball\"");
    if (indenter && l.texture) refuse("load.texture", "(given)", "none with load.kind \"punch\" or \"ball\"");
    need(!poisson || indenter || reads_poisson(s.receptors), "receptors.poisson", poisson.value_or(0),
         "only with receptors.kernel = \"strain\" or \"displacement\", or load.kind \"punch\" or \"ball\"");
    const bool follows = follows_stress(s.receptors);
    for (auto [asked, key, value] :
         {std::tuple{depth, "load.control", "\"depth\""}, {follows, "receptors.follow", "\"stress\""}}) {
        if (!asked) continue;
        need_exact(s, std::string(key) + " = " + value);
        if (!is_uniform(s.material)) refuse(key, value, "none where the material differs from cell to cell");
    }
    if (follows && is_framed(l) && !depth)
        refuse("receptors.follow", "\"stress\"", "\"strain\" where a pressure is known by frames");
    if (!depth) return;
    need(s.grid.spacing.has_value(), "load.intensity", l.intensity, "only with grid.spacing where it is a depth in m");
    if (l.contact == Load::Contact::crests)
        refuse("load.contact", "\"crests\"", "\"even\" with load.control = \"depth\"");
    if (l.hold != Hold::linear) refuse("load.hold", "\"parabolic\"", "\"linear\" with load.control = \"depth\"");
    if (l.kind == Load::Kind::ball) {
        check_ball(l);
        s.load.interval = s.time.step;
    }
    if (!indenter) return check_depths(s);
    poisson = poisson.value_or(0.4);
    check_rows("receptors.", s.receptors);
}

// A texture makes frames, one at each output.
void check_texture(Scene& s) {
    if (!s.load.texture) return;
    Texture& t = *s.load.texture;
    if (s.load.kind == Load::Kind::sequence) refuse("load.texture", "(given)", "none with load.kind = \"sequence\"");
    const Envelope& e = s.load.envelope;
    if (e.kind != Envelope::Kind::step || e.start != 0)
        refuse("load.envelope", "(given)", "none with load.texture, which changes in time");
    need_exact(s, "load.texture");
    for (auto [key, n] : {std::pair{"load.texture.width", t.width}, {"load.texture.height", t.height}})
        need(n >= 1 && n <= 16384, key, n, "1..16384");
    need_map("load.texture.path", t.map, {t.width, t.height, {}});
    if (!t.spacing) t.spacing = s.grid.spacing.value_or(1);
    check_rows("load.texture.", t);
    const double least = s.grid.spacing.value_or(1) / 1024;
    need(*t.spacing >= least, "load.texture.spacing", *t.spacing,
         "at least " + shortest(least) + ", the spacing of the grid over 1024");
    for (double v : t.velocity)
        need(std::abs(v) * s.time.duration <= farthest * *t.spacing, "load.texture.velocity", v,
             "at most 1e9 times load.texture.spacing within time.duration");
    s.load.interval = s.time.step;
}

// Fills in the length of the contact.
void check_contact(Scene& s) {
    Load& l = s.load;
    const bool crests = l.contact == Load::Contact::crests;
    need(crests || l.contact_share == Load().contact_share, "load.contact_share", l.contact_share, with_crests.words);
    if (!crests) return;
    need_pushing(l.envelope, "load.contact = \"crests\"");
    const double spacing = s.grid.spacing.value_or(1),
                 period = s.surface.ridge_period.value_or(cells_per_ridge(s) * spacing);
    if (!l.contact_length && !finite(period))
        refuse("load.contact_length", "(not given)", "a length, required where the surface has no ridge period");
    if (!l.contact_length) l.contact_length = period;
    need(*l.contact_length <= spacing * std::max(s.grid.width, s.grid.height), "load.contact_length", *l.contact_length,
         "at most the longer side of the grid");
}

// Waves, none shorter than two cells along a row or a column.
void check_grating(const Scene& s) {
    if (!s.load.grating) return;
    const Load& l = s.load;
    const Grating& g = *l.grating;
    if (is_framed(l) || l.control == Load::Control::depth)
        refuse("load.grating", "(given)",
               "none with load.kind = \"sequence\", load.texture or load.control = \"depth\"");
    if (l.envelope.kind != Envelope::Kind::step || l.envelope.start != 0)
        refuse("load.envelope", "(given)", "a step from t = 0 on with load.grating, which may have a window");
    check_rows("load.grating.", g);
    if (g.velocity != 0 && l.contact == Load::Contact::crests) // each of its products would be spread by itself
        refuse("load.grating.velocity", shortest(g.velocity), "0 with load.contact = \"crests\"");
    need(!g.amplitudes.empty() && g.amplitudes.size() <= 16, "load.grating.amplitudes", double(g.amplitudes.size()),
         "1 to 16 numbers, one for each harmonic");
    need(g.phases.empty() || g.phases.size() == g.amplitudes.size(), "load.grating.phases", double(g.phases.size()),
         "as many numbers as load.grating.amplitudes, or none");
    need(std::abs(g.velocity) * s.time.duration <= farthest * g.wavelength, "load.grating.velocity", g.velocity,
         "at most 1e9 times load.grating.wavelength within time.duration");
    const double steepest = std::max(std::abs(std::cos(g.direction)), std::abs(std::sin(g.direction))),
                 least = 2 * double(g.amplitudes.size()) * steepest * s.grid.spacing.value_or(1);
    need(g.wavelength >= (1 - 1e-12) * least, "load.grating.wavelength", g.wavelength,
         "at least " + shortest(least) + ", two cells for the shortest harmonic");
}

void check_load(Scene& s) {
    Load& l = s.load;
    const bool sequence = l.kind == Load::Kind::sequence, shaped = l.kind != Load::Kind::map && !sequence;
    if (!shaped && l.center)
        refuse("load.center", text_of(*l.center),
               "only with load.kind \"circular\", \"point\", \"linear\", \"punch\" or \"ball\"");
    check_rows("load.", l);
    if (!is_framed(l) && l.hold != Hold::linear)
        refuse("load.hold", "\"parabolic\"", "\"linear\" but with load.kind = \"sequence\" or load.texture");
    if (!l.center) l.center = Cell{s.grid.width / 2, s.grid.height / 2};
    need_inside("load.center", *l.center, s.grid);
    if (!l.radius) l.radius = std::max(1, std::min(s.grid.width, s.grid.height) / 4);
    if (!l.radius_y) l.radius_y = l.radius;
    need_finite("load.intensity", l.intensity);
    check_envelope(l.envelope, s.time);
    check_contact(s);
    if (l.kind == Load::Kind::map) need_map("load.path", l.map, s.grid);
    if (sequence) check_sequence(s);
    check_taxels(s);
    check_texture(s);
    check_control(s);
    check_grating(s);
}

// Names a parameter of one of several loads, as in load[1].radius.
std::string in_list(const std::string& name, size_t load) {
    return name.starts_with("load.") ? "load[" + std::to_string(load) + "]" + name.substr(4) : name;
}

// Checks one of the loads beside the first, and fills in its defaults. Errors name it.
void check_other(Scene s, size_t i, Load& load) try {
    s.load = load;
    check_load(s);
    load = s.load;
} catch (const Error& e) {
    const std::string what = e.what(), &name = e.parameter();
    if (name.empty() || !what.starts_with(name)) throw;
    throw Error(e.code(), in_list(name, i), in_list(name, i) + what.substr(name.size()));
}

// Checks what a sum of products does not serve, and the loads beside the first.
void check_sum(Scene& s) {
    constexpr size_t most_products = 64;
    if (!is_sum(s)) return;
    const std::string cause = s.more_loads.empty() ? "a grating that moves" : "several loads", with = " with " + cause,
                      allowed = "at most 64 products of a map and an envelope in all";
    need(s.more_loads.size() < most_products, "load", double(1 + s.more_loads.size()), allowed);
    size_t products = 0;
    for (size_t i = 0; i <= s.more_loads.size(); ++i) {
        if (i > 0) check_other(s, i, s.more_loads[i - 1]);
        const Load& l = i > 0 ? s.more_loads[i - 1] : s.load;
        if (is_framed(l)) refuse(in_list("load.kind", i), "(frames)", "a map times an envelope" + with);
        if (l.control == Load::Control::depth) refuse(in_list("load.control", i), "\"depth\"", "\"pressure\"" + with);
        products += l.grating && l.grating->velocity != 0 ? 1 + 2 * l.grating->amplitudes.size() : 1;
    }
    need(products <= most_products, "load", double(products), allowed);
    need_exact(s, cause);
    if (!is_uniform(s.material)) refuse("material", "(a map)", "one for all cells" + with);
    if (follows_stress(s.receptors)) refuse("receptors.follow", "\"stress\"", "\"strain\"" + with);
    const auto& gains = s.receptors.fa2_gains;
    need(gains[0] == -gains[1], "receptors.fa2_gains", gains[1], "the negative of the first one" + with);
}

void check_time(const Scene& s) {
    check_rows("time.", s.time);
    need(finite(s.time.duration) && s.time.duration >= s.time.step, "time.duration", s.time.duration,
         "at least time.step = " + shortest(s.time.step) + " s");
    const double times = s.time.duration / s.time.step;
    const double bytes = times * 8 * (s.output.traces.size() * (3 + s.output.probes.size()) + s.sites.size());
    need(times <= 1e8 && bytes <= 8e9, "time.step", s.time.step,
         "duration/step = " + shortest(times) +
             " outputs of the traces and sites asked for must be at most 1e8 and fit into 8 GB");
}

// A file or a column is written once, of a quantity that a key takes.
void check_quantities(const char* parameter, const Range& taken, std::vector<Quantity> list, const char* hint,
                      const std::string& at = {}) {
    std::ranges::sort(list);
    if (const auto other = std::ranges::find_if_not(list, taken.holds, [](Quantity q) { return double(q); });
        other != list.end())
        refuse(parameter, std::string("\"") + name(*other) + "\"", quoted_names<Quantity>(taken.holds) + hint);
    if (const auto twice = std::ranges::adjacent_find(list); twice != list.end())
        refuse(parameter, std::string("\"") + name(*twice) + "\" twice" + at, "each quantity once");
}

void check_output(const Scene& s) {
    for (size_t i = 0; i < s.output.probes.size(); ++i)
        need_inside("output.probes[" + std::to_string(i) + "]", s.output.probes[i], s.grid);
    check_sites(s);
    check_quantities("output.traces", traced, s.output.traces, "; curvature and deformation as fields");
    std::map<double, std::vector<Quantity>> fields; // of each time
    for (const FieldRequest& f : s.output.fields) {
        need(finite(f.at) && f.at >= 0 && f.at <= s.time.duration, "output.fields.at", f.at,
             "0.." + shortest(s.time.duration) + ", within time.duration");
        const double n = std::round(f.at / s.time.step);
        const bool at_output = snapped(f.at, s.time.step) == Instant::multiple(n, s.time.step);
        need(s.method == Method::exact || (at_output && n < double(outputs(s.time))), "output.fields.at", f.at,
             std::string("an output time (a multiple of time.step, before duration) with method = \"") +
                 name(s.method) + "\"");
        std::vector<Quantity>& of_time = fields[f.at];
        of_time.insert(of_time.end(), f.what.begin(), f.what.end());
    }
    for (const auto& [at, what] : fields)
        check_quantities("output.fields.what", of_fields, what,
                         "; indentation is thickness*strain, and a Skin's response", " at " + shortest(at) + " s");
}

// Fills in models and cells of nerve fibres.
void check_afferents(Scene& s) {
    if (s.afferents.empty()) return;
    need_exact(s, "afferents");
    s.afferents = validated_afferents(s, std::move(s.afferents));
    const bool rests = is_uniform(s.material) && modulus_at_rest(chain_of(s.material)) > 0 &&
                       (s.load.control == Control::pressure || has_spring(s.material));
    for (size_t i = 0; !rests && i < s.afferents.size(); ++i)
        if (follows_stress(s.receptors, s.afferents[i]))
            refuse("afferents[" + std::to_string(i) + "].follow", "\"stress\"",
                   "\"strain\", unless all cells have one material that comes to rest, and a spring in series with "
                   "load.control = \"depth\"");
}

// Opens the file of a sequence, or makes the frames of a texture or a ball; null with any other load.
std::shared_ptr<Frames> open_frames(const Scene& s) {
    if (!is_framed(s.load)) return nullptr;
    if (s.load.kind == Load::Kind::ball) return ball_frames(s);
    std::shared_ptr<Frames> frames;
    if (s.load.texture) frames = texture_frames(s);
    else if (s.load.taxels) frames = taxel_frames(s);
    else frames = std::make_shared<NpyFile>(s.load.path, s.grid.width, s.grid.height, true, "load.path");
    return presses_cells(s.load) ? pressed_frames(s, std::move(frames)) : frames;
}

} // namespace

bool wants(const Scene& s, Quantity q) {
    const Output& o = s.output;
    const auto in = [q](const std::vector<Quantity>& list) { return std::count(list.begin(), list.end(), q) > 0; };
    return in(o.traces) || std::ranges::any_of(s.sites, [q](auto& site) { return site.type == q; }) ||
           std::ranges::any_of(o.fields, [&](auto& f) { return in(f.what); });
}

long long steps_per_frame(double interval, double step) {
    const double ratio = interval / step, whole = std::round(ratio);
    return whole >= 1 && whole <= 1e9 && std::abs(ratio - whole) <= 4 * 0x1p-52 * whole ? static_cast<long long>(whole)
                                                                                        : 0;
}

long long outputs(const Time& t) { return static_cast<long long>(std::ceil(t.duration / t.step - 1e-9)); }

ValidatedScene validate(const Scene& scene) {
    Scene s = scene;
    check_grid(s.grid);
    check_rows("", s);
    check_time(s);
    check_surface(s);
    check_lengths(s);
    check_load(s);
    check_sum(s);
    std::shared_ptr<Frames> frames = open_frames(s);
    check_method(s);
    check_output(s);
    check_afferents(s);
    return {std::move(s), std::move(frames)};
}

} // namespace dermis::scene

const char* dermis::name(Method m) noexcept { return scene::text_of(m); }
const char* dermis::name(Model m) noexcept { return scene::text_of(m); }
