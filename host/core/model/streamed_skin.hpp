// SPDX-License-Identifier: MIT
// A skin that is pressed frame by frame, by dermis::Skin or in a host's command buffer.
#pragma once

#include "dermis/skin.hpp"
#include "host/core/model/skin.hpp"
#include "host/core/model/spread.hpp"

#include <cstring>
#include <span>
#include <type_traits>

namespace dermis::model {

struct StreamedSkin {
    PreparedSkin skin; // of each pad
    Wanted wanted{};   // the responses to compute
    Precision precision = Precision::f32;
    Hold hold = Hold::linear;
    int pads = 1;                         // the number of skins of this description that are pressed together
    std::vector<Element> elements_of_pad; // the elements in series of each pad; empty: all have the elements of `skin`
    std::vector<Afferents> afferents;     // of each pad
    // By class: what spreads it to the depth of its receptors; null: they answer to their cell.
    std::array<std::shared_ptr<const Spread>, REDUCED_MAPS> spread;
    bool follows = false;     // SA1 answers to the stress, the pressure over the modulus at rest
    std::vector<Site> picked; // of a skin by_signals(): the sites, whose responses are picked from fields
    bool deep() const {
        return std::ranges::any_of(spread, [](const auto& s) { return s != nullptr; });
    }
    // Whether responses follow from the signals of another stream, those of signals_of().
    bool by_signals() const { return follows || deep(); }
    // The sites that respond, in the order given; empty: every cell does.
    const std::vector<Site>& sites() const { return picked.empty() ? skin.description.sites : picked; }
    Variant variant() const;
};
// The skin whose responses are the signals of all cells, as they are at the surface.
PreparedSkin signals_of(PreparedSkin);
StreamedSkin signals_of(const StreamedSkin&);
// Throws Error::bad_input. threads: as for Device::cpu.
StreamedSkin streamed_skin(const SkinDescription&, const SkinOptions&, int threads = 0);
// Returns the elements in series of a pad's own material. Throws Error::bad_input naming `parameter` where a skin of
// this description, chain and responses cannot have it.
std::vector<Element> elements_of_pad(const SkinDescription& validated, const Material&, const Chain&, const Wanted&,
                                     const std::string& parameter);

// Pads in the order in which their pressures, steps or states stand.
struct PadList {
    const int* ids = nullptr; // null: 0, 1 ..
    size_t count = 1;
    int operator[](size_t i) const { return ids ? ids[i] : int(i); }
};

// The modulus at which each pad's material comes to rest, Pa, where a pad's cells all have the same elements.
std::vector<double> moduli_at_rest(const StreamedSkin&);

// The elements in series of a pad, whose cells all have the same.
inline std::span<const Element> elements_of(const StreamedSkin& s, int pad) {
    if (s.elements_of_pad.empty()) return s.skin.materials;
    return std::span(s.elements_of_pad).subspan(size_t(pad) * s.skin.chain.length, s.skin.chain.length);
}

// The length of a step between frames, s.
struct FrameStep {
    double dt;
    std::optional<double> before = {}; // under parabolic hold: the step before; 0: there is none to lead on from
    bool operator==(const FrameStep&) const = default;
};

// The lengths of a press's steps, s.
struct StepLengths {
    const double* dt = nullptr;
    bool each = false;        // one for each pad of the press; otherwise one for all
    double* before = nullptr; // the step before of each pad, by its number; null: not known
    bool parabolic = false;   // under parabolic hold
    const double& operator[](size_t i) const { return dt[each ? i : 0]; }
    // The step of a pad, by its place in the list of a press.
    FrameStep of(const PadList& pads, size_t i) const {
        return {(*this)[i], parabolic ? std::optional(before[pads.count ? pads[i] : 0]) : std::nullopt};
    }
    // Whether all pads of a list have the same step before.
    bool alike(const PadList& pads) const {
        for (size_t i = 1; parabolic && i < pads.count; ++i)
            if (of(pads, i) != of(pads, 0)) return false;
        return true;
    }
    // Notes that the steps have been taken.
    void taken(const PadList& pads) const {
        for (size_t i = 0; before && i < pads.count; ++i) before[pads[i]] = (*this)[i];
    }
};

// The coefficients of the next step of each pad. Pads whose elements and steps are the same share a table.
class StepTables {
  public:
    StepTables() = default;
    // elements: the elements of a pad without its own.
    StepTables(const StreamedSkin&, const std::vector<Element>& elements);
    // Returns null. If a step or one of its coefficients does not fit a float, it returns a pointer to that step. It
    // allocates at the first press in which pads have steps of their own, or had them before.
    const double* fill(const PadList&, const StepLengths&);
    size_t length() const { return length_; } // of one table
    bool shared() const { return !each_; }    // whether all pads of the last fill() have one table
    // The first coefficients of a pad's table, after fill() of a list with it.
    const f32::Coefficients* of(int pad) const { return tables_.data() + slot(pad) * length_; }
    // Gives pads other elements, the same number as before.
    void set_elements(const PadList&, const std::vector<Element>&);

