// SPDX-License-Identifier: MIT
// labels: threads long
// The loops of every instruction set that this processor has, in every variant, against the plain ones. On skins and
// marches of any size: the suites `ways` and `backends`.
#include "host/core/cpu/backend.hpp"
#include "host/core/cpu/planes.hpp"
#include "host/core/cpu/spreading.hpp"
#include "host/core/simd/isa.hpp"
#include "host/lab/march/march.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <random>
#include <set>

using namespace test;

namespace {

struct Seen {
    std::vector<std::vector<double>> maps; // at every step
    std::vector<double> totals;
};

// together: maps are read at the end alone, so that steps may be taken together.
Seen seen(const model::PreparedRun& run, Precision precision, int threads, const simd::Isa& isa,
          bool together = false) {
    Seen all;
    cpu::CpuBackend backend(threads, isa);
    const auto stepper =
        model::march(backend, run.skin, run.schedule, precision, [&](auto&, const model::Sample& sample) {
            for (const model::Totals& t : sample.totals) all.totals.insert(all.totals.end(), {t.mean, t.min, t.max});
            all.totals.insert(all.totals.end(), sample.points.begin(), sample.points.end());
        });
    model::Timeline timeline(run.schedule, run.skin);
    std::vector<std::vector<double>> maps;
    double turn = 1;
    const auto read = [&] {
        stepper->read({Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2,
                       Quantity::curvature, Quantity::deformation},
                      maps);
        all.maps.insert(all.maps.end(), maps.begin(), maps.end());
    };
    for (model::Step step; timeline.next(step); turn = -0.7 * turn) {
        if (run.schedule.framed) {
            std::vector<double> frame = run.schedule.pressure;
            for (double& p : frame) p *= turn;
            stepper->frame(frame);
        }
        stepper->press(step);
        if (!together) read();
    }
    stepper->finish();
    if (together) read();
    return all;
}

// A variant of a loop: what templates of host/core/simd are instantiated by.
struct LoopVariant {
    simd::Hold hold = simd::Hold::linear;
    bool materials = false, compensated = false;
    int elements = 1; // and a spring, if there are more than 2
    int stencil = STENCIL_FIVE_POINT;
    bool passed = false, tiles = false, all = true; // FA2 without gains; sums; all responses or one
    int streamed = -1; // responses go past the caches, and begin as many cells behind a cache line; -1: they do not

