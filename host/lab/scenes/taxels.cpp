// SPDX-License-Identifier: MIT
// Recordings of a sensor array: frames with a number for each taxel, spread over the cells of the grid.
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/spline.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace dermis::scene {
namespace {

// Frames of a CSV file: a line of numbers for each, row by row of taxels. A first line without numbers is skipped.
class CsvFile : public Frames {
  public:
    CsvFile(const std::string& path, int columns) : path_(path), columns_(columns) {
        if (const std::string why = why_no_file(path); !why.empty()) throw error(why);
        in_ = throwing(std::ifstream(path, std::ios::binary));
        std::string line;
        for (std::streamoff at = 0; std::getline(in_, line); at = in_.tellg()) {
            const bool names = starts_.empty() && line.find_first_of("0123456789") == line.npos;
            if (!names && !line.empty() && line != "\r") starts_.push_back(at);
            if (in_.eof()) break;
        }
        if (starts_.empty()) throw error("holds no line of numbers");
        std::vector<double> first;
        read_line(0, first);
        if (first.size() % size_t(columns) != 0)
            throw error("has " + std::to_string(first.size()) +
                        " numbers in its first line, no multiple of load.taxels.columns = " + std::to_string(columns));
        rows_ = int(first.size() / size_t(columns));
    }

    int rows() const { return rows_; }
    long long maps() const override { return (long long)starts_.size(); }
    void read(long long map, std::vector<double>& values) override {
        read_line(size_t(map), values);
        if (values.size() != size_t(rows_) * size_t(columns_))
            throw error("frame " + std::to_string(map) + " has " + std::to_string(values.size()) +
                        " numbers, the first has " + std::to_string(size_t(rows_) * size_t(columns_)));
    }

  private:
    void read_line(size_t frame, std::vector<double>& values) {
        std::string line;
        in_.clear();
        in_.seekg(starts_[frame]);
        std::getline(in_, line);
        values.clear();
        for (const char *at = line.data(), *end = at + line.size(); at < end;) {
            double value = 0;
            const auto is_text = [](char c) { return c != ' ' && c != '\t' && c != '\r'; };
            const auto [rest, failed] = std::from_chars(std::find_if(at, end, is_text), end, value);
            const char* next = std::find_if(rest, end, is_text);
            if (failed != std::errc() || !finite(value) || (next < end && *next != ','))
                throw error("frame " + std::to_string(frame) + ", number " + std::to_string(values.size()) +
                            " is no finite number");
            values.push_back(value);
            at = next + 1;
        }
    }
    Error error(const std::string& what) const {
        return Error(Error::Code::bad_input, "load.path",
                     "load.path = \"" + path_ + "\": " + what +
                         "; allowed: a CSV file with a line of numbers for each frame, row by row of taxels");
    }

    std::string path_;
    int columns_, rows_ = 0;
    std::ifstream in_;
    std::vector<std::streamoff> starts_; // of each frame's line
};

// The integral of a B-spline of width 1, 2 or 4 from its beginning to u.
double integral(Taxels::Spread spread, double u) {
    if (u > 0) return 1 - integral(spread, -u);
    switch (spread) {
    case Taxels::Spread::nearest: return std::max(0.0, u + 0.5);
    case Taxels::Spread::linear: return u <= -1 ? 0 : (1 + u) * (1 + u) / 2;
    default: break;
    }
    if (u <= -2) return 0;
    const double v = 2 + u;
    return u <= -1 ? v * v * v * v / 24 : 0.5 + u * (2.0 / 3 - u * u * (1.0 / 3 + u / 8));
}

// A taxel and its share in the pressure of a cell, along one axis: the mean of the taxel's B-spline over the cell.
struct Weight {
    size_t taxel;
    double share;
};
// Returns the taxels of each cell of an axis. The part of a B-spline beyond the grid is reflected at its border, so
// that the force stays the same.
std::vector<std::vector<Weight>> weights_of(Taxels::Spread spread, int taxels, double spacing, double origin,
                                            int cells) {
    std::vector<std::vector<Weight>> all{size_t(cells)};
    for (int t = 0; t < taxels; ++t) {
        const double middle = origin + (t + 0.5) * spacing; // in cells
        std::vector<double> shares(size_t(cells), 0);
        const auto first = static_cast<long long>(std::floor(middle - 2 * spacing)),
                   last = static_cast<long long>(std::ceil(middle + 2 * spacing));
        for (long long x = first; x < last; ++x)
            shares[index_beyond(x, cells, Border::mirrored)] +=
                spacing * (integral(spread, (double(x + 1) - middle) / spacing) -
                           integral(spread, (double(x) - middle) / spacing));
        for (size_t x = 0; x < shares.size(); ++x)
            if (shares[x] != 0) all[x].push_back({size_t(t), shares[x]});
    }
    return all;
}

class Spreading : public Frames {
  public:
    Spreading(const Scene& s, std::shared_ptr<Frames> recording, int columns, int rows)
        : recording_(std::move(recording)), columns_(size_t(columns)), rows_(size_t(rows)) {
        const Taxels& t = *s.load.taxels;
        const double cell = s.grid.spacing.value_or(1), spacing = t.spacing / cell;
        for (auto [axis, taxels, cells] : {std::tuple{0, columns, s.grid.width}, {1, rows, s.grid.height}}) {
            const double origin = t.origin[size_t(axis)] / cell, end = origin + taxels * spacing;
            if (origin < -1e-9 * cells || end > (1 + 1e-9) * cells)
                refuse("load.taxels.origin", shortest(t.origin[size_t(axis)]),
                       "a place from which all taxels lie on the grid: " + std::to_string(taxels) + " along " +
                           (axis ? "y" : "x") + " are " + shortest(taxels * t.spacing) + " long, the grid " +
                           shortest(cells * cell));
            (axis ? down_ : along_) = weights_of(t.spread, taxels, spacing, origin, cells);
        }
    }

    long long maps() const override { return recording_->maps(); }

    void read(long long map, std::vector<double>& values) override {
        recording_->read(map, taxels_);
        lines_.assign(rows_ * along_.size(), 0);
        for (size_t r = 0; r < rows_; ++r)
            for (size_t x = 0; x < along_.size(); ++x)
                for (const Weight& w : along_[x])
                    lines_[r * along_.size() + x] += w.share * taxels_[r * columns_ + w.taxel];
        values.assign(down_.size() * along_.size(), 0);
        for (size_t y = 0; y < down_.size(); ++y)
            for (const Weight& w : down_[y])
                for (size_t x = 0; x < along_.size(); ++x)
                    values[y * along_.size() + x] += w.share * lines_[w.taxel * along_.size() + x];
    }

  private:
    const std::shared_ptr<Frames> recording_;
    const size_t columns_, rows_;
    std::vector<std::vector<Weight>> along_, down_;
    std::vector<double> taxels_, lines_;
};

} // namespace

std::shared_ptr<Frames> taxel_frames(const Scene& s) {
    const std::optional<int>& columns = s.load.taxels->columns;
    if (columns) {
        auto file = std::make_shared<CsvFile>(s.load.path, *columns);
        const int rows = file->rows();
        return std::make_shared<Spreading>(s, std::move(file), *columns, rows);
    }
    auto file = std::make_shared<NpyFile>(s.load.path, 0, 0, true, "load.path");
    const int width = file->width(), height = file->height();
    return std::make_shared<Spreading>(s, std::move(file), width, height);
}

} // namespace dermis::scene
