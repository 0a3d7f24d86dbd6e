// SPDX-License-Identifier: MIT
// Many small pads and receptors, as robots have them: batches beside single skins, sites beside fields, and presses at
// 1 kHz. What is compared is timed in the same rounds.
#include "bench/bench.hpp"
#include "bench/native_pads_loops.hpp"
#include "host/core/base/pool.hpp"
#include "host/core/model/coefficients.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/model/streamed_skin.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <fmt/format.h>
#include <memory>
#include <random>
#include <set>
#include <thread>

namespace bench {

using namespace dermis;

namespace {

SkinDescription rectangle(int width, int height) {
    SkinDescription d;
    d.grid = {width, height, 2.5e-4};
    d.surface.relief = 5e-5;
    d.material = {.modulus = 20e3, .viscosity = 1e3, .thickness = 1e-3, .curvature_length = 1e-5};
    return d;
}

SkinDescription with_sites(SkinDescription d, int count) {
    std::mt19937 random(7);
    constexpr Quantity types[] = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    for (int i = 0; i < count; ++i)
        d.sites.push_back(
            {types[i % 4], {int(random() % unsigned(d.grid.width)), int(random() % unsigned(d.grid.height))}});
    return d;
}

constexpr double press_dt = 0.001; // s

// Skins of one kind and their pressures.
class Contender {
  public:
    // pads: of each of the skins. pressure: Pa; 0 for skins that stay at rest.
    Contender(const Device& device, const SkinDescription& d, int pads, int skins, float pressure) {
        SkinOptions options;
        options.precision = Precision::f32;
        options.count = pads;
        for (int i = 0; i < skins; ++i) skins_.push_back(std::make_unique<Skin>(device, d, options));
        const size_t cells = size_t(pads) * size_t(d.grid.width) * size_t(d.grid.height);
        for (int i = 0; i < 2; ++i) frames_.emplace_back(cells, pressure * float(1 + i));
    }
    double seconds(int presses) {
        return seconds_of([&] {
            for (int i = 0; i < presses; ++i)
                for (auto& skin : skins_) skin->press(frames_[size_t(i % 2)], press_dt);
        });
    }

  private:
    std::vector<std::unique_ptr<Skin>> skins_;
    std::vector<std::vector<float>> frames_;
};

// The native peer: the bits of a batch of pads by a loop for this one kind of pad.
class NativePads {
  public:
    NativePads(const SkinDescription& d, int pads, int threads)
        : pads_(pads), cells_(size_t(d.grid.width) * size_t(d.grid.height)), pitch_((cells_ + 15) / 16 * 16),
          pool_(threads), rest_(pitch_), scratch_(size_t(threads), std::vector<float>(2 * pitch_)) {
        SkinOptions options;
        options.precision = Precision::f32;
        const plan::StreamedSkin skin = plan::streamed_skin(d, options);
        const auto width = size_t(d.grid.width);
        for (size_t y = 0; y * width < cells_; ++y) {
            std::vector<double> row(width);
            plan::rest_curvature_row(skin.skin, int(y), 0, int(width), row.data());
            std::ranges::transform(row, rest_.begin() + long(y * width), [](double x) { return float(x); });
        }
        for (auto& inside : inside_) inside.assign(pitch_, 0);
        for (size_t i = 0; i < cells_; ++i) {
            inside_[0][i] = i % width > 0 ? -1 : 0;
            inside_[1][i] = i % width < width - 1 ? -1 : 0;
            inside_[2][i] = i >= width ? -1 : 0;
            inside_[3][i] = i + width < cells_ ? -1 : 0;
        }
        const size_t beside = width + 16; // what is read beside the first pad and the last one
        for (size_t m = 0; m < std::size(maps_); ++m) maps_[m].assign(pitch_ * size_t(pads) + 2 * beside + 80 * m, 0);
        const auto map = [&](size_t m) { return maps_[m].data() + beside + 80 * m; }; // at other bits of an address
        batch_ = {.step = step_of(skin),
                  .cells = cells_,
                  .width = width,
                  .pitch = pitch_,
                  .rest = rest_.data(),
                  .inside = {inside_[0].data(), inside_[1].data(), inside_[2].data(), inside_[3].data()},
                  .strain = map(0),
                  .integral = map(1),
                  .from = map(2),
                  .to = map(3),
                  .responses = {map(4), map(5), map(6), map(7)}};
    }
    void press(const std::vector<float>& pressure) {
        std::atomic<bool> finite = true;
        pool_.share(pads_, [&](int first, int last) {
            if (!native::take_pads(batch_, size_t(first), size_t(last), pressure.data())) finite = false;
        });
        if (!finite) throw std::runtime_error("the native pads: a pressure is not finite");
        pool_.each([&](int thread) {
            const auto at = [&](int t) { return size_t(pads_) * size_t(t) / size_t(pool_.threads()); };
            native::press_pads(batch_, at(thread), at(thread + 1), scratch_[size_t(thread)].data());
        });
        std::swap(batch_.from, batch_.to);
    }
    bool same(const Skin& skin) const {
        return std::ranges::all_of(std::array{0, 1, 2, 3}, [&](int r) {
            const Skin::Response own = skin.response(Quantity(r + 1));
            return std::memcmp(own.data, batch_.responses[r], own.size * sizeof(float)) == 0;
        });
    }

