// SPDX-License-Identifier: MIT
// labels: long threads
// Receptors at depths in a skin that is pressed frame by frame: by closed forms and by scenes in f64. That they have
// the same bits by every way is what the suite `ways` says.
#include "host/core/model/spread.hpp"
#include "tests/drawn_skin.hpp"
#include "tests/support.hpp"

#include <cstring>
#include <numbers>

using namespace test;

namespace {

using model::Depth; // in cells

constexpr double spread_spacing = 1e-4;

// Pressures spread to a depth, in cells: SA1 of a flat, elastic skin of modulus 1.
class Below {
  public:
    Below(int width, int height, const Depth& depth) : skin_(Device::cpu(1), of(width, height, depth), options()) {}

    std::vector<float> operator()(const std::vector<float>& pressure) {
        skin_.press(pressure, 1);
        return answers(skin_, Quantity::sa1);
    }

  private:
    static SkinDescription of(int width, int height, const Depth& depth) {
        SkinDescription d;
        d.grid = {width, height, spread_spacing};
        d.surface = {.kind = Surface::Kind::flat, .relief = 1e-6};
        d.material = {.modulus = 1, .viscosity = 0, .thickness = 1e-3, .curvature_length = 0};
        d.receptors.depth.sa1 = depth.depth * spread_spacing;
        d.receptors.kernel.sa1 = depth.kernel;
        if (depth.kernel != DepthKernel::stress) d.receptors.poisson = depth.poisson;
        return d;
    }
    static SkinOptions options() { return {.responses = {Quantity::sa1}}; }
    Skin skin_;
};

// What an even square from a corner on, below which it acts, causes per unit of its pressure (Love 1929). All in cells.
double of_corner(double a, double b, const Depth& d) {
    const double z = d.depth, nu = d.poisson, R = std::sqrt(a * a + b * b + z * z), turn = 2 * std::numbers::pi,
                 angle = std::atan(a * b / (z * R)) / turn,
                 stress = angle + a * b * z / R * (1 / (a * a + z * z) + 1 / (b * b + z * z)) / turn;
    if (d.kernel == DepthKernel::stress) return stress;
    if (d.kernel == DepthKernel::strain) return (1 + nu) * (stress - 2 * nu * angle);
    const double around = (a * std::asinh(b / std::hypot(a, z)) + b * std::asinh(a / std::hypot(b, z))) / turn;
    return 3 / (z * (3 - 2 * nu)) * (z * angle + 2 * (1 - nu) * (around - z * angle));
}
double of_cell(double x, double y, const Depth& d) {
    return of_corner(x + 0.5, y + 0.5, d) - of_corner(x - 0.5, y + 0.5, d) - of_corner(x + 0.5, y - 0.5, d) +
           of_corner(x - 0.5, y - 0.5, d);
}

// The skin below which one cell at a time is pressed on a square grid.
class OneCell {
  public:
    OneCell(const Depth& depth, int cells)
        : cells_(cells), below_(cells, cells, depth), pressure_(size_t(cells) * size_t(cells)) {
        for (int y = 0; y < cells; ++y)
            for (int x = 0; x < cells; ++x) weights_.push_back(of_cell(x, y, depth));
    }

    // The sum, over all cells, of the errors below cell (x, y), over the sum of what is right if that is above 1.
    double sum_of_errors(int x, int y) {
        float& one = pressure_[size_t(y * cells_ + x)];
        one = 1;
        const std::vector<float> spread = below_(pressure_);
        one = 0;
        double sum = 0, all = 0;
        for (int j = 0, i = 0; j < cells_; ++j)
            for (int k = 0; k < cells_; ++k, ++i) {
                const double weight = weights_[size_t(std::abs(j - y) * cells_ + std::abs(k - x))];
                sum += std::abs(double(spread[size_t(i)]) - weight), all += std::abs(weight);
            }
        return sum / std::max(all, 1.0);
    }