  private:
    size_t slot(int pad) const { return each_ ? size_t(pad) : 0; }
    bool fill_slot(size_t slot, const FrameStep&);

    Chain chain_;
    ResponseRule rule_{};
    size_t pads_ = 0, length_ = 0;
    size_t elements_of_pad_ = 0;
    bool own_ = false, each_ = false; // whether each pad has elements of its own; and a table of its own
    std::vector<Element> elements_;   // of all pads where each has its own, else of one
    std::vector<f32::Coefficients> tables_;
    std::vector<FrameStep> filled_; // the step for which each table is filled; NaN: none
};

// Throws Error::bad_input where `listed` pads of `all` cannot have another material. uniform: a pad's cells have the
// same elements; own: each pad has elements of its own.
void need_new_material(bool uniform, bool own, size_t listed, size_t all);

// The positions of responses among the floats of a stream.
struct ResponseLayout {
    struct Range {
        size_t first = 0, count = 0;
    };
    // Each quantity's floats stand pad by pad: a field of pitch*height, or its sites in the order given.
    std::array<Range, REDUCED_MAPS> of;
    std::vector<size_t> site; // index of each site's float, of pad 0
    size_t all = 0;           // number of floats
};
ResponseLayout response_layout_of(const StreamedSkin&);
// The numbers of each response that a pad gives: a field of width*height, or its sites.
std::array<size_t, RESPONSE_MAPS> response_counts(const StreamedSkin&);

// The floats of a pad's saved state, the same on every backend: planes of one number for each cell, in the order of a
// state in kernels/layout.h (for sites of the cells that they read, in ascending order); and the pressure that the next
// press starts from, width*height.
struct StateLayout {
    size_t cells = 0, planes = 0, pressure = 0;
};
// Where the floats of pads are, at any address: the planes of pad i at strains + i*strains_step, its pressure at
// pressure + i*pressure_step. Steps are in bytes. Byte: char or const char.
template <class Byte> struct StateMemory {
    Byte *strains, *pressure;
    size_t strains_step = 0, pressure_step = 0;
    operator StateMemory<const Byte>() const { return {strains, pressure, strains_step, pressure_step}; }
    Byte* strains_of(size_t i) const { return strains + i * strains_step; }
    Byte* pressure_of(size_t i) const { return pressure + i * pressure_step; }
};
// Copies n numbers to a saved state or, where Byte is const, from it. `saved` moves behind them.
template <class Byte, class T> void copy_state(Byte*& saved, T* own, size_t n) {
    if constexpr (std::is_const_v<Byte>) std::memcpy(own, saved, n * sizeof(T));
    else std::memcpy(saved, own, n * sizeof(T));
    saved += n * sizeof(T);
}
StateLayout state_layout_of(const StreamedSkin&);

// Where copy_rows() copies a pressure: from rows that begin `stride` numbers apart to rows that begin `pitch` apart.
struct PressureCopy {
    const float* from;
    size_t stride, width;
    float* to;
    size_t pitch;
};
// Copies rows first .. last - 1. Returns whether all numbers are finite.
bool copy_rows(const PressureCopy&, int first, int last);
bool all_finite(const float* numbers, size_t count);
// Returns whether all numbers are +0.
bool all_bits_zero(const float* numbers, size_t count);

// The coefficients of each element in the table of a press.
inline size_t entries_of(Hold hold) { return hold == Hold::parabolic ? 2 : 1; }

// Makes the coefficients of a step for elements in series; of(e): those of element e alone. past: the second ones,
// where FrameStep::before is given.
using SeriesCoefficients = std::array<f64::Coefficients, scene::most_in_series>;
template <class Of>
void join_series(const Element* elements, const Chain& chain, const ResponseRule& rule, const FrameStep& step, Of of,
                 SeriesCoefficients& k, SeriesCoefficients& past) {
    for (size_t e = 0; e < chain.length; ++e) {
        k[e] = of(e);
        if (step.before) past[e] = bend(k[e], elements[e], rule, step.dt, *step.before);
    }
    join_loads<f64>(k.data(), chain.length, chain.spring, step.dt);
    if (step.before) join_loads<f64>(past.data(), chain.length, chain.spring, step.dt);
}

// Writes the coefficients of a press for each of the materials, in K = f32 or f64: one for each element, or two where
// FrameStep::before is given. Returns false if dt or one of them is beyond K. Allocates nothing.
template <class K>
bool fill_table(std::span<const Element> materials, const Chain&, const ResponseRule&, const FrameStep&,
                typename K::Coefficients* table);

// The constants of a press, with these coefficients.
f32::Constants frame_constants(const PreparedSkin&, const f32::Coefficients&);

} // namespace dermis::model
