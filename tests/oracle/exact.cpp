// SPDX-License-Identifier: MIT
#include "tests/oracle/exact.hpp"

#include "tests/oracle/closed_form.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace oracle {

using namespace dermis;

// ---- in space

// The weights of f[j] - f[i] in the second derivative at i.
Curvature::Weights Curvature::along(int n, Stencil stencil, Edges edges) {
    Weights all(static_cast<size_t>(n));
    if (n == 1) return all;                // an axis of one cell has no curvature
    if (edges == published_edges) {        // the gradient of the gradient, one-sided at the ends
        const auto gradient = [n](int i) { // weights of the cells at its two ends
            const int low = std::max(i - 1, 0), high = std::min(i + 1, n - 1);
            const long double weight = 1.0L / (high - low);
            return std::array{std::pair{low, -weight}, std::pair{high, weight}};
        };
        for (int i = 0; i < n; ++i) {
            std::map<int, long double> weights;
            for (auto [k, of_k] : gradient(i))
                for (auto [j, of_j] : gradient(k)) weights[j] += of_k * of_j;
            for (auto [j, weight] : weights)
                if (j != i && weight != 0) all[size_t(i)].push_back({j, weight});
        }
        return all;
    }
    const auto inside = [&](int i) {
        if (edges == Edges::periodic) return ((i % n) + n) % n;
        const int k = ((i % (2 * n)) + 2 * n) % (2 * n); // cell -1 is cell 0
        return k < n ? k : 2 * n - 1 - k;
    };
    for (int i = 0; i < n; ++i)
        for (int side : {-1, 1}) {
            auto& weights = all[size_t(i)];
            if (stencil == Stencil::five_point) weights.push_back({inside(i + side), 1});
            if (stencil == published_stencil) weights.push_back({inside(i + 2 * side), 0.25L});
            if (stencil != Stencil::fourth_order) continue;
            weights.push_back({inside(i + side), 4.0L / 3});
            weights.push_back({inside(i + 2 * side), -1.0L / 12});
        }
    return all;
}

Curvature::Curvature(const SkinDescription& d)
    : width_(d.grid.width), height_(d.grid.height),
      x_(along(width_, d.stencil.value_or(Stencil::five_point), d.edges.value_or(Edges::mirror))),
      y_(along(height_, d.stencil.value_or(Stencil::five_point), d.edges.value_or(Edges::mirror))) {}

template <class T> std::vector<T> Curvature::laplacian(const std::vector<T>& map) const {
    std::vector<T> result(map.size());
    for (int y = 0, i = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x, ++i) {
            const T here = map[size_t(i)];
            T sum = 0;
            for (auto [j, weight] : x_[size_t(x)]) sum += weight * (map[size_t(i - x + j)] - here);
            for (auto [j, weight] : y_[size_t(y)]) sum += weight * (map[size_t(x + j * width_)] - here);
            result[size_t(i)] = sum;
        }
    return result;
}

template Numbers Curvature::laplacian(const Numbers&) const;
template std::vector<Wide> Curvature::laplacian(const std::vector<Wide>&) const;

// ---- below the surface

namespace {

constexpr long double pi = 3.14159265358979323846264338327950288L;

// The nodes and weights of Gauss and Legendre on -1..1.
std::vector<std::pair<long double, long double>> gauss(int n) {
    std::vector<std::pair<long double, long double>> all;
    for (int i = 1; i <= n; ++i) {
        long double x = std::cos(pi * (i - 0.25L) / (n + 0.5L)), slope = 0;
        for (int turn = 0; turn < 60; ++turn) {
            long double p = 1, before = 0;
            for (int k = 1; k <= n; ++k) {
                const long double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1);
            x -= p / slope;
        }
        all.push_back({x, 2 / ((1 - x * x) * slope * slope)});
    }
    return all;
}

} // namespace

