// SPDX-License-Identifier: MIT
#include "host/lab/output/output.hpp"

#include <fmt/ranges.h>

namespace dermis::output {
namespace {

struct Greatest {
    double value = 0;
    size_t row = 0; // of the result's times
    std::optional<Cell> cell;
    bool known = false;

    void take(double x, size_t at, std::optional<Cell> in = {}) {
        if (known && !(std::abs(x) > std::abs(value))) return;
        value = x, row = at, cell = in, known = true;
    }
};

Greatest greatest_of(Quantity q, const Scene& scene, const Result& r) {
    Greatest greatest;
    for (const Trace& t : r.traces)
        for (size_t n = 0; t.quantity == q && n < t.min.size(); ++n)
            greatest.take(t.min[n], n), greatest.take(t.max[n], n);
    if (greatest.known) return greatest;
    const std::vector<Site>& sites = scene.sites;
    for (size_t i = 0; i < r.responses.size(); ++i)
        if (const Site& site = sites[i % sites.size()]; site.type == q)
            greatest.take(r.responses[i], i / sites.size(), site.cell);
    return greatest;
}

} // namespace

std::vector<std::string> greatest_responses(const Scene& scene, const Result& r) {
    std::vector<std::string> lines;
    using Named = std::tuple<Quantity, const char*, const char*>; // with its unit
    for (const auto& pair : {std::array{Named{Quantity::sa1, "SA1", ""}, Named{Quantity::sa2, "SA2", " s"}},
                             std::array{Named{Quantity::fa1, "FA1", " 1/s"}, Named{Quantity::fa2, "FA2", " 1/s^2"}}}) {
        std::vector<std::string> parts;
        for (const auto& [q, called, unit] : pair) {
            const Greatest g = greatest_of(q, scene, r);
            if (!g.known) continue;
            parts.push_back(fmt::format("{} {:.4g}{} at {:.6g} s{}", called, g.value, unit, r.time[g.row],
                                        g.cell ? fmt::format(" in cell [{}, {}]", g.cell->x, g.cell->y) : ""));
        }
        if (!parts.empty()) lines.push_back(fmt::format("greatest {}", fmt::join(parts, ", ")));
    }
    return lines;
}

} // namespace dermis::output
