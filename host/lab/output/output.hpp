// SPDX-License-Identifier: MIT
// Writes the files of a run, and shows its progress.
#pragma once

#include "dermis/dermis.hpp"
#include "host/lab/output/folder.hpp"

#include <chrono>
#include <cstdio>

#include <unistd.h>

namespace dermis::output {

// Returns what a .npy file begins with. descr, shape: as Python writes them.
std::string npy_header(const std::string& descr, const std::string& shape);
// Returns a .npy file of float64, shape (height, width).
std::string npy_of(const std::vector<double>& map, int width, int height);
// The names of the files that write_result writes.
std::vector<std::string> result_files(const Scene&);
// Writes traces.csv, impulses.csv, summary.json, the fields, and with sites receptors.csv and responses.npy, with
// afferents spikes.npy, afferents.csv and psth.csv; all of them or, where one cannot be written, none. What an earlier
// run left there is removed (see earlier.hpp). scene: as it was run. origin: the first lines of summary.json, from
// text_of(const Origin&).
void write_result(const Folder&, const Scene& scene, const Result&, const std::string& origin);

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