long double below_cell(long double x, long double y, long double h, long double z, DepthKernel kernel, long double nu) {
    static const auto nodes = gauss(20);
    const int parts = int(std::ceil(h / z)); // of the cell's sides, none longer than the depth
    const long double half = h / (2 * parts);
    long double sum = 0;
    for (int j = 0; j < parts; ++j)
        for (int i = 0; i < parts; ++i)
            for (const auto& [u, of_u] : nodes)
                for (const auto& [v, of_v] : nodes) {
                    const long double a = x - h / 2 + half * (2 * i + 1 + u), b = y - h / 2 + half * (2 * j + 1 + v);
                    const long double rho = std::sqrt(a * a + b * b + z * z);
                    const long double stress =
                        3 * z * z * z / (2 * pi * (rho * rho * rho * rho * rho)); // of a point force
                    const long double strain = (1 + nu) * (stress - 2 * nu * z / (2 * pi * rho * rho * rho)),
                                      displacement = (1 + nu) / (2 * pi * rho) * (z * z / (rho * rho) + 2 * (1 - nu)),
                                      length = z * (1 + nu) * (3 - 2 * nu) / 3;
                    sum += of_u * of_v * half * half *
                           (kernel == DepthKernel::stress   ? stress
                            : kernel == DepthKernel::strain ? strain
                                                            : displacement / length);
                }
    return sum;
}

