// SPDX-License-Identifier: MIT
// What fills a Result: collects the samples of a run, compares the bits of two runs, and fires nerve fibres.
#pragma once

#include "dermis/run.hpp"
#include "host/core/base/pool.hpp"
#include "host/core/base/text.hpp"
#include "host/lab/march/stepper.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace dermis {

// The quantities that a schedule wants, in order.
inline std::vector<Quantity> wanted_quantities(const model::Schedule& schedule) {
    std::vector<Quantity> list;
    for (int q = 0; q < REDUCED_MAPS; ++q)
        if (schedule.wanted[size_t(q)]) list.push_back(Quantity(q));
    return list;
}

class Collector {
  public:
    // every_cell: the run computes every cell, otherwise only the schedule's points.
    Collector(Result& result, const model::PreparedSkin& skin, const model::Schedule& schedule, bool every_cell)
        : result_(result), skin_(skin), schedule_(schedule), every_cell_(every_cell),
          wanted_(wanted_quantities(schedule)) {
        const Output& output = schedule.output;
        const size_t outputs = size_t(schedule.outputs);
        result.responses.reserve(outputs * skin.description.sites.size());
        simd::prefer_large_pages(result.responses.data(), result.responses.capacity() * sizeof(double));
        for (Quantity q : output.traces) {
            Trace& t = result.traces.emplace_back();
            t.quantity = q;
            t.probes.resize(output.probes.size());
            t.mean.reserve(outputs);
            if (output.extremes) t.min.reserve(outputs), t.max.reserve(outputs);
            for (auto& column : t.probes) column.reserve(outputs);
        }
    }

    void operator()(const model::Step& step, const model::Sample& sample) {
        for (Quantity q : wanted_)
            if (every_cell_) check_sample(sample, q, step.time);
        if (step.trace >= 0) {
            result_.time.push_back(step.time);
            take_traces(sample);
            take_sites(step, sample);
        }
        if (step.impulse >= 0 && every_cell_) take_impulses(step, sample);
    }

    // Throws Error::bad_input where a value is not finite, unless the schedule allows unstable steps.
    void check_finite(double value, Quantity q, double time) const {
        if (std::isfinite(value) || schedule_.allow_unstable) return;
        throw Error(
            Error::Code::bad_input, "",
            std::string(name(q)) + " overflows at t = " + shortest(time) + " s in " + name(result_.precision) +
                "; allowed: loads, materials and lengths whose results stay below 3.4e38 in f32, 1.8e308 in f64");
    }

  private:
    // A march's mean is finite only if every cell is; closed forms compute mean, extremes and probes each by itself.
    void check_sample(const model::Sample& sample, Quantity q, double time) const {
        const model::Totals& totals = sample.totals[size_t(q)];
        check_finite(totals.mean, q, time);
        if (schedule_.output.extremes) {
            check_finite(totals.min, q, time);
            check_finite(totals.max, q, time);
        }
        const double* points = sample.points.data() + size_t(q) * schedule_.points.size();
        for (size_t i = 0; i < schedule_.output.probes.size(); ++i) check_finite(points[i], q, time);
    }
    void take_traces(const model::Sample& sample) {
        for (Trace& t : result_.traces) {
            const size_t q = size_t(t.quantity);
            t.mean.push_back(sample.totals[q].mean);
            if (schedule_.output.extremes) {
                t.min.push_back(sample.totals[q].min);
                t.max.push_back(sample.totals[q].max);
            }
            const double* points = sample.points.data() + q * schedule_.points.size();
            for (size_t i = 0; i < t.probes.size(); ++i) t.probes[i].push_back(points[i]);
        }
    }
    void take_sites(const model::Step& step, const model::Sample& sample) {
        const std::vector<Site>& sites = skin_.description.sites;
        const double* points = sample.points.data() + schedule_.output.probes.size();
        const size_t first = result_.responses.size();
        bool finite = true;
        for (size_t i = 0; i < sites.size(); ++i) {
            const double v = points[size_t(sites[i].type) * schedule_.points.size() + i];
            result_.responses.push_back(v);
            finite &= std::isfinite(v);
        }
        for (size_t i = 0; !finite && i < sites.size(); ++i)
            check_finite(result_.responses[first + i], sites[i].type, step.time);
    }
    void take_impulses(const model::Step& step, const model::Sample& sample) {
        for (auto [quantity, elastic] : {std::pair{Quantity::fa1, true}, {Quantity::fa2, false}}) {
            if (!schedule_.wanted[size_t(quantity)]) continue;
            if (std::ranges::none_of(skin_.materials,
                                     [elastic = elastic](auto& m) { return is_elastic(m) == elastic; }))
                continue;
            const model::Totals& totals = sample.totals[size_t(quantity)];
            const bool extremes = schedule_.output.extremes;
            Impulse& i = result_.impulses.emplace_back();
            i.time = step.time;
            i.quantity = quantity;
            i.mean = totals.mean;
            i.min = extremes ? totals.min : NAN;
            i.max = extremes ? totals.max : NAN;
            const auto first = sample.points.begin() + std::ptrdiff_t(size_t(quantity) * schedule_.points.size());
            i.probes.assign(first, first + std::ptrdiff_t(schedule_.output.probes.size()));
        }
    }

