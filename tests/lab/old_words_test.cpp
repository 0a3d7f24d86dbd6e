// SPDX-License-Identifier: MIT
// labels: command
// Words of scene files that later versions will not read.
#include "host/lab/scenes/scene.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

using namespace test;

namespace {

constexpr const char* begin = "[grid]\nwidth = 9\nheight = 8\n[time]\nduration = 0.1\n[output]\ntraces = []\n";
const std::string today = std::string(begin) + "[[afferents]]\ntype = \"fa1\"\ncells = [[3, 4]]\n"
                                               "[[afferents]]\ntype = \"sa1\"\ncells = [[5, 6]]\nreset = -0.5\n";

std::string with_class(std::string text) {
    for (size_t at; (at = text.find("type = ")) != text.npos;) text.replace(at, 4, "class");
    return text;
}

} // namespace

TEST_CASE(
    "a scene with class in place of type is the same scene, and every door is told the new word once for a scene") {
    static std::vector<std::string> said;
    const auto before = std::exchange(scene::old_word_found, [](const char* sentence) { said.emplace_back(sentence); });
    const std::string text = with_class(today);
    CHECK(scene::written(Scene::from_string(text)).text == scene::written(Scene::from_string(today)).text);
    Scene::from_string(begin, {"afferents={class=\"sa1\", cells=[[1, 1]]}"});
    CHECK(said == std::vector<std::string>(2, "afferents.class is called afferents.type; class is read until 1.0"));
    scene::old_word_found = before;
    refuses([] { Scene::from_string("[afferents]\ntype = \"sa1\"\nclass = \"sa1\"\ncells = [[1, 1]]\n"); },
            "afferents.class = 'sa1'; no such key here");
}

TEST_CASE("the command runs a scene with class as one with type, and names the new word") {
    const Folder folder;
    const std::string old = folder.write("old.toml", with_class(today)), is = folder.write("new.toml", today);
    const Outcome warned = command(folder, "run " + old + " --out " + (folder / "old").string()),
                  silent = command(folder, "run " + is + " --out " + (folder / "new").string());
    CHECK(warned.status == 0);
    CHECK(warned.err == "dermis: afferents.class is called afferents.type; class is read until 1.0\n");
    CHECK(silent.err == "");
    CHECK(slurp(folder / "old" / "afferents.csv") == slurp(folder / "new" / "afferents.csv"));
}
