// SPDX-License-Identifier: MIT
// The benchmark's gate. Its figures have no assertion here: times are ratios within one run of it.
#include "bench/rows.hpp"
#include "tests/support.hpp"

namespace {

std::vector<bench::Measurement> table() {
    std::vector<bench::Measurement> rows(2);
    bench::Measurement &fast = rows[0], &exact = rows[1];
    fast.backend = "cpu-plain";
    fast.workload = "W1";
    fast.width = fast.height = 512;
    fast.steps = 10;
    fast.bytes_per_cell = 44;
    fast.wall = bench::timing_of({0.011, 0.010, 0.0104, 0.0098, 0.012});
    fast.against("copy", 20);
    exact.backend = "vulkan";
    exact.workload = "accuracy";
    exact.width = exact.height = 64;
    exact.errors = {1e-7, 2e-7, NAN, 4e-7, 5e-7, 1.0 / 3};
    return rows;
}

std::string all(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return text;
}

} // namespace

TEST_CASE("medians and quartiles are those of the runs, and of_limit is bytes by time by bandwidth") {
    const bench::Measurement r = table()[0];
    CHECK(r.wall.median == 0.0104);
    CHECK(r.wall.q1 == 0.010);
    CHECK(r.wall.q3 == 0.011);
    CHECK(r.of_limit == doctest::Approx(44.0 * 512 * 512 * 10 / 0.0104 / 20e9));
}

TEST_CASE("a table has lost nothing against itself; a row, an error's last bit, a status or a fifth of speed is told") {
    const std::string before = bench::csv_of(table(), "a");
    CHECK(before.find("schema,commit,date,device,") == 0);
    CHECK(bench::lost(before, bench::csv_of(table(), "b")).empty());
    auto after = table();
    after.pop_back();
    CHECK(all(bench::lost(before, bench::csv_of(after, ""))).find("vulkan 1 accuracy 64 64") != std::string::npos);
    after = table();
    after[1].errors[5] = std::nextafter(after[1].errors[5], 1);
    CHECK(all(bench::lost(before, bench::csv_of(after, ""))).find("err_curvature was 0.333") != std::string::npos);
    after[1].exact = false; // whose errors may differ, but that is told
    CHECK(all(bench::lost(before, bench::csv_of(after, ""))).find("exact was true, is false") != std::string::npos);
    after = table();
    after[0].of_limit *= 0.75; // 10 % and twice the quartile range of 9.6 % may be lost
    CHECK(bench::lost(before, bench::csv_of(after, "")).empty());
    after[0].of_limit *= 0.9;
    CHECK(all(bench::lost(before, bench::csv_of(after, ""))).find("of_limit was") != std::string::npos);
    after = table();
    after[0].status = "wrong";
    CHECK(all(bench::lost(before, bench::csv_of(after, ""))).find("wrong") != std::string::npos);
}
