// SPDX-License-Identifier: MIT
#include "host/core/base/refusal.hpp"
#include "host/lab/output/output.hpp"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <sys/wait.h>

namespace dermis::output {
namespace {

namespace fs = std::filesystem;

std::string in_shell(std::string_view argument) {
    std::string quoted = " '";
    for (char c : argument) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

// Neither Python, which ignores its variables, nor matplotlib, which looks for a matplotlibrc in the working directory,
// takes anything from the folder that the command was called in, and none of the user's settings changes a picture.
std::string call(const std::string& python, std::string_view script) {
    std::signal(SIGCHLD, SIG_DFL); // a process that was started with it ignored could not wait for its children
    return "cd / && MATPLOTLIBRC=/dev/null" + in_shell(python) + " -E -c" + in_shell(script);
}

std::vector<std::string> candidates() {
    std::error_code error;
    const fs::path own = fs::read_symlink("/proc/self/exe", error).parent_path();
    if (fs::exists(own.parent_path() / "pyvenv.cfg", error)) return {(own / "python3").string()};
    if (const char* named = std::getenv("DERMIS_PYTHON"); named && *named)
        return {std::strchr(named, '/') ? fs::absolute(named).string() : named};
    return {"python3", "/usr/bin/python3"};
}

} // namespace

Python python_with(const std::string& modules) {
    Python none;
    for (const std::string& python : candidates()) {
        FILE* pipe = ::popen((call(python, "import " + modules) + " 2>&1").c_str(), "r");
        if (!pipe) return {.path = {}, .why_not = std::strerror(errno)};
        std::string said; // the last line
        for (char line[400]; std::fgets(line, sizeof line, pipe);) said.assign(line, std::strcspn(line, "\n"));
        if (::pclose(pipe) == 0) return {.path = python, .why_not = {}};
        if (none.why_not.empty()) none.why_not = python + " says: " + said;
    }
    return none;
}

int run(const Python& python, std::string_view script, const std::vector<std::string>& arguments,
        std::string_view input) {
    std::string line = call(python.path, script);
    for (const std::string& argument : arguments) line += in_shell(argument);
    std::fflush(stdout); // before what the script prints
    FILE* pipe = ::popen(line.c_str(), "w");
    if (!pipe) throw Error(Error::Code::io, "", std::string("Python cannot be started: ") + std::strerror(errno));
    const auto before = std::signal(SIGPIPE, SIG_IGN); // a script that fails may not read to the end
    std::fwrite(input.data(), 1, input.size(), pipe);
    const int status = ::pclose(pipe);
    std::signal(SIGPIPE, before);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

std::string draw(std::string_view script, const Path& folder, std::vector<std::string> more) {
    const Python python = python_with("matplotlib, numpy");
    if (python.path.empty()) return python.why_not + " (on Debian, python3-matplotlib draws pictures)";
    more.insert(more.begin(), fs::absolute(folder).string());
    if (run(python, script, more, {}) != 0)
        throw Error(Error::Code::io, "", "drawing the figures failed; its message stands above");
    return {};
}

} // namespace dermis::output
