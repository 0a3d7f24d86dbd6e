// SPDX-License-Identifier: MIT
// The cores that control groups grant a process.
#include "host/core/base/cores.hpp"
#include "tests/command.hpp"

#include <doctest/doctest.h>
#include <filesystem>

using namespace test;
using dermis::simd::cores_of_quota;

namespace {

// A folder in place of the system's root.
struct Root {
    const Folder folder;

    void write(const std::string& path, const std::string& text) const {
        std::filesystem::create_directories((folder / path).parent_path());
        folder.write(path, text);
    }
    int cores() const { return cores_of_quota((folder / "").string()); }
};

} // namespace

TEST_CASE("a quota of version 2 is rounded up to whole cores, and the least of a group and its parents holds") {
    const Root root;
    CHECK(root.cores() == 0);
    root.write("proc/self/cgroup", "0::/a/b\n");
    CHECK(root.cores() == 0);
    root.write("sys/fs/cgroup/a/b/cpu.max", "max 100000\n");
    CHECK(root.cores() == 0);
    root.write("sys/fs/cgroup/a/cpu.max", "250000 100000\n");
    CHECK(root.cores() == 3);
    root.write("sys/fs/cgroup/a/b/cpu.max", "200000 100000\n");
    CHECK(root.cores() == 2);
    root.write("sys/fs/cgroup/a/b/cpu.max", "1000 100000\n");
    CHECK(root.cores() == 1);
}

TEST_CASE("a container whose path is the host's has the quota of its own root") {
    const Root root;
    root.write("proc/self/cgroup", "0::/system.slice/docker-1.scope\n");
    root.write("sys/fs/cgroup/cpu.max", "150000 100000\n");
    CHECK(root.cores() == 2);
    root.write("proc/self/cgroup", "0::/\n");
    CHECK(root.cores() == 2);
}

TEST_CASE("a quota of version 1 stands in two files, of a hierarchy that may share its name") {
    for (const std::string name : {"cpu", "cpu,cpuacct"}) {
        const Root root;
        root.write("proc/self/cgroup", "5:memory:/x\n4:" + name + ":/x\n1:name=systemd:/x\n0::/x\n");
        root.write("sys/fs/cgroup/" + name + "/x/cpu.cfs_quota_us", "-1\n");
        root.write("sys/fs/cgroup/" + name + "/x/cpu.cfs_period_us", "100000\n");
        CHECK(root.cores() == 0);
        root.write("sys/fs/cgroup/" + name + "/x/cpu.cfs_quota_us", "350000\n");
        CHECK(root.cores() == 4);
        root.write("sys/fs/cgroup/memory/x/cpu.cfs_quota_us", "100000\n");
        CHECK(root.cores() == 4);
    }
}

TEST_CASE("files that are not what they should be limit nothing") {
    for (const char* text : {"", "\n", "max", "100000", "-5 100000", "100000 0", "nan nan", "x y", "0 100000"}) {
        const Root root;
        root.write("proc/self/cgroup", "0::/\nrubbish\n0:\n::\n");
        root.write("sys/fs/cgroup/cpu.max", text);
        CHECK(root.cores() == 0);
    }
}

TEST_CASE("the CPU path has at least one core and no more than the quota of this process") {
    const int cores = dermis::simd::cores(), quota = cores_of_quota("");
    CHECK(cores >= 1);
    CHECK((quota == 0 || cores <= quota));
}
