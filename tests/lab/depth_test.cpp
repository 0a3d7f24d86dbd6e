// SPDX-License-Identifier: MIT
// labels: threads
// Receptors below the surface: they answer to the stress, or to the strain, that all cells cause at their depth.
#include "host/lab/planner/materials.hpp"
#include "tests/oracle/scene_files.hpp"
#include "tests/support.hpp"

#include <filesystem>
#include <random>

using namespace test;

namespace {

// A spring beside a dashpot of 20 ms, pressed for long; SA1 is then the stress over the modulus.
Scene pressed(int cells, double spacing, const std::vector<double>& map) {
    Scene s;
    s.grid = {.width = cells, .height = cells, .spacing = spacing};
    s.surface = {.kind = Surface::Kind::flat, .relief = 1e-6};
    s.material.modulus = 2e4;
    s.material.viscosity = 4e2;
    s.material.thickness = 1e-3;
    s.material.curvature_length = 0;
    s.load.kind = Load::Kind::map;
    s.load.map = map;
    s.time = {.step = 0.25, .duration = 1};
    s.output.traces = {Quantity::sa1};
    s.output.probes = {{cells / 2, cells / 2}};
    return s;
}

// Pressure by the distance from the middle cell, in cells.
template <class Of> std::vector<double> round_map(int cells, Of of) {
    std::vector<double> map;
    for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x) map.push_back(of(std::hypot(x - cells / 2, y - cells / 2)));
    return map;
}

// The least number >= n without prime factors above 5.
int smooth_number(int n) {
    for (;; ++n) {
        int rest = n;
        for (int factor : {2, 3, 5})
            while (rest % factor == 0) rest /= factor;
        if (rest == 1) return n;
    }
}

double at_end(const Scene& s) { return run(s).traces[0].probes[0].back() * *s.material.modulus; }

std::vector<double> field_of(const Scene& s, Quantity q, double at) {
    Scene asked = s;
    asked.output.fields = {{at, {q}}};
    return run(asked).fields[0].values;
}

// Ridges under a smooth load, each class at another depth.
Scene with_depths(int width, int height) {
    Scene s = small_scene(width, height);
    s.grid.spacing = 5e-5;
    s.surface.relief = 2e-5;
    s.material.modulus = 2e4;
    s.material.viscosity = 1e3;
    s.material.thickness = 1e-3;
    s.material.curvature_length = 5e-5;
    s.load.intensity = 1e4;
    s.receptors.depth = {.sa1 = 1e-4, .sa2 = 1e-3, .fa1 = 3e-4, .fa2 = 3e-4};
    s.output.probes.clear();
    return s;
}

} // namespace

TEST_CASE("on the axis of an even disc the stress is that of Boussinesq") {
    const int cells = 401;
    const double spacing = 1e-5, radius = 1.5e-3;
    // The cells on the rim take their share of the disc.
    const auto disc = round_map(cells, [&](double r) { return std::clamp(radius / spacing - r + 0.5, 0.0, 1.0); });
    for (double z : {1e-4, 3e-4, 1e-3, 2e-3}) {
        CAPTURE(z);
        Scene s = pressed(cells, spacing, disc);
        s.receptors.depth.sa1 = z;
        const double c = z / std::hypot(radius, z);
        CHECK(at_end(s) == doctest::Approx(1 - c * c * c).epsilon(2e-5));
        s.receptors.kernel = DepthKernel::strain; // E times strain, from the stresses of the same disc
        for (double nu : {0.0, 0.4, 0.5}) {
            s.receptors.poisson = nu;
            const double sideways = (1 + 2 * nu) / 2 - (1 + nu) * c + c * c * c / 2; // each of the horizontal stresses
            CHECK(at_end(s) == doctest::Approx(1 - c * c * c - 2 * nu * sideways).epsilon(1e-4));
        }
    }
}

