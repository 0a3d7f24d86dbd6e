// SPDX-License-Identifier: MIT
// Contacts of a whole batch beside the presses that they lead to: few of many pads, all pads of 64 hands, and shear.
#include "dermis/touch.hpp"
#include "bench/skins.hpp"

namespace bench {

using namespace dermis;

namespace {

constexpr int side = 48;

// A contact in the middle of every nth pad of a batch, of a patch with a radius of 2.4 cells.
class Contacts {
  public:
    Contacts(int pads, int every) : touch_(shape(), pads, 1e-3, true), middles_(size_t(3 * pads)) {
        for (int i = 0; i < pads; i += every) {
            pad_.push_back(i);
            position_.insert(position_.end(), {1e-4, -2e-4, 0});
            force_.insert(force_.end(), {0.02, 0.01, -0.1});
        }
    }
    void add() {
        touch_.add({.position = middles_.data(), .rotation = axes_, .rotation_step = 0}, {.count = pad_.size(),
                                                                                          .pad = pad_.data(),
                                                                                          .position = position_.data(),
                                                                                          .force = force_.data(),
                                                                                          .radius = &radius_,
                                                                                          .radius_step = 0});
    }
    const contact::Touch& touch() const { return touch_; }
    const std::vector<int>& pads() const { return pad_; }

  private:
    static contact::Pad shape() {
        return {.width = side, .height = side, .spacing = 2.5e-4, .radius_x = 8e-3, .radius_y = 8e-3};
    }
    contact::Touch touch_;
    std::vector<double> middles_, position_, force_;
    std::vector<int32_t> pad_;
    const double axes_[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, radius_ = 6e-4;
};

// Times some ways to press in turn. The others are compared with the first way.
void add_ways(Bench& bench, int pads, int threads,
              const std::vector<std::pair<const char*, std::function<void()>>>& ways) {
    const int presses = bench.quick ? 5 : 40;
    std::vector<std::function<double()>> work;
    for (const auto& way : ways)
        work.push_back([&way, presses] {
            return seconds_of([&] {
                for (int i = 0; i < presses; ++i) way.second();
            });
        });
    const std::vector<Timing> timings = bench.paired(work, bench.runs);
    for (size_t i = 0; i < ways.size(); ++i) {
        Measurement r = bench.cpu("touch", 0, threads);
        r.model = ways[i].first;
        r.method = shape_of(rectangle(side, side), pads);
        r.precision = "f32";
        r.width = side;
        r.height = static_cast<long long>(side) * pads;
        r.steps = presses;
        r.bytes_per_cell = 48;
        r.wall = timings[i];
        if (i > 0) r.relative_to(ways[0].first, timings[0], r.bytes());
        bench.add(r);
    }
}

// every: one pad of so many is touched.
void add_touched(Bench& bench, int pads, int every, int threads) {
    Contacts contacts(pads, every);
    contacts.add();
    SkinOptions options;
    options.precision = Precision::f32;
    options.count = pads;
    const Device device = Device::cpu(threads);
    Skin listed(device, rectangle(side, side), options), all(device, rectangle(side, side), options);
    options.shear = true;
    Skin sheared(device, rectangle(side, side), options);
    const size_t cells = size_t(side) * side;
    const float* const pressure = contacts.touch().pressure();
    std::vector<float> of_listed;
    for (const int pad : contacts.pads())
        of_listed.insert(of_listed.end(), pressure + size_t(pad) * cells, pressure + size_t(pad + 1) * cells);
    const auto press_listed = [&] { listed.press(of_listed.data(), of_listed.size(), press_dt, contacts.pads()); };
    const auto press_all = [&] { all.press(pressure, size_t(pads) * cells, press_dt); };
    const auto shear = [&] { sheared.press(contacts.touch(), press_dt); };
    for (int i = 0; i < 3; ++i) press_listed(), press_all(), shear();
    for (Quantity q : {Quantity::sa1, Quantity::fa1})
        if (!same(all.response(q), sheared.response(q))) throw std::runtime_error("a touch has other bits");
    add_ways(bench, pads, threads,
             {{"press-listed", press_listed},
              {"touch-add", [&] { contacts.add(); }},
              {"press-all", press_all},
              {"touch-shear", shear}});
}

} // namespace

void touch(Bench& bench) {
    for (const int threads : {1, bench.cores}) {
        add_touched(bench, bench.quick ? 400 : 4096, bench.quick ? 10 : 102, threads);
        add_touched(bench, bench.quick ? 32 : 320, 1, threads);
        if (bench.cores == 1) break;
    }
}

} // namespace bench
