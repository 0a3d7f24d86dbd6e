// SPDX-License-Identifier: MIT
// labels: device threads
// Parabolic hold: from frame to frame the pressure runs along the parabola through the last three frames. That it has
// the same bits everywhere is what the suite `ways` says, and that the strain is right what `planner` measures, of runs
// whose bits the suite `skin` compares with presses.
#include "dermis/vulkan.hpp"
#include "host/lab/schedule/cell.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <numbers>

using namespace test;

namespace {

// Strain, integral, rate and acceleration of a chain at each frame.
using Signals = std::array<std::vector<double>, 4>;
constexpr const char* names[] = {"strain", "SA2", "FA1", "FA2 point", "FA2 mean"};

// Frames s at times t, on a skin at rest at t[0], in double. s[0] acts from t[0] on.
Signals stepped(const std::vector<model::Element>& chain, const std::vector<double>& t, const std::vector<double>& s,
                Hold hold) {
    const bool spring = chain.back().viscosity == 0, bent = hold == Hold::parabolic;
    const model::ResponseRule rule{.sa2_adaptation = INFINITY, .step_mean = false};
    const model::StateShape shape{.elements = chain.size() - spring, .spring = spring, .previous = bent};
    std::vector<f64::Sum> before(model::SingleCell<f64>::sums(shape)), after(before);
    Signals all;
    for (std::vector<double>& signal : all) signal.assign(1, 0);
    for (size_t n = 1; n < t.size(); ++n) {
        const double dt = t[n] - t[n - 1], earlier = bent && n > 1 ? t[n - 1] - t[n - 2] : 0;
        std::vector<f64::Coefficients> own, past;
        for (const model::Element& e : chain) {
            own.push_back(model::exact_coefficients(e, rule, dt));
            past.push_back(model::bend(own.back(), e, rule, dt, earlier));
        }
        for (auto* joined : {&own, &past}) model::join_loads<f64>(joined->data(), chain.size(), spring, dt);
        std::vector<f64::LaneCoefficients> lanes;
        for (size_t e = 0; e < chain.size(); ++e) {
            lanes.push_back(f64::lanes_of(own[e]));
            if (bent) lanes.push_back(f64::lanes_of(past[e]));
        }
        const auto step = f64::step_of(model::SingleCell<f64>{shape, lanes.data(), before.data(), after.data()},
                                       f64::load(s[n - 1], s[n] - s[n - 1], 0));
        before = after;
        const double values[] = {step.motion.strain, step.integral, step.motion.rate, step.motion.acceleration};
        for (size_t q = 0; q < 4; ++q) all[q].push_back(values[q]);
    }
    return all;
}

template <class Load> std::vector<double> sampled(const std::vector<double>& t, Load load) {
    std::vector<double> s;
    for (double time : t) s.push_back(load(time));
    return s;
}

// Under 1 + sin(2 pi f t), in closed form.
Signals truth_of_sine(const std::vector<model::Element>& chain, const std::vector<double>& t, double f) {
    const double w = 2 * std::numbers::pi * f;
    Signals all;
    for (std::vector<double>& signal : all) signal.assign(t.size(), 0);
    for (size_t n = 0; n < t.size(); ++n)
        for (const model::Element& element : chain) {
            const double E = element.modulus, eta = element.viscosity, k = E / eta, D = k * k + w * w,
                         s = std::sin(w * t[n]), c = std::cos(w * t[n]), e = std::exp(-k * t[n]);
            all[0][n] += (1 - e) / E + (k * s - w * c + w * e) / D / eta;
            all[1][n] += (t[n] - (1 - e) / k) / E + (k * (1 - c) / w - s + w * (1 - e) / k) / D / eta;
            all[2][n] += e / eta + (k * w * c + w * w * s - k * w * e) / D / eta;
            all[3][n] += -k * e / eta + (-k * w * w * s + w * w * w * c + k * k * w * e) / D / eta;
        }
    return all;
}

// The mean acceleration over the step before each frame.
std::vector<double> means(const std::vector<double>& t, const std::vector<double>& rate) {
    std::vector<double> mean(1, 0);
    for (size_t n = 1; n < t.size(); ++n) mean.push_back((rate[n] - rate[n - 1]) / (t[n] - t[n - 1]));
    return mean;
}

// The greatest error at every nth frame by the greatest value there: the five of `names`. The mean over the first step
// has the jump at its start and does not count.
std::array<double, 5> errors(const std::vector<double>& t, const Signals& found, const Signals& true_signals,
                             size_t nth) {
    std::array<double, 5> all{};
    for (size_t q = 0; q < 5; ++q) {
        const std::vector<double> x = q < 4 ? found[q] : means(t, found[2]),
                                  y = q < 4 ? true_signals[q] : means(t, true_signals[2]);
        double greatest = 0;
        for (size_t n = nth; n < t.size(); n += nth) {
            greatest = std::max(greatest, std::abs(y[n]));
            if (q < 4 || n > nth) all[q] = std::max(all[q], std::abs(x[n] - y[n]));
        }
        all[q] /= greatest;
    }
    return all;
}

const std::vector<model::Element> stiff = {{2e6, 8e3}, {1e6, 7e4}, {5e5, 7e5}};

} // namespace

