// SPDX-License-Identifier: MIT
#include "host/core/embedding/backend.hpp"

#include "host/core/cpu/fibres.hpp"

#include <cstring>

namespace dermis::vulkan {
namespace {

constexpr size_t fibres_of_kind = 48;
constexpr int fibre_presses = 24;
constexpr double longest = 0.03; // s: of a step that takes several of the longest dispatches

// Fibres of every number of poles, with all that a fibre can have.
std::vector<model::FibreKind> kinds_of_check() {
    AfferentModel resonant;
    resonant.time_constants = {0.6e-3};
    resonant.frequency = 100;
    resonant.quality = 1;
    resonant.gains = {{{900, 400}, {0.4, 0.2}, {1e-4, 0}}};
    resonant.membrane_time = 0.005;
    resonant.refractory_time = 0.001;
    resonant.reset = -0.5;
    resonant.after = {{{.amplitude = -1, .time = 0.004}, {.amplitude = 0.5, .time = 0.02}}};
    AfferentModel single = resonant;
    single.frequency = single.quality = {};
    single.gains = {{{2000, 500}, {0, 0}, {0, 0}}};
    return {{.model = resonant, .count = fibres_of_kind},
            {.model = single, .count = fibres_of_kind},
            {.model = afferent_model(Quantity::fa1), .count = fibres_of_kind},
            {.model = resonant, .count = fibres_of_kind, .endings = 5}};
}

// The spikes and the state of a population after some presses.
std::vector<float> pressed(model::FibrePopulation<f32>& fibres) {
    std::vector<float> all, inputs(fibres.state_size() / FIBRE_PLANES), state(fibres.state_size());
    for (int n = 0; n < fibre_presses; ++n) {
        // no sine: the numbers are the same on every machine
        for (size_t i = 0; i < inputs.size(); ++i)
            inputs[i] = float((n * (3 + int(i) % 7)) % 16) * 1e-4f * float(i % 9);
        (void)fibres.prepare(n % 8 < 6 ? 0.001 : n == 7 ? longest : 0.003);
        fibres.set_input(0, inputs.data());
        fibres.forget_spikes();
        fibres.press(0, 1);
        for (const auto& s : fibres.spikes()) all.insert(all.end(), {float(s.fibre), s.share});
    }
    fibres.save(0, state.data());
    all.insert(all.end(), state.begin(), state.end());
    return all;
}

} // namespace

void need_exact_fibres(const std::shared_ptr<Context>& context) {
    const std::vector<uint32_t> key = {FIBRES_BINDINGS, FIBRE_PLANES}; // no variant of a press is as short
    const auto same = [&] {
        cpu::Fibres<f32> on_cpu(kinds_of_check(), 1, 1, simd::best());
        const auto on_device = fibres(context, kinds_of_check(), 1);
        const std::vector<float> a = pressed(on_cpu), b = pressed(*on_device);
        return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
    };
    if (!context->exact(key, same))
        throw Error(Error::Code::no_device, "afferents",
                    context->physical().info.name + " steps afferents to other bits than the CPU path; allowed: "
                                                    "device cpu, or another driver");
}

} // namespace dermis::vulkan
