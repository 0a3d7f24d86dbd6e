// SPDX-License-Identifier: MIT
#include "tests/oracle/survey.hpp"

#include "tests/oracle/scene_files.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <set>
#include <sstream>
#include <thread>

#include <mpfr.h>

namespace oracle {

using namespace dermis;

Verdict judge(const Case& c) {
    Verdict v;
    v.tolerance = c.scene.tolerance.value_or(HUGE_VAL);
    v.free = !c.scene.precision && c.scene.method == Method::exact && v.tolerance >= 1e-9;
    Result result;
    try {
        result = run(c.scene, Device::cpu(1));
        v.accepted = true;
        v.predicted = result.predicted_error;
        v.unmeasured = std::isnan(result.measured_error);
        if (result.measured_error > result.predicted_error)
            v.failure = "the witnesses are off by more than the prediction";
    } catch (const Error& e) {
        if (e.parameter() != "tolerance") {
            v.failure = e.what();
            return v;
        }
        const std::string message = e.what(), mark = "attainable here: ";
        const size_t at = message.find(mark);
        v.attainable = at == std::string::npos ? HUGE_VAL : std::strtod(message.c_str() + at + mark.size(), nullptr);
        Scene forced = c.scene;
        forced.tolerance.reset();
        forced.precision = Precision::f64;
        try {
            result = run(forced, Device::cpu(1));
        } catch (const Error& overflow) {
            v.measured = {HUGE_VAL, {}, "overflow", 0};
            return v;
        }
    }
    v.model = result.model;
    v.precision = result.precision;
    const Depths& depths = c.scene.receptors.depth;
    v.spread = result.model == Model::march && (depths.sa1 || depths.sa2 || depths.fa1 || depths.fa2);
    v.measured = distance(exact(c), c.scene, result);
    return v;
}

namespace {

std::string text(const Scene& s) {
    static const char* const envelopes[] = {"step", "ramp", "sine", "pulse", "table"};
    const Material& m = s.material;
    std::ostringstream out;
    out << s.grid.width << " x " << s.grid.height << ", "
        << (s.load.kind == Load::Kind::sequence ? "frames" : envelopes[int(s.load.envelope.kind)]) << ", "
        << name(s.method) << ", z = " << m.modulus.value_or(NAN) * s.time.step / m.viscosity.value_or(NAN)
        << (m.modulus_map.empty() ? "" : " in maps") << (m.elements.empty() ? "" : " replaced by a chain") << ", step "
        << s.time.step << ", " << std::ceil(s.time.duration / s.time.step - 1e-9) << " outputs, start "
        << s.load.envelope.start;
    return out.str();
}

} // namespace

std::string text(const Verdict& v, const Scene& s) {
    std::ostringstream out;
    if (!v.failure.empty()) return v.failure + " (" + text(s) + ")";
    out << "tolerance " << v.tolerance << ", " << (v.accepted ? "predicted " : "attainable ")
        << (v.accepted ? v.predicted : v.attainable) << ", measured " << v.measured.value << " in "
        << name(v.measured.quantity) << " " << v.measured.where << " row " << v.measured.row << " by " << name(v.model)
        << " in " << name(v.precision) << " (" << text(s) << ")";
    return out.str();
}

void Survey::take(const Verdict& v, const std::string& line) {
    ++scenes;
    free += v.free;
    unmeasured += v.unmeasured;
    if (!v.failure.empty()) {
        failed.push_back(line);
        return;
    }
    if (!v.accepted) {
        ++refused;
        refused_free += v.free;
        if (v.free && v.kept()) wrongly_refused.push_back(line);
        return;
    }
    ++accepted;
    kept += v.kept();
    below_prediction += v.below_prediction();
    if (!v.kept()) broken.push_back(line);
    if (!v.below_prediction()) exceeded.push_back(line);
    if (v.measured.value > 0 && std::isfinite(v.predicted))
        ratios[v.spread                  ? "spread"
               : v.model == Model::march ? name(v.precision)
                                         : name(v.model)]
            .push_back(v.predicted / v.measured.value);
}

namespace {

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace

double Survey::median_ratio() const {
    std::vector<double> all;
    for (const auto& [arithmetic, of] : ratios)
        if (arithmetic != "spread") all.insert(all.end(), of.begin(), of.end());
    return median(all);
}

std::string Survey::median_ratios() const {
    std::ostringstream out;
    for (const auto& [arithmetic, of] : ratios)
        out << (out.tellp() > 0 ? ", " : "") << arithmetic << " " << median(of) << " (" << of.size() << ")";
    return out.str();
}

std::string Survey::summary() const {
    std::ostringstream out;
    out << scenes << " scenes: " << accepted << " accepted, of which " << broken.size() << " break their tolerance and "
        << exceeded.size() << " exceed their prediction; prediction over measurement " << median_ratio()
        << " in the median: " << median_ratios() << "; " << refused << " refused; of " << free
        << " free ones with a tolerance from 1e-9 on " << refused_free << " refused, " << wrongly_refused.size()
        << " wrongly; in " << unmeasured << " nothing was measured; " << failed.size() << " failed otherwise";
    return out.str();
}

Survey survey(const std::filesystem::path& found) {
    std::set<std::filesystem::path> folders;
    for (const auto& entry : std::filesystem::directory_iterator(found)) folders.insert(entry.path());
    Survey s;
    for (const std::filesystem::path& folder : folders) {
        const Case c = read_case(folder / "scene.toml");
        const Verdict v = judge(c);
        s.take(v, folder.filename().string() + ": " + text(v, c.scene));
    }
    return s;
}

Survey survey(unsigned first, int count, Case (Family::*next_of)()) {
    std::vector<std::pair<Verdict, std::string>> judged(static_cast<size_t>(count));
    std::atomic<int> next = 0;
    const auto work = [&] {
        for (int i; (i = next++) < count;) {
            const unsigned seed = first + unsigned(i);
            Family family(seed);
            const Case c = (family.*next_of)();
            const Verdict v = judge(c);
            judged[size_t(i)] = {v, "seed " + std::to_string(seed) + " (" + family.kind() + "): " + text(v, c.scene)};
        }
    };
    std::vector<std::future<void>> threads;
    for (unsigned n = std::max(std::thread::hardware_concurrency(), 1u); n > 0; --n)
        threads.push_back(std::async(std::launch::async, [&] {
            work();
            mpfr_free_cache(); // each thread has its own
        }));
    for (std::future<void>& thread : threads) thread.get();
    Survey s;
    for (const auto& [verdict, line] : judged) s.take(verdict, line);
    return s;
}

} // namespace oracle
