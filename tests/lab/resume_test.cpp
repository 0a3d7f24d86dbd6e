// SPDX-License-Identifier: MIT
// labels: threads command
// Going on where a run or a sweep was stopped: what stays is finished, whole and of the same making; all else is done
// again.
#include "host/lab/output/earlier.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <fstream>
#include <functional>

using namespace test;
namespace fs = std::filesystem;

namespace {

// A sweep of three runs. A run that is written anew has other files of the same names.
struct Resumed {
    Folder folder;
    fs::path out = folder / "out";
    std::string call = "run " + folder.write("scene.toml", small) + " --device cpu --out " + out.string() + " --set ";
    std::string set = "material.modulus=1,2,3";

    Resumed() { CHECK(command(folder, call + set).status == 0); }
    // Returns the numbers of the runs that stayed.
    std::string kept(const std::string& changed_set = "", const std::string& options = " --resume") const {
        const fs::path before = folder / "before";
        fs::remove_all(before);
        fs::create_directory(before);
        for (const char* run : {"1", "2", "3"}) fs::create_hard_link(out / run / "impulses.csv", before / run);
        const Outcome o = command(folder, call + (changed_set.empty() ? set : changed_set) + options);
        CHECK_MESSAGE(o.status == 0, o.err);
        std::string numbers;
        for (const char* run : {"1", "2", "3"})
            if (fs::equivalent(out / run / "impulses.csv", before / run)) numbers += run;
        if (options == " --resume")
            CHECK(o.out.find(std::to_string(numbers.size()) + " of 3 runs were done before\n") != std::string::npos);
        return numbers;
    }
};

void flip_bit(const fs::path& path, std::uintmax_t byte) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(std::streamoff(byte));
    const char changed = char(file.get() ^ 1);
    file.seekp(std::streamoff(byte));
    file.put(changed);
}

} // namespace

TEST_CASE("--resume keeps the runs of a sweep that are finished, and does the rest") {
    const Resumed sweep;
    const auto whole = contents(sweep.out);
    CHECK(sweep.kept() == "123");
    CHECK(sweep.kept("", "") == ""); // without it all are done again
    CHECK(contents(sweep.out) == whole);
    fs::remove(sweep.out / "1/traces.csv");
    sweep.folder.write("out/2/summary.json", unfinished);
    CHECK(sweep.kept() == "3");
    fs::remove(sweep.out / "3/sa1_t0.05.npy");
    CHECK(sweep.kept() == "12");
    CHECK(contents(sweep.out) == whole);
}

TEST_CASE(
    "--resume does a run again of which any file is cut, emptied or differs in a bit, of a sweep that run alone") {
    const Resumed sweep;
    const auto whole = contents(sweep.out);
    int damages = 0;
    for (const char* name : {"curvature_t0.05.npy", "impulses.csv", "sa1_t0.05.npy", "summary.json", "traces.csv"}) {
        CAPTURE(name);
        const fs::path file = sweep.out / "2" / name;
        // A summary has the seconds that its run took, so that its length changes.
        const auto bytes = [&] { return fs::file_size(file); };
        const std::function<void()> ways[] = {
            [&] { fs::resize_file(file, 0); },           [&] { fs::resize_file(file, bytes() / 2); },
            [&] { fs::resize_file(file, bytes() - 1); }, [&] { flip_bit(file, 0); },
            [&] { flip_bit(file, bytes() / 2); },        [&] { flip_bit(file, bytes() - 1); }};
        for (const auto& damage : ways) {
            damage();
            CHECK(sweep.kept() == "13");
            ++damages;
        }
        CHECK(contents(sweep.out) == whole);
    }
    CHECK(damages == 6 * 5);
}

TEST_CASE("--resume does a run again where scene, keys, options, version or commit differ") {
    const Resumed sweep;
    CHECK(sweep.kept("material.modulus=1,3,2") == "1");
    CHECK(sweep.kept("material.modulus=1,3,2 load.intensity=2") == "");
    CHECK(sweep.kept() == "");
    CHECK(sweep.kept("", " --resume --precision f64") == "");
    CHECK(sweep.kept("", " --resume --check") == "");
    CHECK(sweep.kept() == "");
    const auto edit = [&](const char* run, const char* key) {
        output::Json summary = output::summary_of(sweep.out / run);
        summary.erase("fnv1a");
        summary.at(key) = "x";
        std::ofstream(sweep.out / run / "summary.json") << output::sealed(summary);
    };
    edit("1", "version");
    edit("2", "commit");
    edit("3", "kinks"); // which a run does not follow from
    CHECK(sweep.kept() == "3");
    sweep.folder.write("scene.toml", std::string(small) + "# another\n");
    CHECK(sweep.kept() == "");
    // fewer runs, and one alone
    CHECK(command(sweep.folder, sweep.call + "material.modulus=1,2 --resume").out.find("2 of 2 runs were") == 0);
    CHECK(names_in(sweep.out) == "1 2 runs.csv ");
    CHECK(command(sweep.folder, sweep.call + "material.modulus=1 --resume").status == 0);
    CHECK(names_in(sweep.out) == "curvature_t0.05.npy impulses.csv sa1_t0.05.npy summary.json traces.csv ");
    CHECK(command(sweep.folder, sweep.call + "material.modulus=1 --resume").out.find("1 of 1 runs were") == 0);
}

TEST_CASE("figures of a summary that lacks one, or has a word in place of a number, are refused by their name") {
    const Resumed sweep;
    const fs::path summary = sweep.out / "1/summary.json";
    const std::string whole = slurp(summary);
    const auto says = [&](const std::string& from, const std::string& to, const std::string& what) {
        std::string text = whole;
        text.replace(text.rfind(from), from.size(), to);
        std::ofstream(summary) << text;
        const std::string error = refusal(Error::Code::io, [&] { output::figures_of(sweep.out / "1"); });
        CHECK_MESSAGE(error.find(summary.string() + ": ") == 0, error);
        CHECK_MESSAGE(error.find(what) != std::string::npos, error);
    };
    says("\"predicted_error\": ", "\"error\": ", "key 'predicted_error' not found");
    says("\"measured_error\": null", "\"measured_error\": \"small\"", "type must be number, but is string");
    says("\"cross_check\": null", "\"cross_check\": many", "last read: '\"cross_check\": m'");
    says("{", "[", "syntax error");
}

TEST_CASE("--resume does a run again where a map that it reads holds something else") {
    const Folder folder;
    const auto map = [&](char last) {
        return folder.write("map.npy", npy_header("<f4", "(1, 2)") + std::string("\0\0\x80\x3f\0\0\x80", 7) + last);
    };
    map('\x3f');
    const std::string scene = folder.write(
        "scene.toml",
        "[grid]\nwidth = 2\nheight = 1\n[load]\nkind = \"file\"\npath = \"map.npy\"\n[time]\nduration = 0.1\n");
    const std::string call = "run " + scene + " --device cpu --resume --out " + (folder / "out").string();
    const auto done_before = [&] { return command(folder, call).out.find("1 of 1 runs") == 0; };
    CHECK_FALSE(done_before());
    CHECK(done_before());
    map('\x40');
    CHECK_FALSE(done_before());
    CHECK(done_before());
}
