// SPDX-License-Identifier: MIT
#include "tests/oracle/search.hpp"

#include "tests/oracle/mutation.hpp"
#include "tests/oracle/scene_files.hpp"

#include <atomic>
#include <chrono>
#include <future>
#include <mutex>
#include <sstream>
#include <thread>

#include <mpfr.h>
#include <unistd.h>

namespace oracle {

using namespace dermis;

namespace {

constexpr int most_in_vain = 150; // changes of a climb that bring nothing, one after another

const std::pair<Model, Precision> kinds[] = {
    {Model::moments, Precision::f64}, {Model::maps, Precision::f64},  {Model::sites, Precision::f64},
    {Model::march, Precision::f32},   {Model::march, Precision::f64}, {Model::march, Precision::f32_compensated},
};

// Whether a scene has so many rows, pulses or frames that it is left out, or times that are none.
bool costly(const Scene& s) {
    const double least = s.time.duration / 1000;
    const Envelope& e = s.load.envelope;
    return !(s.time.step > least) || (e.kind == Envelope::Kind::pulse && !(e.period > least)) ||
           (s.load.interval && !(*s.load.interval > least));
}

// Makes a scene one that a model can serve, where it is not far from it. Materials that differ may still rule it out.
void serve_by(Case& c, Model model, Precision precision) {
    Scene& s = c.scene;
    s.model = model;
    s.precision = precision;
    s.method = Method::exact;
    if (model == Model::sites) {
        s.output.traces.clear();
        s.output.fields.clear();
        if (s.sites.empty()) s.sites.push_back({Quantity::sa1, {0, 0}});
    } else if (s.output.traces.empty() && s.output.fields.empty() && s.sites.empty()) {
        s.output.traces = {Quantity::strain};
    }
    if (model == Model::moments) s.output.fields.clear();
    if (model == Model::moments || model == Model::maps) s.receptors.fa2_gains[1] = -s.receptors.fa2_gains[0];
}

// A small scene to begin with.
Case beginning(unsigned seed, Model model, Precision precision) {
    for (;; seed += 1000003) {
        Family family(seed);
        Case c = seed / std::size(kinds) % 4 == 3 ? family.next_sparse() : family.next();
        const Scene& s = c.scene;
        const bool product = model == Model::moments || model == Model::maps;
        if (product && (!c.frames.empty() || !s.material.modulus_map.empty())) continue;
        crop(c, std::min(s.grid.width, 6), std::min(s.grid.height, 4));
        c.scene.time.duration = std::min(s.time.duration, 60 * s.time.step);
        std::erase_if(c.scene.output.fields, [&](const FieldRequest& f) { return f.at > s.time.duration; });
        c.scene.tolerance.reset();
        serve_by(c, model, precision);
        if (std::isfinite(ratio_of(c))) return c;
    }
}

// Takes changes that lower the ratio until many bring nothing, the bound is broken or the time is over.
template <class Over> Found climb(unsigned seed, const Over& over) {
    Found f;
    std::tie(f.model, f.precision) = kinds[seed % std::size(kinds)];
    f.seed = seed;
    f.scene = beginning(seed, f.model, f.precision);
    f.ratio = ratio_of(f.scene);
    Mutation mutation(seed);
    for (int in_vain = 0; in_vain < most_in_vain && f.ratio >= 1 && !over(); ++in_vain, ++f.scenes) {
        Case c = f.scene;
        mutation.change(c);
        serve_by(c, f.model, f.precision);
        const double ratio = ratio_of(c);
        if (!(ratio <= f.ratio)) continue;
        if (ratio < 0.999 * f.ratio) in_vain = 0;
        f.ratio = ratio;
        f.scene = std::move(c);
    }
    return f;
}

} // namespace

double ratio_of(Case c) {
    if (costly(c.scene) || undecided(c.scene)) return HUGE_VAL;
    std::ostringstream name;
    name << "dermis_search_" << getpid() << "_" << std::this_thread::get_id() << ".npy";
    const std::filesystem::path path = std::filesystem::temp_directory_path() / name.str();
    if (!c.frames.empty()) {
        c.scene.load.path = path.string();
        write_frames(path, c.scene.grid, c.frames);
    }
    const Verdict v = judge(c);
    std::filesystem::remove(path);
    if (!v.failure.empty() || !v.accepted || v.measured.value == 0) return HUGE_VAL;
    if (!(v.predicted < 1)) return HUGE_VAL; // promises nothing
    return v.predicted / v.measured.value;
}

Case shrunk(Case c) {
    for (bool again = true; again;) {
        again = false;
        for (Case& less : simpler(c)) {
            if (ratio_of(less) >= 1) continue;
            c = std::move(less);
            again = true;
            break;
        }
    }
    return c;
}

std::vector<Found> search(double seconds, unsigned seed) {
    const auto start = std::chrono::steady_clock::now();
    const auto over = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > seconds;
    };
    std::vector<Found> best;
    for (const auto& [model, precision] : kinds) best.push_back({.model = model, .precision = precision, .scene = {}});
    std::mutex mutex;
    std::atomic<unsigned> next = seed;
    const auto work = [&] {
        while (!over()) {
            Found f = climb(next++, over);
            const std::lock_guard lock(mutex);
            Found& known = best[f.seed % std::size(kinds)];
            f.scenes += known.scenes;
            if (f.ratio < known.ratio) known = std::move(f);
            else known.scenes = f.scenes;
        }
        mpfr_free_cache(); // each thread has its own
    };
    std::vector<std::future<void>> threads;
    for (unsigned n = std::max(std::thread::hardware_concurrency(), 1u); n > 0; --n)
        threads.push_back(std::async(std::launch::async, work));
    for (std::future<void>& thread : threads) thread.get();
    return best;
}

} // namespace oracle
