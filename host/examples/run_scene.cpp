// SPDX-License-Identifier: MIT
// Runs a scene file and prints what each receptor class answered on average.
//
//     run_scene host/examples/first_press.toml
//     run_scene host/examples/first_press.toml load.intensity=2 time.duration=1
#include <dermis/dermis.hpp>

#include <cstdio>
#include <string>
#include <vector>

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: run_scene SCENE.toml [key=value ..]\n");
        return 2;
    }
    try {
        // Further arguments replace keys of the file, as --set does for the command. Whatever is wrong with the file is
        // an error that names the line, the key, its value and what is allowed.
        const std::vector<std::string> overrides(argv + 2, argv + argc);
        const dermis::Scene scene = dermis::Scene::from_file(argv[1], overrides);

        // "auto" takes a hardware GPU where there is one, else the CPU. Both give the same bits.
        const dermis::Device device = dermis::Device::open("auto");

        // The library chooses the cheapest model that keeps the scene's tolerance; the result says which one it was.
        const dermis::Result result = dermis::run(scene, device);
        std::printf("dermis %s: %zu times by the model %s in %s\n", dermis::version(), result.time.size(),
                    name(result.model), name(result.precision));

        // A trace has one value for each time: the mean over all cells, the least and the greatest.
        for (const dermis::Trace& trace : result.traces)
            std::printf("%-6s mean at the end %12.5g\n", name(trace.quantity), trace.mean.back());

        // A jump of the load is an impulse in FA2, which a trace cannot show; it is listed apart.
        for (const dermis::Impulse& impulse : result.impulses)
            std::printf("%-6s impulse at %g s, mean %.5g\n", name(impulse.quantity), impulse.time, impulse.mean);
    } catch (const dermis::Error& e) {
        std::fprintf(stderr, "run_scene: %s\n", e.what());
        return 1;
    }
}
