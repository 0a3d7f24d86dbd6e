// SPDX-License-Identifier: MIT

#include "host/core/base/text.hpp"
#include "host/lab/output/output.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>

#include <fmt/format.h>

namespace dermis::output {
namespace {

struct Fibre {
    size_t entry; // of Scene::afferents
    Quantity type;
    double x, y; // cells: the mean of its endings
    long long spikes;
};

std::vector<Fibre> fibres_of(const Scene& s, const Result& r) {
    std::vector<Fibre> fibres;
    for (size_t i = 0; i < s.afferents.size(); ++i) {
        const Afferents& a = s.afferents[i];
        std::vector<Cell> cells = a.cells;
        for (const Site& site : s.sites)
            if (a.cells.empty() && site.type == a.type) cells.push_back(site.cell);
        for (size_t n = 0; n < cells.size(); ++n) {
            if (n % size_t(a.endings) == 0) fibres.push_back({i, a.type, 0, 0, 0});
            fibres.back().x += double(cells[n].x) / a.endings;
            fibres.back().y += double(cells[n].y) / a.endings;
        }
    }
    for (const FiredSpike& spike : r.spikes) ++fibres[size_t(spike.afferent)].spikes;
    return fibres;
}

} // namespace

std::string spikes_npy(const Result& r) {
    std::string file = npy_header("[('time', '<f8'), ('afferent', '<u4')]", fmt::format("({},)", r.spikes.size()));
    for (const FiredSpike& spike : r.spikes) {
        char record[12];
        const uint32_t afferent = uint32_t(spike.afferent);
        std::memcpy(record, &spike.time, 8);
        std::memcpy(record + 8, &afferent, 4);
        file.append(record, sizeof record);
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

std::string spikes_line(const Scene& s, const Result& r) {
    const std::vector<Fibre> fibres = fibres_of(s, r);
    if (fibres.empty()) return "";
    const auto most = std::ranges::max_element(fibres, {}, &Fibre::spikes);
    return fmt::format("{} spikes of {} nerve fibres, at most {:.4g} Hz of number {}, {} at cell [{}, {}]",
                       r.spikes.size(), fibres.size(), double(most->spikes) / s.time.duration, most - fibres.begin(),
                       name(most->type), shortest(most->x), shortest(most->y));
}

} // namespace dermis::output
