// SPDX-License-Identifier: MIT
// A result in few numbers.
#include "dermis/run.hpp"

#include <algorithm>
#include <cmath>

namespace dermis {

std::vector<TraceColumn> trace_columns(const Result& r) {
    std::vector<TraceColumn> columns;
    for (const Trace& t : r.traces)
        for (auto [statistic, values] : {std::pair{"_mean", &t.mean}, {"_min", &t.min}, {"_max", &t.max}})
            if (!values->empty()) columns.push_back({std::string(name(t.quantity)) + statistic, values});
    for (const Trace& t : r.traces)
        for (size_t p = 0; p < t.probes.size(); ++p)
            columns.push_back({std::string(name(t.quantity)) + "_probe" + std::to_string(p), &t.probes[p]});
    return columns;
}

std::vector<TraceOutcome> outcomes(const Result& r) {
    std::vector<TraceOutcome> all;
    for (const TraceColumn& column : trace_columns(r)) {
        const std::vector<double>& v = *column.values;
        const auto peak = std::ranges::max_element(v, {}, [](double x) { return std::abs(x); });
        if (peak == v.end()) continue;
        all.push_back({column.name + "_final", v.back()});
        all.push_back({column.name + "_peak", *peak});
        all.push_back({column.name + "_peak_time", r.time[size_t(peak - v.begin())]});
    }
    return all;
}

} // namespace dermis
