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
    Press p{
        .model = "surface", .skin = rectangle(shape.width, shape.height, shape.spacing), .options = in_f32(shape.pads)};
    p.reads_last = true;
    const Frames frames = frames_of(p, 1);
    const double cells = (device.info().kind == "software" ? 2e5 : 2e6) / double(p.cells_of_frame());
    const int count = std::clamp(int(cells), 1, 2000);
    std::vector<Contender> all = {pressed(bench, device, "depth", p, count, frames, 1)};
    for (const double z : shape.depths) {
        const double depth = z * shape.spacing;
        p.model = z > 0 ? fmt::format("z/h={:g}", z) : "fingertip";
        p.skin.receptors.depth = z > 0 ? Depths{depth, depth, depth, depth} : fingertip;
        all.push_back(pressed(bench, device, "depth", p, count, frames, 1));
        all.back().ratio_to = "surface";
    }
    bench.measure(std::move(all), bench.runs);
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

// Ways to spread a class to a depth, each with its error and its time for a map of 200 x 200 cells.
class Ways {
  public:
    Ways(Bench& bench, const model::Depth& depth) : bench_(bench), depth_(depth), sums_(sums_of(depth, n)) {}
    void add_pyramid() {
        const int wide = std::clamp(int(20 * depth_.depth), 48, 640); // so that what lies beyond acts by little
        const double error = Pyramid(wide, depth_).error(sums_of(depth_, wide), bench_.quick ? 4 : 64);
        const bool stress = depth_.kernel == DepthKernel::stress;
        add(stress ? "pyramid" : "pyramid-strain", "f32", error, 20, [p = std::make_shared<Pyramid>(n, depth_)] {
            return seconds_of([&] {
                for (int i = 0; i < 20; ++i) p->spread();
            });
        });
    }
    void add_transforms() {
        const auto long_double = [this] { return model::stresses_of(map_, grid_, {&space_, &space_}, pool_); };
        add("fft-long-double", "f64", error_of(long_double()[1].data(), n, x, y, sums_), 2,
            [=] { return seconds_of(long_double); });
    }
    // Of the cells of one column.
    void add_sums() {
        std::vector<double> all;
        for (int i = 0; i < int(cells); ++i) all.push_back(space_.at<double>(map_, {i % n, i / n}));
        add("sums", "f64", error_of(all.data(), n, x, y, sums_), 1, [this] {
            return seconds_of([&] {
                double sum = 0;
                for (int v = 0; v < n; ++v) sum += space_.at<double>(map_, {n / 3, v});
                if (std::isnan(sum)) throw std::runtime_error("depths: a sum is not a number");
            });
        });
        all_.back().row.width = 1;
    }
    void measure() { bench_.measure(std::move(all_), bench_.runs); }

  private:
    void add(const char* model, const char* precision, double error, int maps, std::function<double()> work) {
        Measurement r = row_of(bench_.cpu("depth-errors", n, 1), model, precision, maps);
        r.method = fmt::format("z/h={:g}", depth_.depth);
        r.stencil = "";
        r.errors[1] = error;
        all_.push_back({r, std::move(work)});
    }
    static constexpr int n = 200, x = 87, y = 101;
    static constexpr size_t cells = size_t(n) * n, pressed = size_t(y) * n + x;
    Bench& bench_;
    const model::Depth depth_;
    const std::vector<double> sums_;
    const Grid grid_{n, n, 1.0};
    const model::HalfSpace space_{grid_, depth_};
    const std::vector<double> map_ = [] {
        std::vector<double> map(cells);
        map[pressed] = 1;
        return map;
    }();
    simd::Pool pool_{1};
    std::vector<Contender> all_;
};

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
        for (const auto kernel : {DepthKernel::stress, DepthKernel::strain}) {
            Ways ways(bench, {z, kernel, 0.4});
            ways.add_pyramid();
            if (std::ranges::count(marked, z) && kernel == DepthKernel::stress) ways.add_transforms(), ways.add_sums();
            ways.measure();
        }
}

} // namespace bench