    std::string name() const {
        const char* holds[] = {"held", "linear", "parabolic"};
        return std::string(holds[int(hold)]) + (materials ? ", materials" : "") + (compensated ? ", compensated" : "") +
               ", " + std::to_string(elements) + " in series, stencil " + std::to_string(stencil) +
               (passed ? ", passed" : "") + (tiles ? ", sums" : "") + (all ? "" : ", one response") +
               (streamed < 0 ? "" : ", streamed " + std::to_string(streamed) + " behind a line");
    }
};

// The arguments of a step and an answer in one memory, of which every number can be compared.
template <class K> struct LoopMemory {
    using real = typename K::real;
    static constexpr int width = 150, pitch = 160, far = 2, most_maps = 40, line = 64 / int(sizeof(real));

    LoopMemory(const LoopVariant& v, unsigned seed) : numbers(size_t(most_maps * pitch + 2 * line)) {
        first = line - int(reinterpret_cast<size_t>(numbers.data()) % 64 / sizeof(real)) + std::max(v.streamed, 0);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> number(-1, 1);
        for (int i = 0; i < most_maps * pitch; ++i) map(0)[i] = real(number(random));
        for (auto& k : table)
            for (size_t i = 0; i < sizeof k / sizeof(real); ++i) (&k.E)[i] = real(number(random));
        real* const members = &c.coefficients.E;
        for (size_t i = 0; i < (sizeof c.coefficients + 7 * sizeof(real)) / sizeof(real); ++i)
            members[i] = real(number(random));
        c.gain_plus = real(v.passed ? 1 : 0.5), c.gain_minus = real(v.passed ? -1 : 2);
        const bool spring = v.elements > 2, parabolic = v.hold == simd::Hold::parabolic;
        for (int i = 0; i < pitch; ++i) material[size_t(i)] = i / 5 % 3 * (v.elements + spring);
        for (size_t i = 0; i < line_material.size(); ++i) line_material[i] = i % 2 ? -1 : material[16 * i];
        simd::StateRow<real> state{.value = {map(0), map(8)},
                                   .lost = {v.compensated ? map(9) : nullptr, v.compensated ? map(17) : nullptr},
                                   .element = size_t(pitch),
                                   .strain = v.elements > 1 ? map(18) : map(0),
                                   .rate = spring ? map(19) : nullptr,
                                   .previous = parabolic ? map(20) : nullptr};
        a = {.count = width,
             .elements = v.elements,
             .spring = spring,
             .pressure = map(21),
             .pressure_to = v.hold == simd::Hold::held ? nullptr : map(22),
             .material = v.materials ? material.data() : nullptr,
             .line_material = v.materials ? line_material.data() : nullptr,
             .table = table,
             .from = state,
             .to = state,
             .signal = {map(23), map(24)}};
        r = {.first = 0,
             .last = width,
             .strain =
                 simd::neighbours<real>(far, width, 5, v.stencil, EDGES_MIRROR, [&](int i) { return map(25 + i); }),
             .signal = {map(25 + far), map(30), map(31), map(32)},
             .rest_curvature = map(33),
             .response = {},
             .streams = v.streamed >= 0,
             .tiles = {}};
        for (int i = 0; i < RESPONSE_MAPS; ++i) r.response[i] = v.all || i == 2 ? map(34 + i) : nullptr;
        for (int q = 0; v.tiles && q < REDUCED_MAPS; ++q) r.tiles[q] = tiles[q];
    }
    real* map(int i) { return numbers.data() + first + i * pitch; }
    // Whether all is the same, except the cells beyond a row's end.
    bool same(LoopMemory& other) {
        for (int i = 0; i < most_maps; ++i)
            if (std::memcmp(map(i), other.map(i), width * sizeof(real)) != 0) return false;
        return std::memcmp(tiles, other.tiles, sizeof tiles) == 0;
    }

    std::vector<real> numbers;
    int first; // where the maps begin
    std::array<int, pitch> material;
    std::array<int, pitch / PITCH_CELLS> line_material;
    typename K::Coefficients table[3 * 8];
    typename K::Constants c{};
    typename K::Summary tiles[REDUCED_MAPS][3] = {};
    simd::AdvanceArguments<K> a;
    simd::RespondArguments<K> r;
};

// Compares a loop with the plain one, and notes the variant.
template <class K, class Call>
void compare_loop(std::set<std::string>& ran, const simd::Isa& isa, const char* loop, const LoopVariant& v, Call call) {
    LoopVariant unstreamed = v;
    unstreamed.streamed = -1;
    LoopMemory<K> plain(unstreamed, 3), other(v, 3);
    CAPTURE(isa.name);
    CAPTURE(loop);
    CAPTURE(v.name());
    CHECK(call(isa, other) == call(simd::plain, plain));
    isa.fence_streams();
    CHECK(other.same(plain));
    CHECK(ran.insert(std::string(loop) + (std::is_same_v<K, f32> ? " f32, " : " f64, ") + v.name()).second);
}

// Returns the variants of each loop that an instruction set ran.
template <class K> std::set<std::string> compared_variants(const simd::Isa& isa) {
    std::set<std::string> ran;
    for (simd::Hold hold : {simd::Hold::held, simd::Hold::linear, simd::Hold::parabolic})
        for (bool materials : {false, true})
            for (bool compensated : {false, true})
                for (int elements : {1, 3})
                    compare_loop<K>(ran, isa, "advance", {hold, materials, compensated, elements},
                                    [](const simd::Isa& of, LoopMemory<K>& m) { return of.of<K>().advance(m.a, m.c); });
    for (int stencil : {STENCIL_FIVE_POINT, STENCIL_FOURTH_ORDER, STENCIL_PUBLISHED}) {
        for (bool passed : {false, true})
            for (bool tiles : {false, true})
                for (bool all : {false, true})
                    compare_loop<K>(ran, isa, "respond",
                                    {.stencil = stencil, .passed = passed, .tiles = tiles, .all = all},
                                    [](const simd::Isa& of, LoopMemory<K>& m) {
                                        of.of<K>().respond(m.r, m.c);
                                        return 0;
                                    });
        for (int streamed : {-1, 0, 5})
            for (bool passed : {false, true})
                for (bool compensated : {false, true})
                    for (LoopVariant v : {LoopVariant{simd::Hold::parabolic, false, compensated, 3, stencil},
                                          {simd::Hold::linear, true, compensated, 1, stencil},
                                          {simd::Hold::linear, false, compensated, 1, stencil},
                                          {simd::Hold::linear, false, compensated, 2, stencil},
                                          {simd::Hold::linear, false, compensated, 3, stencil}}) {
                        v.passed = passed, v.streamed = streamed;
                        compare_loop<K>(ran, isa, "step_rows", v, [](const simd::Isa& of, LoopMemory<K>& m) {
                            of.of<K>().step_rows({.advance = m.a, .respond = m.r}, m.c);
                            return 0;
                        });
                    }
    }
    for (int count : {1, 15, 16, 17, 63, 64})
        compare_loop<K>(ran, isa, "join_tiles", {.elements = count}, [&](const simd::Isa& of, LoopMemory<K>& m) {
            std::vector<typename K::Summary> tiles;
            long double sum = 0;
            for (int i = 0; i < count; ++i) {
                tiles.push_back({m.map(0)[i], m.map(1)[i], m.map(2)[i]});
                sum += tiles.back().sum;
            }
            simd::JoinedTiles<K> joined;
            of.of<K>().join_tiles(tiles.data(), count, joined);
            const double total = 0x1p28 * (double(joined.sum.sum) + double(joined.sum.rest));
            CHECK(total == absolute(double(sum), 64 * 0x1p-44));
            CHECK(joined.low == std::ranges::min(tiles, {}, &K::Summary::low).low);
            CHECK(joined.high == std::ranges::max(tiles, {}, &K::Summary::high).high);
            return std::bit_cast<std::array<uint64_t, 2>>(std::array{total, double(joined.low)});
        });
    return ran;
}

// The answers of SA1 and FA2 at two depths, of so many pads under random signals.
template <class K>
std::vector<typename K::real> spread_by(const simd::Isa& isa, const model::PreparedSkin& skin, size_t pads,
                                        const std::vector<typename cpu::Spreading<K>::Class>& classes) {
    using real = typename K::real;
    cpu::Spreading<K> spreading(skin, classes, size_t(skin.width()), pads, true, 1, isa);
    const size_t all = skin.cells() * pads;
    std::mt19937 random(3);
    std::vector<real> strain(all), signal(all), answers(2 * all);
    for (size_t i = 0; i < all; ++i) strain[i] = real(random()) * 0x1p-34f, signal[i] = real(random()) * 0x1p-31f - 1;
    const real* const from[] = {strain.data(), signal.data()};
    real* const to[] = {answers.data(), answers.data() + all};
    spreading.spread({.count = pads}, from, to, strain.data());
    return answers;
}

// Compares pads that stand side by side, as each instruction set has them, and alone with plain loops.
template <class K> void compare_spreads(const model::PreparedSkin& skin, const model::Depth& depth, double deeper) {
    std::vector<typename cpu::Spreading<K>::Class> classes;
    for (const auto& [q, deep] : {std::pair{QUANTITY_SA1, depth.depth}, {QUANTITY_FA2, deeper * depth.depth}})
        classes.push_back({q, std::make_shared<const model::Spread>(
                                  model::spread_of({deep, depth.kernel, depth.poisson}, skin.width(), skin.height()))});
    for (const simd::Isa* isa : simd::isas())
        for (const size_t pads : {size_t(1), size_t(isa->of<K>().beside + 1)}) {
            CAPTURE(isa->name);
            CAPTURE(pads);
            CAPTURE(skin.width());
            CHECK(same_bits(spread_by<K>(*isa, skin, pads, classes), spread_by<K>(simd::plain, skin, pads, classes)));
        }
}

} // namespace

