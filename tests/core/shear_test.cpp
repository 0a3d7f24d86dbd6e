// SPDX-License-Identifier: MIT
// labels: device
// The shear of a skin: tractions strain the material's chain with a third of its moduli, on each backend alike.
#include "dermis/touch.hpp"
#include "host/core/description/element.hpp"
#include "host/core/press/device.hpp"
#include "tests/contacts.hpp"
#include "tests/expected.hpp"
#include "tests/support.hpp"

using namespace test;

namespace {

constexpr int rows = 20, columns = 24, cells_of_pad = rows * columns;

// Two retardation times and a spring, in metres.
SkinDescription sheared_skin() {
    SkinDescription d;
    d.grid = {columns, rows, 5e-4};
    d.surface.kind = Surface::Kind::flat;
    d.surface.relief = 5e-5;
    d.material.thickness = 1e-3;
    d.material.curvature_length = 1e-5;
    d.material.elements = {{.modulus = 6e4, .viscosity = 3e3}, {.modulus = 2e5, .viscosity = 8e2}};
    d.material.spring = 9e5;
    d.receptors.fa2 = Fa2::step_mean;
    return d;
}

SkinOptions with_shear(int count = 1) { return {.count = count, .shear = true}; }

// A smooth patch of `peak` Pa around the middle of a pad.
std::vector<float> patch(double peak) {
    std::vector<float> map;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const double dx = (x - 11.5) / 6, dy = (y - 9.5) / 5, in = 1 - dx * dx - dy * dy;
            map.push_back(float(in > 0 ? peak * std::sqrt(in) : 0));
        }
    return map;
}

std::vector<float> joined(std::vector<float> a, const std::vector<float>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

// The strain of the material's elements under a stress that is held since t = 0, of which a ramp of dt seconds came
// first; the shear moduli are a third of the moduli.
double strain_after(double stress, double t, double dt) {
    double strain = stress / (9e5 / 3);
    for (const auto& [modulus, viscosity] : {std::pair{6e4, 3e3}, std::pair{2e5, 8e2}}) {
        const double tau = viscosity / modulus;
        // the ramp is the integral of steps
        strain += stress / (modulus / 3) * (1 - tau / dt * (std::exp(-(t - dt) / tau) - std::exp(-t / tau)));
    }
    return strain;
}

} // namespace

TEST_CASE(
    "Under a traction that is held the shear strain creeps as the chain of a third of the moduli, on each backend") {
    const Validated vulkan;
    const double dt = 2e-3;
    const std::vector<float> none(cells_of_pad), along_x = patch(2e3), along_y = patch(-7e2);
    for (const Device& device : {Device::cpu(1), Device::cpu(3), vulkan.device()}) {
        CAPTURE(device.info().name);
        Skin skin(device, sheared_skin(), with_shear());
        for (int n = 1; n <= 30; ++n) {
            skin.press(none.data(), joined(along_x, along_y).data(), cells_of_pad, dt);
            const std::vector<float> x = answers(skin, Quantity::shear_x), y = answers(skin, Quantity::shear_y);
            double sum_x = 0, sum_y = 0, stress_x = 0, stress_y = 0;
            for (size_t i = 0; i < cells_of_pad; ++i)
                sum_x += x[i], sum_y += y[i], stress_x += along_x[i], stress_y += along_y[i];
            CHECK(sum_x == relative(strain_after(stress_x, n * dt, dt), 1e-5));
            CHECK(sum_y == relative(strain_after(stress_y, n * dt, dt), 1e-5));
        }
        for (Quantity q : all_responses) CHECK(answers(skin, q) == none); // no shear changes a response
    }
}

TEST_CASE(
    "Tractions leave the bits of strain and responses, and the planes of shear swap with the axes, on each backend") {
    const Validated vulkan;
    const std::vector<float> pressure = patch(1e4), none(cells_of_pad), a = patch(2e3), b = patch(5e2);
    std::vector<float> first;
    for (const Device& device : {Device::cpu(1), Device::cpu(3), vulkan.device()}) {
        CAPTURE(device.info().name);
        Skin plain(device, sheared_skin()), skin(device, sheared_skin(), with_shear()),
            turned(device, sheared_skin(), with_shear());
        for (int n = 0; n < 5; ++n) {
            plain.press(pressure, 1e-3);
            skin.press(pressure.data(), joined(a, b).data(), cells_of_pad, 1e-3);
            turned.press(none.data(), joined(b, a).data(), cells_of_pad, 1e-3);
        }
        CHECK(answers(skin) == answers(plain));
        CHECK(answers(skin, Quantity::strain) == answers(plain, Quantity::strain));
        const std::vector<float> x = answers(skin, Quantity::shear_x), y = answers(skin, Quantity::shear_y);
        CHECK(answers(turned, Quantity::shear_x) == y);
        CHECK(answers(turned, Quantity::shear_y) == x);
        if (first.empty()) first = x;
        CHECK(x == first); // the same bits on all
    }
}

