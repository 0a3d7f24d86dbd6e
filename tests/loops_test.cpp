// SPDX-License-Identifier: MIT
// The loops of every instruction set that this processor has, in every variant, against the plain ones.
#include "host/cpu/stepper.hpp"
#include "host/simd/isa.hpp"
#include "tests/support.hpp"

#include <cstring>
#include <random>

using namespace test;

namespace {

struct Seen {
    std::vector<std::vector<double>> maps; // at every step
    std::vector<double> totals;
};

Seen seen(const plan::PreparedRun& run, Precision precision, int threads, const simd::Isa& isa) {
    Seen all;
    const auto stepper = cpu::stepper(
        run.skin, run.schedule, precision, threads,
        [&](auto&, const plan::Sample& sample) {
            for (const plan::Totals& t : sample.totals) all.totals.insert(all.totals.end(), {t.mean, t.min, t.max});
            all.totals.insert(all.totals.end(), sample.points.begin(), sample.points.end());
        },
        isa);
    plan::Timeline timeline(run.schedule, run.skin);
    std::vector<std::vector<double>> maps;
    double turn = 1;
    for (plan::Step step; timeline.next(step); turn = -0.7 * turn) {
        if (run.schedule.framed) {
            std::vector<double> frame = run.schedule.pressure;
            for (double& p : frame) p *= turn;
            stepper->frame(frame);
        }
        stepper->press(step);
        stepper->read({Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2,
                       Quantity::curvature, Quantity::deformation},
                      maps);
        all.maps.insert(all.maps.end(), maps.begin(), maps.end());
    }
    return all;
}

bool same(const std::vector<double>& a, const std::vector<double>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

} // namespace

TEST_CASE("every instruction set and number of threads gives the bits of plain loops on one thread") {
    MESSAGE("instruction sets here: " << simd::isas().size() << ", best " << std::string(simd::best().name));
    std::mt19937 random(5);
    std::uniform_real_distribution<double> number(-1, 1);
    for (auto [width, height] : {std::pair{1, 1}, {2, 2}, {5, 3}, {67, 13}, {130, 9}, {333, 211}})
        for (Stencil stencil : {Stencil::five_point, Stencil::fourth_order, Stencil::published})
            for (Edges edges : {Edges::mirror, Edges::periodic, Edges::published}) {
                if (edges == Edges::published && (stencil != Stencil::published || width < 2)) continue;
                for (int variant = 0; variant < 8; ++variant) {
                    CAPTURE(width);
                    CAPTURE(int(stencil));
                    CAPTURE(int(edges));
                    CAPTURE(variant);
                    Scene s = small_scene(width, height);
                    s.stencil = stencil;
                    s.edges = edges;
                    s.time = {0.05, 0.15};
                    s.load.kind = Load::Kind::map;
                    for (int i = 0; i < width * height; ++i) s.load.map.edit().push_back(number(random));
                    s.load.envelope.start = 0.07; // one step looks ahead and is taken back
                    s.receptors.fa2_gains = {0.5, -2};
                    if (variant & 1)
                        for (int i = 0; i < width * height; ++i)
                            s.material.modulus_map.edit().push_back(2 + number(random));
                    const Precision precision = variant == 5  ? Precision::f64
                                                : variant & 2 ? Precision::f32_compensated
                                                              : Precision::f32;
                    plan::PreparedRun run = everything(s);
                    run.schedule.framed = (variant & 4) != 0;
                    const Seen plain = seen(run, precision, 1, simd::plain);
                    for (const simd::Isa* isa : simd::isas())
                        for (int threads : {1, 2}) {
                            if (threads == 2 && width < 333) continue; // too small to be shared
                            CAPTURE(isa->name);
                            CAPTURE(threads);
                            const Seen other = seen(run, precision, threads, *isa);
                            CHECK(same(other.totals, plain.totals));
                            REQUIRE(other.maps.size() == plain.maps.size());
                            for (size_t i = 0; i < plain.maps.size(); ++i) CHECK(same(other.maps[i], plain.maps[i]));
                        }
                }
            }
}

TEST_CASE("a streamed frame in place has the bits of a copy: what a band reads of another is what it was") {
    for (int threads : {1, 2, 3, 4}) { // bands of one row and more
        Scene s = small_scene(16384, 8);
        s.edges = Edges::periodic;
        s.time = {0.05, 0.2};
        const plan::PreparedRun run = everything(s);
        const Seen one = seen(run, Precision::f32, 1, simd::plain),
                   other = seen(run, Precision::f32, threads, simd::best());
        CHECK(same(one.totals, other.totals));
        for (size_t i = 0; i < one.maps.size(); ++i) CHECK(same(other.maps[i], one.maps[i]));
    }
}

TEST_CASE("what moments and estimates are made of has the same bits on every instruction set") {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> number(-1, 1);
    for (int n : {1, 7, 16, 150, 1031}) {
        std::vector<double> maps(size_t(n) * 4), plain, other;
        for (double& v : maps) v = number(random);
        const double* m = maps.data();
        const auto all = [&](const simd::Isa& isa) {
            std::vector<double> out(size_t(n) * 13);
            double* o = out.data();
            const auto row = [&](int i) { return o + i * n; };
            isa.moments(m, m + n, m + 2 * n, n, 0.3, 1.7, row(0), row(1), {row(2), row(3), row(4), row(5), row(6)});
            std::vector<double> lean(size_t(3 * n));
            isa.means(m, m + n, m + 2 * n, n, 0.3, 1.7,
                      {lean.data(), lean.data() + n, lean.data() + 2 * n, nullptr, nullptr});
            for (int x = 0; x < n; ++x) // of one row, from nothing
                REQUIRE((lean[size_t(x)] == m[x] && lean[size_t(n + x)] == row(0)[x] &&
                         lean[size_t(2 * n + x)] == row(1)[x]));
            simd::HalfPlane edges[simd::polygon_edges];
            for (int e = 0; e < simd::polygon_edges; ++e) edges[e] = {0.1 * e, 0.2, 0.3 - 0.1 * e, -0.4 + 0.2 * e};
            const bool outside = isa.outside(m, m + n, n, edges, row(12));
            const bool kinked = isa.compare(m, m + n, m + 2 * n, m + 3 * n, n, row(9), row(10), row(11));
            out.insert(out.end(), {double(outside), double(kinked)});
            return out;
        };
        for (const simd::Isa* isa : simd::isas()) CHECK(same(all(*isa), all(simd::plain)));
    }
}
