// SPDX-License-Identifier: MIT
// A scene, then overrides of its keys, each after a 0.
#include "host/lab/scenes/scene.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dermis;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (fuzz::may_be_crowded({data, data + size})) return 0;
    std::vector<std::string> words = fuzz::texts(data, size);
    const std::string text = words[0];
    words.erase(words.begin());
    fuzz::taken([&] { scene::read_scene(scene::text_of_string(text, "/nowhere"), words); });
    return 0;
}