TEST_CASE("every cell has the sum over all cells, of a stress and of a strain") {
    Scene s = with_depths(23, 17);
    std::vector<double> map;
    s.load = {.kind = Load::Kind::map};
    for (int i = 0; i < 23 * 17; ++i) map.push_back(std::sin(3.0 * i) * (i % 5));
    s.load.map = map;
    s.material.curvature_length = 0;
    for (auto [kernel, nu] : {std::pair{DepthKernel::stress, 0.0},
                              {DepthKernel::strain, 0.0},
                              {DepthKernel::strain, 0.37},
                              {DepthKernel::strain, 0.5},
                              {DepthKernel::displacement, 0.37}}) {
        s.receptors.kernel.fa2 = kernel;
        s.receptors.poisson.reset();
        if (kernel != DepthKernel::stress) s.receptors.poisson = nu;
        const std::vector<double> deep = field_of(s, Quantity::fa2, 0.3), own = [&] {
            Scene flat = s;
            flat.receptors.depth = {};
            flat.receptors.kernel = DepthKernel::stress;
            flat.receptors.poisson.reset();
            return field_of(flat, Quantity::fa2, 0.3);
        }();
        std::vector<long double> weights;
        for (int i = 0; i < 23 * 17; ++i)
            weights.push_back(oracle::below_cell(5e-5L * (i % 23), 5e-5L * (i / 23), 5e-5L, 3e-4L, kernel, nu));
        std::vector<double> sums;
        for (int i = 0; i < 23 * 17; ++i) {
            long double sum = 0;
            for (int j = 0; j < 23 * 17; ++j)
                sum += own[size_t(j)] * weights[size_t(std::abs(i / 23 - j / 23) * 23 + std::abs(i % 23 - j % 23))];
            sums.push_back(double(sum));
        }
        CHECK(difference(deep, sums) < 1e-12);
    }
}

TEST_CASE("what a cell adds is right to its last place, however near, deep or far away it is") {
    for (double depth : {0.05, 0.9, 1.9, 2.1, 3.9, 4.1, 30.0, 44.0, 46.0, 1000.0, 2e4}) // cells
        for (auto kernel : {DepthKernel::stress, DepthKernel::strain, DepthKernel::displacement}) {
            CAPTURE(depth);
            CAPTURE(kernel);
            const double h = 0x1p-14;
            const model::HalfSpace space({.width = 60, .height = 50, .spacing = h}, {depth * h, kernel, 0.3});
            double norm = 0, squares = 0, most = 0, worst = 0;
            for (int y = 0; y < 50; ++y)
                for (int x = 0; x < 60; ++x) {
                    const double w = space.weight(-x, y), of = (x > 0 ? 2 : 1) * (y > 0 ? 2 : 1);
                    norm += of * std::abs(w), squares += of * w * w, most = std::max(most, std::abs(w));
                    if ((x * y) % 7 > 1 || (x + y > 3 && depth < 1)) continue; // the reference takes its time
                    const long double exact = oracle::below_cell(x * h, y * h, h, depth * h, kernel, 0.3);
                    worst = std::max(worst, double(std::abs(w - exact)) / std::max(std::abs(w), space.most() / 8));
                }
            CHECK(worst <= 1.1 * 0x1p-53);
            CHECK(space.norm() == doctest::Approx(norm).epsilon(1e-12));
            CHECK(space.squares() == doctest::Approx(squares).epsilon(1e-12));
            CHECK(space.most() == most);
        }
}

TEST_CASE("weights that are computed in 53 binary digits are off by no more than the excess for 53 digits") {
    constexpr int n = 60;
    for (double h : {0x1p-14, 5e-5, 7.7e-4})
        for (double depth : {1e-3, 0.05, 0.3, 1.9, 2.1, 10.0, 44.0, 79.0, 1000.0, 2e4}) // cells
            for (auto kernel : {DepthKernel::stress, DepthKernel::strain, DepthKernel::displacement})
                for (double nu : {0.3, 0.5}) {
                    CAPTURE(depth);
                    CAPTURE(kernel);
                    CAPTURE(nu);
                    const model::Depth below{depth * h, kernel, nu};
                    const model::HalfSpace space({.width = n, .height = n, .spacing = h}, below);
                    const model::PointForce<double> force(below);
                    double sum = 0, most = 0;
                    for (int y = 0; y < n; ++y)
                        for (int x = 0; x < n; ++x) {
                            const double off = model::of_square(x * h, y * h, h, force) - space.weight(x, y);
                            sum += (x > 0 ? 2 : 1) * (y > 0 ? 2 : 1) * std::abs(off),
                                most = std::max(most, std::abs(off));
                        }
                    // `off` has the rounding of the better weight too, of half a unit.
                    CHECK(sum <= space.excess(space.norm(), 4.0 * n * n, 53) + 1.6 * 0x1p-53 * space.norm());
                    CHECK(most <= space.excess(space.most(), 1, 53) + 1.6 * 0x1p-53 * space.most());
                    CHECK(space.excess(space.norm(), 4.0 * n * n, 53) >= 14 * 0x1p-53 * space.norm());
                    if (depth < 0.3) continue; // the terms of a strain may cancel there, whatever the digits
                    for (int digits : {64, 106, 113}) CHECK(space.excess(space.norm(), 4.0 * n * n, digits) == 0);
                }
}