    Result& result_;
    const model::PreparedSkin& skin_;
    const model::Schedule& schedule_;
    const bool every_cell_;
    const std::vector<Quantity> wanted_;
};

// Takes the steps of a march in float with a second one, and compares every cell of every output and every sample.
class CrossCheck {
  public:
    using MakeStepper = std::function<std::unique_ptr<model::Stepper>(model::Stepper::Sink)>;
    // Counts in `result` the cells that are compared and the cells that differ.
    CrossCheck(const MakeStepper& make, Result& result, const model::PreparedSkin& skin,
               const model::Schedule& schedule)
        : result_(result), skin_(skin), wanted_(wanted_quantities(schedule)),
          collect_(other_result_, skin, schedule, true), stepper_(make(std::ref(collect_))) {}

    void frame(const std::vector<double>& pressure) { stepper_->frame(pressure); }
    void press(const model::Step& step, model::Stepper& first) {
        stepper_->press(step);
        if (!step.respond()) return;
        std::vector<Quantity> read = wanted_;
        if (read.empty() || read[0] != Quantity::strain)
            read.insert(read.begin(), Quantity::strain); // every march has it
        first.read(read, ours_);
        stepper_->read(read, theirs_);
        for (size_t i = 0; i < read.size(); ++i) result_.cells_different += different(ours_[i], theirs_[i]);
        result_.cells_compared += static_cast<long long>(read.size() * skin_.cells());
    }
    void finish() {
        stepper_->finish();
        for (size_t i = 0; i < result_.traces.size(); ++i) {
            const Trace &a = result_.traces[i], &b = other_result_.traces[i];
            result_.cells_different += different(a.mean, b.mean) + different(a.min, b.min) + different(a.max, b.max);
            for (size_t p = 0; p < a.probes.size(); ++p) result_.cells_different += different(a.probes[p], b.probes[p]);
        }
    }

  private:
    // Counts the numbers whose bits differ. The sign and the payload of a NaN are no number, and are left to each
    // device.
    static long long different(const std::vector<double>& a, const std::vector<double>& b) {
        if (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0) return 0;
        long long n = 0;
        for (size_t i = 0; i < a.size(); ++i)
            n += std::memcmp(&a[i], &b[i], sizeof(double)) != 0 && !(std::isnan(a[i]) && std::isnan(b[i]));
        return n;
    }

    Result& result_;
    const model::PreparedSkin& skin_;
    const std::vector<Quantity> wanted_;
    Result other_result_;
    Collector collect_;
    std::unique_ptr<model::Stepper> stepper_;
    std::vector<std::vector<double>> ours_, theirs_; // maps at an output
};

constexpr double share_of_fibres = 0.5; // of the progress of a run that has fibres

// Returns the spikes of a scene by time, then by fibre. afferents: the scene's, validated. threads: as for Device::cpu.
std::vector<FiredSpike> spikes_of(const Scene&, const std::vector<Afferents>& afferents, int threads);

} // namespace dermis