  private:
    int cells_;
    Below below_;
    std::vector<float> pressure_;
    std::vector<double> weights_;
};

// Ridges, a chain, gains, each class at another depth.
SkinDescription deep_ridges(int width, int height) {
    SkinDescription d;
    d.grid = {width, height, spread_spacing};
    d.surface = {.kind = Surface::Kind::wave, .relief = 5e-5, .ridge_period = 8e-4};
    d.material.thickness = 1e-3, d.material.curvature_length = 1e-5;
    d.material.elements = {{2e5, 8e2, {}, {}}, {1.5e5, 1e4, {}, {}}};
    d.material.spring = 5e5;
    d.receptors.fa2_gains = {1, -0.5};
    d.receptors.depth = {.sa1 = 3e-4, .sa2 = 1.1e-3, .fa1 = {}, .fa2 = 6e-5};
    return d;
}
std::vector<float> drawn_pressure(Random& r, size_t cells) {
    std::vector<float> all(cells);
    for (float& p : all) p = chance(r, 0.7) ? float(r.within(-100, 1e4)) : 0;
    return all;
}

} // namespace

TEST_CASE("below a pressed cell the errors against Love's corners sum to less than 1e-3, at every depth and place") {
    constexpr double ratios[] = {0.05, 0.3, 1,    1.5, 2,  2.5,   3,  3.5, 4,  5, 6,
                                 6.5,  7,   7.99, 8,   10, 13.99, 14, 22,  28, 40};
    for (const auto kernel : {DepthKernel::stress, DepthKernel::strain, DepthKernel::displacement})
        for (double z : ratios) {
            CAPTURE(z);
            CAPTURE(kernel);
            if (!night() && z > 14) continue;
            const int cells = night() ? std::clamp(int(14 * z), 96, 512) : 96, each = night() ? 1 : 11;
            OneCell one({z, kernel, 0.4}, cells);
            const int period = std::min(1 << (model::spread_of({z, kernel, 0.4}, cells, cells).size() - 1), 64),
                      first = cells / 2 / period * period;
            for (int v = 0, n = 0; v <= std::max(period / 2 - 1, 0); ++v)
                for (int u = 0; u <= v; ++u) // the other places in the pyramid are these, turned
                    if (n++ % each == 0) CHECK(one.sum_of_errors(first + u, first + v) <= model::spread_error);
        }
}

TEST_CASE("and so they do on grids of any size, at whose ends the last level joins cells") {
    Random r;
    for (int cells : {9, 10, 12, 16, 17, 18, 19, 20, 21, 22, 32, 33, 36, 37, 40, 41, 42, 64, 65, 72, 73, 80, 81, 82})
        for (const auto kernel : {DepthKernel::stress, DepthKernel::strain, DepthKernel::displacement})
            for (double z : {0.5, 1.0, 6.0, cells / 4.0, cells / 2.0}) {
                CAPTURE(cells);
                CAPTURE(kernel);
                CAPTURE(z);
                OneCell one({z, kernel, 0.4}, cells);
                for (int n = 0; n < (night() ? 40 : 6); ++n)
                    CHECK(one.sum_of_errors(whole(r, 0, cells - 1), whole(r, cells / 4, 3 * cells / 4)) <=
                          model::spread_error);
            }
}

TEST_CASE("pads of up to 8 x 8 cells have the sums over all cells, within 4 units of float") {
    Random r;
    for (int n = 0; n < 60; ++n) {
        const int width = whole(r, 1, 8), height = whole(r, 1, 8);
        const Depth depth{r.decades(-1, 2), DepthKernel(whole(r, 0, 2)), r.within(0, 0.5)};
        std::vector<float> pressure(size_t(width * height));
        for (float& p : pressure) p = float(r.within(0, 1));
        const std::vector<float> spread = Below(width, height, depth)(pressure);
        for (int at = 0; at < width * height; ++at) {
            double sum = 0, sizes = 0; // a strain has weights of both signs
            for (int i = 0; i < width * height; ++i) {
                const double part =
                    double(pressure[size_t(i)]) * of_cell(at % width - i % width, at / width - i / width, depth);
                sum += part, sizes += std::abs(part);
            }
            CHECK(spread[size_t(at)] == absolute(sum, 4 * 0x1p-23 * sizes));
        }
    }
}

