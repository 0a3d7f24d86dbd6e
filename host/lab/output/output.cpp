// SPDX-License-Identifier: MIT
#include "host/lab/output/output.hpp"

#include "host/core/base/text.hpp"
#include "host/lab/output/earlier.hpp"
#include "host/lab/scenes/scene_names.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <list>

#include <fmt/format.h>

namespace dermis::output {
namespace {

std::string traces_csv(const Result& r) {
    std::string out = "time";
    const std::vector<TraceColumn> columns = trace_columns(r);
    for (const TraceColumn& column : columns) out += "," + column.name;
    out += '\n';
    out.reserve(out.size() + r.time.size() * (columns.size() + 1) * 20); // bytes of most numbers
    for (size_t n = 0; n < r.time.size(); ++n) {
        append_shortest(out, r.time[n]);
        for (const TraceColumn& column : columns) append_shortest(out += ',', (*column.values)[n]);
        out += '\n';
    }
    return out;
}

std::string impulses_csv(const Result& r) {
    const bool extremes = r.impulses.empty() || !std::isnan(r.impulses[0].min);
    std::string out = extremes ? "time,quantity,mean,min,max" : "time,quantity,mean";
    const size_t probes = r.impulses.empty() ? 0 : r.impulses[0].probes.size();
    for (size_t p = 0; p < probes; ++p) out += fmt::format(",probe{}", p);
    out += '\n';
    for (const Impulse& i : r.impulses) {
        append_shortest(out, i.time);
        (out += ',') += name(i.quantity);
        append_shortest(out += ',', i.mean);
        for (double v : {i.min, i.max})
            if (extremes) append_shortest(out += ',', v);
        for (double v : i.probes) append_shortest(out += ',', v);
        out += '\n';
    }
    return out;
}

std::string receptors_csv(const Scene& scene) {
    std::string list = scene.grid.spacing ? "id,type,x,y,x_m,y_m\n" : "id,type,x,y\n";
    for (size_t i = 0; i < scene.sites.size(); ++i) {
        const Cell cell = scene.sites[i].cell;
        fmt::format_to(std::back_inserter(list), "{},{},{},{}", i, name(scene.sites[i].type), cell.x, cell.y);
        for (int at : {cell.x, cell.y}) // the middle of the cell
            if (scene.grid.spacing) append_shortest(list += ',', (at + 0.5) * *scene.grid.spacing);
        list += '\n';
    }
    return list;
}

// Of float64, shape (height, width).
std::string npy_of(const std::vector<double>& map, int width, int height) {
    std::string content = npy_header("'<f8'", fmt::format("({}, {})", height, width));
    content.append(reinterpret_cast<const char*>(map.data()), map.size() * sizeof(double));
    return content;
}

struct Fibre {
    size_t entry; // of Scene::afferents
    Quantity type;
    double x, y; // cells: its site, around which its endings were drawn, or the mean of its endings
    long long spikes;
};

std::vector<Fibre> fibres_of(const Scene& s, const Result& r) {
    std::vector<Fibre> fibres;
    for (size_t i = 0; i < s.afferents.size(); ++i) {
        const Afferents& a = s.afferents[i];
        std::vector<Cell> cells = a.cells;
        for (const Site& site : s.sites)
            if (a.cells.empty() && site.type == a.type) cells.push_back(site.cell);
        const int listed = a.radius ? 1 : a.endings;
        for (size_t n = 0; n < cells.size(); ++n) {
            if (n % size_t(listed) == 0) fibres.push_back({i, a.type, 0, 0, 0});
            fibres.back().x += double(cells[n].x) / listed;
            fibres.back().y += double(cells[n].y) / listed;
        }
    }
    for (const FiredSpike& spike : r.spikes) ++fibres[size_t(spike.afferent)].spikes;
    return fibres;
}

// A structured array.
std::string spikes_npy(const Result& r) {
    std::string file = npy_header("[('time', '<f8'), ('afferent', '<u4')]", fmt::format("({},)", r.spikes.size()));
    for (const FiredSpike& spike : r.spikes) {
        const uint32_t afferent = uint32_t(spike.afferent);
        file.append(reinterpret_cast<const char*>(&spike.time), sizeof spike.time);
        file.append(reinterpret_cast<const char*>(&afferent), sizeof afferent);
    }
    return file;
}

std::string afferents_csv(const Scene& s, const Result& r) {
    std::string out = "number,class,x,y,spikes,rate\n";
    size_t number = 0;
    for (const Fibre& f : fibres_of(s, r))
        fmt::format_to(std::back_inserter(out), "{},{},{},{},{},{}\n", number++, name(f.type), shortest(f.x),
                       shortest(f.y), f.spikes, shortest(double(f.spikes) / s.time.duration));
    return out;
}

// The bins are of the longer of Time::step and 1 ms; the last one ends with the run.
std::string psth_csv(const Scene& s, const Result& r) {
    const double bin = std::max(s.time.step, 1e-3);
    const size_t bins = size_t(std::max(1.0, std::ceil(s.time.duration / bin - 1e-9))), entries = s.afferents.size();
    const std::vector<Fibre> fibres = fibres_of(s, r);
    std::vector<double> spikes(bins * entries), count(entries);
    for (const Fibre& f : fibres) ++count[f.entry];
    for (const FiredSpike& spike : r.spikes) {
        const size_t at = std::min(bins - 1, size_t(spike.time / bin));
        ++spikes[at * entries + fibres[size_t(spike.afferent)].entry];
    }
    std::string out = "time";
    for (size_t e = 0; e < entries; ++e) out += fmt::format(",{}_{}", name(s.afferents[e].type), e);
    out += '\n';
    for (size_t i = 0; i < bins; ++i) {
        const double start = double(i) * bin, length = std::min(bin, s.time.duration - start);
        append_shortest(out, start);
        for (size_t e = 0; e < entries; ++e) append_shortest(out += ',', spikes[i * entries + e] / (count[e] * length));
        out += '\n';
    }
    return out;
}

std::string field_name(Quantity quantity, double at) { return fmt::format("{}_t{}.npy", name(quantity), shortest(at)); }

// Returns the summary of a result, behind its first keys.
Json summary_of(const Scene& s, const Result& r, Json json) {
    const auto known = [](auto number, bool is) { return is ? Json(number) : Json(); };
    const auto given = [](const auto& number) { return number ? Json(*number) : Json(); };
    DERMIS_KEYS(json["device"], r.device, name, kind, driver, uuid, exact);
    Json& plan = json["plan"];
    DERMIS_KEYS(plan, r, model);
    DERMIS_KEYS(plan, s, method);
    DERMIS_KEYS(plan, r, precision, predicted_error, measured_error, measured_cells, unmeasured);
    DERMIS_KEYS(json["grid"], s.grid, width, height);
    json["grid"]["spacing"] = given(s.grid.spacing);
    Json& loads = json["loads"] = Json::array();
    for (size_t i = 0; i <= s.more_loads.size(); ++i) {
        const Load& l = i ? s.more_loads[i - 1] : s.load;
        Json load = {{"kind", scene::text_of(l.kind)}, {"control", scene::text_of(l.control)}};
        load.update({{"intensity", l.intensity}, {"envelope", scene::text_of(l.envelope.kind)}});
        load["center"] = l.center ? Json{l.center->x, l.center->y} : Json();
        load.update({{"radius", given(l.radius)}, {"radius_y", given(l.radius_y)}});
        loads.push_back(load);
    }
    json["pattern"] = Json();
    if (const auto pattern = moving_pattern(s)) DERMIS_KEYS(json["pattern"], *pattern, velocity, repeat);
    DERMIS_KEYS(json, r, steps, left_out);
    json["outputs"] = r.time.size();
    DERMIS_KEYS(json, r, dispatches, seconds);
    json["cross_check"] = Json();
    if (r.cells_compared) json["cross_check"] = {{"cells", r.cells_compared}, {"different", r.cells_different}};
    DERMIS_KEYS(json, r, tau_min, tau_max);
    json["z_min"] = s.time.step / r.tau_max;
    json["z_max"] = s.time.step / r.tau_min;
    DERMIS_KEYS(json, r, greatest_gain, greatest_curvature, stencil_estimate);
    json["kinks"] = known(r.kinks, r.kinks >= 0);
    json["pressed_cells"] = known(r.pressed_cells, r.pressed_cells >= 0);
    json["spikes"] = known(r.spikes.size(), !s.afferents.empty());
    json["outcomes"] = Json::object();
    for (const auto& [name, value] : outcomes(r)) json["outcomes"][name] = value;
    json["report"] = report(s, r);
    json["warnings"] = warnings(s, r);
    return json;
}

} // namespace

std::string npy_header(const std::string& descr, const std::string& shape) {
    std::string header = fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': {}, }}", descr, shape);
    header.resize((10 + header.size() + 1 + 63) / 64 * 64 - 10 - 1, ' ');
    header += '\n';
    std::string content("\x93NUMPY\x01\x00", 8);
    content += char(header.size() & 255);
    content += char(header.size() >> 8);
    return content + header;
}

std::vector<std::string> result_files(const Scene& scene) {
    std::vector<std::string> names = {"traces.csv", "impulses.csv"};
    for (const FieldRequest& f : scene.output.fields)
        for (Quantity quantity : f.what) names.push_back(field_name(quantity, f.at));
    if (!scene.sites.empty()) names.insert(names.end(), {"receptors.csv", "responses.npy"});
    if (!scene.afferents.empty()) names.insert(names.end(), {"spikes.npy", "afferents.csv", "psth.csv"});
    names.push_back("summary.json");
    return names;
}

void write_result(const Folder& folder, const Scene& scene, const Result& result, Json origin) {
    const Path& out = folder.path();
    // Known before anything is written, because there may be no memory to find it out later.
    const EarlierRun earlier = earlier_run(out, result_files(scene));
    PartFile unfinished(out / "summary.json", made_by_dermis + "\n  \"unfinished\": true\n}\n");
    std::list<PartFile> parts;
    std::vector<Contents> files;
    const auto add = [&](const std::string& name, const std::string& content) {
        parts.emplace_back(out / name, content);
        files.push_back({name});
        files.back().add(content.data(), content.size());
    };
    add("traces.csv", traces_csv(result));
    add("impulses.csv", impulses_csv(result));
    for (const Field& f : result.fields)
        add(field_name(f.quantity, f.at), npy_of(f.values, scene.grid.width, scene.grid.height));
    if (!scene.sites.empty()) {
        add("receptors.csv", receptors_csv(scene));
        add("responses.npy", npy_of(result.responses, int(scene.sites.size()), int(result.time.size())));
    }
    if (!scene.afferents.empty()) {
        add("spikes.npy", spikes_npy(result));
        add("afferents.csv", afferents_csv(scene, result));
        add("psth.csv", psth_csv(scene, result));
    }
    std::ranges::sort(files, {}, &Contents::name);
    origin["files"] = files;
    add("summary.json", sealed(summary_of(scene, result, std::move(origin))));
    // A kill from here on leaves files of two runs, and the summary that says so.
    const HeldSignals signals;
    if (earlier.owned) unfinished.publish(signals);
    for (const Path& path : earlier.files) remove_file(path);
    for (PartFile& part : parts) part.publish(signals);
}

std::string spikes_line(const Scene& s, const Result& r) {
    const std::vector<Fibre> fibres = fibres_of(s, r);
    if (fibres.empty()) return "";
    const auto most = std::ranges::max_element(fibres, {}, &Fibre::spikes);
    return fmt::format("{} spikes of {} afferents, at most {:.4g} Hz of number {}, {} at cell [{}, {}]",
                       r.spikes.size(), fibres.size(), double(most->spikes) / s.time.duration, most - fibres.begin(),
                       name(most->type), shortest(most->x), shortest(most->y));
}

void Progress::clear() {
    if (showing_) fmt::print(to_, "\r\033[K");
    showing_ = false;
}

void Progress::operator()(double done) {
    const auto now = std::chrono::steady_clock::now();
    if (now - start_ < std::chrono::seconds(1) || now - shown_ < std::chrono::milliseconds(100) || !on_terminal_)
        return;
    shown_ = now;
    showing_ = true;
    const double passed = std::chrono::duration<double>(now - start_).count(); // s
    fmt::print(to_, "\r\033[K{} {:3.0f} %, {:.0f} s left", what_, 100 * done,
               passed * (1 - done) / std::max(done, 1e-3));
}

} // namespace dermis::output