namespace {

// ---- in time

// A time within 4 ulp of an output is the output's.
Real snapped(const Real& t, const Real& step) {
    const Real near = whole(t / step) * step;
    return abs(t - near) <= t * Real::power_of_two(-50) ? near : t;
}

// The times at which a load jumps, and by how much each load jumps there.
struct Jump {
    Real time;
    std::vector<Real> sizes;
};

// Outputs, fields and jumps.
std::vector<Instant> instants_of(const Scene& s, const std::vector<Jump>& jumps, bool step_mean) {
    const Real step = s.time.step;
    const long long rows = static_cast<long long>(std::ceil(s.time.duration / s.time.step - 1e-9));
    std::vector<Instant> all;
    for (long long n = 0; n < rows; ++n) all.push_back({step * Real(double(n)), n});
    const auto add = [&](const Instant& instant) {
        const auto here = std::lower_bound(all.begin(), all.end(), instant,
                                           [](const Instant& a, const Instant& b) { return a.time < b.time; });
        if (here == all.end() || !(here->time == instant.time)) all.insert(here, instant);
    };
    for (const FieldRequest& f : s.output.fields) add({snapped(Real(f.at), step)});
    for (const Jump& jump : jumps) add({jump.time});
    long before = -1;
    for (size_t i = 0; i < all.size(); ++i) {
        if (step_mean) all[i].since = before;
        if (all[i].row >= 0) before = long(i);
    }
    return all;
}

// A window as straight lines, and the waves that begin at its knots: each jump and each bend of the lines begins one.
void take_window(const Envelope& e, const Real& step, Pressure& p) {
    const Envelope::Window& w = *e.window;
    const bool wave = e.kind == Envelope::Kind::sine;
    const Real from = snapped(w.start, step), risen = snapped(Real(w.start) + Real(w.rise), step);
    const auto knot = [&](const Real& time, double left, double right) {
        const Real mean = wave ? e.mean : 1;
        p.knots.push_back({time, mean * left, mean * right});
    };
    struct Bend {
        Real time, jump, slope;
    };
    std::vector<Bend> bends;
    if (w.rise > 0) {
        knot(from, 0, 0);
        knot(risen, 1, 1);
        bends = {{from, 0, Real(1) / (risen - from)}, {risen, 0, Real(-1) / (risen - from)}};
    } else {
        knot(from, 0, 1);
        bends = {{from, 1, 0}};
    }
    if (w.until) {
        const Real until = snapped(*w.until, step), end = snapped(Real(*w.until) + Real(w.fall), step);
        knot(until, 1, w.fall > 0);
        if (w.fall > 0) {
            knot(end, 0, 0);
            bends.push_back({until, 0, Real(-1) / (end - until)});
            bends.push_back({end, 0, Real(1) / (end - until)});
        } else bends.push_back({until, -1, 0});
    }
    const Real angular = Real(2) * Real::pi() * Real(e.frequency), amplitude = e.amplitude;
    for (const Bend& b : bends)
        if (wave)
            p.waves.push_back(
                {amplitude * b.jump, angular, angular * b.time + Real(e.phase), b.time, amplitude * b.slope});
}

Pressure pressure_of(const Scene& s, const Envelope& e) {
    const Real start = e.start, step = s.time.step;
    Pressure p;
    if (e.window) {
        take_window(e, step, p);
        return p;
    }
    const auto knot = [&](const Real& time, double left, double right) {
        p.knots.push_back({snapped(time, step), left, right});
    };
    switch (e.kind) {
    case Envelope::Kind::step: knot(start, 0, 1); break;
    case Envelope::Kind::ramp:
        knot(start, 0, 0);
        knot(start + Real(e.rise), 1, 1);
        break;
    case Envelope::Kind::sine:
        knot(0, 0, e.mean);
        p.waves = {{e.amplitude, Real(2) * Real::pi() * Real(e.frequency), e.phase}};
        break;
    case Envelope::Kind::pulse:
        for (double k = 0; start + Real(k) * Real(e.period) <= Real(s.time.duration); ++k) {
            knot(start + Real(k) * Real(e.period), 0, 1);
            knot(start + Real(k) * Real(e.period) + Real(e.length), 1, 0);
        }
        break;
    case Envelope::Kind::table:
        for (size_t i = 0; i < e.times.size(); ++i)
            if (i > 0 && e.times[i] == e.times[i - 1]) p.knots.back().right = e.values[i];
            else knot(e.times[i], i ? e.values[i] : 0, e.values[i]);
    }
    return p;
}

// 0 before frame k and 1 from it on: of such steps equal frames have none, so that nothing cancels between them. Along
// parabolas a step also bends the pressure one frame later.
Pressure pressure_of_step(const Scene& s, size_t k, size_t count) {
    const Real interval = *s.load.interval, step = s.time.step;
    const bool bent = s.load.hold == Hold::parabolic;
    const auto time = [&](size_t i) { return snapped(interval * Real(double(i)), step); };
    const auto slope = [&](size_t i) { // from frame i on, along a line
        return Real(double(i + 1 == k)) / (time(i + 1) - time(i));
    };
    Pressure p;
    for (size_t i = k ? k - 1 : 0; i < std::min(k + 1 + bent, count); ++i) {
        const double here = i >= k;
        Knot knot{time(i), i ? here : 0, here};
        if (bent && i > 0 && i + 1 < count)
            knot.bow = Real(2) * (slope(i) - slope(i - 1)) / (time(i + 1) - time(i - 1));
        p.knots.push_back(knot);
    }
    return p;
}

// The jumps of pressures within the duration.
std::vector<Jump> jumps_of(const Scene& s, const std::vector<Pressure>& pressures) {
    std::vector<Jump> jumps;
    const auto add = [&](size_t load, const Real& time, const Real& size) {
        if (size == Real(0) || !(time < Real(s.time.duration))) return;
        auto here = std::find_if(jumps.begin(), jumps.end(), [&](const Jump& jump) { return jump.time == time; });
        if (here == jumps.end()) here = jumps.insert(here, {time, std::vector<Real>(pressures.size())});
        here->sizes[load] += size;
    };
    for (size_t load = 0; load < pressures.size(); ++load) {
        for (const Knot& k : pressures[load].knots) add(load, k.time, k.right - k.left);
        for (const Wave& w : pressures[load].waves) add(load, w.start, w.amplitude * sine_and_cosine(w.phase).first);
    }
    std::sort(jumps.begin(), jumps.end(), [](const Jump& a, const Jump& b) { return a.time < b.time; });
    return jumps;
}

using Chain = std::vector<Element>; // in series: their strains add up

// Four bits for each binade of a time constant over the step: closed forms cancel as often.
long bits_of(const Scene& s, const std::vector<Chain>& materials) {
    const int step = std::ilogb(s.time.step);
    int longest = step - 1; // as a power of two, because a quotient of two doubles may be none
    if (s.receptors.sa2_adaptation) longest = std::max(longest, std::ilogb(*s.receptors.sa2_adaptation));
    std::vector<Load> loads = s.more_loads;
    loads.push_back(s.load);
    for (const Load& load : loads)
        if (load.envelope.kind == Envelope::Kind::sine)
            longest = std::max(longest, -std::ilogb(load.envelope.frequency));
    for (const Chain& chain : materials)
        for (const Element& m : chain)
            if (m.modulus > 0 && m.viscosity > 0)
                longest = std::max(longest, std::ilogb(m.viscosity) - std::ilogb(m.modulus));
    return 4L * (longest - step + 1);
}

// ---- both

// Under one load, to more bits than a double's square has: loads and frames cancel in sums.
struct Moment {
    Wide strain = 0, integral = 0, rate = 0, acceleration = 0;
};

// The rounding of each addition is added at the end, so that a million cells have the mean of one.
long double mean_of(const Numbers& map) {
    long double sum = 0, lost = 0;
    for (long double v : map) {
        const long double next = sum + v, part = next - sum;
        lost += (sum - (next - part)) + (v - part);
        sum = next;
    }
    return (sum + lost) / (long double)map.size();
}

size_t place(const Scene& s, Cell c) { return size_t(c.y) * size_t(s.grid.width) + size_t(c.x); }

long double gained(const Receptors& r, long double v) { return v >= 0 ? r.fa2_gains[0] * v : r.fa2_gains[1] * -v; }

// The quantities of a scene, instant by instant.
class Evaluation {
  public:
    Evaluation(const Case& c, long more_bits)
        : s_(c.scene), cells_(size_t(s_.grid.width) * size_t(s_.grid.height)), curvature_(s_) {
        take_materials();
        Real::bits = more_bits + bits_of(s_, materials_);
        const bool sequence = s_.load.kind == Load::Kind::sequence;
        const Fa2 fa2 = s_.receptors.fa2.value_or(sequence ? Fa2::step_mean : Fa2::point);
        std::vector<Pressure> loads = {sequence ? pressure_of_step(s_, 0, c.frames.size())
                                                : pressure_of(s_, s_.load.envelope)};
        for (const Load& load : s_.more_loads) loads.push_back(pressure_of(s_, load.envelope));
        jumps_ = jumps_of(s_, loads);
        instants_ = instants_of(s_, jumps_, fa2 == Fa2::step_mean);
        take_space();
        std::vector<Wide> p = pressed_by(sequence ? c.frames[0] : s_.load.map.values(), s_.load.intensity);
        take_load(loads[0], p);
        for (size_t k = 0; k < s_.more_loads.size(); ++k)
            take_load(loads[1 + k], pressed_by(s_.more_loads[k].map, s_.more_loads[k].intensity));
        for (size_t k = 1; k < c.frames.size(); ++k) {
            const std::vector<Wide> before = std::exchange(p, pressed_by(c.frames[k], s_.load.intensity));
            std::vector<Wide> change(cells_);
            for (size_t i = 0; i < cells_; ++i) change[i] = p[i] - before[i];
            take_load(pressure_of_step(s_, k, c.frames.size()), change);
        }
    }