  private:
    static native::PadStep step_of(const plan::StreamedSkin& s) {
        const auto k = plan::rounded<f32>(plan::exact_coefficients(s.skin.materials[0], s.skin.rule, press_dt));
        const f32::Constants c = plan::frame_constants(s.skin, k);
        return {.E = k.E,
                .b = k.b,
                .f = k.f,
                .i0 = k.i0,
                .i1 = k.i1,
                .i2 = k.i2,
                .leak = k.leak,
                .v0 = k.v0,
                .v1 = k.v1,
                .a0 = k.a0,
                .a1 = k.a1,
                .a2 = k.a2,
                .start = c.start,
                .rise = c.rise,
                .jump = c.jump,
                .bend = c.bend,
                .length = c.curvature_length};
    }

    const int pads_;
    const size_t cells_, pitch_;
    simd::Pool pool_;
    std::vector<float> rest_, maps_[8];
    std::vector<int> inside_[4];
    std::vector<std::vector<float>> scratch_; // of each thread
    native::PadBatch batch_{};
};

struct Row {
    const char* model;
    SkinDescription description;
    int pads, skins;
    float pressure = 1e4f;
    long long cells() const {
        return static_cast<long long>(description.grid.width) * description.grid.height * pads * skins;
    }
    int presses(const Device* device) const {   // at once
        const double work = device ? 5e5 : 2e6; // cells
        return std::clamp(int(work / double(cells())), 2, 2000);
    }
};

void add_rows(Bench& bench, const Device* device, const std::vector<Row>& all) {
    const Device cpu = Device::cpu(1);
    std::vector<std::unique_ptr<Contender>> contenders;
    std::vector<std::function<double()>> work;
    for (const Row& r : all) {
        contenders.push_back(
            std::make_unique<Contender>(device ? *device : cpu, r.description, r.pads, r.skins, r.pressure));
        work.push_back([c = contenders.back().get(), n = r.presses(device)] { return c->seconds(n); });
    }
    const std::vector<Timing> timings = bench.paired(work, bench.runs);
    for (size_t i = 0; i < all.size(); ++i) {
        Measurement r = device ? bench.on_vulkan("pads", 0) : bench.cpu("pads", 0, 1);
        r.model = all[i].model;
        r.method = fmt::format("exact-{}x{}x{}", all[i].description.grid.width, all[i].description.grid.height,
                               all[i].pads * all[i].skins);
        r.precision = "f32";
        r.width = all[i].description.grid.width;
        r.height = all[i].cells() / r.width;
        r.receptors = static_cast<long long>(all[i].description.sites.size()) * all[i].pads;
        r.steps = all[i].presses(device);
        r.wall = timings[i];
        bench.add(r);
    }
}

// Adds a batch of pads on the CPU beside the native peer, which must have the same bits.
void add_batch(Bench& bench, const SkinDescription& d, int pads, int threads) {
    SkinOptions options;
    options.precision = Precision::f32;
    options.count = pads;
    Skin batch(Device::cpu(threads), d, options);
    NativePads native(d, pads, threads);
    const size_t cells = size_t(pads) * size_t(d.grid.width) * size_t(d.grid.height);
    std::mt19937 random(11);
    std::vector<std::vector<float>> frames(4, std::vector<float>(cells));
    for (std::vector<float>& frame : frames)
        for (float& p : frame) p = float(random() % 20000);
    for (size_t i = 0; i < 6; ++i) {
        batch.press(frames[i % 4], press_dt);
        native.press(frames[i % 4]);
    }
    if (!native.same(batch)) throw std::runtime_error("the native pads differ from the batch");
    const int presses = std::clamp(int(2e6 / double(cells)), 2, 2000);
    const auto timed = [&](auto& pressed) {
        return std::function<double()>([&] {
            return seconds_of([&] {
                for (int i = 0; i < presses; ++i) pressed(frames[size_t(i % 4)]);
            });
        });
    };
    const auto press_batch = [&](const std::vector<float>& frame) { batch.press(frame, press_dt); };
    const auto press_native = [&](const std::vector<float>& frame) { native.press(frame); };
    const std::vector<Timing> timings = bench.paired({timed(press_native), timed(press_batch)}, 2 * bench.runs);
    for (size_t i = 0; i < 2; ++i) {
        Measurement r = bench.cpu("pads", 0, threads);
        r.model = i == 0 ? "native-bits" : "batch";
        r.method = fmt::format("exact-{}x{}x{}", d.grid.width, d.grid.height, pads);
        r.precision = "f32";
        r.width = d.grid.width;
        r.height = static_cast<long long>(d.grid.height) * pads;
        r.receptors = 0;
        r.steps = presses;
        r.bytes_per_cell = 48; // read and written: pressures, strain and integral, the pressure taken, four responses
        r.wall = timings[i];
        if (i == 1) r.relative_to("native-bits", timings[0], r.bytes());
        bench.add(r);
    }
}

// Batches by the size of a pad and their number, and single skins with the same number of cells.
void add_sizes(Bench& bench, const Device* device) {
    const int most = device || bench.quick ? 64000 : 1 << 24; // cells
    for (const auto& [width, height] : {std::pair{4, 4}, {4, 6}, {8, 8}, {16, 16}, {20, 25}, {64, 64}})
        for (int count = 64; count <= 4096 && count * width * height <= most; count *= 8) {
            if (device) add_rows(bench, device, {{"batch", rectangle(width, height), count, 1}});
            else
                for (int threads : std::set{1, bench.cores}) add_batch(bench, rectangle(width, height), count, threads);
        }
    std::vector<Row> single;
    for (int n : {8, 32, 128, 512, 1024})
        if (n * n <= (device || bench.quick ? 128000 : 1 << 20)) single.push_back({"one-skin", rectangle(n, n), 1, 1});
    add_rows(bench, device, single);
}

// Saving and loading the state of 2000 pads, beside a copy of the same number of bytes.
void add_state(Bench& bench) {
    SkinOptions options;
    options.count = 2000;
    const SkinDescription d = rectangle(20, 25);
    Skin skin(Device::cpu(), d, options);
    skin.press(std::vector<float>(size_t(options.count) * 500, 1e4f), 0.001);
    std::vector<char> state(skin.state_bytes()), copy(state.size());
    skin.save(state.data(), state.size());
    const std::vector<Timing> timings =
        bench.paired({[&] { return seconds_of([&] { std::memcpy(copy.data(), state.data(), state.size()); }); },
                      [&] { return seconds_of([&] { skin.save(state.data(), state.size()); }); },
                      [&] { return seconds_of([&] { skin.load(state.data(), state.size()); }); }},
                     3 * bench.runs);
    const char* const models[] = {"memcpy", "save", "load"};
    for (size_t i = 0; i < timings.size(); ++i) {
        Measurement r = bench.cpu("state", 0, bench.cores);
        r.model = models[i];
        r.width = d.grid.width;
        r.height = static_cast<long long>(d.grid.height) * options.count;
        r.steps = 1;
        r.wall = timings[i];
        bench.add(r);
    }
}

// Making 4096 pads, and the second skin of a kind on a device.
void add_made(Bench& bench, const Device* device) {
    for (int count : {4096, 1}) {
        SkinOptions options;
        options.count = count;
        const SkinDescription d = rectangle(20, 25);
        const Device cpu = Device::cpu();
        Measurement r = device ? bench.on_vulkan("pads-made", 0) : bench.cpu("pads-made", 0, bench.cores);
        r.model = count == 1 ? "second-skin" : "batch";
        r.width = d.grid.width;
        r.height = static_cast<long long>(d.grid.height) * count;
        r.steps = 1;
        r.wall = bench.paired({[&] { return seconds_of([&] { Skin(device ? *device : cpu, d, options); }); }},
                              bench.runs)[0];
        bench.add(r);
    }
}

// Presses at 1 kHz, and the same number of waits with nothing to do, which show how late the machine itself is.
void add_paced(Bench& bench, const char* model, const SkinDescription* d) {
    using Clock = std::chrono::steady_clock;
    SkinOptions options;
    options.precision = Precision::f32;
    std::optional<Skin> skin;
    std::vector<float> frame;
    if (d) {
        skin.emplace(Device::cpu(1), *d, options);
        frame.assign(size_t(d->grid.width) * size_t(d->grid.height), 1e4f);
    }
    const int steps = bench.quick ? 500 : 5000;
    std::vector<double> seconds;
    int in_time = 0;
    Clock::time_point due = Clock::now();
    for (int i = 0; i < steps; ++i) {
        due += std::chrono::milliseconds(1);
        std::this_thread::sleep_until(due);
        const auto begin = Clock::now();
        if (skin) skin->press(frame, 0.001);
        seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
        in_time += seconds.back() < 1e-3;
    }
    Measurement r = bench.cpu("paced", 0, 1);
    r.model = model;
    r.precision = "f32";
    r.width = 240;
    r.height = 320;
    if (d) r.receptors = static_cast<long long>(d->sites.size());
    r.steps = 1;
    r.wall = timing_of(std::move(seconds));
    r.limit = "1 ms";
    r.of_limit = double(in_time) / steps;
    bench.add(r);
}

} // namespace

void pads(Bench& bench) {
    const SkinDescription small = rectangle(20, 25), hand = rectangle(240, 320);
    const std::vector<Row> batches = {{"batch", small, 512, 1},
                                      {"one-skin", rectangle(512, 500), 1, 1},
                                      {"skins", small, 1, 512},
                                      {"at-rest", small, 512, 1, 0},
                                      {"batch-sites", with_sites(small, 80), 512, 1}};
    add_rows(bench, nullptr, batches);
    if (bench.vulkan) add_rows(bench, &*bench.vulkan, {batches[0], batches[1], batches[3], batches[4]});
    for (int sites : {12000, 3000, 300})
        add_rows(bench, nullptr, {{"sites", with_sites(hand, sites), 1, 1}, {"fields", hand, 1, 1}});
    add_sizes(bench, nullptr);
    if (bench.vulkan) add_sizes(bench, &*bench.vulkan);
    add_state(bench);
    add_made(bench, nullptr);
    if (bench.vulkan) add_made(bench, &*bench.vulkan);
    const SkinDescription receptors = with_sites(hand, 12000);
    add_paced(bench, "empty", nullptr);
    add_paced(bench, "sites", &receptors);
    add_paced(bench, "fields", &hand);
}

} // namespace bench
