// SPDX-License-Identifier: MIT
// The benchmark's gate. Its figures have no assertion here: times are ratios within one run of it.
#include "bench/gate.hpp"
#include "bench/rows.hpp"
#include "tests/support.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <sys/wait.h>

namespace {

std::vector<bench::Measurement> table() {
    std::vector<bench::Measurement> rows(4);
    bench::Measurement &fast = rows[0], &exact = rows[1], &wide = rows[2], &study = rows[3];
    fast.backend = "cpu-plain";
    fast.workload = "press";
    fast.width = fast.height = 512;
    fast.steps = 10;
    fast.bytes_per_cell = 44;
    fast.wall = bench::timing_of({0.011, 0.010, 0.0104, 0.0098, 0.012});
    fast.against("copy", 20);
    fast.wall.busy = 0.009;
    fast.relative_to("moves", {.busy = 0.02}, 4e8);
    exact.backend = "vulkan";
    exact.device = "llvmpipe";
    exact.driver = "llvmpipe";
    exact.driver_version = "Mesa 22";
    exact.workload = "accuracy";
    exact.width = exact.height = 64;
    exact.errors = {1e-7, 2e-7, NAN, 4e-7, 5e-7, 1.0 / 3};
    wide = fast;
    wide.backend = "cpu-avx512";
    study.backend = "cpu-avx512"; // is merely the best one here
    study.workload = "study";
    study.errors[0] = 0.25;
    return rows;
}

const bench::Origin here{"a", "quick", {"Brand, model 3", 2, "GCC 12"}};
const std::set<std::string> all_cpus = {"cpu-plain", "cpu-avx2", "cpu-avx512"};

std::vector<bench::Columns> read(const std::vector<bench::Measurement>& rows, const bench::Origin& origin = here) {
    return bench::read_table(bench::csv_of(rows, origin), "now.csv");
}

bench::Verdict against(const std::vector<bench::Columns>& now, const bench::GateOptions& options = {.cpus = all_cpus}) {
    return bench::compare(read(table()), now, options);
}

std::string all(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return text;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

template <class Call> std::string incomparable(Call&& call) {
    try {
        call();
    } catch (const bench::Incomparable& e) {
        return e.what();
    }
    FAIL_CHECK("compared");
    return "";
}

} // namespace

TEST_CASE("least, medians and quartiles are those of the runs; of_limit is bytes by time by bandwidth, the ratio busy "
          "time by busy time") {
    const bench::Measurement r = table()[0];
    CHECK(r.wall.least == 0.0098);
    CHECK(r.wall.median == 0.0104);
    CHECK(r.wall.q1 == 0.010);
    CHECK(r.wall.q3 == 0.011);
    CHECK(r.of_limit == test::relative(44.0 * 512 * 512 * 10 / 0.0104 / 20e9, 1e-12));
    CHECK(r.ratio == test::relative(0.009 / (44.0 * 512 * 512 * 10) / (0.02 / 4e8), 1e-12));
}

TEST_CASE("each row carries commit, CPU, cores, compiler and driver") {
    const std::vector<bench::Columns> rows = read(table());
    for (const bench::Columns& row : rows) {
        CHECK(row.at("schema") == "3");
        CHECK(row.at("commit") == "a");
        CHECK(row.at("size") == "quick");
        CHECK(row.at("cpu") == "Brand; model 3");
        CHECK(row.at("cores") == "2");
        CHECK(row.at("compiler") == "GCC 12");
    }
    CHECK(rows[1].at("driver_version") == "Mesa 22");
    const bench::Machine machine = bench::this_machine();
    CHECK(!machine.cpu.empty());
    CHECK(machine.cores > 0);
    CHECK(!machine.compiler.empty());
    CHECK(bench::supported_backends().count("cpu-plain") == 1);
}

TEST_CASE("a table has lost nothing against itself; a row, an error's last bit, exactness or a status is told") {
    const bench::Verdict itself = against(read(table()));
    CHECK(itself.failed.empty());
    CHECK(itself.said.empty());
    CHECK(itself.rows == 4);
    CHECK(itself.speeds == 0);
    auto after = table();
    after.erase(after.begin() + 1);
    CHECK(contains(all(against(read(after)).failed), "vulkan 1 accuracy 64 64"));
    after = table();
    after[1].errors[5] = std::nextafter(after[1].errors[5], 1);
    CHECK(contains(all(against(read(after)).failed), "err_curvature was 0.333"));
    after[1].exact = false; // whose errors may differ, but that is told
    CHECK(all(against(read(after)).failed) == "vulkan 1 accuracy 64 64       : exact was true, is false\n");
    after = table();
    after[0].status = "wrong";
    CHECK(contains(all(against(read(after)).failed), "status was ok, is wrong"));
}

TEST_CASE("speed is compared only when asked for, by the ratio within a run, with the slack") {
    auto after = table();
    after[0].ratio *= bench::speed_slack * 1.001;
    after[0].wall = bench::timing_of({10.0}); // times themselves are never compared
    after[0].of_limit = 1e-3;
    const bench::GateOptions speed{.speed = true, .cpus = all_cpus};
    CHECK(against(read(after)).failed.empty());
    const bench::Verdict slow = against(read(after), speed);
    CHECK(slow.speeds == 2);
    CHECK(slow.failed.size() == 1);
    CHECK(contains(all(slow.failed), "time over that of moves was "));
    after[0].ratio = table()[0].ratio * bench::speed_slack * 0.999;
    CHECK(against(read(after), speed).failed.empty());
    const bench::Origin other{"a", "quick", {"Brand, model 3", 2, "Clang 15"}}; // computes the same bits, not as fast
    CHECK(against(read(after, other)).failed.empty());
    CHECK(incomparable([&] { against(read(after, other), speed); }) ==
          "no speed in common: the compiler was GCC 12, is Clang 15");
}

TEST_CASE("rows of different machines, sizes or drivers are never joined; with none in common that is said") {
    const bench::Origin cpu{"a", "quick", {"Other", 2, "GCC 12"}}, cores{"a", "quick", {"Brand, model 3", 4, "GCC 12"}},
        full{"a", "full", {"Brand, model 3", 2, "GCC 12"}};
    for (const bench::Origin& origin : {cpu, cores, full})
        CHECK(
            contains(incomparable([&] { against(read(table(), origin)); }),
                     "no row in common: the earlier table is of Brand; model 3 with 2 cores, quick; this run is of "));
    auto after = table();
    after[1].driver_version = "Mesa 23";
    after[1].errors[0] = 1;
    const bench::Verdict driver = against(read(after));
    CHECK(driver.failed.empty());
    CHECK(all(driver.said) == "not compared: another device or driver: llvmpipe llvmpipe Mesa 22 (1 rows)\n");
}

TEST_CASE("a row that this processor or this run cannot have is said; one that the program has lost fails") {
    auto after = table();
    after[2] = after[0];
    after[3].backend = "cpu-avx2"; // the same bits by other instructions
    CHECK(contains(all(against(read(after)).failed), "cpu-avx512 1 press 512 512 10"));
    const bench::Verdict narrow = against(read(after), {.cpus = {"cpu-plain", "cpu-avx2"}});
    CHECK(narrow.failed.empty());
    CHECK(narrow.rows == 3);
    CHECK(all(narrow.said) == "not compared: this processor has no avx512 (1 rows)\n");
    after[3].errors[0] = 0.5;
    CHECK(contains(all(against(read(after), {.cpus = {"cpu-plain"}}).failed), "err_strain was 0.25, is 0.5"));
    after = table();
    after.erase(after.begin() + 1);
    const bench::Verdict cpu = against(read(after), {.devices = false, .cpus = all_cpus});
    CHECK(cpu.failed.empty());
    CHECK(all(cpu.said) == "not compared: Vulkan was not asked for (1 rows)\n");
    auto peer = table();
    peer[0].backend = "numpy";
    CHECK(bench::compare(read(peer), read(after), {.devices = false, .cpus = all_cpus}).failed.empty());
}

TEST_CASE("a table that is empty, foreign, older or cut off is refused") {
    const auto refused = [](const std::string& csv) {
        return incomparable([&] { bench::read_table(csv, "old.csv"); });
    };
    const std::string own = bench::csv_of(table(), here), header = own.substr(0, own.find('\n') + 1);
    CHECK(refused("") == "old.csv is no table of dermis-bench");
    CHECK(refused("time,strain\n0,1\n") == "old.csv is no table of dermis-bench");
    CHECK(refused(header) == "old.csv has no rows");
    CHECK(refused("schema,commit,date\n1,a,b\n") == "old.csv, line 2: schema = 1; allowed: 3");
    CHECK(refused("schema,commit,date\n3,a,b\n") == "old.csv has other columns than schema 3");
    CHECK(contains(refused(own.substr(0, own.size() - 9)), "old.csv, line 5 has "));
}

#ifdef DERMIS_BENCH_PROGRAM
TEST_CASE("the program refuses a table that it cannot compare with before it measures: exit status 2 and a message") {
    namespace fs = std::filesystem;
    const fs::path folder = test::temporary("bench");
    fs::create_directories(folder);
    const std::string earlier = (folder / "old.csv").string(), messages = (folder / "messages").string();
    const auto refusal = [&](const std::string& options) {
        const int status = std::system((DERMIS_BENCH_PROGRAM " --quick --device cpu --out " +
                                        (folder / "new.csv").string() + " " + options + " 2>" + messages)
                                           .c_str());
        CHECK(WEXITSTATUS(status) == 2);
        CHECK(!fs::exists(folder / "new.csv"));
        std::ostringstream text;
        text << std::ifstream(messages).rdbuf();
        return text.str();
    };
    CHECK(refusal("--compare " + earlier) == "dermis-bench: " + earlier + " cannot be read\n");
    std::ofstream(earlier) << "";
    CHECK(refusal("--compare " + earlier) == "dermis-bench: " + earlier + " is no table of dermis-bench\n");
    std::ofstream(earlier) << "schema,commit\n1,a\n";
    CHECK(contains(refusal("--compare " + earlier), "line 2: schema = 1; allowed: 3\n"));
    CHECK(contains(refusal("--speed"), "--compare"));
    fs::remove_all(folder);
}
#endif
