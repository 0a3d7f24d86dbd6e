// SPDX-License-Identifier: MIT
// Runs the command dermis in a folder of its own.
#pragma once

#include <filesystem>
#include <string>

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

} // namespace test
