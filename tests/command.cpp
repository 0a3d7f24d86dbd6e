// SPDX-License-Identifier: MIT
#include "tests/command.hpp"

#include <cstdlib>
#include <fstream>
#include <sstream>

#include <sys/wait.h>
#include <unistd.h>

namespace fs = std::filesystem;

test::Folder::Folder() : path_(fs::temp_directory_path() / ("dermis_cli_test_" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
}

std::string test::Folder::write(const std::string& name, const std::string& content) const {
    std::ofstream(path_ / name) << content;
    return (path_ / name).string();
}

std::string test::slurp(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

test::Outcome test::command(const Folder& folder, const std::string& arguments, const std::string& before) {
    const std::string out = (folder / "stdout").string(), err = (folder / "stderr").string();
    const int status = std::system((before + " " DERMIS_CLI " " + arguments + " >" + out + " 2>" + err).c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(out), slurp(err)};
}