    Exact all() {
        Exact e;
        e.traces.resize(s_.output.traces.size());
        for (ExactTrace& t : e.traces) t.probes.resize(s_.output.probes.size());
        for (const FieldRequest& f : s_.output.fields)
            for (Quantity q : f.what) e.fields.push_back({f.at, q, {}});
        bent_ =
            std::any_of(e.fields.begin(), e.fields.end(), [](auto& f) { return f.quantity >= Quantity::curvature; });
        for (size_t i = 0; i < instants_.size(); ++i) take(i, e);
        return e;
    }

  private:
    // Elements in series, each modulus and viscosity a number or a map.
    std::vector<std::pair<double, double>> chain_in(size_t cell) const {
        if (s_.load.control == Control::depth) return {{1, 0}}; // the load is the strain
        const Material& m = s_.material;
        const auto at = [cell](const Map& map, double otherwise) { return map.empty() ? otherwise : map[cell]; };
        if (m.elements.empty())
            return {{at(m.modulus_map, m.modulus.value_or(1.54)), at(m.viscosity_map, m.viscosity.value_or(1))}};
        std::vector<std::pair<double, double>> chain;
        for (const KelvinVoigt& e : m.elements)
            chain.push_back({at(e.modulus_map, e.modulus), at(e.viscosity_map, e.viscosity)});
        if (m.spring) chain.push_back({*m.spring, 0});
        if (m.dashpot) chain.push_back({0, *m.dashpot});
        return chain;
    }

