// SPDX-License-Identifier: MIT
// labels: threads command long
// Folders of results: one writer at a time, whole files alone, whatever ends the command.
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/output.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <csignal>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <regex>
#include <sstream>

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace test;
namespace fs = std::filesystem;

namespace {

bool is_part(const fs::path& path) { return path.extension() == ".part"; }

// Does some work in a process of its own, in which leftovers are removed on signals. Returns the status it ended with.
int in_child(const std::function<void()>& work) {
    const pid_t child = fork();
    if (child == 0) {
        const rlimit no_core = {};
        setrlimit(RLIMIT_CORE, &no_core);
        for (int signal = 1; signal <= SIGRTMAX; ++signal) std::signal(signal, SIG_DFL); // the test program's own
        output::remove_leftovers_on_signals();
        work();
        _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return status;
}

// runs.csv of a sweep over two keys before the runs are done.
std::string without_figures(const std::string& table) {
    static const std::regex outcomes(",[a-z0-9_]+_(final|peak|peak_time)(?=,)"),
        line("\n([0-9]+),(?:[^,]*,){9}([^,]*,[^,]*,)[^\"]*(\"[^\n]*)");
    return std::regex_replace(std::regex_replace(table, outcomes, ""), line, "\n$1,,,,,,,,,,$2$3");
}

} // namespace

TEST_CASE("every signal that can be caught and ends a process removes its parts, and folders that are empty") {
    const Folder folder;
    int ended = 0;
    for (int signal = 1; signal <= SIGRTMAX; ++signal) {
        if (signal == SIGKILL || signal == SIGSTOP || signal == SIGTSTP || signal == SIGTTIN || signal == SIGTTOU)
            continue;
        CAPTURE(signal);
        const fs::path out = folder / "a/b";
        const int status = in_child([&] {
            const output::Folder made(out), empty(folder / "a/c");
            const output::PartFile first(out / "traces.csv", "1"), second(out / "traces.csv", "2");
            if (fs::exists(out / ("traces.csv.dermis-" + std::to_string(getpid()) + ".part"))) raise(signal);
        });
        if (WIFEXITED(status)) continue; // it is one that ends nobody
        ++ended;
        CHECK(WTERMSIG(status) == signal);
        CHECK_FALSE(fs::exists(folder / "a/c"));
        CHECK_MESSAGE(!fs::exists(out), names_in(out));
    }
    CHECK(ended >= 50); // with those of real time
}

TEST_CASE("a signal that arrives while files get their names ends the process after the last") {
    const Folder folder;
    const int status = in_child([&] {
        output::PartFile first(folder / "first", "1"), second(folder / "second", "2"), third(folder / "third", "3");
        const output::HeldSignals signals;
        first.publish(signals);
        raise(SIGINT);
        second.publish(signals);
    });
    CHECK(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == SIGINT);
    CHECK(names_in(folder / "") == "first second ");
}

TEST_CASE("a signal that was ignored stays so") {
    const Folder folder;
    CHECK(in_child([] {
              std::signal(SIGHUP, SIG_IGN); // as under nohup
              output::remove_leftovers_on_signals();
              raise(SIGHUP);
          }) == 0);
}

TEST_CASE("a part takes the place of no file, link or pipe, and the name behind a link gets a file of its own") {
    const Folder folder;
    const std::string precious = folder.write("precious", "mine");
    const auto part = [&](int n) {
        return folder / "out/traces.csv.dermis-" += std::to_string(getpid() + n) + ".part";
    };
    const output::Folder out(folder / "out");
    fs::create_symlink(precious, part(0));
    REQUIRE(mkfifo(part(1).c_str(), 0600) == 0);
    std::ofstream(part(2)) << "mine";
    fs::create_symlink(precious, folder / "out/traces.csv");
    output::write_file(folder / "out/traces.csv", "theirs");
    CHECK(slurp(precious) == "mine");
    CHECK(slurp(folder / "out/traces.csv") == "theirs");
    CHECK_FALSE(fs::is_symlink(folder / "out/traces.csv"));
    CHECK(fs::is_symlink(part(0)));
    CHECK(fs::is_fifo(part(1)));
    CHECK(slurp(part(2)) == "mine");
    CHECK_FALSE(fs::exists(part(3)));
}

TEST_CASE("of two commands that write into one folder the second is refused, until the first has ended in any way") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const fs::path out = folder / "out";
    const std::string call = "run " + scene + " --device cpu --out " + out.string();
    const auto refused = [&](const std::string& arguments, const fs::path& named) {
        const Outcome o = command(folder, arguments);
        CHECK(o.status == 1);
        CHECK(o.err == "dermis: " + named.string() +
                           ": another dermis writes into this folder; allowed: another --out, or this one when that "
                           "has ended\n");
    };
    {
        const output::Folder first(out);
        refused(call, out);
        refused(call + " --set material.modulus=1,2", out);
        refused("fit " DERMIS_TEST_DATA "/../../host/examples/fingerpad_relaxation.csv --elements 2 --out " +
                    out.string(),
                out);
        CHECK(names_in(out).empty());
    }
    CHECK_FALSE(fs::exists(out)); // which the first had made
    CHECK(command(folder, call).status == 0);
    {
        const output::Folder one_run(out / "2");
        refused(call + " --set material.modulus=1,2", out / "2");
    }
    CHECK(WTERMSIG(in_child([&] {
              const output::Folder first(out);
              raise(SIGKILL);
          })) == SIGKILL);
    CHECK(command(folder, call).status == 0);
}

