// SPDX-License-Identifier: MIT
// What a run leaves on disk, and what it says while it works.
#pragma once

#include "dermis/dermis.hpp"

#include <chrono>
#include <cstdio>
#include <filesystem>

#include <unistd.h>

namespace dermis::output {

using Path = std::filesystem::path;

// Each is written beside its place and renamed; throws Error::io naming the file.
void write_file(const Path&, const std::string& content);
void write_npy(const Path&, const std::vector<double>& map, int width, int height);
// traces.csv, impulses.csv, fields, summary.json. `scene` as it was run.
void write_result(const Path& folder, const Scene& scene, const Result&);

// A line on the terminal that tells how far the work is, from the second second on; nothing where stderr is no
// terminal.
class Progress {
  public:
    explicit Progress(std::string what, bool on_terminal = isatty(2), FILE* to = stderr)
        : what_(std::move(what)), on_terminal_(on_terminal), to_(to) {}
    ~Progress() { clear(); }
    void operator()(double done);
    void clear(); // takes the line away, so that something else can be printed

  private:
    std::string what_;
    bool on_terminal_;
    FILE* to_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), shown_ = start_;
    bool showing_ = false;
};

} // namespace dermis::output