    void take_materials() {
        std::map<std::vector<std::pair<double, double>>, size_t> known;
        for (size_t i = 0; i < cells_; ++i) {
            const auto chain = chain_in(i);
            const auto [place, fresh] = known.insert({chain, materials_.size()});
            if (fresh) {
                Chain& elements = materials_.emplace_back();
                for (const auto& [modulus, viscosity] : chain) elements.push_back({modulus, viscosity});
            }
            material_of_.push_back(place->second);
        }
    }

    void take_space() {
        const long double spacing = s_.grid.spacing.value_or(1);
        area_ = spacing * spacing;
        l_ = s_.material.curvature_length.value_or(1);
        h_ = s_.material.thickness.value_or(1);
        height_.assign(s_.surface.map.begin(), s_.surface.map.end());
        rest_ = curvature_.laplacian(height_); // of the map: its differences are exact, however high it lies
        for (Numbers* map : {&height_, &rest_})
            for (long double& v : *map) v *= s_.surface.relief.value_or(1);
    }

    std::vector<Wide> pressed_by(const std::vector<double>& map, double intensity) const {
        std::vector<Wide> p;
        for (double v : map) {
            if (s_.load.control == Control::depth) // the strain is a map of doubles
                v = v * intensity > 0 ? v / s_.material.thickness.value_or(1) : 0;
            p.push_back(Wide(v) * intensity);
        }
        return p;
    }

    void take_load(const Pressure& pressure, const std::vector<Wide>& p) {
        take_depths(p);
        const PreparedPressure prepared(pressure, instants_);
        std::vector<std::vector<Moment>>& moments = moments_.emplace_back();
        for (const Chain& chain : materials_) {
            std::vector<Moment>& list = moments.emplace_back(instants_.size());
            for (const Element& m : chain) {
                const std::vector<Responses> all = prepared.responses(m, s_.receptors.sa2_adaptation);
                for (size_t i = 0; i < all.size(); ++i) {
                    list[i].strain += all[i].strain.wide();
                    list[i].integral += all[i].integral.wide();
                    list[i].rate += all[i].rate.wide();
                    list[i].acceleration += all[i].acceleration.wide();
                }
            }
        }
    }

    // What acts at the depth of each class under a map; the map itself for a class without a depth.
    void take_depths(const std::vector<Wide>& p) {
        std::array<std::vector<Wide>, 5>& deep = deep_maps_.emplace_back();
        deep.fill(p);
        const Depths& depths = s_.receptors.depth;
        const std::optional<double> of[] = {{}, depths.sa1, depths.sa2, depths.fa1, depths.fa2};
        const int width = s_.grid.width, height = s_.grid.height;
        std::vector<size_t> pressed;
        for (size_t i = 0; i < cells_; ++i)
            if (!((long double)p[i] == 0)) pressed.push_back(i);
        for (size_t q = 1; q < 5; ++q) {
            if (!of[q] || *of[q] == 0) continue;
            const DepthKernels& k = s_.receptors.kernel;
            const DepthKernel kernel[] = {{}, k.sa1, k.sa2, k.fa1, k.fa2};
            Numbers& weight = weights_[q]; // made once
            for (int i = 0; weight.size() < cells_; ++i)
                weight.push_back(below_cell(*s_.grid.spacing * (i % width), *s_.grid.spacing * (i / width),
                                            *s_.grid.spacing, *of[q], kernel[q], s_.receptors.poisson.value_or(0.4)));
            for (int i = 0; i < width * height; ++i) {
                Wide sum = 0;
                for (size_t j : pressed)
                    sum += p[j] * weight[size_t(std::abs(i / width - int(j) / width) * width +
                                                std::abs(i % width - int(j) % width))];
                deep[q][size_t(i)] = sum;
            }
        }
    }

