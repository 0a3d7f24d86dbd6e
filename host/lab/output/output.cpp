// SPDX-License-Identifier: MIT
#include "host/lab/output/output.hpp"

#include "host/core/base/text.hpp"
#include "host/lab/output/earlier.hpp"

#include <iterator>
#include <list>

#include <fmt/format.h>

namespace dermis::output {
namespace {

void append(std::string& line, double value) {
    line += ',';
    append_shortest(line, value);
}

std::string traces_csv(const Result& r) {
    std::string out = "time";
    const std::vector<TraceColumn> columns = trace_columns(r);
    for (const TraceColumn& column : columns) out += "," + column.name;
    out += '\n';
    out.reserve(out.size() + r.time.size() * (columns.size() + 1) * 20); // bytes of most numbers
    for (size_t n = 0; n < r.time.size(); ++n) {
        append_shortest(out, r.time[n]);
        for (const TraceColumn& column : columns) append(out, (*column.values)[n]);
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
        append(out, i.mean);
        for (double v : {i.min, i.max})
            if (extremes) append(out, v);
        for (double v : i.probes) append(out, v);
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
            if (scene.grid.spacing) append(list, (at + 0.5) * *scene.grid.spacing);
        list += '\n';
    }
    return list;
}

std::string field_name(Quantity quantity, double at) { return fmt::format("{}_t{}.npy", name(quantity), shortest(at)); }

// Returns the summary of a result, behind its first keys.
Json summary_of(const Scene& s, const Result& r, Json json) {
    const auto known = [](auto number, bool is) { return is ? Json(number) : Json(); };
    DERMIS_KEYS(json["device"], r.device, name, kind, driver, uuid, exact);
    Json& plan = json["plan"];
    DERMIS_KEYS(plan, r, model);
    DERMIS_KEYS(plan, s, method);
    DERMIS_KEYS(plan, r, precision, predicted_error, measured_error, measured_cells, unmeasured);
    DERMIS_KEYS(json["grid"], s.grid, width, height);
    json["grid"]["spacing"] = known(s.grid.spacing.value_or(0), s.grid.spacing.has_value());
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

std::string npy_of(const std::vector<double>& map, int width, int height) {
    std::string content = npy_header("'<f8'", fmt::format("({}, {})", height, width));
    content.append(reinterpret_cast<const char*>(map.data()), map.size() * sizeof(double));
    return content;
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
    add_files(origin, files);
    add("summary.json", sealed(summary_of(scene, result, std::move(origin))));
    // A kill from here on leaves files of two runs, and the summary that says so.
    const HeldSignals signals;
    if (earlier.owned) unfinished.publish(signals);
    for (const Path& path : earlier.files) remove_file(path);
    for (PartFile& part : parts) part.publish(signals);
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
    fmt::print(to_, "\r\033[K{} {:3.0f} %", what_, 100 * done);
}

} // namespace dermis::output