TEST_CASE("what lines and parabolas between frames lose of a smooth load is what an independent program found") {
    // errors of strain, SA2, FA1, FA2 at the frame and as the mean over the step, for 1 + sin(2 pi 5 Hz t)
    struct Row {
        std::vector<double> steps; // s, in turn
        Hold hold;
        double expected[5];
    };
    const Row rows[] = {
        {{0.01}, Hold::linear, {2.011e-3, 1.572e-4, 2.276e-2, 0.2182, 3.061e-3}},
        {{0.01}, Hold::parabolic, {2.705e-4, 7.279e-6, 3.793e-3, 5.118e-2, 5.100e-4}},
        {{0.0025}, Hold::linear, {1.292e-4, 9.826e-6, 1.536e-3, 7.488e-2, 6.900e-4}},
        {{0.0025}, Hold::parabolic, {4.343e-6, 1.006e-7, 6.085e-5, 4.006e-3, 2.762e-5}},
        {{0.008, 0.012}, Hold::linear, {2.465e-3, 1.757e-4, 2.721e-2, 0.1427, 6.468e-3}},
        {{0.008, 0.012}, Hold::parabolic, {3.396e-4, 6.851e-6, 4.217e-3, 3.360e-2, 1.011e-3}},
    };
    for (const Row& row : rows) {
        std::vector<double> t(1, 0);
        const size_t steps = row.steps.size() > 1 ? 256 : size_t(std::lround(2.56 / row.steps[0]));
        for (size_t n = 0; n < steps; ++n)
            t.push_back(row.steps.size() > 1 ? t.back() + row.steps[n % 2] : double(n + 1) * row.steps[0]);
        const auto load = [](double time) { return 1 + std::sin(10 * std::numbers::pi * time); };
        const auto found = errors(t, stepped(stiff, t, sampled(t, load), row.hold), truth_of_sine(stiff, t, 5),
                                  row.steps[0] == 0.0025 ? 4 : 1);
        for (size_t q = 0; q < 5; ++q) {
            CAPTURE(row.steps[0]);
            CAPTURE(int(row.hold));
            CAPTURE(names[q]);
            CHECK(found[q] == relative(row.expected[q], 0.05));
        }
    }
}

TEST_CASE("a step from rest, after a reset and after a pause is linear, bit for bit") {
    const Validated vulkan;
    SkinDescription one = small_scene(19, 11), sites = with_sites(with_chain(ridged(19, 11)), 40),
                    deep = with_chain(finger(19, 11));
    one.receptors.fa2 = Fa2::step_mean;
    sites.stencil = deep.stencil = Stencil::fourth_order; // it reads the most cells
    deep.receptors.depth = {.sa1 = 1e-3, .sa2 = {}, .fa1 = 2e-3, .fa2 = 1e-3};
    for (const Device& device : {Device::cpu(1), vulkan.device()})
        for (const SkinDescription& d : {one, sites, deep}) {
            SkinOptions options{.precision = Precision::f32};
            Skin linear(device, d, options);
            options.hold = Hold::parabolic;
            Skin bent(device, d, options);
            const auto same = [&] { return answers(linear) == answers(bent); };
            const auto press = [&](int n, double dt) {
                for (Skin* skin : {&linear, &bent}) skin->press(frame(d, n), dt);
            };
            press(1, 0.01);
            CHECK(same());
            press(2, 0); // a pause
            press(3, 0.02);
            CHECK(same());
            press(4, 0.02);
            CHECK_FALSE(same());
            for (Skin* skin : {&linear, &bent}) skin->reset();
            press(5, 0.01);
            CHECK(same());
        }
}

TEST_CASE("a state says under which hold it was saved, and its steps are checked") {
    SkinDescription d = small_scene(9, 7);
    d.receptors.fa2 = Fa2::step_mean;
    SkinOptions options;
    Skin linear(Device::cpu(1), d, options);
    options.hold = Hold::parabolic;
    Skin bent(Device::cpu(1), d, options);
    const auto bytes_of = [](const Skin& skin) {
        std::vector<char> bytes(skin.state_bytes());
        skin.save(bytes.data(), bytes.size());
        return bytes;
    };
    const auto refused = [](Skin& skin, const std::vector<char>& bytes) {
        return refusal(Error::Code::bad_input, [&] { skin.load(bytes.data(), bytes.size()); });
    };
    CHECK(refused(bent, bytes_of(linear)) == "state = (parabolic hold 0); allowed: parabolic hold 1, as the skin has");
    CHECK(refused(linear, bytes_of(bent)) == "state = (parabolic hold 1); allowed: parabolic hold 0, as the skin has");
    bent.press(frame(d, 1), 0.125);
    std::vector<char> bytes = bytes_of(bent);
    const double step = 0.125, wrong = -0.125;
    const auto at = std::search(bytes.begin(), bytes.end(), reinterpret_cast<const char*>(&step),
                                reinterpret_cast<const char*>(&step + 1));
    REQUIRE(at != bytes.end());
    std::copy_n(reinterpret_cast<const char*>(&wrong), sizeof wrong, at);
    CHECK(refused(bent, bytes).find("(a step of -0.125000 s)") != std::string::npos);
}

TEST_CASE("a SkinProgram refuses parabolic hold by name") {
    SkinOptions options{.hold = Hold::parabolic};
    CHECK(refusal(Error::Code::bad_input, [&] { vulkan::SkinProgram({}, small_scene(9, 7), 2, options); }) ==
          "hold = parabolic; allowed: linear in a SkinProgram; a Skin has both");
}

TEST_CASE("a report names the vibration of which frames lose a tenth") {
    SkinDescription d = small_scene(9, 7);
    Skin skin(Device::cpu(1), d);
    CHECK(std::isnan(skin.report().vibration.value));
    skin.press(frame(d, 1), 0.004);
    const double x = skin.report().vibration.value * 0.004 * std::numbers::pi;
    CHECK(std::pow(std::sin(x) / x, 2) == relative(0.9, 1e-12));
    skin.press(frame(d, 2), 0);
    CHECK(std::isnan(skin.report().vibration.value));
}
