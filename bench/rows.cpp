// SPDX-License-Identifier: MIT
#include "bench/rows.hpp"

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <map>
#include <sstream>

#include <fmt/format.h>

namespace bench {
namespace {

constexpr const char* header =
    "schema,commit,date,device,device_uuid,driver,driver_version,exact,backend,threads,workload,width,height,steps,"
    "receptors,model,method,precision,stencil,dt_over_tau,bytes_per_cell,flops_per_cell,wall_median_s,wall_q1_s,"
    "wall_q3_s,gpu_median_s,runs,limit,limit_GBs,of_limit,err_strain,err_sa1,err_sa2,err_fa1,err_fa2,err_curvature,"
    "status";

std::string number(double x) { return std::isnan(x) ? "" : fmt::format("{:.6g}", x); }
std::string exactly(double x) { return std::isnan(x) ? "" : fmt::format("{}", x); }
std::string count(long long n) { return n ? std::to_string(n) : ""; }
std::string text(std::string s) {
    std::replace(s.begin(), s.end(), ',', ';');
    return s;
}

using Columns = std::map<std::string, std::string>;

std::vector<Columns> rows_of(const std::string& csv) {
    std::istringstream lines(csv);
    std::string line, cell;
    std::getline(lines, line);
    std::vector<std::string> names;
    for (std::istringstream in(line); std::getline(in, cell, ',');) names.push_back(cell);
    std::vector<Columns> rows;
    while (std::getline(lines, line)) {
        Columns& row = rows.emplace_back();
        std::istringstream in(line);
        for (const std::string& name : names) {
            cell.clear();
            std::getline(in, cell, ',');
            row[name] = cell;
        }
    }
    return rows;
}

std::string key(Columns row) {
    std::string key;
    for (const char* name : {"device", "backend", "threads", "workload", "width", "height", "steps", "receptors",
                             "model", "method", "precision", "stencil", "dt_over_tau"})
        key += (key.empty() ? "" : " ") + row[name];
    return key;
}

double value(const std::string& text) { return text.empty() ? NAN : std::atof(text.c_str()); }

} // namespace

Timing timing_of(std::vector<double> seconds) {
    std::sort(seconds.begin(), seconds.end());
    const auto at = [&](double part) { return seconds[size_t(part * double(seconds.size() - 1) + 0.5)]; };
    return {at(0.5), at(0.25), at(0.75), int(seconds.size())};
}

void Measurement::against(const std::string& name, double GBs) {
    limit = name;
    limit_GBs = GBs;
    of_limit = bytes_per_cell * double(width * height * steps) / wall.median / 1e9 / GBs;
}

std::string csv_of(const std::vector<Measurement>& rows, const std::string& commit) {
    char date[32];
    const std::time_t now = std::time(nullptr);
    std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
    std::string csv = std::string(header) + "\n";
    for (const Measurement& r : rows) {
        csv += fmt::format("1,{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                           commit, date, text(r.device), r.device_uuid, text(r.driver), text(r.driver_version), r.exact,
                           r.backend, r.threads, r.workload, count(r.width), count(r.height), count(r.steps),
                           count(r.receptors), r.model, r.method, r.precision, r.stencil, number(r.dt_over_tau),
                           number(r.bytes_per_cell), number(r.flops_per_cell), number(r.wall.median), number(r.wall.q1),
                           number(r.wall.q3), number(r.gpu_median), count(r.wall.runs), r.limit, number(r.limit_GBs),
                           number(r.of_limit));
        for (double e : r.errors) csv += "," + exactly(e);
        csv += "," + r.status + "\n";
    }
    return csv;
}

std::vector<std::string> lost(const std::string& earlier_csv, const std::string& csv) {
    std::map<std::string, Columns> now;
    for (const Columns& row : rows_of(csv)) now[key(row)] = row;
    std::vector<std::string> complaints;
    for (Columns before : rows_of(earlier_csv)) {
        const std::string name = key(before);
        const auto found = now.find(name);
        if (found == now.end()) {
            complaints.push_back(name + ": the row is lost");
            continue;
        }
        Columns& row = found->second;
        for (const char* error : {"err_strain", "err_sa1", "err_sa2", "err_fa1", "err_fa2", "err_curvature"})
            if (before["exact"] == "true" && row["exact"] == "true" && before[error] != row[error])
                complaints.push_back(name + ": " + error + " was " + before[error] + ", is " + row[error]);
        if (row["exact"] != before["exact"])
            complaints.push_back(name + ": exact was " + before["exact"] + ", is " + row["exact"]);
        const double was = value(before["of_limit"]), is = value(row["of_limit"]);
        const double range = (value(before["wall_q3_s"]) - value(before["wall_q1_s"])) / value(before["wall_median_s"]);
        if (is < was * (1 - 0.1 - 2 * range))
            complaints.push_back(fmt::format("{}: of_limit was {:.3g}, is {:.3g}", name, was, is));
        if (before["status"] == "ok" && row["status"] != "ok") complaints.push_back(name + ": " + row["status"]);
    }
    return complaints;
}

} // namespace bench
