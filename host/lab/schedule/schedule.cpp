// SPDX-License-Identifier: MIT
#include "host/lab/schedule/schedule.hpp"

#include "host/core/base/refusal.hpp"
#include "host/core/base/text.hpp"
#include "host/lab/scenes/waveform.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::model {
namespace {

// Widens the box to contain all cells that a map presses.
void widen(PressedBox& box, const std::vector<double>& map, int width, int height) {
    int first = box.first_column(), last = box.last_tile * TILE_CELLS;
    for (int y = 0; y < height; ++y) {
        const double* row = map.data() + size_t(y) * size_t(width);
        bool none = true; // no early exit, so that the loop vectorises
        for (int x = 0; x < width; ++x) none &= row[x] == 0;
        if (none) continue;
        box.first_row = std::min(box.first_row, y);
        box.last_row = std::max(box.last_row, y + 1);
        first = int(std::find_if(row, row + std::min(first, width), [](double v) { return v != 0; }) - row);
        for (int x = width; x > last; --x)
            if (row[x - 1] != 0) last = x;
    }
    box.first_tile = first / TILE_CELLS;
    box.last_tile = (last + TILE_CELLS - 1) / TILE_CELLS;
}

// The greatest |next[i] - last[i]|, in parts that are independent of each other, so that the loop vectorises.
double greatest_change(const std::vector<double>& last, const std::vector<double>& next) {
    double greatest[8] = {};
    size_t i = 0;
    for (; i + 8 <= next.size(); i += 8)
        for (size_t j = 0; j < 8; ++j) greatest[j] = std::max(greatest[j], std::abs(next[i + j] - last[i + j]));
    for (; i < next.size(); ++i) greatest[0] = std::max(greatest[0], std::abs(next[i] - last[i]));
    return *std::ranges::max_element(greatest);
}

// Reads every frame once, for its peaks and its pressed cells; NpyFile::read refuses values that are not finite.
void take_sequence(Schedule& s, const PreparedSkin& skin) {
    const double scale = std::abs(s.load.intensity);
    std::vector<double> frame, before, rest(skin.cells());
    s.pressure = rest;
    std::vector<double>& greatest = s.pressure.edit();
    if (scene::has_depth(skin.description.receptors) && !s.parabolic()) s.frame_roughness = 0;
    double most = 0; // change
    for (long long k = 0; k < s.sequence->maps(); ++k) {
        before.swap(frame);
        s.sequence->read(k, frame);
        if (!s.crests.empty()) scene::press_crests(s.load, s.crests, skin.width(), s.load.intensity, frame);
        const double peak = greatest_change(rest, frame);
        s.frame_peaks.push_back(scene::product(peak, scale));
        if (s.frame_roughness && peak > 0) {
            const std::vector<double> bent =
                laplacian(frame, without_spacing(skin.description.grid), skin.stencil, skin.edges);
            s.frame_roughness = std::max(*s.frame_roughness, greatest_change(rest, bent) / peak);
        }
        if (k > 0) s.frame_changes.push_back(scene::product(greatest_change(before, frame), scale));
        for (size_t i = 0; i < frame.size(); ++i) {
            greatest[i] = std::max(greatest[i], std::abs(frame[i]));
            if (k > 0 && std::abs(frame[i] - before[i]) > most)
                most = std::abs(frame[i] - before[i]), s.changed_most = i;
        }
    }
    for (double& p : greatest) p = scene::product(p, scale);
}

// Sets the half-spaces, and makes the maps below them.
void take_depths(Schedule& s, const PreparedSkin& skin, int threads) {
    const Receptors& receptors = skin.description.receptors;
    const Grid& grid = skin.description.grid;
    std::vector<const HalfSpace*> spaces; // each once
    for (const scene::ReceptorClass& c : scene::receptor_classes) {
        auto& space = s.half_space[size_t(c.type)];
        const std::optional<double> depth = receptors.depth.*c.depth;
        if (depth && s.wanted[size_t(c.type)]) {
            const Depth of{*depth, receptors.kernel.*c.kernel, receptors.poisson.value_or(0)};
            for (const auto& known : s.half_space)
                if (known && known->depth() == of) space = known;
            if (!space) spaces.push_back((space = std::make_shared<const HalfSpace>(grid, of)).get());
        }
    }
    if (spaces.empty() || s.framed) return;
    simd::Pool pool(simd::useful_threads(skin.cells(), threads));
    const auto take_stress = [&](Schedule& of) {
        std::vector<Map> maps;
        for (auto& map : stresses_of(of.pressure, grid, spaces, pool)) maps.push_back(std::move(map));
        of.half_space = s.half_space;
        for (size_t q = 0; q < s.stress.size(); ++q)
            for (size_t i = 0; i < spaces.size(); ++i)
                if (s.half_space[q].get() == spaces[i]) of.stress[q] = maps[i];
    };
    take_stress(s);
    for (Schedule& other : s.others) take_stress(other);
}

// Sets the times at which one of the products jumps.
void take_jumps(Schedule& s) {
    for (size_t i = 0; i < s.products(); ++i) {
        const scene::Waveform load(s.product(i).load.envelope, s.time);
        for (const scene::Knot& k : load.knots())
            if (k.left != k.right) s.jumps.push_back(k.time);
    }
    std::ranges::sort(s.jumps, [](auto& a, auto& b) { return a < b; });
    s.jumps.erase(std::unique(s.jumps.begin(), s.jumps.end()), s.jumps.end());
    for (Schedule& other : s.others) other.jumps = s.jumps;
}

} // namespace