    // Of what a quantity answers to, under the loads from `first` on.
    std::vector<Wide> sum(size_t instant, size_t q, Wide Moment::*what, size_t first, size_t count) const {
        std::vector<Wide> map(cells_);
        for (size_t k = first; k < first + count; ++k)
            for (size_t i = 0; i < cells_; ++i)
                map[i] += deep_maps_[k][q][i] * (moments_[k][material_of_[i]][instant].*what);
        return map;
    }
    Numbers sum(size_t instant, size_t q, Wide Moment::*what) const {
        const std::vector<Wide> map = sum(instant, q, what, 0, deep_maps_.size());
        return Numbers(map.begin(), map.end());
    }

    // The quantities at an instant; FA2 before its gains. Without curvature and deformation where no field asks for
    // one.
    std::array<Numbers, 7> quantities(size_t instant) const {
        std::array<Numbers, 7> x;
        x[0] = sum(instant, 0, &Moment::strain);
        x[1] = sum(instant, 1, &Moment::strain);
        x[2] = sum(instant, 2, &Moment::integral);
        x[3] = sum(instant, 3, &Moment::rate);
        x[4] = sum(instant, 4, &Moment::acceleration);
        const Numbers C = curvature_at(instant);
        for (size_t q = 1; q < 5; ++q)
            for (size_t i = 0; i < cells_; ++i) x[q][i] *= 1 + l_ * C[i];
        if (!bent_) return x;
        x[5] = C;
        for (size_t i = 0; i < cells_; ++i) x[6].push_back(height_[i] - h_ * x[0][i]);
        return x;
    }

    // Each load bends the skin by itself, because a great one that is even leaves a small one's curvature as it is.
    // Frames are one load.
    Numbers curvature_at(size_t instant) const {
        std::vector<Wide> bent(cells_);
        const size_t count = s_.more_loads.empty() ? deep_maps_.size() : 1;
        for (size_t k = 0; k < deep_maps_.size(); k += count) {
            const std::vector<Wide> of = curvature_.laplacian(sum(instant, 0, &Moment::strain, k, count));
            for (size_t i = 0; i < cells_; ++i) bent[i] += of[i];
        }
        Numbers C(cells_);
        for (size_t i = 0; i < cells_; ++i) C[i] = (long double)(rest_[i] - h_ * bent[i]) / area_;
        return C;
    }

    void take_impulse(size_t instant, const Jump& jump, Exact& e) const {
        const Numbers C = curvature_at(instant);
        for (Quantity q : {Quantity::fa1, Quantity::fa2}) {
            ExactImpulse impulse{jump.time.rounded(), q, Numbers(cells_, 0)};
            bool any = false;
            for (size_t i = 0; i < cells_; ++i) {
                long double weight = 0;
                for (const Element& m : materials_[material_of_[i]]) {
                    if ((m.viscosity == 0) != (q == Quantity::fa1)) continue;
                    any = true;
                    for (size_t load = 0; load < jump.sizes.size(); ++load)
                        weight += jump.sizes[load].rounded() * deep_maps_[load][size_t(q)][i] /
                                  (m.viscosity == 0 ? m.modulus : m.viscosity) * (1 + l_ * C[i]);
                }
                impulse.values[i] = q == Quantity::fa2 ? gained(s_.receptors, weight) : weight;
            }
            if (any) e.impulses.push_back(std::move(impulse));
        }
    }

    void take(size_t instant, Exact& e) const {
        const Real& time = instants_[instant].time;
        for (const Jump& jump : jumps_)
            if (jump.time == time) take_impulse(instant, jump, e);
        const auto here = [&](double at) { return snapped(Real(at), s_.time.step) == time; };
        const bool row = instants_[instant].row >= 0,
                   field = std::any_of(e.fields.begin(), e.fields.end(), [&](auto&f) { return here(f.at); });
        if (!row && !field) return;
        std::array<Numbers, 7> x = quantities(instant);
        for (size_t q = 0; q < x.size(); ++q)
            for (long double v : x[q]) e.largest[q] = std::max(e.largest[q], std::abs(v));
        for (const Site& site : s_.sites)
            if (const size_t q = size_t(site.type); row)
                e.largest_at_sites[q] = std::max(e.largest_at_sites[q], std::abs(x[q][place(s_, site.cell)]));
        for (long double& v : x[4]) v = gained(s_.receptors, v);
        for (ExactField& f : e.fields)
            if (here(f.at)) f.values = x[size_t(f.quantity)];
        if (!row) return;
        for (size_t t = 0; t < e.traces.size(); ++t) {
            const Numbers& map = x[size_t(s_.output.traces[t])];
            ExactTrace& trace = e.traces[t];
            trace.mean.push_back(mean_of(map));
            trace.min.push_back(*std::min_element(map.begin(), map.end()));
            trace.max.push_back(*std::max_element(map.begin(), map.end()));
            for (size_t p = 0; p < trace.probes.size(); ++p)
                trace.probes[p].push_back(map[place(s_, s_.output.probes[p])]);
        }
        for (const Site& site : s_.sites) e.responses.push_back(x[size_t(site.type)][place(s_, site.cell)]);
    }

