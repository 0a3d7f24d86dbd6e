// SPDX-License-Identifier: MIT
#include "bench/gate.hpp"

#include "bench/rows.hpp"

#include <cstdlib>
#include <sstream>

#include <fmt/format.h>

namespace bench {
namespace {

std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells(1);
    for (char c : line)
        if (c == ',') cells.emplace_back();
        else cells.back() += c;
    return cells;
}

// Throws unless the text is empty or one number as a whole.
void need_number(const std::string& text, const std::string& where) {
    char* end = nullptr;
    std::strtod(text.c_str(), &end);
    if (*end != 0) throw Incomparable(fmt::format("{} = {}; allowed: a number, or nothing", where, text));
}

std::string joined(const Columns& row, std::initializer_list<const char*> names) {
    std::string text;
    for (const char* name : names) text += (text.empty() ? "" : " ") + row.at(name);
    return text;
}

bool on_device(const Columns& row) { return row.at("backend").rfind("vulkan", 0) == 0; }
bool on_cpu(const Columns& row) { return row.at("backend").rfind("cpu-", 0) == 0; }

std::string machine_of(const Columns& row) { return fmt::format("{} with {} cores", row.at("cpu"), row.at("cores")); }
std::string driver_of(const Columns& row) { return joined(row, {"device", "driver", "driver_version"}); }

// Every instruction set computes the same bits. Where instruction sets are compared as contenders, each has a row of
// its own; elsewhere a row's backend says which one was the best.
bool contends(const Columns& row) { return row.at("workload") == "press" || row.at("workload") == "press-fa1"; }

std::string name_of(const Columns& row) {
    return (on_cpu(row) && !contends(row) ? "cpu" : row.at("backend")) + " " +
           joined(row, {"threads", "workload", "width", "height", "steps", "receptors", "model", "method", "precision",
                        "stencil", "dt_over_tau"});
}

std::string key(const Columns& row) {
    return joined(row, {"cpu", "cores", "size"}) + " " + driver_of(row) + " " + name_of(row);
}

class Comparison {
  public:
    Comparison(const std::vector<Columns>& now, const GateOptions& options) : options_(options) {
        for (const Columns& row : now) {
            now_[key(row)] = &row;
            machines_.insert(machine_of(row) + ", " + row.at("size"));
            devices_ |= on_device(row);
            drivers_.insert(driver_of(row));
        }
    }

    // Compares a row of the earlier table with its partner.
    void take(const Columns& before) {
        if (!on_cpu(before) && !on_device(before)) return; // a peer's
        const auto found = now_.find(key(before));
        if (found == now_.end()) return missing(before);
        const Columns& row = *found->second;
        ++verdict_.rows;
        for (const char* error : {"err_strain", "err_sa1", "err_sa2", "err_fa1", "err_fa2", "err_curvature"})
            if (before.at("exact") == "true" && row.at("exact") == "true") need_equal(before, row, error);
        need_equal(before, row, "exact");
        need_equal(before, row, "status");
        if (options_.speed) compare_speed(before, row);
    }

    Verdict verdict(const std::vector<Columns>& earlier) {
        if (!verdict_.rows)
            throw Incomparable(fmt::format("no row in common: the earlier table is of {}, {}; this run is of {}",
                                           machine_of(earlier.front()), earlier.front().at("size"),
                                           fmt::join(machines_, " and ")));
        if (options_.speed && !verdict_.speeds)
            throw Incomparable(fmt::format("no speed in common{}", compilers_.empty() ? "" : ": " + compilers_));
        if (!compilers_.empty()) verdict_.said.push_back("some speeds are not compared: " + compilers_);
        for (const auto& [why, rows] : said_)
            verdict_.said.push_back(fmt::format("not compared: {} ({} rows)", why, rows));
        return verdict_;
    }

  private:
    // A row that is missing is lost, unless a reason is given why there cannot be one.
    void missing(const Columns& before) {
        if (!machines_.count(machine_of(before) + ", " + before.at("size")))
            ++said_[fmt::format("only the earlier table has {}, {}", machine_of(before), before.at("size"))];
        else if (on_device(before) && !options_.devices) ++said_["Vulkan was not asked for"];
        else if (on_device(before) && devices_ && !drivers_.count(driver_of(before)))
            ++said_["another device or driver: " + driver_of(before)];
        else if (on_cpu(before) && !options_.cpus.count(before.at("backend")))
            ++said_[fmt::format("this processor has no {}", before.at("backend").substr(4))];
        else verdict_.failed.push_back(name_of(before) + ": the row is lost");
    }

    void need_equal(const Columns& before, const Columns& row, const char* column) {
        if (before.at(column) != row.at(column))
            verdict_.failed.push_back(
                fmt::format("{}: {} was {}, is {}", name_of(before), column, before.at(column), row.at(column)));
    }

    void compare_speed(const Columns& before, const Columns& row) {
        if (before.at("ratio").empty() || row.at("ratio").empty() || before.at("ratio_to") != row.at("ratio_to"))
            return;
        if (before.at("compiler") != row.at("compiler")) {
            compilers_ = fmt::format("the compiler was {}, is {}", before.at("compiler"), row.at("compiler"));
            return;
        }
        ++verdict_.speeds;
        const double was = std::atof(before.at("ratio").c_str()), is = std::atof(row.at("ratio").c_str());
        if (!(is <= was * speed_slack))
            verdict_.failed.push_back(fmt::format("{}: time over that of {} was {:.3g}, is {:.3g}; allowed: {:.3g}",
                                                  name_of(before), row.at("ratio_to"), was, is, was * speed_slack));
    }

    const GateOptions& options_;
    std::map<std::string, const Columns*> now_;
    std::set<std::string> machines_, drivers_;
    bool devices_ = false;
    std::string compilers_; // how the compilers differ
    std::map<std::string, int> said_;
    Verdict verdict_;
};

} // namespace

std::vector<Columns> read_table(const std::string& csv, const std::string& name) {
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    const std::vector<std::string> names = cells_of(line);
    const bool own = line + "\n" == csv_of({}, {});
    if (names.front() != "schema") throw Incomparable(name + " is no table of dermis-bench");
    std::vector<Columns> rows;
    for (int number = 2; std::getline(lines, line); ++number) {
        const std::vector<std::string> cells = cells_of(line);
        if (cells.front() != std::to_string(schema))
            throw Incomparable(
                fmt::format("{}, line {}: schema = {}; allowed: {}", name, number, cells.front(), schema));
        if (!own) throw Incomparable(fmt::format("{} has other columns than schema {}", name, schema));
        if (cells.size() != names.size())
            throw Incomparable(
                fmt::format("{}, line {} has {} cells; allowed: {}", name, number, cells.size(), names.size()));
        Columns& row = rows.emplace_back();
        for (size_t i = 0; i < names.size(); ++i) row[names[i]] = cells[i];
        need_number(row["ratio"], fmt::format("{}, line {}: ratio", name, number));
    }
    if (rows.empty()) throw Incomparable(name + " has no rows");
    return rows;
}

Verdict compare(const std::vector<Columns>& earlier, const std::vector<Columns>& now, const GateOptions& options) {
    Comparison comparison(now, options);
    for (const Columns& row : earlier) comparison.take(row);
    return comparison.verdict(earlier);
}

} // namespace bench