// Sets what follows the stress. Under a given pressure the stress is the pressure; under a given depth it relaxes, as
// E(t) = equilibrium + sum of G e^(-t/tau): each term is G times the depth less that of an element with this tau.
void take_follow(Schedule& s, const Scene& scene) {
    s.follows[QUANTITY_SA1] = scene.receptors.follow.sa1 == Signal::stress;
    s.follows[QUANTITY_SA2] = scene.receptors.follow.sa2 == Signal::stress;
    if (!scene::follows_stress(scene.receptors)) return;
    const scene::Series series = scene::series_at(scene.material, 0);
    std::vector<KelvinVoigt> elements;
    for (size_t e = 0; e < series.length; ++e)
        elements.push_back({series.elements[e].modulus, series.elements[e].viscosity});
    if (std::ranges::all_of(elements, [](const KelvinVoigt& e) { return e.viscosity > 0; }))
        scene::refuse(
            "receptors.follow", "\"stress\"",
            "\"strain\" in a material without a spring in series: a step of its strain takes an infinite stress");
    const Relaxation r = relaxation_of(elements);
    if (r.equilibrium == 0)
        scene::refuse("receptors.follow", "\"stress\"",
                      "\"strain\" in a material with a dashpot, whose stress ends at 0");
    const bool depth = scene.load.control == Load::Control::depth;
    s.modes.push_back({.modulus = 1, .viscosity = 0});
    s.shares.push_back(1 / r.equilibrium);
    if (!depth) return;
    s.shares[0] = 1;
    for (size_t i = 0; i < r.moduli.size(); ++i) {
        s.modes.push_back({.modulus = 1, .viscosity = r.times[i]});
        s.shares.push_back(-r.moduli[i] / r.equilibrium);
        s.shares[0] += r.moduli[i] / r.equilibrium;
    }
}

