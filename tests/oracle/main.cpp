// SPDX-License-Identifier: MIT
// dermis-oracle N SEED: the survey of the planner's promises on N scenes of other seeds than those of the tests.
#include "tests/oracle/survey.hpp"

#include <chrono>
#include <cstdio>

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "dermis-oracle N SEED: scenes of the seeds SEED .. SEED + N - 1\n");
        return 2;
    }
    const int count = std::atoi(argv[1]);
    const unsigned first = unsigned(std::strtoul(argv[2], nullptr, 10));
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