TEST_CASE("every variant of the loops of each instruction set here has the bits of the plain one") {
    std::vector<std::string> here, expected = {"plain"};
    for (const simd::Isa* isa : simd::isas()) here.push_back(isa->name);
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx2")) expected.push_back("avx2");
    else MESSAGE("without AVX2 none of its variants runs here");
    if (__builtin_cpu_supports("avx512f")) expected.push_back("avx512");
    else MESSAGE("without AVX-512 none of its variants runs here");
#endif
    std::ranges::sort(here), std::ranges::sort(expected);
    CHECK(here == expected);
    for (const simd::Isa* isa : simd::isas()) {
        std::string names;
        for (const std::set<std::string>& ran : {compared_variants<f32>(*isa), compared_variants<f64>(*isa)}) {
            CHECK(ran.size() == 24 + 24 + 180 + 6); // of advance, respond, step_rows and join_tiles
            for (const std::string& name : ran) names += "\n  " + name;
        }
        MESSAGE(isa->name, names);
    }
}

TEST_CASE(
    "maps that spread to depths on grids of any side have the bits of the plain loops, pads alone and side by side") {
    for (int side : {1, 2, 3, 4, 5, 6, 7, 8, 9, 40})
        for (DepthKernel kernel : {DepthKernel::stress, DepthKernel::displacement}) {
            SkinDescription d = small_scene(side, std::min(side, 23));
            d.receptors.fa2 = Fa2::point;
            const model::PreparedSkin skin = model::prepare_skin(d, 1);
            for (const double deeper : {0.2, 5.0}) { // FA2 than SA1
                compare_spreads<f32>(skin, {0.1 * side, kernel, 0.4}, deeper);
                compare_spreads<f64>(skin, {0.1 * side, kernel, 0.4}, deeper);
            }
        }
}

