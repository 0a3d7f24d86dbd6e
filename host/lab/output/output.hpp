// SPDX-License-Identifier: MIT
// What a run leaves: its files, and what is said of it. Scripts of Python, which draw pictures.
#pragma once

#include "host/lab/output/folder.hpp"
#include "host/lab/output/json.hpp"

#include <chrono>
#include <cstdio>

#include <unistd.h>

namespace dermis::output {

// Returns what a .npy file begins with. descr, shape: as Python writes them.
std::string npy_header(const std::string& descr, const std::string& shape);
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

// Returns a line with the number of spikes and the afferent of the greatest rate; empty without afferents.
std::string spikes_line(const Scene&, const Result&);

// A line on the terminal that shows the share of the work done and the seconds left, once a second has passed; nothing
// where stderr is no terminal.
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

struct Python {
    std::string path, why_not; // path: empty if no Python has the modules; why_not: then what it said
};

// Returns a Python that has these modules, "a, b": the one of the environment that the command is installed in, else
// the one that the variable DERMIS_PYTHON names, else python3, or Debian's if python3 does not have them.
Python python_with(const std::string& modules);

// Runs a script with arguments and an input, in the folder /. Its output is the command's. Returns its exit status.
// Throws Error::io if it cannot be started.
int run(const Python&, std::string_view script, const std::vector<std::string>& arguments, std::string_view input);

// Runs a script that draws pictures of a folder's files. Its arguments are the folder and then `more`. Returns why
// there can be no pictures, as Python says it; empty: they are drawn. Throws Error::io if the script fails.
std::string draw(std::string_view script, const Path& folder, std::vector<std::string> more);

} // namespace dermis::output