TEST_CASE("sites at depths read all cells, whose state and report are those of a skin without sites") {
    SkinDescription fields = deep_ridges(23, 17), sites = fields;
    sites.sites = {{Quantity::fa2, {0, 0}}, {Quantity::sa1, {7, 5}}, {Quantity::fa1, {21, 15}}};
    SkinOptions options{.responses = {Quantity::sa1, Quantity::fa1, Quantity::fa2}, .count = 3};
    Skin all(Device::cpu(1), fields, options), some(Device::cpu(1), sites, options);
    CHECK(some.cells() == all.cells());
    Random r;
    const std::vector<float> pressure = drawn_pressure(r, 3 * 23 * 17);
    all.press(pressure, 1e-3), some.press_cells(pressure.data(), pressure.size(), 1e-3);
    CHECK(saved(all) == saved(some));
    CHECK(some.report(1).strain.value == all.report(1).strain.value);
    CHECK_THROWS_AS(some.response(Quantity::sa2), Error);
}

TEST_CASE("pads at depths that are not pressed keep the responses of their sites; after a reset they are 0") {
    SkinDescription d = deep_ridges(23, 17);
    d.sites = {{Quantity::fa2, {0, 0}}, {Quantity::sa1, {7, 5}}, {Quantity::sa1, {21, 15}}};
    SkinOptions options{.responses = {Quantity::sa1, Quantity::fa2}, .count = 3};
    Skin cpu(Device::cpu(1), d, options), vulkan(Device::open("vulkan"), d, options);
    Random r;
    const std::vector<float> all = drawn_pressure(r, 3 * 23 * 17), one = drawn_pressure(r, 23 * 17);
    for (Skin* skin : {&cpu, &vulkan})
        skin->press(all, 1e-3), skin->reset(std::vector{0}), skin->press(one, 1e-3, std::vector{1});
    for (Quantity q : options.responses) {
        CHECK(cpu.response(q)[0] == 0);
        CHECK(answers(vulkan, q) == answers(cpu, q));
    }
}

TEST_CASE("a state saved without depths goes on at depths, and the other way round, by the same bits") {
    SkinDescription deep = deep_ridges(23, 17), flat = deep;
    flat.receptors.depth = {};
    Random r;
    for (const Hold hold : {Hold::linear, Hold::parabolic}) {
        SkinOptions options;
        options.hold = hold, options.count = 2;
        Skin a(Device::cpu(1), deep, options), b(Device::cpu(1), flat, options), c(Device::cpu(1), deep, options),
            e(Device::cpu(1), flat, options);
        const auto press_all = [&] {
            const std::vector<float> pressure = drawn_pressure(r, 2 * 23 * 17);
            for (Skin* skin : {&a, &b, &c, &e}) skin->press(pressure, 1e-3);
        };
        const auto hand_over = [](const Skin& from, Skin& to) {
            const Bytes state = saved(from);
            to.load(state.data(), state.size());
        };
        press_all(), press_all();
        CHECK(saved(a) == saved(b));
        c.reset(), e.reset();
        hand_over(b, c), hand_over(a, e);
        press_all();
        CHECK(answers(c) == answers(a));
        CHECK(answers(e) == answers(b));
    }
}

