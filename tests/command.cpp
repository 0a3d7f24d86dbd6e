// SPDX-License-Identifier: MIT
#include "tests/command.hpp"

#include "tests/support.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace fs = std::filesystem;

namespace {

std::string without_seconds(const fs::path& path) {
    static const std::regex in_summary("\"seconds\": [^,]*|,\n  \"fnv1a\": [^,]*$"),
        in_table("(\n[0-9]+,[^,]*,[^,]*,)[^,]*");
    const std::string text = test::slurp(path);
    if (path.filename() == "summary.json") return std::regex_replace(text, in_summary, "");
    return path.filename() == "runs.csv" ? std::regex_replace(text, in_table, "$1") : text;
}

} // namespace

test::Folder::Folder() : path_(temporary("command")) {
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

std::string test::names_in(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    std::string all;
    for (const std::string& name : names) all += name + " ";
    return all;
}

std::map<std::string, std::string> test::contents(const fs::path& folder) {
    std::map<std::string, std::string> all;
    if (!fs::exists(folder)) return all;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) all[entry.path().lexically_relative(folder)] = without_seconds(entry.path());
    return all;
}

test::Outcome test::command(const Folder& folder, const std::string& arguments, const std::string& before) {
    const std::string out = (folder / "stdout").string(), err = (folder / "stderr").string();
    const int status = std::system((before + " " DERMIS_CLI " " + arguments + " >" + out + " 2>" + err).c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(out), slurp(err)};
}

pid_t test::started(const std::string& line) {
    std::vector<std::string> words;
    std::istringstream in(line);
    for (std::string word; in >> word;) words.push_back(word);
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    posix_spawn_file_actions_addopen(&quiet, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&quiet, 1, 2);
    pid_t pid = 0;
    if (posix_spawn(&pid, argv[0], &quiet, nullptr, argv.data(), environ) != 0) throw std::runtime_error(line);
    posix_spawn_file_actions_destroy(&quiet);
    return pid;
}
