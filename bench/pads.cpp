// SPDX-License-Identifier: MIT
// Many small pads and receptors, as robots have them: batches beside single skins, sites beside fields, and presses at
// 1 kHz. What is compared is timed in the same rounds.
#include "bench/native_pads_loops.hpp"
#include "bench/skins.hpp"
#include "host/core/base/pool.hpp"
#include "host/core/model/coefficients.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/model/streamed_skin.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

namespace bench {

using namespace dermis;

namespace {

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
          pool_(std::clamp(int(cells_ * size_t(pads) / 8192), 1, threads)), // a second thread pays from there
          rest_(pitch_), scratch_(size_t(pool_.threads()), std::vector<float>(2 * pitch_)) {
        SkinOptions options;
        options.precision = Precision::f32;
        const model::StreamedSkin skin = model::streamed_skin(d, options);
        const auto width = size_t(d.grid.width);
        for (size_t y = 0; y * width < cells_; ++y) {
            std::vector<double> row(width);
            model::rest_curvature_row(skin.skin, int(y), 0, int(width), row.data());
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
    void press(const float* pressure) {
        std::atomic<bool> finite = true;
        pool_.share(pads_, [&](int first, int last) {
            if (!native::take_pads(batch_, size_t(first), size_t(last), pressure)) finite = false;
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
    static native::PadStep step_of(const model::StreamedSkin& s) {
        const auto k = model::rounded<f32>(model::exact_coefficients(s.skin.materials[0], s.skin.rule, press_dt));
        const f32::Constants c = model::frame_constants(s.skin, k);
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
        Measurement r = device ? bench.on_vulkan("pads-batch", 0) : bench.cpu("pads-batch", 0, 1);
        r.model = all[i].model;
        r.method = shape_of(all[i].description, all[i].pads * all[i].skins);
        r.precision = "f32";
        r.width = all[i].description.grid.width;
        r.height = all[i].cells() / r.width;
        r.receptors = static_cast<long long>(all[i].description.sites.size()) * all[i].pads;
        r.steps = all[i].presses(device);
        r.wall = timings[i];
        bench.add(r);
    }
}

// Batches of one shape, by precision, on threads of the CPU and on the device, beside the native peer.
class Batches {
  public:
    Batches(Bench& bench, const SkinDescription& d, int pads)
        : bench_(bench), d_(d), pads_(pads), cells_(size_t(pads) * size_t(d.grid.width) * size_t(d.grid.height)),
          frames_(random_frames(cells_, 4)) {}

    void add_native(int threads) {
        natives_.push_back(std::make_unique<NativePads>(d_, pads_, threads));
        NativePads& native = *natives_.back();
        Measurement r = bench_.cpu("pads", 0, threads);
        r.model = "native-bits";
        r.precision = "f32";
        add(r, presses(), [this, &native](size_t i) { native.press(frame(i)); });
    }
    void add_skin(const Device& device, Precision precision) {
        SkinOptions options;
        options.precision = precision;
        options.count = pads_;
        Skin& skin = *skins_.emplace_back(std::make_unique<Skin>(device, d_, options));
        Measurement r = bench_.on(device, "pads", 0);
        r.model = "batch";
        r.precision = name(precision);
        const int fewer = device.info().kind == "software" ? std::clamp(int(3e5 / double(cells_)), 1, 20) : presses();
        add(r, fewer, [this, &skin](size_t i) { skin.press(frame(i), cells_, press_dt); });
        std::unique_ptr<Skin>& first = precision == Precision::f32 ? first_ : first_compensated_;
        if (!first) first = std::make_unique<Skin>(Device::cpu(1), d_, options), press(*first);
        for (Quantity q : options.responses)
            if (!same(skin.response(q), first->response(q))) throw std::runtime_error("a batch has other bits");
    }
    // Times all of them in turn.
    void measure() {
        for (const auto& native : natives_)
            if (!native->same(*first_)) throw std::runtime_error("the native pads differ from the batch");
        first_.reset();
        first_compensated_.reset();
        std::vector<Timing> timings = bench_.paired(work_, bench_.runs);
        for (size_t i = 0; i < rows_.size(); ++i) {
            Measurement& r = rows_[i];
            r.wall = timings[i];
            for (size_t k = 0; k < rows_.size(); ++k) // stands before its batch
                if (rows_[k].model == std::string("native-bits") && r.model == "batch" &&
                    r.backend.starts_with("cpu") && r.precision == "f32" && rows_[k].threads == r.threads)
                    r.relative_to("native-bits", timings[k], rows_[k].bytes());
            bench_.add(r);
        }
    }

  private:
    const float* frame(size_t i) const { return frames_.data() + i % 4 * cells_; }
    int presses() const { return std::clamp(int((bench_.quick ? 5e5 : 2e6) / double(cells_)), 2, 2000); }
    void press(Skin& skin) const {
        for (size_t i = 0; i < 6; ++i) skin.press(frame(i), cells_, press_dt);
    }
    void add(Measurement r, int presses, const std::function<void(size_t)>& pressed) {
        for (size_t i = 0; i < 6; ++i) pressed(i);
        r.method = shape_of(d_, pads_);
        r.width = d_.grid.width;
        r.height = static_cast<long long>(d_.grid.height) * pads_;
        r.steps = presses;
        r.bytes_per_cell = 48; // read and written: pressures, strain and integral, the pressure taken, four responses
        rows_.push_back(r);
        work_.push_back([pressed, presses] {
            return seconds_of([&] {
                for (size_t i = 0; i < size_t(presses); ++i) pressed(i);
            });
        });
    }

    Bench& bench_;
    const SkinDescription d_;
    const int pads_;
    const size_t cells_;
    const std::vector<float> frames_;
    std::vector<std::unique_ptr<NativePads>> natives_;
    std::vector<std::unique_ptr<Skin>> skins_;
    std::unique_ptr<Skin> first_, first_compensated_; // whose bits all others have
    std::vector<Measurement> rows_;
    std::vector<std::function<double()>> work_;
};

// The time of a press by shape, number of pads, threads and precision. Above `most_at_once` cells one thread and all of
// them are timed apart, because all skins together would take too much memory, and a software device is left out.
void add_presses(Bench& bench, const SkinDescription& d, int pads) {
    constexpr long long most_at_once = 1 << 22;
    const long long cells = static_cast<long long>(d.grid.width) * d.grid.height * pads;
    std::vector<int> threads = {1};
    if (bench.cores > 1) threads.push_back(bench.cores);
    std::vector<std::vector<int>> rounds = {threads};
    if (cells > most_at_once) rounds.assign({{1}, {bench.cores}});
    for (const std::vector<int>& together : rounds) {
        Batches all(bench, d, pads);
        for (int t : together) {
            if (d.grid.width <= 64) all.add_native(t);
            for (Precision p : {Precision::f32, Precision::f32_compensated}) all.add_skin(Device::cpu(t), p);
        }
        if (bench.vulkan && cells <= most_at_once)
            for (Precision p : {Precision::f32, Precision::f32_compensated}) all.add_skin(*bench.vulkan, p);
        all.measure();
    }
}

void add_sizes(Bench& bench) {
    const long long most = bench.quick ? 70000 : 1 << 24; // cells
    for (const auto& [width, height] : {std::pair{4, 4}, {4, 6}, {8, 8}, {16, 16}, {20, 25}, {64, 64}})
        for (int count : {1, 64, 512, 4096})
            if (static_cast<long long>(count) * width * height <= most)
                add_presses(bench, rectangle(width, height), count);
    add_presses(bench, rectangle(240, 320), 1);
    if (!bench.quick) add_presses(bench, rectangle(1024, 1024), 1);
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
    add_sizes(bench);
    add_state(bench);
    add_made(bench, nullptr);
    if (bench.vulkan) add_made(bench, &*bench.vulkan);
    const SkinDescription receptors = with_sites(hand, 12000);
    add_paced(bench, "empty", nullptr);
    add_paced(bench, "sites", &receptors);
    add_paced(bench, "fields", &hand);
}

} // namespace bench