namespace {

// later: whether the material is set after the skin is made.
void check_inputs(const Validated& vulkan, int width, int height, bool later, bool spring = false) {
    const int cells = width * height;
    SkinDescription d = deep_ridges(width, height);
    d.receptors.depth = {.sa1 = 3e-4, .sa2 = {}, .fa1 = {}, .fa2 = 1.2e-3};
    if (!spring) d.material.spring.reset(); // its strain a step rounds otherwise than who reads the state
    if (later) d.material.elements.push_back({.modulus = 4e5, .viscosity = 2e3});
    SkinDescription as_input = d;
    as_input.material.curvature_length = 0;
    SkinOptions options, plain;
    plain.responses = {Quantity::sa1};
    plain.count = options.count = 2;
    options.responses = {Quantity::fa1};
    for (Quantity q : {Quantity::sa1, Quantity::fa1, Quantity::fa2}) {
        options.afferents.push_back({.type = q, .model = afferent_model(q), .cells = {}});
        options.afferents.back().model->spread = 0; // all feel the same
        for (int i = 0; i < 10; ++i) options.afferents.back().cells.push_back({2 * i % width, i % height});
    }
    Material other = d.material;
    other.elements[1].modulus = 3e5;
    for (const Signal follow : {Signal::strain, Signal::stress})
        for (const Device& device : {Device::cpu(1), vulkan.device()}) {
            as_input.receptors.follow.sa1 = follow;
            for (Afferents& a : options.afferents) a.follow = follow;
            Skin skin(device, d, options);
            std::vector<Skin> inputs;
            for (const std::optional<double> z :
                 {d.receptors.depth.sa1, d.receptors.depth.fa1, d.receptors.depth.fa2}) {
                as_input.receptors.depth = {.sa1 = z};
                inputs.emplace_back(Device::cpu(1), as_input, plain);
            }
            if (later) skin.set_material(other);
            for (Skin& input : inputs)
                if (later) input.set_material(other);
            Random r;
            for (int n = 0; n < 2; ++n) {
                const std::vector<float> pressure = drawn_pressure(r, size_t(2 * cells));
                skin.press(pressure, 1e-3);
                for (Skin& input : inputs) input.press(pressure, 1e-3);
            }
            const Bytes state = saved(skin);
            constexpr char part[] = "fibres\0";
            const unsigned char* at = &*std::search(state.begin(), state.end(), part, part + sizeof part) + 16;
            for (size_t pad = 0; pad < 2; ++pad)
                for (size_t kind = 0; kind < 3; ++kind)
                    for (const Cell& c : options.afferents[kind].cells) {
                        CAPTURE(kind);
                        CAPTURE(int(follow));
                        float planes[FIBRE_PLANES];
                        std::memcpy(planes, at, sizeof planes);
                        at += sizeof planes;
                        const double right =
                            inputs[kind].response(Quantity::sa1)[pad * size_t(cells) + size_t(c.y * width + c.x)];
                        CHECK(double(planes[FIBRE_INPUT]) == absolute(right, spring ? 1e-6 * std::abs(right) : 0));
                    }
        }
}

} // namespace

TEST_CASE("the input of a fibre is the response of SA1 at its depth, without gain, of a material set later and on any "
          "number of cells") {
    const Validated vulkan;
    check_inputs(vulkan, 21, 12, false);
    check_inputs(vulkan, 3, 1, true);
    check_inputs(vulkan, 7, 5, true, true);
    check_inputs(vulkan, 1, 1, false);
}

