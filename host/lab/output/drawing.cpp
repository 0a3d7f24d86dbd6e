// SPDX-License-Identifier: MIT
#include "host/lab/output/drawing.hpp"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

namespace dermis::output {

namespace {

std::string in_shell(const std::string& argument) {
    std::string quoted = " '";
    for (char c : argument) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

} // namespace

std::string draw(std::string_view script, const Path& folder, const std::vector<std::string>& more) {
    std::signal(SIGCHLD, SIG_DFL); // a process that was started with it ignored could not wait for its children
    // Debian's Python, which has Debian's matplotlib. Neither Python (-I) nor matplotlib, which looks for a
    // matplotlibrc in the working directory, takes anything from the folder that the command was called in, and none
    // of the user's settings changes a picture.
    const std::string python = "cd / && MATPLOTLIBRC=/dev/null /usr/bin/python3 -I";
    if (FILE* pipe = ::popen((python + " -c 'import matplotlib, numpy' 2>&1").c_str(), "r")) {
        std::string said; // the last line
        for (char line[400]; std::fgets(line, sizeof line, pipe);) said.assign(line, std::strcspn(line, "\n"));
        if (::pclose(pipe) != 0)
            return "/usr/bin/python3 says: " + said + " (on Debian, python3-matplotlib draws pictures)";
    }
    std::string arguments = in_shell(std::filesystem::absolute(folder).string());
    for (const std::string& argument : more) arguments += in_shell(argument);
    FILE* pipe = ::popen((python + " -" + arguments).c_str(), "w");
    if (!pipe) return std::strerror(errno);
    std::fwrite(script.data(), 1, script.size(), pipe);
    if (::pclose(pipe) != 0) throw Error(Error::Code::io, "", "drawing the figures failed; its message stands above");
    return {};
}

} // namespace dermis::output
