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

std::string last_line(std::string text) {
    while (text.ends_with('\n')) text.pop_back();
    return text.substr(text.rfind('\n') + 1);
}

// Lets this process wait for its children: one that was started with SIGCHLD ignored cannot.
struct Awaiting {
    Awaiting() : before(std::signal(SIGCHLD, SIG_DFL)) {}
    ~Awaiting() { std::signal(SIGCHLD, before); }
    void (*before)(int);
};

} // namespace

std::string draw(std::string_view script, const Path& folder, const std::vector<std::string>& more) {
    const Awaiting awaiting;
    // Debian's Python, which has Debian's matplotlib. Neither Python (-I) nor matplotlib, which looks for a
    // matplotlibrc in the working directory, takes anything from the folder that the command was called in, and none
    // of the user's settings changes a picture.
    const std::string python = "cd / && MATPLOTLIBRC=/dev/null /usr/bin/python3 -I";
    if (FILE* pipe = ::popen((python + " -c 'import matplotlib, numpy' 2>&1").c_str(), "r")) {
        std::string said;
        for (int c; (c = std::fgetc(pipe)) != EOF;) said += char(c);
        if (::pclose(pipe) != 0)
            return "/usr/bin/python3 says: " + last_line(said) + " (on Debian, python3-matplotlib draws pictures)";
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
