// SPDX-License-Identifier: MIT
// Receptors at depths: presses of skins with them beside presses of the same skin without, in the same rounds; and how
// far the spread of one pressed cell is off Love's sums, by the pyramid, by Fourier transforms and by the sums alone.
#include "bench/skins.hpp"
#include "host/core/cpu/spreading.hpp"
#include "host/lab/schedule/half_space.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace bench {

using namespace dermis;

namespace {

constexpr double h = 5e-5; // m
constexpr Depths fingertip = {.sa1 = 3e-4, .sa2 = 1.1e-3, .fa1 = 5e-4, .fa2 = 2e-3};

// Pads, and the depth of all classes in cells; 0: each class lies at the depth of a fingertip.
struct Shape {
    int width, height, pads;
    double spacing; // m
    std::vector<double> depths;
};

std::vector<Shape> shapes_of(bool quick) {
    const auto some = [quick](int pads) { return quick ? pads / 8 : pads; };
    std::vector<Shape> all = {{200, 200, 1, h, {0, 1, 6, 10, 22, 40}}};
    if (!quick)
        all.push_back({320, 240, 1, h, {1, 6, 10, 22, 40}}), all.push_back({1024, 1024, 1, h, {1, 6, 10, 22, 40}});
    for (const auto& [width, height, pads, z] : {std::tuple{4, 4, 4096, 1},
                                                 {8, 8, 2048, 1},
                                                 {12, 12, 1024, 1},
                                                 {16, 16, 4096, 1},
                                                 {20, 25, 512, 1},
                                                 {32, 32, 256, 2},
                                                 {64, 64, 64, 6}})
        all.push_back({width, height, some(pads), h, {double(z)}});
    all.back().depths.push_back(10);
    all.push_back({16, 16, 512, 1e-3, {0}});
    all.push_back({80, 80, 5, 2.5e-4, {0}}); // a hand
    return all;
}

void add_presses(Bench& bench, const Device& device, const Shape& shape) {
    Press p{.model = "surface",
            .skin = rectangle(shape.width, shape.height, shape.spacing),
            .options = in_f32(shape.pads),
            .reads_last = true,
            .ring = 1};
    std::vector<Press> all = {p};
    p.ratio_to = p.model;
    for (const double z : shape.depths) {
        const double depth = z * shape.spacing;
        p.model = z > 0 ? fmt::format("z/h={:g}", z) : "fingertip";
        p.skin.receptors.depth = z > 0 ? Depths{depth, depth, depth, depth} : fingertip;
        all.push_back(p);
    }
    measure_presses(bench, "depth", {device}, all, {2e6, 2e5}, bench.runs);
}

// What a pressed cell causes at cells 0 .. n - 1 columns and rows away, per unit of its pressure. depth: in cells.
std::vector<double> sums_of(const model::Depth& depth, int n) {
    const model::PointForce<double> below(depth);
    std::vector<double> sums(size_t(n) * size_t(n));
    for (int y = 0; y < n; ++y)
        for (int x = 0; x <= y; ++x)
            sums[size_t(y * n + x)] = sums[size_t(x * n + y)] = model::of_square(double(x), double(y), 1.0, below);
    return sums;
}

// The sum of all |errors| of a spread map on which cell (x, y) alone is pressed, by 1.
template <class T> double error_of(const T* spread, int n, int x, int y, const std::vector<double>& sums) {
    double error = 0;
    for (int v = 0; v < n; ++v) {
        const double* row = sums.data() + std::abs(v - y) * n;
        for (int u = 0; u < n; ++u) error += std::abs(double(spread[v * n + u]) - row[std::abs(u - x)]);
    }
    return error;
}

// One class of n x n cells, spread by the library on one thread.
class Pyramid {
  public:
    Pyramid(int n, const model::Depth& depth)
        : n_(n), skin_(skin_of(n, depth)), from_(simd::map_of(size_t(n) * size_t(n), 0.0f)), to_(from_),
          spreading_(skin_.skin, {{QUANTITY_SA1, skin_.spread[QUANTITY_SA1]}}, size_t(n), 1, false, 1, simd::best()) {}
    void spread() {
        const float* const from = from_.data();
        float* const to = to_.data();
        spreading_.spread({}, &from, &to, nullptr);
    }
    // Of the worst place among the nodes of a pressed cell; `places` of them along an axis.
    double error(const std::vector<double>& sums, int places) {
        const int period = std::min(1 << (skin_.spread[QUANTITY_SA1]->size() - 1), places),
                  first = n_ / 2 / period * period;
        double worst = 0;
        for (int y = first; y <= first + period / 2; ++y)
            for (int x = first; x <= y; ++x) {
                float& cell = from_[size_t(y * n_ + x)];
                cell = 1;
                spread();
                cell = 0;
                worst = std::max(worst, error_of(to_.data(), n_, x, y, sums));
            }
        return worst;
    }

