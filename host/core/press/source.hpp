// SPDX-License-Identifier: MIT
// The numbers that a caller hands to a press: pressures, or depths, which become strains. They are checked and copied
// before anything is pressed.
#pragma once

#include "host/core/base/finite.hpp"
#include "host/core/base/float_environment.hpp"
#include "host/core/base/pool.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/base/watch.hpp"
#include "host/core/press/pressed_cells.hpp"

namespace dermis {

class Source {
  public:
    Source(const model::StreamedSkin& s, const SkinOptions& options)
        : pads_(size_t(s.pads)), width_(size_t(s.skin.width())), cells_(s.skin.cells()),
          thickness_(options.control == Control::depth ? float(*s.skin.description.material.thickness) : 0),
          strains_(depths() ? pads_ * cells_ : 0) {}
    bool depths() const { return thickness_ > 0; } // SkinOptions::control
    // Throws Error::bad_input for a step, or a number of pressures, that no press takes.
    void need(size_t numbers, const model::StepLengths& dt, const model::PadList& pads, size_t cells_of_pad) const {
        // Only on failure: need_not_negative() builds its message first, which allocates.
        for (size_t i = 0; i < (dt.each ? pads.count : 1); ++i)
            if (!finite(dt[i]) || dt[i] < 0) scene::need_not_negative("dt", dt[i]);
        if (numbers != pads.count * cells_of_pad)
            scene::refuse("pressure", std::to_string(numbers) + " cells",
                          (pads_ > 1 ? std::to_string(pads.count) + " pads of " : "") +
                              (cells_of_pad == cells_ ? "width*height = " + std::to_string(cells_) + ", row 0 first"
                                                      : std::to_string(cells_of_pad) + ", as cells() lists them"));
    }
    // Hands pressures of all cells, or of the cells that sites read, to the stream. Throws Error::bad_input for one
    // that is not finite.
    void take(PressedCells& cells, const model::PadList& pads, const float* pressures, size_t numbers) {
        if (!cells.stream().take(pads, to_take(pressures, numbers))) refuse("pressure", pressures, pads);
    }
    void take_read(PressedCells& cells, const model::PadList& pads, const float* pressures, size_t numbers) {
        if (!cells.stream().take_cells(pads, to_take(pressures, numbers), cells.read(), cells_))
            refuse("pressure", pressures, pads, 1, cells.read());
    }
    // Returns a copy of frames, as pressures or strains. It calls look() from time to time. It is valid until the next
    // call.
    const float* copied(PressedCells& cells, const model::PadList& pads, const float* frames, size_t n,
                        size_t numbers) {
        scene::need(n <= taken_.max_size() / numbers, "count", double(n), "as many frames as memory holds");
        const size_t all = n * numbers, most = std::max((size_t(1) << 20) / numbers, size_t(1)) * numbers; // about 1 ms
        if (taken_.capacity() < all) {
            taken_ = {};
            taken_.reserve(all);
            simd::prefer_large_pages(taken_.data(), all * sizeof(float));
        }
        for (size_t i = 0; i < all; i += most) {
            if (i > 0) scene::look();
            const size_t some = std::min(most, all - i);
            taken_.resize(std::max(taken_.size(), i + some));
            float* to = taken_.data() + i;
            if (depths()) to_strains(frames + i, some, to);
            if (!(depths() ? model::all_finite(to, some) : cells.stream().copy(frames + i, some, to)))
                refuse("pressure", frames, pads, n);
        }
        return taken_.data();
    }
    // Throws Error::bad_input naming the first number that is not finite, or none if another thread has changed it
    // since. listed: the cells whose numbers these are; empty: all cells.
    [[noreturn]] void refuse(const char* argument, const float* numbers, const model::PadList& pads, size_t frames = 1,
                             const std::vector<size_t>& listed = {}) const {
        const std::string of = argument == std::string_view("traction") ? " of axis " : " of frame ";
        const float unit = depths() ? thickness_ : 1.0f;
        for (size_t k = 0; k < frames * pads.count; ++k)
            for (size_t i = 0, n = listed.empty() ? cells_ : listed.size(); i < n; ++i, ++numbers)
                if (!finite(double(*numbers / unit)))
                    scene::refuse(argument,
                                  shortest(double(*numbers)) + " in cell " +
                                      scene::cell_text(listed.empty() ? i : listed[i], int(width_)) +
                                      (pads_ > 1 ? " of pad " + std::to_string(pads[k % pads.count]) : "") +
                                      (frames > 1 ? of + std::to_string(k / pads.count) : ""),
                                  finite(double(*numbers)) ? "depths below 3.4e38 times the thickness"
                                                           : "finite numbers");
        scene::refuse(argument, "(a number that was not finite)", "finite numbers");
    }

  private:
    const float* to_take(const float* numbers, size_t count) {
        if (!depths()) return numbers;
        to_strains(numbers, count, strains_.data());
        return strains_.data();
    }
    // A depth that is not finite, or too great, becomes a strain that is not finite.
    void to_strains(const float* depths, size_t n, float* to) const {
        const DefaultFloats guard;
        for (size_t i = 0; i < n; ++i) {
            const float deep = depths[i]; // once: another thread may change it
            to[i] = deep < 0 && finite(double(deep)) ? 0.0f : deep / thickness_;
        }
    }

    const size_t pads_, width_, cells_;
    const float thickness_;      // m, of a skin that is pressed by depths; otherwise 0
    std::vector<float> strains_; // of a frame of depths
    std::vector<float> taken_;   // copies of the frames of a call
};

} // namespace dermis