// Of a load that is one product, or known by frames.
static Schedule make_one(const scene::ValidatedScene& validated, const PreparedSkin& skin, bool check) {
    const Scene& scene = validated.scene;
    Schedule s;
    s.method = scene.method;
    s.allow_unstable = scene.allow_unstable;
    s.load = scene.load;
    s.time = scene.time;
    s.output = scene.output;
    s.outputs = scene::outputs(scene.time);
    s.points = scene.output.probes;
    for (const Site& site : scene.sites) s.points.push_back(site.cell);
    for (int q = 0; q < REDUCED_MAPS; ++q) s.wanted[size_t(q)] = scene::wants(scene, Quantity(q));
    s.keeps_maps = check || !s.points.empty() || !scene.output.fields.empty();
    for (const FieldRequest& f : scene.output.fields) {
        s.field_times.push_back(scene::snapped(f.at, scene.time.step));
        for (Quantity q : f.what) s.derives |= q >= Quantity::curvature;
    }
    std::sort(s.field_times.begin(), s.field_times.end());
    s.field_times.erase(std::unique(s.field_times.begin(), s.field_times.end()), s.field_times.end());
    s.sequence = validated.frames;
    s.framed = s.sequence != nullptr;
    s.pressed = {.first_row = skin.height(), .last_row = 0, .first_tile = skin.tiles, .last_tile = 0}; // empty
    const bool crests = scene.load.contact == Load::Contact::crests;
    if (crests) s.crests = scene::crest_factors(scene, skin.heights);
    if (s.framed) take_sequence(s, skin);
    else s.pressure = scene::pressure_map(validated);
    if (crests && !s.framed) scene::press_crests(s.load, s.crests, skin.width(), 1, s.pressure.edit());
    widen(s.pressed, s.pressure, skin.width(), skin.height());
    if (s.pressed.last_row == 0) s.pressed = {};
    return s;
}

static Schedule make_schedule(const scene::ValidatedScene& validated, const PreparedSkin& skin, bool check) {
    if (!scene::is_sum(validated.scene)) return make_one(validated, skin, check);
    std::vector<Schedule> products;
    scene::ValidatedScene one = validated;
    for (Load& load : scene::products_of(validated.scene)) {
        one.scene.load = std::move(load);
        products.push_back(make_one(one, skin, check));
    }
    Schedule s = std::move(products.front());
    s.others.assign(std::make_move_iterator(products.begin() + 1), std::make_move_iterator(products.end()));
    take_jumps(s);
    return s;
}

PreparedRun prepare_run(const Scene& scene, bool check, int threads) {
    return prepare_run(scene::validate(scene), check, threads);
}

PreparedRun prepare_run(const scene::ValidatedScene& validated, bool check, int threads) {
    // In a braced list whose second member throws, GCC 12 would destroy the first one twice.
    SkinDescription description = validated.scene;
    if (validated.scene.load.control == Load::Control::depth) { // the load gives the strain, not the pressure
        scene::drop_maps(description.material);
        scene::take_chain(description.material, {{.modulus = 1, .viscosity = 0}});
    }
    PreparedSkin skin = prepare_skin(description, threads);
    Schedule schedule = make_schedule(validated, skin, check);
    take_follow(schedule, validated.scene);
    take_depths(schedule, skin, threads);
    return {.skin = std::move(skin), .schedule = std::move(schedule)};
}

Schedule with_fewer_outputs(const Schedule& schedule, long long most) {
    Schedule few = schedule;
    while ((few.outputs - 1) / few.every >= most) few.every *= 2;
    few.outputs = (few.outputs - 1) / few.every + 1;
    for (Schedule& other : few.others) other = with_fewer_outputs(other, most);
    return few;
}

PressedCells pressed_cells(const Schedule& schedule) {
    return {schedule.pressed, schedule.pressure.data(), schedule.spreads()};
}

Variant variant_of(const PreparedSkin& skin, const Schedule& schedule, Precision precision) {
    return {.stencil = skin.stencil,
            .edges = skin.edges,
            .compensated = precision != Precision::f32,
            .materials = !skin.uniform(),
            .framed = schedule.framed,
            .parabolic = schedule.parabolic(),
            .chain = skin.chain,
            .keeps_strain = skin.chain.length > 1,
            .wanted = schedule.wanted};
}

