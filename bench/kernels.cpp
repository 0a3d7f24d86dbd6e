// SPDX-License-Identifier: MIT
// One press of one skin, and means of a map, against the memory's bandwidth.
#include "bench/bench.hpp"
#include "bench/frames.hpp"
#include "bench/native.hpp"
#include "bench/opencl.hpp"
#include "host/core/cpu/stream.hpp"
#include "host/core/embedding/backend.hpp"
#include "host/lab/reduced/moments.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>

#include <fmt/format.h>

namespace bench {

using namespace dermis;

namespace {

constexpr double frame_bytes = 44; // L(S), pressure before and now, strain and integral twice, four responses
constexpr double frame_flops = 62;
// Rounds are many and short, so that each contender's least time is from a round that nobody else disturbed.
int rounds(const Bench& bench) { return bench.quick ? 5 : 15; }
double cells_of_round(const Bench& bench) { return bench.quick ? 2e6 : 1e7; } // cells and steps, at least one frame

// The responses after some frames.
using Responses = std::array<std::vector<float>, RESPONSE_MAPS>;

constexpr int checked_frames = 6;

Responses after_frames(const FrameScene& scene, int threads, const simd::Isa& isa) {
    cpu::FramePress frames(scene.streamed, threads, isa);
    Responses r;
    float* to[RESPONSE_MAPS];
    for (size_t i = 0; i < r.size(); ++i) {
        r[i].resize(scene.cells());
        to[i] = r[i].data();
    }
    for (size_t i = 0; i < checked_frames; ++i)
        frames.press({scene.dt}, scene.frames[i % 4].data(), scene.frames[(i + 1) % 4].data(), to);
    return r;
}

bool same(const Responses& a, const Responses& b) {
    for (size_t i = 0; i < a.size(); ++i)
        if (std::memcmp(a[i].data(), b[i].data(), a[i].size() * sizeof(float)) != 0) return false;
    return true;
}

// A row of the table, and the work that is timed for it.
struct Series {
    Measurement row;
    std::function<double()> work;    // seconds of the host
    std::vector<double> gpu_seconds; // of every run on a device; empty on the CPU
};

// The series of one grid. growth: the best loops and the native ones on all threads. device: on a device alone.
enum class Contenders { all, growth, device };

// One press on one grid: pressure in, strain and integral carried, four responses out. Every series is timed in the
// same rounds as loops that only move the memory.
class StreamedFrames {
  public:
    StreamedFrames(Bench& bench, int n, Contenders);
    void measure(); // times all series and adds their rows

  private:
    void add_all_of_cpu();
    void add_cpu(const simd::Isa&, int threads, bool all_responses);
    void add_moves(int threads, bool past_caches);
    Series& add_peer(const std::string& name, int threads);
    void add_native(int threads, NativeFrames::Way);
    void add_pocl(bool past_caches);
    void add_peers_in_python();
    void check_peer(Measurement&, const std::array<const float*, 4>& responses);
    void add_vulkan(VulkanFrames::Shader);
    void measure_recording();
    void set_device_time(Series&) const;
    void set_limit(Series&) const;