TEST_CASE(
    "A force turned by 90 degrees turns the shear of a square pad with it, and stretch is that of the displacement") {
    SkinDescription d = sheared_skin();
    d.grid = {columns, columns, 5e-4};
    Skin along_x(Device::cpu(1), d, with_shear()), along_y(Device::cpu(1), d, with_shear());
    constexpr size_t all = size_t(columns) * columns;
    std::vector<float> map(all), transposed(all);
    for (size_t y = 0; y < columns; ++y)
        for (size_t x = 0; x < columns; ++x) {
            const double dx = (double(x) - 9) / 6, dy = (double(y) - 13) / 4, in = 1 - dx * dx - dy * dy;
            map[y * columns + x] = transposed[x * columns + y] = float(in > 0 ? 3e3 * in : 0);
        }
    const std::vector<float> none(all);
    along_x.press(none.data(), joined(map, none).data(), all, 1e-2);
    along_y.press(none.data(), joined(none, transposed).data(), all, 1e-2);
    const std::vector<float> x = answers(along_x, Quantity::shear_x), y = answers(along_y, Quantity::shear_y);
    const std::vector<float> ex = answers(along_x, Quantity::stretch_x), exy = answers(along_x, Quantity::stretch_xy);
    const std::vector<float> ey = answers(along_y, Quantity::stretch_y), eyx = answers(along_y, Quantity::stretch_xy);
    const auto at = [](int row, int column) { // mirrored at the edges
        return size_t(std::clamp(row, 0, columns - 1)) * columns + size_t(std::clamp(column, 0, columns - 1));
    };
    double sum = 0, greatest = 0;
    for (int i = 0; i < columns; ++i)
        for (int k = 0; k < columns; ++k) {
            REQUIRE(x[at(i, k)] == y[at(k, i)]);
            // u = 1 mm * gamma, over two cells of 0.5 mm
            const double by_x = double(x[at(i, k + 1)]) - double(x[at(i, k - 1)]),
                         by_y = double(x[at(i + 1, k)]) - double(x[at(i - 1, k)]), least = 1e-7 * x[at(13, 9)];
            REQUIRE(ex[at(i, k)] == absolute(by_x, least));
            REQUIRE(exy[at(i, k)] == absolute(by_y / 2, least));
            REQUIRE(ey[at(k, i)] == ex[at(i, k)]);
            REQUIRE(eyx[at(k, i)] == exy[at(i, k)]);
            sum += ex[at(i, k)];
            greatest = std::max(greatest, std::abs(double(ex[at(i, k)])));
        }
    CHECK(greatest > 0);
    CHECK(sum == absolute(0, 1e-5 * greatest)); // skin is drawn apart behind the patch and together before it
    CHECK(ex[at(13, 3)] > 0);
    CHECK(ex[at(13, 15)] < 0);
    for (float e : answers(along_x, Quantity::stretch_y)) REQUIRE(e == 0);
}

TEST_CASE("The stretch along a row sums up to the shear of its last cell less that of its first, or to 0 if edges are "
          "periodic") {
    for (Edges edges : {Edges::mirror, Edges::periodic}) {
        SkinDescription d = sheared_skin();
        d.edges = edges;
        SkinOptions options = with_shear();
        Skin skin(Device::cpu(1), d, options);
        std::vector<float> slanted(cells_of_pad), none(cells_of_pad);
        for (int i = 0; i < cells_of_pad; ++i) slanted[size_t(i)] = float(100 + 10 * (i % columns));
        skin.press(none.data(), joined(slanted, none).data(), cells_of_pad, 0.01);
        const std::vector<float> shear = answers(skin, Quantity::shear_x), stretch = answers(skin, Quantity::stretch_x);
        for (int y = 0; y < rows; ++y) {
            double sum = 0, magnitudes = 0;
            for (int x = 0; x < columns; ++x)
                sum += stretch[size_t(y * columns + x)], magnitudes += std::abs(stretch[size_t(y * columns + x)]);
            const double ends = double(shear[size_t((y + 1) * columns - 1)]) - shear[size_t(y * columns)],
                         expected = edges == Edges::mirror ? ends * 1e-3 / 5e-4 : 0;
            CHECK(sum == absolute(expected, 1e-5 * magnitudes));
            if (edges == Edges::mirror) CHECK(sum > 0.9 * magnitudes); // far from 0
        }
    }
}

