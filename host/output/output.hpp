// SPDX-License-Identifier: MIT
// Writes the files of a run, and shows its progress.
#pragma once

#include "dermis/dermis.hpp"

#include <chrono>
#include <cstdio>
#include <filesystem>

#include <unistd.h>

namespace dermis::output {

using Path = std::filesystem::path;

// Makes a folder with those above it, unless it is there. Throws Error::io.
void make_folder(const Path&);
// Each file is written under a temporary name, then renamed. Throws Error::io, naming the file.
void write_file(const Path&, const std::string& content);
void write_npy(const Path&, const std::vector<double>& map, int width, int height);
// The names of the files that write_result writes.
std::vector<std::string> result_files(const Scene&);
// Writes traces.csv, impulses.csv, summary.json, the fields, and with sites receptors.csv and responses.npy. What an
// earlier run left there beside them is removed (see earlier.hpp). scene: as it was run.
void write_result(const Path& folder, const Scene& scene, const Result&);

// A line on the terminal that shows the share of the work done, once a second has passed; nothing where stderr is no
// terminal.
class Progress {
  public:
    explicit Progress(std::string what, bool on_terminal = isatty(2), FILE* to = stderr)
        : what_(std::move(what)), on_terminal_(on_terminal), to_(to) {}
    ~Progress() { clear(); }
    void operator()(double done);
    void clear(); // removes the line, so that something else can be printed

  private:
    std::string what_;
    bool on_terminal_;
    FILE* to_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), shown_ = start_;
    bool showing_ = false;
};

} // namespace dermis::output