TEST_CASE("the strain just below a cell that keeps its volume is within its excess, though its terms cancel") {
    for (double depth : {1e-6, 1e-5, 1e-4}) // cells
        for (double h : {1e-3, 5e-5, 7.7e-4}) {
            CAPTURE(depth);
            CAPTURE(h);
            const model::HalfSpace space({.width = 1, .height = 1, .spacing = h},
                                         {depth * h, DepthKernel::strain, 0.5});
            // Love's solution on the axis of a square; its arcs cancel at a Poisson's ratio of 1/2.
            const long double a = h / 2.0L, z = depth * h, R = std::sqrt(2 * a * a + z * z),
                              exact = 6 / std::numbers::pi_v<long double> * a * a * z / (R * (a * a + z * z));
            const double off = double(std::abs(space.weight(0, 0) - exact)), plain = 1.1 * 0x1p-53 * double(exact);
            CHECK(off <= plain + space.excess(double(exact), 1));
            if (std::numeric_limits<long double>::digits == 64) CHECK(off > plain); // so that the excess is needed
        }
}

TEST_CASE("stresses at a depth are within their bound, which is at most 100 times their error") {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> number(-1, 1);
    simd::Pool pool(1);
    for (auto [width, height] : {std::pair{20, 30}, {33, 32}, {48, 40}, {64, 75}}) // above 1,024 cells by transforms
        for (double depth : {1.0, 3.0, 10.0, 40.0})
            for (int kind = 0; kind < 4; ++kind) {
                CAPTURE(width);
                CAPTURE(depth);
                CAPTURE(kind);
                const double h = 0x1p-14, nu = 0.25;
                const Grid grid{.width = width, .height = height, .spacing = h};
                const int cells = width * height;
                std::vector<double> map;
                for (int i = 0; i < cells; ++i) {
                    const double r = std::hypot(i % width - width / 3, i / width - height / 2) / 9;
                    map.push_back(kind == 0   ? 1e4 * number(random)
                                  : kind == 1 ? 3e3 * std::abs(number(random))
                                  : kind == 2 ? std::sqrt(std::max(0.0, 1 - r * r))
                                              : i == cells / 2);
                }
                const DepthKernel kernel = kind == 3   ? DepthKernel::strain
                                           : kind == 2 ? DepthKernel::displacement
                                                       : DepthKernel::stress;
                const model::HalfSpace first(grid, {depth * h, DepthKernel::stress, 0}),
                    space(grid, {depth * h, kernel, nu});
                const auto stress = model::stresses_of(map, grid, {&first, &space}, pool)[1];
                std::vector<long double> weights;
                for (int i = 0; i < cells; ++i)
                    weights.push_back(oracle::below_cell(h * (i % width), h * (i / width), h, depth * h, kernel, nu));
                double error = 0, peak = 0;
                for (int i = 0; i < cells; ++i) {
                    long double sum = 0;
                    for (int j = 0; j < cells; ++j)
                        sum +=
                            map[size_t(j)] *
                            weights[size_t(std::abs(i / width - j / width) * width + std::abs(i % width - j % width))];
                    error = std::max(error, double(std::abs(stress[size_t(i)] - sum)));
                    peak = std::max(peak, std::abs(stress[size_t(i)]));
                }
                const double bound = model::error_of_stresses(map, grid, space);
                CHECK(error > 0);
                CHECK(error <= 0x1p-53 * peak + bound); // a stress is rounded to double
                CHECK(0x1p-53 * peak + bound <= 100 * error);
                // The bound is what its comment says.
                double sum = 0, squares = 0, most = 0;
                for (double p : map) sum += std::abs(p), squares += p * p, most = std::max(most, std::abs(p));
                const double both = std::sqrt(squares * space.squares()),
                             magnitudes = std::min({most * space.norm(), both, sum * space.most()});
                const double units =
                    cells <= 1024
                        ? (0.25 * width + height + 4) * magnitudes
                        : (66 * std::log2(double(smooth_number(2 * width - 1) * smooth_number(2 * height - 1))) + 4) *
                              1.8 * both;
                CHECK(bound == doctest::Approx(1.1 * 0x1p-53 * magnitudes + 0x1p-64 * units).epsilon(1e-6));
            }
}

