// SPDX-License-Identifier: MIT
// Runs the command dermis in a folder of its own.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <sys/types.h>

namespace test {

// An empty folder that goes with its object.
class Folder {
  public:
    Folder();
    ~Folder() { std::filesystem::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    // Writes a file and returns its path.
    std::string write(const std::string& name, const std::string& content) const;

  private:
    std::filesystem::path path_;
};

// The content of a file.
std::string slurp(const std::filesystem::path&);

// The names of a folder's entries in alphabetical order, with a space behind each.
std::string names_in(const std::filesystem::path& folder);

// The files below a folder, by their paths in it; without the seconds that their runs took, which are never the same,
// and the hash of a summary, which has them.
std::map<std::string, std::string> contents(const std::filesystem::path& folder);

// The summary.json of a run that was stopped while its files got their names.
inline const std::string unfinished = "{\n  \"program\": \"dermis\",\n  \"unfinished\": true\n}\n";

struct Outcome {
    int status;
    std::string out, err;
};

// `before` goes before the command: variables, limits, a terminal.
Outcome command(const Folder&, const std::string& arguments, const std::string& before = "");

// A scene of 20 x 12 cells and 10 outputs, with a probe and two fields.
inline constexpr const char* small =
    "[grid]\nwidth = 20\nheight = 12\n[surface]\nkind = \"wave\"\n[time]\nduration = 0.1\n"
    "[output]\nprobes = [[3, 4]]\nfields = [{ at = 0.05, what = [\"sa1\", \"curvature\"] }]\n";

// Starts a program by its path, without waiting for it; what it prints is not kept.
pid_t started(const std::string& line);

} // namespace test
