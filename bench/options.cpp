// SPDX-License-Identifier: MIT
// What each option of a skin saves: responses that are not asked for, receptors in place of fields, precision, and
// several frames in one press. All options of a skin on one device are timed in the same rounds, by the frame.
#include "bench/skins.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace bench {

using namespace dermis;

namespace {

struct Option {
    const char* name;
    std::vector<Quantity> responses = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    Precision precision = Precision::f32;
    bool receptors = false, cells = false; // receptors in place of fields, and the pressures of their cells alone
    size_t frames = 1;                     // of a press
};

const Option all_options[] = {{.name = "all"},
                              {.name = "compensated", .precision = Precision::f32_compensated},
                              {.name = "three", .responses = {Quantity::sa1, Quantity::fa1, Quantity::fa2}},
                              {.name = "two", .responses = {Quantity::sa1, Quantity::fa1}},
                              {.name = "one", .responses = {Quantity::sa1}},
                              {.name = "receptors", .receptors = true},
                              {.name = "receptors-cells", .receptors = true, .cells = true},
                              {.name = "frames-4", .frames = 4},
                              {.name = "frames-8", .frames = 8}};

constexpr size_t ring = 8; // frames, which are used cyclically

// A skin with one of the options.
class Contender {
  public:
    Contender(const Device& device, SkinDescription d, int pads, int receptors, const Option& o,
              const std::vector<float>& frames)
        : option_(o), cells_(frames.size() / ring), frames_(&frames),
          skin_(device, o.receptors ? with_sites(d, receptors) : d, options(o, pads)) {
        if (o.cells) gather(size_t(d.grid.width) * size_t(d.grid.height), size_t(pads));
    }
    void press_all() { // frames of the ring
        const size_t count = option_.cells ? gathered_.size() / ring : cells_;
        const float* frame = option_.cells ? gathered_.data() : frames_->data();
        for (size_t i = 0; i < ring; i += option_.frames, frame += count * option_.frames)
            if (option_.cells) skin_.press_cells(frame, count, press_dt);
            else if (option_.frames > 1) skin_.press_frames(frame, option_.frames, count, press_dt);
            else skin_.press(frame, count, press_dt);
    }
    // After as many frames, the responses are those of a skin without options; compensated ones to rounding.
    void check(const Skin& base, const SkinDescription& d, int receptors) const {
        const auto differ = [&] { throw std::runtime_error(fmt::format("option {}: wrong responses", option_.name)); };
        for (Quantity q : option_.receptors ? std::vector{Quantity::sa1} : option_.responses) {
            const Skin::Response own = skin_.response(q), all = base.response(q);
            if (option_.receptors) {
                size_t i = 0;
                for (size_t pad = 0; pad < cells_; pad += size_t(d.grid.width) * size_t(d.grid.height))
                    for (const Site& s : with_sites(d, receptors).sites)
                        if (s.type == q &&
                            own[i++] != all[pad + size_t(s.cell.y) * size_t(d.grid.width) + size_t(s.cell.x)])
                            differ();
            } else if (option_.precision == Precision::f32) {
                if (!same(own, all)) differ();
            } else {
                const float greatest = std::abs(*std::max_element(all.begin(), all.end()));
                for (size_t i = 0; i < own.size; ++i)
                    if (!(std::abs(own[i] - all[i]) <= 1e-4f * greatest)) differ();
            }
        }
    }
    const Skin& skin() const { return skin_; }

  private:
    static SkinOptions options(const Option& o, int pads) {
        SkinOptions all;
        all.precision = o.precision;
        all.responses = o.responses;
        all.count = pads;
        return all;
    }
    void gather(size_t of_pad, size_t pads) {
        const std::vector<int> cells = skin_.cells();
        for (size_t pad = 0; pad < ring * pads; ++pad)
            for (int cell : cells) gathered_.push_back((*frames_)[pad * of_pad + size_t(cell)]);
    }

    const Option& option_;
    const size_t cells_;
    const std::vector<float>* frames_;
    std::vector<float> gathered_; // the pressures of the cells that receptors need
    Skin skin_;
};

void add_options(Bench& bench, const Device& device, const SkinDescription& d, int pads, int receptors) {
    const std::vector<float> frames = random_frames(size_t(pads) * size_t(d.grid.width) * size_t(d.grid.height), ring);
    std::vector<std::unique_ptr<Contender>> contenders;
    std::vector<std::function<double()>> work;
    const auto rings_of = [&](const Option& o) { // a press of receptors' cells alone takes microseconds
        const int rings =
            std::clamp(int((device.info().kind == "software" ? 2e5 : 2e6) / double(frames.size())), 1, 200);
        return o.cells && !device.info().vulkan ? std::max(rings, 100) : rings;
    };
    for (const Option& o : all_options) {
        Contender& c = *contenders.emplace_back(std::make_unique<Contender>(device, d, pads, receptors, o, frames));
        c.press_all();
        c.check(contenders[0]->skin(), d, receptors);
        work.push_back([&c, rings = rings_of(o)] {
            return seconds_of([&] {
                for (int i = 0; i < rings; ++i) c.press_all();
            });
        });
    }
    const std::vector<Timing> timings = bench.paired(work, bench.runs);
    for (size_t i = 0; i < timings.size(); ++i) {
        Measurement r = bench.on(device, "options", 0);
        r.model = all_options[i].name;
        r.method = shape_of(d, pads);
        r.precision = name(all_options[i].precision);
        r.width = d.grid.width;
        r.height = static_cast<long long>(d.grid.height) * pads;
        r.receptors = all_options[i].receptors ? static_cast<long long>(receptors) * pads : 0;
        r.steps = rings_of(all_options[i]) * static_cast<long long>(ring);
        r.wall = timings[i];
        bench.add(r);
    }
}

} // namespace

void options(Bench& bench) {
    const int n = bench.quick ? 512 : 2048;
    std::vector<Device> devices = {Device::cpu(1)};
    if (bench.cores > 1) devices.push_back(Device::cpu(bench.cores));
    for (const Device& device : devices) {
        add_options(bench, device, rectangle(20, 25), 512, 10);
        add_options(bench, device, rectangle(n, n), 1, 100);
    }
    if (bench.vulkan) add_options(bench, *bench.vulkan, rectangle(20, 25), bench.quick ? 64 : 512, 10);
}

} // namespace bench