TEST_CASE("a response at a depth is the signal there times the gain at the surface") {
    Scene s = with_depths(40, 31);
    s.model = Model::maps;
    const double at = 0.35, l = *s.material.curvature_length;
    const std::vector<double> C = field_of(s, Quantity::curvature, at);
    Scene plain = s;
    plain.material.curvature_length = 0;
    for (Quantity q : all_responses) {
        std::vector<double> expected = field_of(plain, q, at);
        for (size_t i = 0; i < C.size(); ++i) expected[i] *= 1 + l * C[i];
        CHECK(difference(field_of(s, q, at), expected) < 1e-13);
    }
    CHECK(field_of(s, Quantity::strain, at) == field_of(
                                                   [&] {
                                                       Scene surface = s;
                                                       surface.receptors.depth = {};
                                                       return surface;
                                                   }(),
                                                   Quantity::strain, at));
}

TEST_CASE("means and extremes at a depth are those of the field") {
    Scene s = with_depths(40, 31);
    s.output.traces = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    const Result traced = run(s);
    CHECK(int(traced.model) == int(Model::moments));
    for (size_t t = 0; t < 4; ++t)
        for (size_t n : {1u, 4u, 7u}) {
            const std::vector<double> field = field_of(s, traced.traces[t].quantity, double(n) * s.time.step);
            double mean = 0;
            for (double v : field) mean += v / double(field.size());
            const auto [least, most] = std::ranges::minmax_element(field);
            const double scale = std::max(std::abs(*least), std::abs(*most));
            CHECK(std::abs(traced.traces[t].mean[n] - mean) < 1e-13 * scale);
            CHECK(std::abs(traced.traces[t].min[n] - *least) < 1e-13 * scale);
            CHECK(std::abs(traced.traces[t].max[n] - *most) < 1e-13 * scale);
        }
}

// The same scene with four frames in a file in place of the map, each times a value of the table.
struct AsFrames {
    explicit AsFrames(Scene& product) : path(temporary("depth.npy")) {
        product.load.envelope = {
            .kind = Envelope::Kind::table, .times = {0, 0.1, 0.2, 0.3}, .values = {0, 1, 0.25, 0.5}};
        product.receptors.fa2 = Fa2::step_mean;
        std::vector<std::vector<double>> frames;
        for (double level : product.load.envelope.values)
            for (frames.emplace_back(); double p : maps(product).pressure) frames.back().push_back(p * level);
        oracle::write_frames(path, product.grid, frames);
        scene = product;
        scene.load = {.kind = Load::Kind::sequence, .path = path.string(), .interval = 0.1};
    }
    ~AsFrames() { std::filesystem::remove(path); }
    std::filesystem::path path;
    Scene scene;
};

TEST_CASE("receptors at a depth answer under frames as under the product that these frames are samples of") {
    Scene product = with_depths(33, 20);
    product.output.traces.clear();
    for (int i = 0; i < 20; ++i) product.sites.push_back({all_responses[i % 4], {(7 * i) % 33, (3 * i) % 20}});
    const AsFrames frames(product);
    const Result a = run(frames.scene), b = run(product);
    CHECK(int(a.model) == int(Model::sites));
    CHECK(difference(a.responses, b.responses) < 1e-12);
}

TEST_CASE("a receptor at a depth beside the pressed cells is bent by them") {
    Scene product = with_depths(33, 20);
    product.output.traces.clear();
    std::vector<double> map(33 * 20, 0);
    for (int x = 0; x < 33; ++x) map[size_t(9 * 33 + x)] = 1;
    product.load = {.kind = Load::Kind::map, .intensity = 1e4, .map = map};
    product.sites = {{Quantity::sa1, {16, 10}}}; // no other receptor needs the cells above
    const AsFrames frames(product);
    Scene even = product;
    even.material.curvature_length = 0;
    const Result a = run(frames.scene), b = run(product);
    CHECK(int(a.model) == int(Model::sites));
    CHECK(difference(b.responses, run(even).responses) > 1e-3);
    CHECK(difference(a.responses, b.responses) < 1e-12);
    product.tolerance = 1e-9; // with witnesses
    const Result witnessed = run(product);
    CHECK(witnessed.measured_error <= witnessed.predicted_error);
}

// All responses, in fields, means, extremes, a probe and sites.
Scene read_everywhere(int width, int height) {
    Scene s = with_depths(width, height);
    s.output.traces.assign(std::begin(all_responses), std::end(all_responses));
    s.output.fields = {{0.3, s.output.traces}, {0.17, {Quantity::strain, Quantity::sa1}}};
    s.output.probes = {{width / 2, height / 2}};
    for (int i = 0; i < 8; ++i) s.sites.push_back({all_responses[i % 4], {(width + i) / 2, (height - i) / 2}});
    return s;
}