TEST_CASE("a run that fails leaves no file, and an earlier run as it was") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const fs::path out = folder / "out";
    const auto run = [&](const std::string& set, const std::string& before = "") {
        return command(folder, "run " + scene + " --device cpu --out " + out.string() + set, before);
    };
    // the first file cannot be written, or the third
    const std::string first = "", third = " --set 'output.traces=[]'";
    for (const std::string& fails : {first, third}) {
        const Outcome o = run(fails, "ulimit -f 2;");
        CHECK(o.status == 1);
        CHECK_MESSAGE(o.err.find("cannot be written (File too large)") != std::string::npos, o.err);
        CHECK((o.err.find("traces.csv") == std::string::npos) == (fails == third));
        CHECK_FALSE(fs::exists(out));
    }
    REQUIRE(run("").status == 0);
    const auto before = contents(out);
    for (const std::string& fails : {first, third}) {
        CHECK(run(fails, "ulimit -f 2;").status == 1);
        CHECK(contents(out) == before);
    }
}

TEST_CASE("a folder that is a file, or lies in one, and a name that a folder has, are errors that name it") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small), file = folder.write("file", "mine");
    fs::create_directories(folder / "out/traces.csv");
    const auto says = [&](const fs::path& out, const std::string& what) {
        const Outcome o = command(folder, "run " + scene + " --device cpu --out " + out.string());
        CHECK(o.status == 1);
        CHECK(o.err == "dermis: " + what + "\n");
    };
    says(file, file + ": cannot be created (Not a directory)");
    says(file + "/out", file + "/out: cannot be created (Not a directory)");
    says(folder / "out", (folder / "out/traces.csv").string() + ": cannot be written (Is a directory)");
    CHECK(slurp(file) == "mine");
}

TEST_CASE("parts of a process that was killed go with the next run; names that are like them stay") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const std::string call = "run " + scene + " --device cpu --out " + (folder / "out").string();
    REQUIRE(command(folder, call + " --set material.modulus=1,2").status == 0);
    for (const char* name : {"traces.csv.dermis-12345.part", "2/notes.txt.dermis-1.part"})
        folder.write("out/" + std::string(name), "");
    for (const char* name : {"a.dermis-.part", "a.dermis-1x.part", "film.1.part", "a.dermis-1.parts"})
        folder.write("out/" + std::string(name), "");
    CHECK(command(folder, call).status == 0);
    CHECK(names_in(folder / "out") ==
          "a.dermis-.part a.dermis-1.parts a.dermis-1x.part curvature_t0.05.npy film.1.part impulses.csv "
          "sa1_t0.05.npy summary.json traces.csv ");
}

