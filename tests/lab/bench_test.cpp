// SPDX-License-Identifier: MIT
// The benchmark's table. Its figures have no assertion here: times are ratios within one run of it. The gate, which
// compares two tables, has tests/documents/gate_test.py.
#include "bench/rows.hpp"
#include "tests/support.hpp"

#include <map>
#include <sstream>

namespace {

std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream parts(line + ",");
    for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(cell);
    return cells;
}

} // namespace

TEST_CASE("least, medians and quartiles are those of the runs; of_limit is bytes by time by bandwidth, the ratio busy "
          "time by busy time") {
    bench::Measurement r;
    r.width = r.height = 512;
    r.steps = 10;
    r.bytes_per_cell = 44;
    r.wall = bench::timing_of({0.011, 0.010, 0.0104, 0.0098, 0.012});
    r.against("copy", 20);
    r.wall.busy = 0.009;
    r.relative_to("moves", {.busy = 0.02}, 4e8);
    CHECK(r.wall.least == 0.0098);
    CHECK(r.wall.median == 0.0104);
    CHECK(r.wall.q1 == 0.010);
    CHECK(r.wall.q3 == 0.011);
    CHECK(r.of_limit == test::relative(44.0 * 512 * 512 * 10 / 0.0104 / 20e9, 1e-12));
    CHECK(r.ratio == test::relative(0.009 / (44.0 * 512 * 512 * 10) / (0.02 / 4e8), 1e-12));
}

TEST_CASE("each row carries commit, CPU, cores, compiler and driver, and errors to their last bit") {
    bench::Measurement r;
    r.driver_version = "Mesa 22";
    r.errors = {1e-7, 2e-7, NAN, 4e-7, 5e-7, 1.0 / 3};
    std::istringstream lines(bench::csv_of({r}, {"a", "quick", {"Brand, model 3", 2, "GCC 12"}}));
    std::string head, line;
    std::getline(lines, head);
    std::getline(lines, line);
    const std::vector<std::string> names = cells_of(head), cells = cells_of(line);
    REQUIRE(names.size() == cells.size());
    std::map<std::string, std::string> row;
    for (size_t i = 0; i < names.size(); ++i) row[names[i]] = cells[i];
    CHECK(row.at("schema") == "3");
    CHECK(row.at("commit") == "a");
    CHECK(row.at("size") == "quick");
    CHECK(row.at("cpu") == "Brand; model 3");
    CHECK(row.at("cores") == "2");
    CHECK(row.at("compiler") == "GCC 12");
    CHECK(row.at("driver_version") == "Mesa 22");
    CHECK(row.at("err_sa2").empty());
    CHECK(std::stod(row.at("err_curvature")) == 1.0 / 3);
    const bench::Machine machine = bench::this_machine();
    CHECK(!machine.cpu.empty());
    CHECK(machine.cores > 0);
    CHECK(!machine.compiler.empty());
}