TEST_CASE("a tile has the range and the sum of its responses, in whichever cells the greatest and the least are") {
    const auto check = [](auto k, const simd::Isa& isa, const LoopVariant& v) {
        using K = decltype(k);
        LoopMemory<K> m(v, 3);
        for (int turn = 0; turn < m.width; ++turn) {
            for (int i = 0; i < m.most_maps; ++i) std::rotate(m.map(i), m.map(i) + 1, m.map(i) + m.width);
            isa.of<K>().respond(m.r, m.c);
            for (int q = 0; q < REDUCED_MAPS; ++q)
                for (int x = 0; x < m.width; x += TILE_CELLS) {
                    const auto* of = (q == QUANTITY_STRAIN ? m.r.strain.here : m.r.response[q - QUANTITY_SA1]) + x;
                    const int cells = std::min(TILE_CELLS, m.width - x);
                    const auto& tile = m.tiles[q][x / TILE_CELLS];
                    REQUIRE(tile.low == *std::min_element(of, of + cells));
                    REQUIRE(tile.high == *std::max_element(of, of + cells));
                    double sum = 0, size = 0;
                    for (int i = 0; i < cells; ++i) sum += of[i], size += std::abs(double(of[i]));
                    REQUIRE(double(tile.sum) ==
                            absolute(sum, 8 * double(std::numeric_limits<decltype(tile.sum)>::epsilon()) * size));
                }
        }
    };
    for (const simd::Isa* isa : simd::isas())
        for (int stencil : {STENCIL_FIVE_POINT, STENCIL_FOURTH_ORDER, STENCIL_PUBLISHED})
            for (bool passed : {false, true}) {
                CAPTURE(isa->name);
                CAPTURE(stencil);
                check(f32(), *isa, {.stencil = stencil, .passed = passed, .tiles = true});
                check(f64(), *isa, {.stencil = stencil, .passed = passed, .tiles = true});
            }
}

TEST_CASE("steps taken together by bands of rows have the bits of steps taken one by one") {
    struct Case {
        int width, height;
        Stencil stencil;
        Edges edges;
        Precision precision;
        bool materials;
    };
    for (const Case& c : {Case{16384, 9, Stencil::five_point, Edges::periodic, Precision::f32, false},
                          Case{16384, 9, Stencil::five_point, Edges::mirror, Precision::f32_compensated, true},
                          Case{9000, 40, Stencil::fourth_order, Edges::periodic, Precision::f64, false},
                          Case{9000, 40, published_stencil, published_edges, Precision::f32, true}}) {
        CAPTURE(c.width);
        CAPTURE(int(c.stencil));
        Scene s = small_scene(c.width, c.height);
        s.stencil = c.stencil;
        s.edges = c.edges;
        s.time = {0.05, 0.6};
        s.load.envelope.start = 0.07;
        s.output.fields = {{0.12, {Quantity::sa1}}, {0.4, {Quantity::fa1}}};
        if (c.materials)
            for (int i = 0; i < c.width * c.height; ++i) s.material.modulus_map.edit().push_back(1 + i / 700 % 3);
        const model::PreparedRun run = everything(s);
        const Seen one = seen(run, c.precision, 1, simd::plain);
        for (int threads : {1, 2, 3}) {
            CAPTURE(threads);
            const Seen together = seen(run, c.precision, threads, simd::best(), true);
            CHECK(same_bits(one.totals, together.totals));
            REQUIRE(together.maps.size() == 7); // at the end
            for (size_t i = 0; i < 7; ++i) CHECK(same_bits(together.maps[i], one.maps[one.maps.size() - 7 + i]));
        }
    }
}
