// SPDX-License-Identifier: MIT
#include "bench/rows.hpp"

#include <algorithm>
#include <ctime>

#include <fmt/format.h>

namespace bench {
namespace {

constexpr const char* header =
    "schema,commit,date,size,cpu,cores,compiler,device,device_uuid,driver,driver_version,exact,backend,threads,"
    "workload,width,height,steps,receptors,model,method,precision,stencil,dt_over_tau,bytes_per_cell,flops_per_cell,"
    "wall_least_s,wall_median_s,wall_q1_s,wall_q3_s,busy_least_s,gpu_median_s,runs,limit,limit_GBs,of_limit,ratio_to,"
    "ratio,err_"
    "strain,err_sa1,err_sa2,err_fa1,err_fa2,err_curvature,"
    "status";

std::string number(double x) { return std::isnan(x) ? "" : fmt::format("{:.6g}", x); }
std::string exactly(double x) { return std::isnan(x) ? "" : fmt::format("{}", x); }
std::string count(long long n) { return n ? std::to_string(n) : ""; }
std::string text(std::string s) {
    std::replace(s.begin(), s.end(), ',', ';');
    return s;
}

} // namespace

Timing timing_of(std::vector<double> seconds) {
    std::sort(seconds.begin(), seconds.end());
    const auto at = [&](double part) { return seconds[size_t(part * double(seconds.size() - 1) + 0.5)]; };
    return {.least = seconds.front(), .median = at(0.5), .q1 = at(0.25), .q3 = at(0.75), .runs = int(seconds.size())};
}

void Measurement::against(const std::string& name, double GBs) {
    limit = name;
    limit_GBs = GBs;
    of_limit = bytes() / wall.median / 1e9 / GBs;
}

void Measurement::relative_to(const std::string& name, const Timing& reference, double reference_bytes) {
    ratio_to = name;
    ratio = wall.busy / bytes() / (reference.busy / reference_bytes);
}

std::string csv_of(const std::vector<Measurement>& rows, const Origin& origin) {
    char date[32];
    const std::time_t now = std::time(nullptr);
    std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
    std::string csv = std::string(header) + "\n";
    for (const Measurement& r : rows) {
        const auto put = [&csv](const auto&... cells) {
            csv += fmt::format("{}", fmt::join(std::vector<std::string>{cells...}, ","));
        };
        put(std::to_string(schema), text(origin.commit), date, origin.size, text(origin.machine.cpu),
            std::to_string(origin.machine.cores), text(origin.machine.compiler), text(r.device), r.device_uuid,
            text(r.driver), text(r.driver_version), r.exact ? "true" : "false", r.backend, std::to_string(r.threads),
            r.workload, count(r.width), count(r.height), count(r.steps), count(r.receptors), r.model, r.method,
            r.precision, r.stencil, number(r.dt_over_tau), number(r.bytes_per_cell), number(r.flops_per_cell),
            number(r.wall.least), number(r.wall.median), number(r.wall.q1), number(r.wall.q3), number(r.wall.busy),
            number(r.gpu_median), count(r.wall.runs), r.limit, number(r.limit_GBs), number(r.of_limit), r.ratio_to,
            number(r.ratio));
        for (double e : r.errors) csv += "," + exactly(e);
        csv += "," + r.status + "\n";
    }
    return csv;
}

} // namespace bench