    const Scene& s_;
    const size_t cells_;
    const Curvature curvature_;
    std::vector<Chain> materials_;
    std::vector<size_t> material_of_;
    std::vector<Jump> jumps_;
    std::vector<Instant> instants_;
    Numbers height_, rest_; // S, and L(S) of a spacing of 1
    long double area_ = 1, l_ = 1, h_ = 1;
    bool bent_ = false;                                       // a field asks for curvature or deformation
    std::vector<std::array<std::vector<Wide>, 5>> deep_maps_; // [load][quantity]
    std::array<Numbers, 5> weights_;                          // of cells, at the depth of each quantity
    std::vector<std::vector<std::vector<Moment>>> moments_;   // [load][material][instant]
};

// ---- the distance of a result

class Measure {
  public:
    Measure(const Exact& exact, const Scene& scene, Precision precision)
        : exact_(exact), least_(precision == Precision::f64 ? 0x1p-340 : 0x1p-64) {
        const auto& gains = scene.receptors.fa2_gains;
        gain_[4] = std::max(std::abs(gains[0]), std::abs(gains[1]));
    }

    template <class Values>
    void take(Quantity quantity, bool site, const char* where, const Values& values, const Numbers& truth,
              size_t first = 0, size_t stride = 1) {
        if (values.size() != truth.size()) {
            worst = {HUGE_VAL, quantity, where, values.size()};
            return;
        }
        const size_t q = size_t(quantity);
        const long double largest = (site ? exact_.largest_at_sites[q] : exact_.largest[q]) * gain_[q];
        for (size_t i = first; i < truth.size(); i += stride) {
            double off = double(std::abs(values[i] - truth[i]) / std::max<long double>(largest, least_));
            if (largest <= least_ && std::abs(values[i]) <= 2 * least_) off = 0; // exact, stored as 0 or thereabouts
            if (!(off >= 0)) off = HUGE_VAL;
            if (off < 0x1p-60) off = 0; // below the rounding of the truth
            if (off > worst.value) worst = {off, quantity, where, i};
        }
    }

    Distance worst;

  private:
    const Exact& exact_;
    const double least_; // what is stored
    std::array<long double, 7> gain_{1, 1, 1, 1, 1, 1, 1};
};

} // namespace

Exact exact(const Case& c, long more_bits) { return Evaluation(c, more_bits).all(); }

Distance distance(const Exact& exact, const Scene& scene, const Result& result) {
    Measure measure(exact, scene, result.precision);
    for (size_t t = 0; t < exact.traces.size(); ++t) {
        const ExactTrace& truth = exact.traces[t];
        const Trace& trace = result.traces[t];
        measure.take(trace.quantity, false, "mean", trace.mean, truth.mean);
        if (scene.output.extremes) {
            measure.take(trace.quantity, false, "min", trace.min, truth.min);
            measure.take(trace.quantity, false, "max", trace.max, truth.max);
        }
        for (size_t p = 0; p < truth.probes.size(); ++p)
            measure.take(trace.quantity, false, "probe", trace.probes[p], truth.probes[p]);
    }
    for (const ExactField& truth : exact.fields)
        for (const Field& f : result.fields)
            if (f.at == truth.at && f.quantity == truth.quantity)
                measure.take(f.quantity, false, "field", f.values, truth.values);
    for (size_t i = 0; i < scene.sites.size(); ++i)
        measure.take(scene.sites[i].type, true, "site", result.responses, exact.responses, i, scene.sites.size());
    return measure.worst;
}

} // namespace oracle
