// SPDX-License-Identifier: MIT
// dermis-oracle N SEED: the survey of the planner's promises on the scenes of found/, and on N of other seeds than the
// tests' in each of two families. dermis-oracle --search SECONDS SEED FOLDER: climbs towards scenes that break them;
// what it finds is in FOLDER.
#include "tests/oracle/scene_files.hpp"
#include "tests/oracle/search.hpp"

#include <cstdio>
#include <string_view>

namespace {

unsigned number(const char* text) { return unsigned(std::strtoul(text, nullptr, 10)); }

// Prints what a survey found; whether it found nothing wrong.
bool told(const oracle::Survey& s, const std::string& scenes) {
    for (auto [title, lines] : {std::pair{"tolerance broken", &s.broken},
                                {"prediction exceeded", &s.exceeded},
                                {"refused, and f64 met it", &s.wrongly_refused},
                                {"failed", &s.failed}})
        for (const std::string& line : *lines) std::printf("%s: %s\n", title, line.c_str());
    std::printf("%s, %s\n", scenes.c_str(), s.summary().c_str());
    return s.broken.empty() && s.exceeded.empty() && s.failed.empty();
}

int surveyed(int count, unsigned first) {
    const bool found = told(oracle::survey(DERMIS_FOUND), "found before");
    const bool drawn = told(oracle::survey(first, count), "seed " + std::to_string(first));
    const bool sparse =
        told(oracle::survey(first, count, &oracle::Family::next_sparse), "sparse, seed " + std::to_string(first));
    return found && drawn && sparse ? 0 : 1;
}

// Prints how near each bound came to its error, and writes what is beyond it into a folder.
int searched(double seconds, unsigned seed, const std::filesystem::path& folder) {
    int status = 0;
    for (oracle::Found& f : oracle::search(seconds, seed)) {
        const std::string name = std::string(dermis::name(f.model)) + " in " + dermis::name(f.precision);
        std::printf("%s: %lld scenes, least bound over error %.4g, from seed %u\n", name.c_str(), f.scenes, f.ratio,
                    f.seed);
        if (f.ratio >= 1) continue;
        status = 1;
        f.scene = oracle::shrunk(std::move(f.scene));
        const std::filesystem::path place =
            folder / (std::string(dermis::name(f.model)) + "_" + dermis::name(f.precision));
        oracle::write_case(f.scene, place);
        std::printf("  %s: %s\n", (place / "scene.toml").c_str(),
                    text(oracle::judge(oracle::read_case(place / "scene.toml")), f.scene.scene).c_str());
    }
    return status;
}

int written(unsigned seed, const char* folder, oracle::Case (oracle::Family::*next)()) {
    oracle::Family family(seed);
    oracle::write_case((family.*next)(), folder);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc == 3) return surveyed(std::atoi(argv[1]), number(argv[2]));
    if (argc == 4 && argv[1] == std::string_view("--write"))
        return written(number(argv[2]), argv[3], &oracle::Family::next);
    if (argc == 4 && argv[1] == std::string_view("--write-sparse"))
        return written(number(argv[2]), argv[3], &oracle::Family::next_sparse);
    if (argc == 5 && argv[1] == std::string_view("--search"))
        return searched(std::atof(argv[2]), number(argv[3]), argv[4]);
    std::fprintf(stderr,
                 "dermis-oracle N SEED: judges the scenes of the seeds SEED .. SEED + N - 1\n"
                 "dermis-oracle --search SECONDS SEED FOLDER: looks for scenes whose bound is below their error\n"
                 "dermis-oracle --write SEED FOLDER: writes the scene of a seed as dermis run reads it; --write-sparse "
                 "of the other "
                 "family\n");
    return 2;
}