    Bench& bench_;
    const int n_;
    const FrameScene scene_;
    const int frames_, device_frames_;                       // presses of one run; fewer on a software driver
    const Responses expected_;                               // by plain loops
    std::optional<std::array<double, 4>> errors_of_library_; // against the model in double, once a peer asks
    std::vector<Floats> out_;                                // the responses of the CPU's series
    std::vector<std::unique_ptr<cpu::FramePress>> streams_;
    std::vector<std::unique_ptr<CpuMoves>> moves_;
    std::vector<std::unique_ptr<NativeFrames>> natives_;
    std::vector<std::unique_ptr<OpenclFrames>> pocls_;
    std::vector<std::unique_ptr<VulkanFrames>> devices_;
    std::deque<Series> series_; // their work refers to them, so that they must not move
};

StreamedFrames::StreamedFrames(Bench& bench, int n, Contenders contenders)
    : bench_(bench), n_(n), scene_(n), frames_(std::max(1, int(cells_of_round(bench) / n / n))),
      device_frames_(bench.vulkan && bench.vulkan->info().kind == "software" ? std::max(1, frames_ / 8) : frames_),
      expected_(after_frames(scene_, 1, simd::plain)) {
    for (int i = 0; i < 4; ++i) out_.emplace_back(scene_.cells());
    if (contenders == Contenders::all) add_all_of_cpu();
    if (contenders == Contenders::growth) {
        add_cpu(simd::best(), bench.cores, true);
        for (bool past_caches : {true, false}) add_moves(bench.cores, past_caches);
        add_native(bench.cores, NativeFrames::Way::past_caches);
    }
    if (!bench.vulkan || contenders == Contenders::growth) return;
    for (auto shader : {VulkanFrames::Shader::press, VulkanFrames::Shader::moves}) add_vulkan(shader);
}

void StreamedFrames::add_all_of_cpu() {
    const std::vector<int> threads = bench_.cores > 1 ? std::vector{1, bench_.cores} : std::vector{1};
    for (const simd::Isa* isa : simd::isas())
        for (int t : threads) {
            add_cpu(*isa, t, true);
            if (isa == &simd::best()) add_cpu(*isa, t, false);
        }
    for (int t : threads)
        for (bool past_caches : {true, false}) add_moves(t, past_caches);
    using Way = NativeFrames::Way;
    for (int t : threads)
        for (Way way : {Way::past_caches, Way::plain_stores, Way::two_passes}) add_native(t, way);
    for (bool past_caches : {true, false}) add_pocl(past_caches);
    add_peers_in_python();
}

void StreamedFrames::add_cpu(const simd::Isa& isa, int threads, bool all_responses) {
    Series& s = series_.emplace_back();
    s.row = bench_.cpu(all_responses ? "press" : "press-fa1", n_, threads);
    s.row.backend = std::string("cpu-") + isa.name;
    s.row.model = "march";
    s.row.precision = "f32";
    s.row.bytes_per_cell = all_responses ? frame_bytes : frame_bytes - 12;
    s.row.flops_per_cell = all_responses ? frame_flops : frame_flops - 17;
    s.row.exact = same(expected_, after_frames(scene_, threads, isa));
    if (!s.row.exact) s.row.status = "wrong";
    cpu::FramePress& stream = *streams_.emplace_back(std::make_unique<cpu::FramePress>(scene_.streamed, threads, isa));
    s.work = [this, &stream, all_responses] {
        float* response[RESPONSE_MAPS]; // `press-fa1` computes FA1 alone
        for (size_t i = 0; i < RESPONSE_MAPS; ++i)
            response[i] = all_responses || i == QUANTITY_FA1 - QUANTITY_SA1 ? out_[i].data() : nullptr;
        return seconds_of([&] {
            for (size_t i = 0; i < size_t(frames_); ++i)
                stream.press({scene_.dt}, scene_.frames[i % 4].data(), scene_.frames[(i + 1) % 4].data(), response);
        });
    };
}

// The same memory and no model: its time is what the memory of a grid of this size allows.
void StreamedFrames::add_moves(int threads, bool past_caches) {
    Series& s = series_.emplace_back();
    s.row = bench_.cpu("press", n_, threads);
    s.row.backend = past_caches ? "cpu-moves" : "cpu-moves-cached";
    s.row.model = "march";
    s.row.precision = "f32";
    s.row.bytes_per_cell = frame_bytes;
    s.row.flops_per_cell = 0;
    CpuMoves& moves = *moves_.emplace_back(std::make_unique<CpuMoves>(scene_, threads, past_caches));
    s.work = [this, &moves] { return seconds_of([&] { moves.press(frames_); }); };
}

// A peer is right if its error against the model in double is allowed, and so is the library's.
void StreamedFrames::check_peer(Measurement& row, const std::array<const float*, 4>& responses) {
    if (!errors_of_library_)
        errors_of_library_ =
            errors_of_frames(scene_, checked_frames, bench_.cores,
                             {expected_[0].data(), expected_[1].data(), expected_[2].data(), expected_[3].data()});
    const std::array<double, 4> errors = errors_of_frames(scene_, checked_frames, bench_.cores, responses);
    for (size_t q = 0; q < 4; ++q) {
        row.errors[q + 1] = errors[q];
        if (!(errors[q] <= peer_error && (*errors_of_library_)[q] <= peer_error)) row.status = "wrong";
    }
}

Series& StreamedFrames::add_peer(const std::string& name, int threads) {
    Series& s = series_.emplace_back();
    s.row = bench_.cpu("press", n_, threads);
    s.row.backend = s.row.driver = name;
    s.row.model = "march";
    s.row.precision = "f32";
    s.row.bytes_per_cell = frame_bytes;
    s.row.exact = false;
    return s;
}

void StreamedFrames::add_native(int threads, NativeFrames::Way way) {
    Series& s = add_peer("native", threads);
    s.row.method = way == NativeFrames::Way::past_caches    ? "past-caches"
                   : way == NativeFrames::Way::plain_stores ? "plain-stores"
                                                            : "two-passes";
    NativeFrames& native = *natives_.emplace_back(std::make_unique<NativeFrames>(scene_, threads, way));
    native.press(checked_frames);
    check_peer(s.row, native.responses());
    native.press(2); // a multiple of the ring in all, as on a device
    s.work = [this, &native] { return seconds_of([&] { native.press(frames_); }); };
}

// It has one thread for each core of the machine.
void StreamedFrames::add_pocl(bool past_caches) {
    Series& s = add_peer("pocl", bench_.cores);
    s.row.method = past_caches ? "past-caches" : "plain-stores";
    std::unique_ptr<OpenclFrames> made = OpenclFrames::make(scene_, past_caches);
    if (!made) {
        s.row.status = not_installed;
        return;
    }
    OpenclFrames& pocl = *pocls_.emplace_back(std::move(made));
    s.row.driver_version = pocl.driver_version();
    pocl.press(checked_frames);
    check_peer(s.row, pocl.responses());
    pocl.press(2);
    s.work = [this, &pocl] { return seconds_of([&] { pocl.press(frames_); }); };
}

// They have compared themselves with the model in double.
void StreamedFrames::add_peers_in_python() {
    for (const Peers::Peer& peer : bench_.peers->prepare(fmt::format("frames {}", n_))) {
        Series& s = add_peer(peer.name, bench_.cores);
        s.row = bench_.of_peer(peer, "press", n_);
        s.row.model = "march";
        s.row.precision = "f32";
        s.row.bytes_per_cell = frame_bytes;
        if (peer.method.empty()) continue;
        for (size_t q = 0; q < 4; ++q) s.row.errors[q + 1] = peer.errors.at(q);
        if (std::ranges::any_of(peer.errors, [](double e) { return !(e <= peer_error); })) s.row.status = "wrong";
        s.work = [this, peer] { return bench_.peers->seconds(peer, frames_); };
    }
}

void StreamedFrames::add_vulkan(VulkanFrames::Shader shader) {
    const bool moves = shader == VulkanFrames::Shader::moves; // the memory alone: no kernel is faster
    Series& s = series_.emplace_back();
    s.row = bench_.on_vulkan("press", n_);
    if (moves) s.row.backend = "vulkan-moves";
    s.row.bytes_per_cell = frame_bytes;
    s.row.flops_per_cell = moves ? 0 : frame_flops;
    VulkanFrames& device = *devices_.emplace_back(
        std::make_unique<VulkanFrames>(scene_, vulkan::context_of(*bench_.vulkan->impl().backend), shader));
    device.press(checked_frames);
    Responses made;
    for (size_t i = 0; i < made.size(); ++i) made[i] = device.response(int(i));
    s.row.exact = moves || same(expected_, made);
    if (!s.row.exact) s.row.status = "wrong";
    device.press(2); // a multiple of the ring in all: states and frames are where they began
    s.work = [this, &s, &device] { return seconds_of([&] { s.gpu_seconds.push_back(device.press(device_frames_)); }); };
}

// A software driver's threads are this process's own, so that their time is known already.
void StreamedFrames::set_device_time(Series& s) const {
    const Timing device = timing_of(s.gpu_seconds);
    s.row.gpu_median = device.median;
    if (bench_.vulkan->info().kind != "software") s.row.wall.busy = device.least;
}

// A kernel's limit is the fastest kernel that only moves the same memory, with the same threads on the same device.
// Their ratio is gated on one thread and on devices: what several threads cost depends on who else is served.
void StreamedFrames::set_limit(Series& s) const {
    const std::string moves = s.gpu_seconds.empty() ? "cpu-moves" : "vulkan-moves";
    const Series* limit = nullptr;
    for (const Series& m : series_)
        if (m.row.backend.starts_with(moves) && m.row.threads == s.row.threads &&
            (!limit || m.row.wall.median < limit->row.wall.median))
            limit = &m;
    if (!limit || s.row.backend.starts_with(moves) || !s.work) return;
    s.row.against("moves", limit->row.bytes() / limit->row.wall.median / 1e9);
    if (s.row.threads <= 1) s.row.relative_to("moves", limit->row.wall, limit->row.bytes());
}

void StreamedFrames::measure() {
    std::vector<std::function<double()>> work;
    for (const Series& s : series_)
        if (s.work) work.push_back(s.work);
    const std::vector<Timing> timings = bench_.paired(work, rounds(bench_));
    auto timing = timings.begin();
    for (Series& s : series_) {
        if (s.work) s.row.wall = *timing++;
        const bool on_device = !s.gpu_seconds.empty();
        s.row.steps = on_device ? device_frames_ : frames_;
        if (on_device) set_device_time(s);
    }
    for (Series& s : series_) {
        set_limit(s);
        bench_.add(s.row);
    }
    if (!devices_.empty()) measure_recording();
}

// The host's time to record a frame, apart from its submission.
void StreamedFrames::measure_recording() {
    Measurement r = bench_.on_vulkan("press-record", n_);
    r.steps = 1;
    r.wall = bench_.paired({[&] {
                               devices_[0]->press(device_frames_);
                               return devices_[0]->recording();
                           }},
                           bench_.runs)[0];
    bench_.add(r);
}

} // namespace

void streamed_frames(Bench& bench) {
    for (int n : bench.quick ? std::vector{256, 1024} : std::vector{256, 512, 768, 1024, 2048, 4096})
        StreamedFrames(bench, n, Contenders::all).measure();
    if (!bench.quick) StreamedFrames(bench, 8192, Contenders::growth).measure();
}

void streamed_frames_on_device(Bench& bench, int n) { StreamedFrames(bench, n, Contenders::device).measure(); }

namespace {

// Means alone of a constant map by `moments`, beside a read of the memory in the same rounds.
void add_moments(Bench& bench, const model::PreparedRun& prepared, int n, int threads) {
    Measurement r = bench.cpu("held-map", n, threads);
    r.model = "moments";
    r.precision = "f64";
    r.steps = prepared.schedule.outputs;
    r.bytes_per_cell = 16 / double(r.steps); // surface and pressure are read once
    double last = 0;
    const auto moments = [&] {
        const auto& [skin, schedule] = prepared;
        const auto stepper =
            reduced::separable(skin, schedule, reduced::moments_of(skin, schedule, false, threads), false,
                               [&](auto&, const model::Sample& sample) { last += sample.totals[1].mean; });
        model::Timeline timeline(schedule, skin);
        for (model::Step step; timeline.next(step);) stepper->press(step);
    };
    Limits memory(threads);
    const auto timings =
        bench.paired({[&] { return memory.read(); }, [&] { return seconds_of(moments); }}, rounds(bench));
    r.wall = timings[1];
    if (!std::isfinite(last)) r.status = "wrong";
    r.against("read", double(Limits::moved()) / timings[0].median / 1e9);
    if (threads == 1) r.relative_to("read", timings[0], double(Limits::moved()));
    bench.add(r);
}

} // namespace

void constant_map(Bench& bench) {
    for (int n : bench.quick ? std::vector{512, 2048} : std::vector{512, 2048, 4096}) {
        Scene s;
        s.grid = {n, n, {}};
        s.surface.kind = Surface::Kind::wave;
        s.surface.noise = 0;
        s.load.kind = Load::Kind::linear;
        s.load.radius = n;
        s.output.extremes = false;
        s = with_maps(s);
        const model::PreparedRun prepared = model::prepare_run(s);
        for (int t : {1, bench.cores}) add_moments(bench, prepared, n, t);
        if (n > 512) continue;
        for (bool vulkan : {false, true}) {
            if (vulkan && !bench.vulkan) continue;
            Measurement r = vulkan ? bench.on_vulkan("held-map", n) : bench.cpu("held-map", n, bench.cores);
            r.model = "march";
            r.precision = "f32";
            Scene marched = s;
            marched.model = Model::march;
            marched.precision = Precision::f32;
            marched.time.duration = vulkan ? 1 : 10;
            r.steps = vulkan ? 100 : 1000;
            r.wall = bench.paired({[&] { return run(marched, vulkan ? *bench.vulkan : Device::cpu()).seconds; }},
                                  std::min(bench.runs, 3))[0];
            bench.add(r);
        }
    }
}

} // namespace bench