// The greatest difference of any output, by the greatest value of its quantity in a field.
double distance_of(const Result& a, const Result& b) {
    std::map<Quantity, double> greatest;
    for (const Field& f : b.fields)
        for (double v : f.values) greatest[f.quantity] = std::max(greatest[f.quantity], std::abs(v));
    double most = 0;
    const auto take = [&](Quantity q, const std::vector<double>& x, const std::vector<double>& y) {
        REQUIRE(x.size() == y.size());
        for (size_t i = 0; i < x.size(); ++i) most = std::max(most, std::abs(x[i] - y[i]) / greatest[q]);
    };
    for (size_t i = 0; i < a.fields.size(); ++i) take(a.fields[i].quantity, a.fields[i].values, b.fields[i].values);
    for (size_t i = 0; i < a.traces.size(); ++i) {
        const Quantity q = a.traces[i].quantity;
        take(q, a.traces[i].mean, b.traces[i].mean);
        take(q, a.traces[i].min, b.traces[i].min);
        take(q, a.traces[i].max, b.traces[i].max);
        take(q, a.traces[i].probes[0], b.traces[i].probes[0]);
    }
    for (size_t i = 0; i < a.responses.size(); ++i) take(all_responses[i % 4], {a.responses[i]}, {b.responses[i]});
    return most;
}

TEST_CASE("fields, traces and sites of frames at depths are those of the product, within 1e-3 of what presses") {
    for (auto kernel : {DepthKernel::stress, DepthKernel::strain, DepthKernel::displacement}) {
        Scene product = kernel == DepthKernel::displacement ? read_everywhere(41, 20) : read_everywhere(70, 41);
        product.receptors.kernel = kernel;
        if (kernel != DepthKernel::stress) product.receptors.poisson = 0.4;
        const AsFrames frames(product);
        const Result a = run(frames.scene), b = run(product);
        CHECK(int(a.model) == int(Model::march));
        CHECK(int(a.precision) == int(Precision::f32_compensated)); // double would be no better
        CHECK(distance_of(a, b) < 1e-3);
        CHECK(distance_of(a, b) > 1e-6);
        CHECK(a.predicted_error > 1e-3);
        CHECK(a.predicted_error < (kernel == DepthKernel::displacement ? 0.5 : 2e-2)); // of a sum above 1
    }
}

TEST_CASE("a march at depths on a grid of 8 x 8, whose weights are those of the sums, is exact") {
    Scene product = read_everywhere(8, 7);
    const AsFrames frames(product);
    Scene marched = product, framed = frames.scene;
    marched.model = framed.model = Model::march;
    marched.precision = framed.precision = Precision::f64;
    for (const Scene& s : {marched, framed}) CHECK(distance_of(run(s), run(product)) < 1e-12);
}

TEST_CASE("a class without a depth has the bits of a march without depths, beside classes with one") {
    Scene s = read_everywhere(40, 31);
    s.model = Model::march;
    for (Precision precision : {Precision::f32, Precision::f64}) {
        s.precision = precision;
        s.receptors.depth = {};
        const Result surface = run(s, Device::cpu(1));
        s.receptors.depth.fa2 = 3e-4;
        const Result deep = run(s, Device::cpu(1));
        for (size_t i : {0u, 1u, 2u, 3u, 4u}) CHECK(deep.fields[i].values == surface.fields[i].values);
        CHECK(deep.fields[5].values != surface.fields[5].values);
        for (size_t t = 0; t < 3; ++t) {
            CHECK(deep.traces[t].mean == surface.traces[t].mean);
            CHECK(deep.traces[t].max == surface.traces[t].max);
            CHECK(deep.traces[t].probes == surface.traces[t].probes);
        }
    }
}

TEST_CASE(
    "a tolerance that is given binds a march at depths: witnesses keep it, or it is refused with what is in reach") {
    Scene product = read_everywhere(70, 41);
    const AsFrames frames(product);
    Scene s = frames.scene;
    s.tolerance = 2e-2;
    const Result r = run(s);
    CHECK(int(r.model) == int(Model::march));
    CHECK(r.measured_cells >= 4);
    CHECK(r.measured_error > 0);
    CHECK(r.measured_error < r.predicted_error);
    s.tolerance = 5e-4;
    const std::string refused = refusal(Error::Code::bad_input, [&] { run(s); });
    CHECK(refused.find("tolerance = 5e-04; attainable here: 0.01") != std::string::npos);
    CHECK(refused.find("with model march in f64") != std::string::npos);
    s.output.traces.clear(), s.output.fields.clear(); // sites alone take the sums themselves
    CHECK(int(run(s).model) == int(Model::sites));
    product.tolerance = 1e-9;
    CHECK(int(run(product).model) == int(Model::maps));
}
