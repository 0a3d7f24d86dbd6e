// SPDX-License-Identifier: MIT
// Words of a command line after a scene, each after a 0 but the first: --set, and what it makes of the scene.
#include "host/lab/command/commands.hpp"
#include "host/lab/scenes/scene.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dermis;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (fuzz::may_be_crowded({data, data + size})) return 0;
    std::vector<std::string> overrides;
    const std::vector<std::string> words = cli::with_each_set(fuzz::texts(data, size));
    for (size_t i = 0; i + 1 < words.size(); ++i)
        if (words[i] == "--set") overrides.push_back(words[++i]);
    fuzz::taken([&] {
        const std::vector<cli::Setting> settings = cli::settings_of(overrides);
        size_t runs = 1;
        for (const cli::Setting& s : settings) {
            fuzz::need(!s.values.empty(), "a key without values");
            runs *= s.values.size();
            if (runs > 1000) return;
        }
        const auto all = cli::combinations(settings);
        fuzz::need(all.size() == runs, "another number of combinations");
        for (size_t i = 0; i < all.size() && i < 4; ++i) scene::read_scene(scene::text_of_string("", ""), all[i]);
    });
    return 0;
}