TEST_CASE("A Touch with shear presses tractions whose sum over the modulus is the force along the surface to 1e-6") {
    contact::Pad shape;
    shape.width = columns, shape.height = rows, shape.spacing = 5e-4;
    SkinDescription d = sheared_skin();
    d.material.elements = {{.modulus = 6e4, .viscosity = 6}}; // comes to rest within 1 ms
    d.material.spring.reset();
    Skin skin(Device::cpu(2), d, with_shear(4));
    contact::Touch touch(shape, 4, 1e-3, true);
    const std::vector<double> middles(12), axes = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const int32_t pad[] = {2, 2};
    const double position[] = {0, 0, 0, 1e-3, -1e-3, 0}, force[] = {0.03, 0.04, -0.2, 0.01, -0.05, -0.1}, size = 2e-3;
    const contact::Poses poses{.position = middles.data(), .rotation = axes.data(), .rotation_step = 0};
    const contact::Contacts contacts{
        .count = 2, .pad = pad, .position = position, .force = force, .radius = &size, .radius_step = 0};
    const contact::ContactReport& report = touch.add(poses, contacts);
    CHECK(report.shear[0] == relative(0.04, 1e-9));
    CHECK(report.shear[1] == relative(-0.01, 1e-9));
    for (int n = 0; n < 40; ++n) skin.press(touch, 1e-3);
    const double cell = 5e-4 * 5e-4;
    double x = 0, y = 0;
    const std::vector<float> gamma_x = answers(skin, Quantity::shear_x), gamma_y = answers(skin, Quantity::shear_y);
    for (size_t i = 0; i < gamma_x.size(); ++i) x += gamma_x[i], y += gamma_y[i];
    CHECK(x * 2e4 * cell == relative(0.04, 1e-6));
    CHECK(y * 2e4 * cell == relative(-0.01, 1e-6));
    CHECK(std::all_of(gamma_x.begin(), gamma_x.begin() + 2 * cells_of_pad, [](float g) { return g == 0; }));

    Skin same(Device::cpu(1), d, with_shear(4));
    for (int n = 0; n < 40; ++n) same.press(touch.pressure(), touch.traction(), 4 * cells_of_pad, 1e-3);
    CHECK(answers(same, Quantity::shear_x) == gamma_x);
    CHECK(answers(same, Quantity::sa1) == answers(skin, Quantity::sa1));
    touch.add(poses, {});
    CHECK(std::all_of(touch.traction(), touch.traction() + 8 * cells_of_pad, [](float t) { return t == 0; }));
}

TEST_CASE(
    "SA2 on request answers to the stretch, all round or along a direction, with its adaptation, on each backend") {
    const Validated vulkan;
    SkinDescription d = sheared_skin();
    d.material.elements = {{.modulus = 6e4, .viscosity = 0.06}}; // comes to rest within a microsecond
    d.material.spring.reset();
    const double adaptation = 0.05, dt = 4e-3;
    d.receptors.sa2_adaptation = adaptation;
    const std::vector<float> none(cells_of_pad), both = joined(patch(2e3), patch(-7e2));
    for (const Device& device : {Device::cpu(1), Device::cpu(3), vulkan.device()}) {
        CAPTURE(device.info().name);
        for (const std::array<double, 2>& n : {std::array{0.0, 0.0}, {3.0, 0.0}, {0.0, -2.0}, {1.0, 1.0}}) {
            CAPTURE(n[0]);
            CAPTURE(n[1]);
            SkinOptions options = with_shear();
            options.sa2_stretch = n;
            Skin skin(device, d, options), plain(Device::cpu(1), d);
            for (int step = 1; step <= 25; ++step) {
                skin.press(none.data(), both.data(), cells_of_pad, dt);
                plain.press(none, dt);
            }
            const std::vector<float> x = answers(skin, Quantity::stretch_x), y = answers(skin, Quantity::stretch_y),
                                     xy = answers(skin, Quantity::stretch_xy), sa2 = answers(skin, Quantity::sa2);
            // of a stretch that has risen over the first step
            const double gain =
                adaptation *
                (1 - adaptation / dt * (std::exp(-24 * dt / adaptation) - std::exp(-25 * dt / adaptation)));
            double greatest = 0;
            for (size_t k = 0; k < cells_of_pad; ++k) greatest = std::max(greatest, std::abs(double(x[k])));
            for (size_t k = 0; k < cells_of_pad; ++k) {
                const double square = n[0] * n[0] + n[1] * n[1],
                             along = n[0] * n[0] * x[k] + n[1] * n[1] * y[k] + 2 * n[0] * n[1] * xy[k],
                             stretch = square > 0 ? along / square : double(x[k]) + double(y[k]);
                REQUIRE(sa2[k] == absolute(gain * stretch, 1e-5 * gain * greatest));
            }
            CHECK(answers(skin, Quantity::fa1) == answers(plain, Quantity::fa1));
        }
    }
}

