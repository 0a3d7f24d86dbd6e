// SPDX-License-Identifier: MIT
#include "host/lab/output/drawing.hpp"

#include <cstdlib>

namespace dermis::output {

namespace {

std::string in_shell(const std::string& argument) {
    std::string quoted = " '";
    for (char c : argument) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

} // namespace

bool draw(std::string_view script, const Path& folder, const std::vector<std::string>& more) {
    // Debian's Python, which has Debian's matplotlib. Neither Python (-I) nor matplotlib, which looks for a
    // matplotlibrc in the working directory, takes anything from the folder that the command was called in.
    const std::string python = "cd / && /usr/bin/python3 -I";
    if (std::system((python + " -c 'import matplotlib' >/dev/null 2>&1").c_str()) != 0) return false;
    std::string arguments = in_shell(std::filesystem::absolute(folder).string());
    for (const std::string& argument : more) arguments += in_shell(argument);
    FILE* pipe = ::popen((python + " -" + arguments).c_str(), "w");
    if (!pipe) return false;
    std::fwrite(script.data(), 1, script.size(), pipe);
    if (::pclose(pipe) != 0) throw Error(Error::Code::io, "", "drawing the figures failed; its message stands above");
    return true;
}

} // namespace dermis::output
