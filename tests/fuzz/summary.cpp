// SPDX-License-Identifier: MIT
// The bytes are what an earlier run has left in a folder: a summary.json, and after a 0 a runs.csv.
#include "host/lab/output/earlier.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <filesystem>

using namespace dermis;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const std::filesystem::path folder = "/dev/shm/dermis_fuzz_" + std::to_string(getpid());
    std::filesystem::create_directories(folder);
    const std::vector<std::string> texts = fuzz::texts(data, size);
    std::ofstream(folder / "summary.json") << texts[0];
    if (texts.size() > 1) std::ofstream(folder / "runs.csv") << texts[1];
    fuzz::taken([&] { output::figures_of(folder); });
    fuzz::taken([&] { output::is_finished(folder, output::origin_of("", {}, {}, {})); });
    fuzz::taken([&] { output::need_inputs_kept(folder, 2, {"traces.csv"}, {folder / "runs.csv"}); });
    fuzz::taken([&] { output::remove_earlier_sweep(folder, 1); });
    fuzz::taken([&] { output::remove_earlier_run(folder); });
    std::filesystem::remove_all(folder);
    return 0;
}
