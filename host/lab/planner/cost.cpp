// SPDX-License-Identifier: MIT
#include "host/lab/planner/choice.hpp"

#include "host/core/model/site_cells.hpp"
#include "host/lab/march/stepper.hpp"

#include <algorithm>

namespace dermis::planner {
namespace {

using model::PreparedSkin;
using model::Schedule;

// Adds the map of pressure over stiffness.
void cost_quotient(Candidate& c, const PreparedSkin& skin) {
    if (skin.uniform()) return;
    const double cells = double(skin.cells());
    c.bytes += 12 * cells + 24 * double(skin.materials.size()); // with each cell's number, and the table of elements
    c.seconds += 4e-9 * cells;
}

// Adds the maps at depths, their weights, and the two planes in which maps are transformed.
void cost_depths(Candidate& c, const PreparedSkin& skin, const Schedule& schedule) {
    std::vector<const model::HalfSpace*> spaces;
    for (const auto& space : schedule.half_space)
        if (space && std::ranges::find(spaces, space.get()) == spaces.end()) spaces.push_back(space.get());
    if (spaces.empty()) return;
    const double cells = double(skin.cells()), maps = double(spaces.size());
    c.bytes += cells * (schedule.framed ? 8 * maps : 16 * maps + 2 * 4 * 16);
    if (schedule.framed && c.model == Model::sites)
        c.seconds += double(c.steps) * double(schedule.points.size()) * cells * 3e-10;
}

void cost_moments(Candidate& c, const PreparedSkin& skin, const Schedule& schedule) {
    const double cells = double(skin.cells()), steps = double(c.steps);
    const double fields = double(schedule.output.fields.size()), points = double(schedule.points.size());
    const double products = double(schedule.products()), parts = std::max(products, double(skin.parts.size()));
    c.bytes = cells * (8 + 8 * parts + 8 * fields);
    c.seconds = cells * (5e-9 + 1e-8 * parts + 4e-9 * fields) + steps * parts * (2e-7 + 2e-9 * points);
    if (products > 1) { // each is bent by all; extremes are of all cells at every output
        const double traces = schedule.output.extremes ? double(schedule.output.traces.size()) : 0;
        c.seconds += cells * products * (5e-9 * products + steps * 6e-10 * (traces > 0 ? 1 + traces : 0));
        c.bytes += 8 * cells * (traces > 0 ? products : 0);
    }
    cost_quotient(c, skin);
}

void cost_sites(Candidate& c, const PreparedSkin& skin, const Schedule& schedule, const model::Capabilities& cpu) {
    const double cells = double(skin.cells()), steps = double(c.steps), points = double(schedule.points.size());
    const double needed = double(model::SiteCells(skin, pressed_cells(schedule), schedule.points).cells.size());
    const bool separable = why_not_separable(skin, schedule).empty();
    const double elements = separable ? 1 : double(skin.chain.elements()); // each of which is stepped by itself
    c.bytes = cells * 16 + needed * 64 * elements + points * 300;
    c.seconds = separable ? points * double(schedule.products()) * (3e-7 + steps * 1e-8)
                          : steps * (needed * 4e-9 + points * 10e-9) * elements / cpu.threads;
    if (separable) cost_quotient(c, skin);
}

double precision_factor(Precision precision) {
    return precision == Precision::f32 ? 1 : precision == Precision::f32_compensated ? 1.2 : 1.9;
}

// Adds the maps of materials and the coefficients of each, which are made in double and rounded for every step.
void cost_materials(Candidate& c, const PreparedSkin& skin, const Schedule& schedule, double real,
                    const model::Capabilities& backend) {
    if (skin.uniform()) return;
    const Material& m = skin.description.material;
    const bool device = backend.double_buffered, rows = !device && skin.differs_everywhere();
    const double cells = double(skin.cells()), steps = double(c.steps), materials = double(skin.materials.size());
    const double in_double = sizeof(f64::Coefficients), rounded = in_double / sizeof(double) * real,
                 tables = rows     ? 0
                          : device ? 1
                                   : std::min(steps, double(model::steps_of_batch));
    double maps = !m.modulus_map.empty() + !m.viscosity_map.empty();
    for (const KelvinVoigt& e : m.elements) maps += !e.modulus_map.empty() + !e.viscosity_map.empty();
    const bool sine = !schedule.framed && schedule.load.envelope.kind == Envelope::Kind::sine;
    const double gains = sine ? sizeof(model::SineGains<double>) : 0;
    c.bytes += cells * (sizeof(int) + 8.0 * maps) +
               materials * (sizeof(model::Element) + in_double + gains + rounded * tables);
    if (device) return;
    c.seconds += (materials * 3e-7 + steps * cells * (!rows ? 4e-10 : sine ? 8e-9 : 6e-9)) / backend.threads;
}

void cost_march(Candidate& c, const PreparedSkin& skin, const Schedule& schedule, const model::Capabilities& backend) {
    const double cells = double(skin.cells()), steps = double(c.steps);
    const model::PressedBox& box = schedule.pressed;
    const double pressed =
        double(box.last_row - box.first_row) * std::min((box.last_tile - box.first_tile) * TILE_CELLS, skin.pitch);
    const bool buffered = backend.double_buffered;
    const double real = c.precision == Precision::f64 ? 8 : 4;
    const model::Variant variant = variant_of(skin, schedule, c.precision);
    model::StateShape shape = variant.state();
    shape.integral |= !buffered; // a device keeps it only if SA2 is asked for
    const double state = shape.planes();
    const double responses = double(std::count(schedule.wanted.begin() + QUANTITY_SA1, schedule.wanted.end(), true));
    const double batch = buffered ? 1 : std::min(steps, double(model::steps_of_batch));
    const double pressure = schedule.framed ? batch + 1 : 1; // maps that are held
    const auto jumps = [](const scene::Knot& k) { return k.right != k.left; };
    const bool peeks = !schedule.field_times.empty() || schedule.framed ||
                       std::ranges::any_of(scene::Waveform(schedule.load.envelope, schedule.time).knots(), jumps);
    const double held = buffered ? pressure + 1 + 2 * state + responses
                                 : pressure + 1 + (peeks ? 2 : 1) * state + (schedule.keeps_maps ? responses : 0);
    const double tiles = double(skin.tiles) * skin.height() * (responses + 1) * 3 * real;
    const double more = double(skin.chain.elements()) - 1; // elements in series
    // Surface, pressure and the strain at the end are in double.
    c.bytes = cells * (16 + 8) + real * double(skin.padded_cells()) * held + tiles * batch;
    c.seconds = steps * (2e-6 + pressed * precision_factor(c.precision) * backend.cell_step *
                                    (1 + (buffered ? 0.4 : 0.15) * more));
    cost_materials(c, skin, schedule, real, backend);
    // Spread on the host: a map of each class, and its levels.
    const double spread = cells * double(std::ranges::count_if(schedule.half_space, [](auto& s) { return bool(s); }));
    c.bytes += 3 * real * spread;
    c.seconds += steps * spread * 2e-9 * precision_factor(c.precision) / std::max(backend.threads, 1);
    if (backend.dispatch > 0) {
        c.dispatches = c.steps * (2 + static_cast<long long>(responses));
        c.seconds += double(c.dispatches) * backend.dispatch;
    }
}

} // namespace

void estimate_cost(Candidate& c, const PreparedSkin& skin, const Schedule& schedule,
                   const model::Capabilities& backend) {
    c.steps = schedule.outputs + (schedule.sequence ? std::max(0LL, schedule.sequence->maps() - schedule.outputs) : 0) +
              static_cast<long long>(schedule.field_times.size());
    if (c.model == Model::moments || c.model == Model::maps) cost_moments(c, skin, schedule);
    else if (c.model == Model::sites) cost_sites(c, skin, schedule, backend);
    else cost_march(c, skin, schedule, backend);
    cost_depths(c, skin, schedule);
}

} // namespace dermis::planner
