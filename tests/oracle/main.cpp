// SPDX-License-Identifier: MIT
// dermis-oracle N SEED: the survey of the planner's promises on N scenes of other seeds than those of the tests.
#include "tests/oracle/scene_files.hpp"
#include "tests/oracle/survey.hpp"

#include <chrono>
#include <cstdio>
#include <string_view>

namespace {

unsigned number(const char* text) { return unsigned(std::strtoul(text, nullptr, 10)); }

int surveyed(int count, unsigned first) {
    const auto start = std::chrono::steady_clock::now();
    const oracle::Survey s = oracle::survey(first, count);
    for (auto [title, lines] : {std::pair{"tolerance broken", &s.broken},
                                {"prediction exceeded", &s.exceeded},
                                {"refused, and f64 met it", &s.wrongly_refused},
                                {"failed", &s.failed}})
        for (const std::string& line : *lines) std::printf("%s: %s\n", title, line.c_str());
    std::printf("seed %u, %s; %.1f s\n", first, s.summary().c_str(),
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    return s.broken.empty() && s.exceeded.empty() && s.failed.empty() ? 0 : 1;
}

int written(unsigned seed, const char* folder) {
    oracle::Family family(seed);
    oracle::write_case(family.next(), folder);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc == 3) return surveyed(std::atoi(argv[1]), number(argv[2]));
    if (argc == 4 && argv[1] == std::string_view("--write")) return written(number(argv[2]), argv[3]);
    std::fprintf(stderr, "dermis-oracle N SEED: judges the scenes of the seeds SEED .. SEED + N - 1\n"
                         "dermis-oracle --write SEED FOLDER: writes the scene of a seed as dermis run reads it\n");
    return 2;
}
