// SPDX-License-Identifier: MIT
// What a run leaves: its files, and what is said of it.
#pragma once

#include "host/lab/output/folder.hpp"
#include "host/lab/output/json.hpp"

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
// run left there is removed (see earlier.hpp). scene: as it was run. origin: from origin_of().
void write_result(const Folder&, const Scene& scene, const Result&, Json origin);

// Returns a sentence for each reason not to trust a result as it stands, with what can be done about it. A figure that
// the result does not know gives none. scene: as it was run.
std::vector<std::string> warnings(const Scene& scene, const Result&);

// Two lines at most, of the slowly and of the rapidly adapting classes: the greatest response of each class and its
// time, of all cells where the class has a trace with extremes, else of its receptors, with the receptor's cell.
std::vector<std::string> greatest_responses(const Scene&, const Result&);

// Returns spikes.npy: a structured array with the fields time, float64, and afferent, uint32.
std::string spikes_npy(const Result&);
// Returns afferents.csv: a line for each fibre, with its spikes and its mean rate over the duration, Hz.
std::string afferents_csv(const Scene&, const Result&);
// Returns psth.csv: the mean rate of the fibres of each entry of Scene::afferents, Hz, in bins from `time` on, of the
// longer of Time::step and 1 ms; the last bin ends with the run.
std::string psth_csv(const Scene&, const Result&);
// Returns a line with the number of spikes and the fibre of the greatest rate; empty without fibres.
std::string spikes_line(const Scene&, const Result&);

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