TEST_CASE("what a killed run leaves is cleared by the next one, but for files that are not dermis's") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small);
    const std::string call =
        "run " + scene + " --device cpu --set 'output.fields=[]' --out " + (folder / "out").string();
    fs::create_directory(folder / "out");
    folder.write("out/summary.json", unfinished); // as between the first name and the last
    folder.write("out/sa1_t7.npy", "theirs");
    folder.write("out/notes.npy", "mine");
    CHECK(command(folder, call).status == 0);
    CHECK(names_in(folder / "out") == "impulses.csv notes.npy summary.json traces.csv ");
}

namespace {

// Kills the command at random times, each time on top of what was left before, and compares every file that is there
// under its own name with that of a run that nobody killed.
class Killer {
  public:
    Killer(const Folder& folder, std::string arguments, const std::string& name)
        : arguments_(std::move(arguments)), reference_(folder / (name + "_whole")), out_(folder / name) {
        const auto start = std::chrono::steady_clock::now();
        CHECK(command(folder, arguments_ + " --out " + reference_.string()).status == 0);
        seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        whole_ = contents(reference_);
    }

    void kill(int signal, bool resume) {
        const pid_t pid =
            started(DERMIS_CLI " " + arguments_ + " --out " + out_.string() + (resume ? " --resume" : ""));
        usleep(useconds_t(1e6 * seconds_ * double(random_()) / double(random_.max())));
        ::kill(pid, signal);
        int status = 0;
        waitpid(pid, &status, 0);
        ++kills;
        while_it_ran += WIFSIGNALED(status);
        seconds_ *= WIFSIGNALED(status) ? 1.3 : 0.5; // so that most are killed while they run, on a busy machine too
        compare(signal);
    }

    // Ends what was begun.
    void finish(const Folder& folder) {
        CHECK(command(folder, arguments_ + " --resume --out " + out_.string()).status == 0);
        CHECK(contents(out_) == whole_);
    }

    int kills = 0, while_it_ran = 0, torn = 0;

  private:
    void compare(int signal) {
        for (const auto& [path, content] : contents(out_)) {
            CAPTURE(path);
            const fs::path name = fs::path(path).filename();
            const auto right = whole_.find(path);
            const bool killed = signal == SIGKILL, part = is_part(name);
            const bool whole = right != whole_.end() && content == right->second,
                       said = killed && name == "summary.json" && content == unfinished,
                       table = name == "runs.csv" && content == without_figures(right->second);
            if (!whole && !said && !table && !(killed && part)) ++torn;
            CHECK_MESSAGE((whole || said || table || (killed && part)), content);
        }
    }

    std::string arguments_;
    fs::path reference_, out_;
    double seconds_; // within which the next kill comes
    std::map<std::string, std::string> whole_;
    std::minstd_rand random_{1};
};

} // namespace

TEST_CASE("of runs and sweeps killed at random times each file under its own name is whole, and --resume ends them") {
    const Folder folder;
    const std::string scene = folder.write("scene.toml", small), run = "run " + scene + " --device cpu",
                      set = " --set surface.kind=wave,spiral material.modulus=1,2,3";
    Killer killers[] = {{folder, run, "run"}, {folder, run + set, "sweep"}, {folder, run + set, "caught"}};
    const int caught[] = {SIGINT, SIGTERM, SIGHUP};
    const int each = night() ? 100 : 40;
    for (int i = 0; i < each; ++i) {
        killers[0].kill(SIGKILL, i % 2);
        killers[1].kill(SIGKILL, i % 2);
        killers[2].kill(caught[i % 3], i % 2);
    }
    int kills = 0, while_it_ran = 0, torn = 0;
    for (Killer& k : killers) {
        k.finish(folder);
        kills += k.kills, while_it_ran += k.while_it_ran, torn += k.torn;
    }
    MESSAGE(kills, " kills, ", while_it_ran, " of them before the end: ", torn, " torn files");
    CHECK(kills == 3 * each);
    CHECK(while_it_ran > each);
    CHECK(torn == 0);
}