  private:
    static model::StreamedSkin skin_of(int n, const model::Depth& depth) {
        SkinDescription d = rectangle(n, n);
        d.receptors.kernel = depth.kernel;
        d.receptors.depth.sa1 = depth.depth * *d.grid.spacing;
        if (depth.kernel != DepthKernel::stress) d.receptors.poisson = depth.poisson;
        SkinOptions options = in_f32();
        options.responses = {Quantity::sa1};
        return model::streamed_skin(d, options);
    }
    const int n_;
    const model::StreamedSkin skin_;
    std::vector<float> from_, to_;
    cpu::Spreading<f32> spreading_;
};

// Ways to spread a class to a depth, each with its error and its time for a map of 200 x 200 cells. all: beside the
// pyramid those that are right to the last digit.
void add_ways(Bench& bench, const model::Depth& depth, bool all) {
    constexpr int n = 200, x = 87, y = 101;
    std::vector<Contender> ways;
    const auto add = [&](const char* model, const char* precision, double error, int maps, auto work) {
        Measurement r = row_of(bench.cpu("depth-errors", n, 1), model, precision, maps);
        r.method = fmt::format("z/h={:g}", depth.depth);
        r.stencil = "";
        r.errors[1] = error;
        ways.push_back({r, [work] { return seconds_of(work); }});
    };
    const int wide = std::clamp(int(20 * depth.depth), 48, 640); // so that what lies beyond acts by little
    add(depth.kernel == DepthKernel::stress ? "pyramid" : "pyramid-strain", "f32",
        Pyramid(wide, depth).error(sums_of(depth, wide), bench.quick ? 4 : 64), 20,
        [p = std::make_shared<Pyramid>(n, depth)] {
            for (int i = 0; i < 20; ++i) p->spread();
        });
    const std::vector<double> sums = sums_of(depth, n);
    const Grid grid{n, n, 1.0};
    const model::HalfSpace space{grid, depth};
    std::vector<double> map(size_t(n) * n), at;
    map[size_t(y) * n + x] = 1;
    simd::Pool pool{1};
    if (all) {
        const auto transformed = [&] { return model::stresses_of(map, grid, {&space, &space}, pool); };
        add("fft-long-double", "f64", error_of(transformed()[1].data(), n, x, y, sums), 2, transformed);
        for (int i = 0; i < n * n; ++i) at.push_back(space.at<double>(map, {i % n, i / n}));
        add("sums", "f64", error_of(at.data(), n, x, y, sums), 1, [&] { // of one column
            for (int v = 0; v < n; ++v) at[size_t(v)] = space.at<double>(map, {n / 3, v});
        });
        ways.back().row.width = 1;
    }
    bench.measure(std::move(ways), bench.runs);
}

} // namespace

void depth(Bench& bench) {
    std::vector<Device> devices = bench.cpus();
    for (const Device& device : bench.devices()) devices.push_back(device);
    constexpr int most_in_pads = 600000; // cells on a device: margins of so many small pads take 300 bytes a cell
    for (const Shape& shape : shapes_of(bench.quick))
        for (const Device& device : devices)
            if (!device.info().vulkan || shape.pads == 1 || shape.pads * shape.width * shape.height <= most_in_pads)
                add_presses(bench, device, shape);
    constexpr double marked[] = {1, 6, 10, 22, 40}; // of all ways
    std::set<double> depths(std::begin(marked), std::end(marked));
    if (!bench.quick)
        depths.insert({0.3, 0.5, 0.7, 1.5, 2, 2.5, 3, 4, 5, 7, 7.99, 8, 12, 13.9, 14, 18, 27.9, 28, 55.9, 56});
    for (const double z : depths)
        for (const auto kernel : {DepthKernel::stress, DepthKernel::strain})
            add_ways(bench, {z, kernel, 0.4}, kernel == DepthKernel::stress && std::ranges::count(marked, z));
}

} // namespace bench