double unit_of(const std::vector<double>& map) {
    const auto greatest = [&](size_t stride) {
        double most = 0;
        for (size_t i = 0; i < map.size(); i += stride) most = std::max(most, std::abs(map[i]));
        return most;
    };
    const auto is_plain = [](double p) { return p > 0x1p-200 && p < 0x1p200; };
    if (is_plain(greatest(map.size() / 1024 + 1))) return 1; // some cells say so: most maps need no more
    const double most = greatest(1);
    return most == 0 || is_plain(most) ? 1 : std::ldexp(1, std::ilogb(most));
}

static void take_unit(Schedule& s) {
    const double unit = s.unit = unit_of(s.pressure);
    if (unit == 1) return;
    for (Map* map : {&s.pressure, &s.stress[QUANTITY_SA1], &s.stress[QUANTITY_SA2], &s.stress[QUANTITY_FA1],
                     &s.stress[QUANTITY_FA2]})
        if (!map->empty())
            for (double& p : map->edit()) p /= unit;
}

PreparedRun in_units(PreparedRun run) {
    take_unit(run.schedule);
    for (Schedule& other : run.schedule.others) take_unit(other);
    return run;
}

PreparedRun in_parts(PreparedRun run) {
    PreparedSkin& skin = run.skin;
    if (skin.uniform()) return run;
    Map pressure = std::vector<double>(skin.cells());
    double* quotient = pressure.edit().data();
    double least = INFINITY;
    for (size_t i = 0; i < skin.cells(); ++i) {
        const double by = scene::resistance(skin.materials[skin.material_at(i)]), p = run.schedule.pressure[i];
        quotient[i] = p / by;
        if (p != 0) least = std::min(least, by);
    }
    run.schedule.quantum = std::max(run.schedule.quantum / least, 0x1p-1074);
    run.schedule.pressure = pressure;
    for (int& material : skin.material_of) material = skin.part_of[size_t(material)];
    skin.materials.clear();
    for (const TimeGroup& part : skin.parts) skin.materials.push_back(part.element);
    if (skin.parts.size() == 1) skin.material_of.clear();
    else run.schedule.output.extremes = false; // see why_not(): no trace asks for them
    scene::drop_maps(skin.description.material);
    return run;
}

std::string why_not_separable(const PreparedSkin& skin, const Schedule& schedule) {
    const auto& gains = skin.description.receptors.fa2_gains;
    if (!skin.uniform() && skin.chain.length > 1) return "elements in series differ from cell to cell";
    if (!skin.uniform() && skin.parts.empty()) return "the material has more than 8 retardation times";
    if (schedule.framed) return "the load is not one map times an envelope";
    if (gains[0] != -gains[1]) return "receptors.fa2_gains make FA2 depend on its sign";
    return "";
}

std::vector<Element> elements_of(const PreparedSkin& skin, const Schedule& schedule) {
    std::vector<Element> all = skin.materials;
    all.insert(all.end(), schedule.modes.begin(), schedule.modes.end());
    return all;
}

std::string why_not(const PreparedSkin& skin, const Schedule& schedule, Model model) {
    const Output& o = schedule.output;
    if (!schedule.others.empty() && model == Model::march)
        return "the load is a sum of products with envelopes of their own; a march takes one";
    const bool framed_sites = schedule.framed && model == Model::sites;
    if (!schedule.modes.empty() && !framed_sites &&
        (model == Model::march || !why_not_separable(skin, schedule).empty()))
        return "receptors.follow: only a map times an envelope has a stress of its own, and sites under frames";
    if (model == Model::march) {
        for (const auto& space : schedule.half_space)
            if (space && !space->spreads())
                return "receptors.depth = " + shortest(space->depth().depth) +
                       ": a march spreads to a millionth up to a million times grid.spacing";
        return "";
    }
    if (model == Model::sites) {
        if (skin.description.sites.empty()) return "there are no sites";
        return o.traces.empty() && o.fields.empty() ? "" : "traces or fields of all cells are asked for";
    }
    if (model == Model::moments && !o.fields.empty()) return "fields are asked for";
    if (skin.parts.size() > 1 && o.extremes && !o.traces.empty())
        return "extremes of several retardation times are asked for";
    return why_not_separable(skin, schedule);
}

} // namespace dermis::model
