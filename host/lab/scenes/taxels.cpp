// SPDX-License-Identifier: MIT
// Recordings of a sensor array: frames with a number for each taxel, spread over the cells of the grid.
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/spline.hpp"
#include "host/lab/scenes/table_file.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace dermis::scene {
namespace {

// Frames of a CSV file: a line for each, row by row of taxels. The first line may have names.
class CsvFile : public Frames {
  public:
    CsvFile(const std::string& path, const Taxels& t) : taxels_(size_t(*t.rows) * size_t(*t.columns)) {
        const size_t first = size_t(t.skip), end = first + taxels_;
        const std::string hint = ": " + std::to_string(*t.rows) + " rows of " + std::to_string(*t.columns) +
                                 " taxels, after load.taxels.skip = " + std::to_string(t.skip) + " others";
        TableFile file(path, "load.path");
        for (bool names = true; file.next(); names = false) {
            file.need_columns(end, hint);
            if (names && are_names({file.words().begin() + long(first), file.words().end()})) continue;
            for (size_t i = first; i < end; ++i) numbers_.push_back(file.number(i));
        }
        if (numbers_.empty()) file.refuse_file("holds no line of numbers; allowed: one for each frame");
    }

    long long maps() const override { return (long long)(numbers_.size() / taxels_); }
    void read(long long map, std::vector<double>& values) override {
        const auto first = numbers_.begin() + long(map) * long(taxels_);
        values.assign(first, first + long(taxels_));
    }

  private:
    // Whether words are no numbers, and each is there once, as those of a line of units are not.
    static bool are_names(const std::vector<std::string_view>& words) {
        return std::ranges::none_of(words, is_number) && std::set(words.begin(), words.end()).size() == words.size();
    }

    size_t taxels_;
    std::vector<double> numbers_;
};

// The integral of a B-spline of width 1, 2 or 4 from its beginning to u.
double integral(Taxels::Spread spread, double u) {
    if (u > 0) return 1 - integral(spread, -u);
    if (spread == Taxels::Spread::nearest) return std::max(0.0, u + 0.5);
    if (spread == Taxels::Spread::linear) return u <= -1 ? 0 : (1 + u) * (1 + u) / 2;
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
        : recording_(std::move(recording)), columns_(size_t(columns)), rows_(size_t(rows)),
          unit_(*s.load.taxels->unit) {
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
        recording_->read(0, offsets_);
        for (size_t i = 0; i < offsets_.size() && !t.offset && !t.first_at_rest; ++i)
            if (offsets_[i] != 0)
                refuse("load.taxels.offset", "(not given)",
                       "offset = \"first\" where the first frame is at rest, or offset = 0 or another number at rest: "
                       "the first frame has " +
                           shortest(offsets_[i]) + " at taxel " + cell_text(i, columns));
        if (!t.first_at_rest) offsets_.assign(offsets_.size(), t.offset.value_or(0));
    }

    long long maps() const override { return recording_->maps(); }

    void read(long long map, std::vector<double>& values) override {
        recording_->read(map, taxels_);
        for (size_t i = 0; i < taxels_.size(); ++i) taxels_[i] = (taxels_[i] - offsets_[i]) * unit_;
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
    const double unit_;
    std::vector<double> offsets_; // the numbers at rest
    std::vector<std::vector<Weight>> along_, down_;
    std::vector<double> taxels_, lines_;
};

} // namespace

std::shared_ptr<Frames> taxel_frames(const Scene& s) {
    const Taxels& t = *s.load.taxels;
    if (t.columns)
        return std::make_shared<Spreading>(s, std::make_shared<CsvFile>(s.load.path, t), *t.columns, *t.rows);
    auto file = std::make_shared<NpyFile>(s.load.path, 0, 0, true, "load.path");
    const int width = file->width(), height = file->height();
    return std::make_shared<Spreading>(s, std::move(file), width, height);
}

} // namespace dermis::scene