TEST_CASE("whatever a skin is made of, its shear is the strain under three times the stress, and a material set again "
          "changes nothing") {
    std::vector<Material> all(7);
    all[0].modulus = 1e4, all[0].viscosity = 0;
    all[1].modulus = 0, all[1].viscosity = 1e3;
    all[2].elements = {{1e4, 0}};
    all[3].elements = {{0, 1e3}};
    all[4].elements = {{0, 1e5}, {1e4, 1e2}};
    all[5].elements = {{1e4, 0}}, all[5].dashpot = 1e5;
    all[6].elements.assign(8, {1e4, 1e3}), all[6].spring = 1e5, all[6].dashpot = 1e5;
    const std::vector<float> load = patch(2e3), none(cells_of_pad), along_x = joined(load, none);
    std::vector<float> stronger;
    for (const float p : load) stronger.push_back(3 * p);
    for (const Material& m : all) {
        SkinDescription d = sheared_skin();
        scene::take_elements(d.material, m);
        SkinOptions options = with_shear();
        options.responses = {Quantity::sa1};
        Skin skin(Device::cpu(1), d, options), again(Device::cpu(1), d, options),
            strained(Device::cpu(1), d, {.responses = {Quantity::sa1}});
        for (int n = 0; n < 5; ++n) {
            if (n == 3) again.set_material(m);
            for (Skin* s : {&skin, &again}) s->press(none.data(), along_x.data(), cells_of_pad, 1e-3);
            strained.press(stronger, 1e-3);
        }
        const std::vector<float> x = answers(skin, Quantity::shear_x), e = answers(strained, Quantity::strain);
        CHECK(answers(again, Quantity::shear_x) == x);
        for (size_t k = 0; k < cells_of_pad; ++k) REQUIRE(x[k] == relative(e[k], 1e-5));
    }
}

TEST_CASE("a material whose dashpots are others than the skin's is refused, as it would not come to rest or strains "
          "would change places") {
    SkinDescription d = sheared_skin();
    Material m;
    m.elements = {{0, 1e5}, {1e4, 1e2}};
    scene::take_elements(d.material, m);
    Skin flows(Device::cpu(1), d);
    m.elements = {{1e4, 1e2}}, m.dashpot = 1e5;
    refuses([&] { flows.set_material(m); },
            "allowed: a dashpot, which has no modulus, in the same places as in the skin");
    d = sheared_skin();
    d.receptors.follow.sa1 = Signal::stress;
    Skin rests(Device::cpu(1), d);
    m = d.material, m.elements[1].modulus = 0;
    refuses([&] { rests.set_material(m); }, "material.elements = (another dashpot)");
    refuses([&] { Skin(Device::cpu(1), d, {.count = 2, .materials = {d.material, m}}); }, "materials[1]");
}

TEST_CASE("SA2 of the stretch is off by rounding alone after a hundred thousand presses, whatever the length of its "
          "direction") {
    SkinDescription d = sheared_skin();
    d.grid = {8, 4, 5e-4};
    d.material = {.modulus = 6e4, .viscosity = 0, .thickness = 1e-3, .curvature_length = 0};
    const std::vector<float> none(32), both = [] {
        std::vector<float> t(64);
        for (size_t i = 0; i < 32; ++i) t[i] = float(1e3 * double(i % 8));
        return t;
    }();
    const auto pressed = [&](std::array<double, 2> direction, int presses) {
        SkinOptions options{.responses = {Quantity::sa2}, .shear = true};
        options.sa2_stretch = direction;
        Skin skin(Device::cpu(1), d, options);
        for (int n = 0; n < presses; ++n) skin.press(none.data(), both.data(), 32, 1e-3);
        return std::pair{answers(skin, Quantity::sa2), answers(skin, Quantity::stretch_x)};
    };
    const auto [sa2, stretch] = pressed({1, 0}, 100000);
    for (size_t k = 0; k < 32; ++k) CHECK(sa2[k] == relative(double(stretch[k]) * (100 - 5e-4), 1e-6));
    for (const double length : {1e200, 1e-200}) CHECK(pressed({3 * length, length}, 3) == pressed({3, 1}, 3));
}

