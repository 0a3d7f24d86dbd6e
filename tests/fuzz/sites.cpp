// SPDX-License-Identifier: MIT
// A list of receptors.
#include "host/lab/scenes/scene.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dermis;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    std::vector<Site> sites;
    if (!fuzz::taken([&] { sites = scene::read_sites(fuzz::file_of(data, size), {.spacing = 1e-4}); })) return 0;
    fuzz::need(!sites.empty(), "a list without receptors");
    for (const Site& site : sites) fuzz::need(scene::is_receptor_class(site.type), "a receptor of no class");
    return 0;
}
