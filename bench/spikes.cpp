// SPDX-License-Identifier: MIT
// Afferents step by step, beside the methods of other models on the same number of afferents.
#include "bench/bench.hpp"

#include <cmath>
#include <numbers>

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
class Vibrating {
  public:
    Vibrating(std::unique_ptr<model::FibrePopulation<f32>> fibres, double strain, double step = dt)
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
            Vibrating c(Device::cpu(1).impl().backend->fibres(kinds_of(4000), 1), strain * factor);
            c.press();
            c.press();
            if (c.rate() > rate || strain > 1) break;
        }
    return strain;
}

} // namespace

void spikes(Bench& bench) {
    std::vector<Contender> all;
    const auto add = [&](const Device& device, const char* workload, long long n, const std::string& method,
                         double strain, double step = dt) {
        const auto fibres =
            std::make_shared<Vibrating>(device.impl().backend->fibres(kinds_of(size_t(n)), 1), strain, step);
        Measurement r = row_of(bench.on(device, workload, n), "located", "f32", presses);
        r.stencil = "";
        r.method = method;
        r.receptors = n;
        r.height = 1;
        all.push_back({r, [fibres] { return fibres->press(); }});
    };
    for (const double rate : {10.0, 62.0}) {
        const double strain = strain_for(rate);
        if (rate == 10)
            for (const double step : {1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2})
                add(Device::cpu(1), "spikes-steps", 17000, fmt::format("{:g}", step), strain, step);
        for (const long long n : {17000LL, 230000LL}) {
            std::vector<Device> devices = bench.cpus();
            if (bench.vulkan) devices.push_back(*bench.vulkan);
            for (const Device& device : devices) add(device, "spikes", n, fmt::format("exact-{:.0f}Hz", rate), strain);
        }
    }
    Measurement like = row_of(bench.cpu("spikes", 230000, 1), "", "", presses);
    like.stencil = "";
    like.height = 1;
    like.receptors = 230000;
    for (Contender& c : bench.of_peers("spikes 230000", like, presses)) all.push_back(std::move(c));
    bench.measure(std::move(all), bench.runs);
}

} // namespace bench