TEST_CASE("SA2 of the stretch is refused where it cannot be") {
    SkinOptions options = with_shear(3);
    options.sa2_stretch = {1, 0};
    const auto refused = [&](auto change) {
        SkinOptions own = options;
        change(own);
        return refusal(Error::Code::bad_input, [&] { Skin(Device::cpu(1), sheared_skin(), own); });
    };
    CHECK(refused([](SkinOptions& o) { o.shear = false; }) == "sa2_stretch = (given); allowed: none without shear");
    CHECK(refused([](SkinOptions& o) { o.responses = {Quantity::sa1}; }) ==
          "sa2_stretch = (given); allowed: none where sa2 is not among the responses");
    CHECK(refused([](SkinOptions& o) { o.sa2_stretch = {NAN, 0}; }).find("sa2_stretch = ") == 0);
}

TEST_CASE("A step that the pressure refuses leaves the shear as it was") {
    Skin skin(Device::cpu(1), sheared_skin(), with_shear());
    const std::vector<float> pressure = patch(1e4), both = joined(patch(2e3), patch(5e2));
    skin.press(pressure.data(), both.data(), cells_of_pad, 1e-3);
    std::vector<char> before(skin.state_bytes()), after(before);
    int refused = 0;
    for (double dt = 1e-60; dt < 1e60; dt *= 7) {
        CAPTURE(dt);
        skin.save(before.data(), before.size());
        try {
            skin.press(pressure.data(), both.data(), cells_of_pad, dt);
            skin.load(before.data(), before.size());
        } catch (const Error& e) {
            CHECK(e.code() == Error::Code::bad_input);
            skin.save(after.data(), after.size());
            CHECK(before == after);
            ++refused;
        }
    }
    CHECK(refused > 0);
}

TEST_CASE("What no shear can be asked of is refused by name, and nothing is changed") {
    const auto message = [](auto call) { return refusal(Error::Code::bad_input, call); };
    const auto refused = [&](auto change) {
        SkinDescription d = sheared_skin();
        SkinOptions o = with_shear();
        change(d, o);
        return message([&] { Skin(Device::cpu(1), d, o); });
    };
    CHECK(refused([](SkinDescription& d, SkinOptions&) {
              d.sites = {{Quantity::sa1, {3, 4}}};
          }) == "shear = true; allowed: false in a skin with sites");
    CHECK(refused([](SkinDescription&, SkinOptions& o) { o.control = Control::depth; }) ==
          "shear = true; allowed: false with control = depth");
    CHECK(refused([](SkinDescription& d, SkinOptions&) {
              d.material.elements[0].modulus_map = Map(std::vector<double>(cells_of_pad, 1e5));
          }) == "shear = true; allowed: false in a skin whose material has maps");
    CHECK(refused([](SkinDescription& d, SkinOptions&) { d.edges = published_edges, d.stencil = published_stencil; }) ==
          "shear = true; allowed: false with curvature.edges = published");

    Skin skin(Device::cpu(1), sheared_skin(), with_shear()), plain(Device::cpu(1), sheared_skin());
    const std::vector<float> pressure = patch(1e4);
    std::vector<float> both = joined(patch(2e3), patch(5e2));
    CHECK(message([&] { skin.press(pressure, 1e-3); }) ==
          "traction = (not given); allowed: tractions: the skin was made with shear");
    CHECK(message([&] { plain.press(pressure.data(), both.data(), cells_of_pad, 1e-3); }) ==
          "traction = (given); allowed: none: the skin was made without shear");
    CHECK(message([&] { skin.press_frames(pressure.data(), 1, cells_of_pad, 1e-3); }).find("traction = (not") == 0);
    CHECK(message([&] { skin.press_cells(pressure.data(), cells_of_pad, 1e-3); }).find("traction = (not") == 0);
    both[cells_of_pad + columns + 2] = INFINITY;
    CHECK(message([&] { skin.press(pressure.data(), both.data(), cells_of_pad, 1e-3); }) ==
          "traction = inf in cell [2, 1] of axis 1; allowed: finite numbers");
    CHECK(message([&] { skin.press(pressure.data(), nullptr, cells_of_pad, 1e-3); }) ==
          "traction = (null); allowed: a pointer");
    CHECK(message([&] { plain.response(Quantity::shear_x); }).find("response = \"shear_x\"") == 0);
    std::vector<char> state(skin.state_bytes()), other(plain.state_bytes());
    skin.save(state.data(), state.size());
    plain.save(other.data(), other.size());
    CHECK(message([&] { plain.load(state.data(), state.size()); }).find("state = (part \"shear\")") == 0);
    CHECK(message([&] { skin.load(other.data(), other.size()); }) ==
          "state = (shear 0); allowed: shear 1, as the skin has");
}
