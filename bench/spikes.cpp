// SPDX-License-Identifier: MIT
// Afferents step by step, beside the methods of other models on the same number of afferents.
#include "bench/bench.hpp"
#include "host/core/embedding/backend.hpp"
#include "host/core/press/device.hpp"

#include <numbers>

#include <fmt/format.h>

namespace bench {

using namespace dermis;

namespace {

constexpr double dt = 1e-3, period = 0.032; // s
constexpr int presses = 64;                 // in two periods

// Fibres of a fingertip's shares: SA1, FA1 and FA2 as 4 to 5 to 1.
std::vector<model::FibreKind> kinds_of(size_t n) {
    return {{.model = afferent_model(Quantity::sa1), .count = n * 4 / 10},
            {.model = afferent_model(Quantity::fa1), .count = n / 2},
            {.model = afferent_model(Quantity::fa2), .count = n - n * 4 / 10 - n / 2}};
}

// Fibres under strains that vibrate, each with an amplitude and a phase of its own.
class Contender {
  public:
    Contender(std::unique_ptr<model::FibrePopulation<f32>> fibres, double strain, double step = dt)
        : step_(step), fibres_(std::move(fibres)),
          inputs_(size_t(period / step), std::vector<float>(fibres_->count())) {
        for (size_t i = 0; i < fibres_->count(); ++i) {
            const double share = std::fmod(0.618034 * double(i), 1),
                         phase = 2 * std::numbers::pi * 0.7548777 * double(i);
            for (size_t k = 0; k < inputs_.size(); ++k)
                inputs_[k][i] = float(
                    strain * share * (1 + std::sin(2 * std::numbers::pi * double(k) / double(inputs_.size()) + phase)));
        }
        (void)fibres_->prepare(step);
    }

    // Seconds of some presses, without those in which inputs are taken.
    double press() {
        double seconds = 0;
        spikes_ = 0;
        for (int k = 0; k < presses; ++k, ++frame_) {
            fibres_->set_input(0, inputs_[frame_ % inputs_.size()].data());
            fibres_->forget_spikes();
            seconds += seconds_of([&] { fibres_->press(0, 1); });
            spikes_ += fibres_->spikes().size();
        }
        return seconds;
    }
    double rate() const {
        return double(spikes_) / (presses * step_) / double(fibres_->count());
    } // Hz, of the last press()

  private:
    const double step_; // s
    std::unique_ptr<model::FibrePopulation<f32>> fibres_;
    std::vector<std::vector<float>> inputs_;
    size_t frame_ = 0, spikes_ = 0;
};

// The strain at which fibres fire at a mean rate, Hz.
double strain_for(double rate) {
    double strain = 1e-6;
    for (double factor = 2; factor > 1.02; factor = std::sqrt(factor))
        for (;; strain *= factor) {
            Contender c(Device::cpu(1).impl().backend->fibres(kinds_of(4000), 1), strain * factor);
            c.press();
            c.press();
            if (c.rate() > rate || strain > 1) break;
        }
    return strain;
}

} // namespace

void spikes(Bench& bench) {
    std::vector<std::pair<Measurement, std::function<double()>>> all;
    std::vector<std::unique_ptr<Contender>> contenders;
    const auto add = [&](Measurement r, model::Backend& backend, size_t n, double strain, double step = dt) {
        auto& c = contenders.emplace_back(std::make_unique<Contender>(backend.fibres(kinds_of(n), 1), strain, step));
        all.emplace_back(r, [&c = *c] { return c.press(); });
    };
    const auto row_of = [](Measurement r, long long n, const std::string& method) {
        r.model = "located";
        r.precision = "f32";
        r.stencil = "";
        r.method = method;
        r.width = r.receptors = n;
        r.height = 1;
        r.steps = presses;
        return r;
    };
    for (const double rate : {10.0, 62.0}) {
        const double strain = strain_for(rate);
        if (rate == 10)
            for (const double step : {1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2})
                add(row_of(bench.cpu("spikes-steps", 17000, 1), 17000, fmt::format("{:g}", step)),
                    *Device::cpu(1).impl().backend, 17000, strain, step);
        for (const long long n : {17000LL, 230000LL}) {
            const auto row = [&](const Measurement& r) { return row_of(r, n, fmt::format("exact-{:.0f}Hz", rate)); };
            for (const int threads : {1, bench.cores})
                add(row(bench.cpu("spikes", n, threads)), *Device::cpu(threads).impl().backend, size_t(n), strain);
            if (bench.vulkan) add(row(bench.on_vulkan("spikes", n)), *bench.vulkan->impl().backend, size_t(n), strain);
        }
    }
    for (const Peers::Peer& peer : bench.peers->prepare("spikes 230000")) {
        Measurement r = bench.of_peer(peer, "spikes", 230000);
        r.stencil = "";
        r.height = 1;
        r.receptors = 230000;
        r.steps = presses;
        all.emplace_back(r, [&bench, peer] { return bench.peers->seconds(peer, presses); });
    }
    std::vector<std::function<double()>> work;
    for (const auto& [row, seconds] : all)
        if (row.status != not_installed) work.push_back(seconds);
    const std::vector<Timing> timings = bench.paired(work, bench.runs);
    size_t next = 0;
    for (auto& [row, seconds] : all) {
        if (row.status != not_installed) row.wall = timings[next++];
        bench.add(row);
    }
}

} // namespace bench
