// SPDX-License-Identifier: MIT
// One press of one skin against the memory's bandwidth, and by elements in series.
#include "bench/frames.hpp"
#include "bench/skins.hpp"

#include <algorithm>
#include <cstring>
#include <deque>
#include <stdexcept>

namespace bench {

using namespace dermis;

namespace {

constexpr double frame_bytes = 44; // L(S), pressure before and now, strain and integral twice, four responses
constexpr double frame_flops = 62;
constexpr int checked = 6; // frames

// The series of one grid. growth: the best loops and the native ones on all threads. device: on a device alone.
enum class Contenders { all, growth, device };

// One press on one grid: pressure in, strain and integral carried, four responses out. Every series is timed in the
// same rounds as loops that only move the memory.
class StreamedFrames {
  public:
    StreamedFrames(Bench& bench, int n, Contenders which)
        : bench_(bench), n_(n), scene_(n), frames_(std::max(1, int((bench.quick ? 2e6 : 1e7) / n / n))) {
        Stepper plain = library(scene_, 1, simd::plain);
        plain.press(checked);
        expected_ = plain.responses();
        const std::vector<int> all = bench.cores > 1 ? std::vector{1, bench.cores} : std::vector{1};
        if (which == Contenders::all) add_cpu(all, simd::isas(), {true, false});
        if (which == Contenders::growth) add_cpu({bench.cores}, std::array{&simd::best()}, {true});
        if (which == Contenders::all) add_peers_in_python("frames", bench_.cpu("press", n_, 1));
        if (!bench.vulkan || which == Contenders::growth) return;
        if (which == Contenders::device) add_peers_in_python("device_frames", bench_.on(*bench_.vulkan, "press", n_));
        for (bool moves : {false, true}) add_vulkan(moves);
    }
    void measure(); // times all series and adds their rows

  private:
    template <class Isas> void add_cpu(const std::vector<int>& all, const Isas& isas, const std::vector<bool>& ways) {
        for (const simd::Isa* isa : isas)
            for (int t : all) {
                add_library(*isa, t, false);
                if (isa == &simd::best() && ways.size() > 1) add_library(*isa, t, true);
            }
        for (int t : all)
            for (bool past : {true, false})
                add(past ? "cpu-moves" : "cpu-moves-cached", t, moves(scene_, t, past)).flops_per_cell = 0;
        for (int t : all)
            for (bool past : ways) add_native(t, past);
    }
    Measurement& add(const std::string& backend, int threads, const Stepper& stepper, int frames = 0) {
        frames = frames ? frames : frames_;
        Measurement r = row_of(bench_.cpu("press", n_, threads), "march", "f32", frames);
        r.backend = backend;
        r.bytes_per_cell = frame_bytes;
        return series_.emplace_back(Contender{r, [press = stepper.press, frames] { return press(frames); }}).row;
    }
    // Whether the responses after some frames have the bits of plain loops; then presses on to a multiple of the ring.
    void check_bits(Measurement& row, const Stepper& stepper) const {
        stepper.press(checked);
        const Responses made = stepper.responses();
        for (size_t r = 0; r < made.size(); ++r)
            row.exact &= std::memcmp(made[r].data(), expected_[r].data(), made[r].size() * sizeof(float)) == 0;
        if (!row.exact) row.status = "wrong";
        stepper.press(2);
    }
    void add_library(const simd::Isa& isa, int threads, bool fa1) {
        const Stepper stepper = library(scene_, threads, isa, fa1);
        Measurement& row = add(std::string("cpu-") + isa.name, threads, stepper);
        row.flops_per_cell = fa1 ? frame_flops - 17 : frame_flops;
        if (!fa1) return check_bits(row, stepper);
        row.workload = "press-fa1";
        row.bytes_per_cell = frame_bytes - 12;
    }
    // A peer is right if its error against the model in double is allowed, and so is the library's.
    void add_native(int threads, bool past_caches) {
        const Stepper stepper = native_loop(scene_, threads, past_caches);
        Measurement& row = add("native", threads, stepper);
        row.driver = "native";
        row.method = past_caches ? "past-caches" : "plain-stores";
        row.exact = false;
        stepper.press(checked);
        const auto errors = errors_of_frames(scene_, checked, stepper.responses());
        if (own_errors_.empty()) {
            const auto own = errors_of_frames(scene_, checked, expected_);
            own_errors_ = {own.begin(), own.end()};
        }
        for (size_t q = 0; q < errors.size(); ++q) {
            row.errors[q + 1] = errors[q];
            if (!(errors[q] <= peer_error && own_errors_[q] <= peer_error)) row.status = "wrong";
        }
        stepper.press(2); // a multiple of the ring in all
    }
    // They have compared themselves with the model in double.
    void add_peers_in_python(const char* work, const Measurement& where) {
        Measurement like = row_of(where, "march", "f32", frames_);
        like.bytes_per_cell = frame_bytes;
        for (Contender& c : bench_.of_peers(fmt::format("{} {}", work, n_), like, frames_, {1, 2, 3, 4})) {
            if (std::any_of(&c.row.errors[1], &c.row.errors[5], [](double e) { return e > peer_error; }))
                c.row.status = "wrong";
            series_.push_back(std::move(c));
        }
    }
    void add_vulkan(bool moves) {
        const int fewer = bench_.vulkan->info().kind == "software" ? std::max(1, frames_ / 8) : frames_;
        const Stepper stepper = on_device(scene_, vulkan::context_of(*bench_.vulkan->impl().backend), moves);
        Measurement& row = add("vulkan", 0, stepper, fewer);
        row = row_of(bench_.on(*bench_.vulkan, "press", n_), "march", "f32", fewer);
        row.bytes_per_cell = frame_bytes;
        row.flops_per_cell = moves ? 0 : frame_flops;
        if (moves) row.backend = "vulkan-moves", stepper.press(checked + 2);
        else check_bits(row, stepper);
    }
    void set_limit(Measurement&) const;