TEST_CASE("SA1 that follows the stress answers as a spring of the modulus at rest does, with the gain of the strain") {
    SkinDescription d = deep_ridges(21, 12);
    d.receptors.follow.sa1 = Signal::stress;
    SkinOptions options;
    options.count = 3, options.responses = {Quantity::sa1, Quantity::fa1};
    Material other = d.material;
    other.spring = 2e5;
    options.materials = {d.material, other, d.material};
    Random r;
    for (const std::optional<double> depth : {std::optional<double>(), {3e-4}}) {
        d.receptors.depth = {.sa1 = depth};
        SkinDescription strained = d, spring = d;
        strained.receptors.follow = {}, spring.receptors.follow = {};
        spring.material = {.modulus = 1, .viscosity = 0, .thickness = 1e-3, .curvature_length = 0};
        SkinOptions of_spring = options, of_strain = options;
        of_strain.responses = {Quantity::fa1};
        of_spring.responses = {Quantity::sa1};
        const auto at_rest = [](const Material& m) {
            return Material{.modulus = 1 / (1 / m.elements[0].modulus + 1 / m.elements[1].modulus + 1 / *m.spring),
                            .viscosity = 0};
        };
        of_spring.materials.clear();
        for (const Material& m : options.materials) of_spring.materials.push_back(at_rest(m));
        for (Device device : {Device::cpu(1), Device::cpu(3), Device::open("vulkan")}) {
            Skin skin(device, d, options), same(Device::cpu(1), strained, of_strain),
                springs(Device::cpu(1), spring, of_spring);
            for (int n = 0; n < 3; ++n) {
                const std::vector<float> pressure = drawn_pressure(r, 3 * 21 * 12);
                for (Skin* s : {&skin, &same, &springs}) s->press(pressure, 1e-3);
                if (n == 1) {
                    skin.set_material(other, std::vector<int>{2}), same.set_material(other, std::vector<int>{2});
                    springs.set_material(at_rest(other), std::vector<int>{2});
                }
            }
            CHECK(answers(skin, Quantity::fa1) == answers(same, Quantity::fa1));
            const std::vector<float> got = answers(skin, Quantity::sa1), signal = answers(springs, Quantity::sa1),
                                     C = answers(same, Quantity::curvature);
            for (size_t i = 0; i < got.size(); ++i) {
                CAPTURE(i);
                CHECK(got[i] == absolute(double(signal[i]) * (1 + 1e-5 * double(C[i])), 2e-6 * greatest_of(signal)));
            }
        }
    }
}

TEST_CASE("what a skin at depths cannot have is refused by name") {
    const auto says = [](auto change, const char* part) {
        SkinDescription d = deep_ridges(12, 9);
        SkinOptions options;
        change(d, options);
        refuses([&] { Skin(Device::cpu(1), d, options); }, part);
    };
    says([](SkinDescription& d, SkinOptions&) { d.material.elements[0].modulus_map = std::vector<double>(108, 1e5); },
         "receptors.depth.sa1 = 3e-04; allowed: none where the material differs");
    says([](SkinDescription& d, SkinOptions&) { d.edges = Edges::periodic; },
         "receptors.depth.sa1 = 3e-04; allowed: none with curvature.edges = \"periodic\"");
    says([](SkinDescription&, SkinOptions& o) { o.control = Control::depth; },
         "receptors.depth = (given); allowed: none with control = depth");
    says([](SkinDescription& d, SkinOptions&) { d.grid.spacing.reset(); }, "only with grid.spacing");
    says([](SkinDescription& d, SkinOptions&) { d.receptors.depth.fa1 = 200; },
         "receptors.depth.fa1 = 200; allowed: 0, or 1e-10 .. 100, a millionth and a million times grid.spacing");
    says([](SkinDescription& d, SkinOptions&) { d.receptors.follow.sa2 = Signal::stress; },
         "receptors.follow.sa2 = \"stress\"; allowed: \"strain\" in a skin pressed frame by frame: only scenes");
    says([](SkinDescription& d, SkinOptions&) { d.receptors.follow.sa1 = Signal::stress, d.material.dashpot = 1e5; },
         "receptors.follow.sa1 = \"stress\"; allowed: \"strain\", unless");
    says(
        [](SkinDescription& d, SkinOptions& o) {
            d.receptors.depth = {}, d.receptors.follow.sa1 = Signal::stress, o.control = Control::depth;
        },
        "receptors.follow.sa1");
    says(
        [](SkinDescription&, SkinOptions& o) {
            o.shear = true, o.sa2_stretch = {1, 0};
        },
        "sa2_stretch = (given); allowed: none with receptors.depth.sa2");
    says(
        [](SkinDescription& d, SkinOptions& o) {
            d.sites = {{Quantity::sa1, {1, 1}}}, o.shear = true;
        },
        "shear = true; allowed: false in a skin with sites");
}