    Bench& bench_;
    const int n_;
    const FrameScene scene_;
    const int frames_;               // presses of one run; fewer on a software driver
    Responses expected_;             // by plain loops
    std::vector<double> own_errors_; // of the library, against the model in double; once a peer asks
    std::vector<Contender> series_;
};

// A kernel's limit is the fastest kernel that only moves the same memory, with the same threads on the same device.
// Their ratio is gated on one thread and on devices: what several threads cost depends on who else is served.
void StreamedFrames::set_limit(Measurement& row) const {
    const std::string moves = row.device == "cpu" ? "cpu-moves" : "vulkan-moves";
    const Measurement* limit = nullptr;
    for (const auto& [m, work, name, reference] : series_)
        if (m.backend.starts_with(moves) && m.threads == row.threads && (!limit || m.wall.median < limit->wall.median))
            limit = &m;
    if (!limit || row.backend.starts_with(moves) || std::isnan(row.wall.median)) return;
    row.against("moves", limit->bytes() / limit->wall.median / 1e9);
    if (row.threads <= 1) row.relative_to("moves", limit->wall, limit->bytes());
}

// Rounds are many and short, so that each contender's least time is from a round that nobody else disturbed.
void StreamedFrames::measure() {
    const bool hardware = bench_.vulkan && bench_.vulkan->info().kind != "software";
    // The clocks of a GPU that idles are low: the first presses of 512 x 512 cells took an H100 3.6 times as long.
    for (double warm = hardware ? 1 : 0; warm > 0;) warm -= seconds_of([&] { series_.back().work(); });
    bench_.time(series_, bench_.quick ? 5 : 15);
    for (auto& [row, work, name, reference] : series_) {
        if (row.backend.starts_with("vulkan")) row.gpu_median = row.wall.median; // timed by the device's clock
        // A software driver's threads are this process's own, so that their time is known already.
        if (row.backend.starts_with("vulkan") && hardware) row.wall.busy = row.wall.least;
    }
    for (Contender& c : series_) {
        set_limit(c.row);
        bench_.add(c.row);
    }
}

} // namespace

void streamed_frames(Bench& bench) {
    for (int n : bench.quick ? std::vector{256, 1024} : std::vector{256, 512, 768, 1024, 2048, 4096})
        StreamedFrames(bench, n, Contenders::all).measure();
    if (!bench.quick) StreamedFrames(bench, 8192, Contenders::growth).measure();
}

void streamed_frames_on_device(Bench& bench, int n) { StreamedFrames(bench, n, Contenders::device).measure(); }

void chains(Bench& bench) {
    const int n = bench.quick ? 1024 : 2048;
    constexpr int presses = 4;
    for (bool vulkan : {false, true}) {
        if (vulkan && !bench.vulkan) continue;
        std::deque<FrameScene> scenes;
        std::vector<Contender> all;
        for (const auto& [elements, spring] : {std::pair{1, false}, {2, false}, {3, false}, {3, true}, {8, false}}) {
            const FrameScene& scene = scenes.emplace_back(n, chain_of(elements, spring));
            const Stepper stepper =
                vulkan ? on_device(scene, dermis::vulkan::context_of(*bench.vulkan->impl().backend), false)
                       : library(scene, bench.cores, simd::best());
            Measurement r = vulkan ? bench.on(*bench.vulkan, "chains", n) : bench.cpu("chains", n, bench.cores);
            r = row_of(r, "march", "f32", presses);
            r.method = "exact-" + std::to_string(elements) + (spring ? "-spring" : "");
            r.bytes_per_cell = 36 + 8 * elements + (spring ? 8 : 0); // of each element, the integral, the spring's rate
            all.push_back({r, [stepper] { return seconds_of([&] { stepper.press(presses); }); }});
        }
        bench.measure(std::move(all), 3 * bench.runs);
    }
}

} // namespace bench
