// SPDX-License-Identifier: MIT
#include "host/core/model/fibres.hpp"

#include "host/core/base/watch.hpp"
#include "host/core/description/description.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace dermis::model {

FibreKind kind_of(const Afferents& a) {
    const size_t endings = size_t(a.endings);
    FibreKind k{
        .model = *a.model, .count = a.cells.size() / endings, .endings = endings, .factors = scene::drawn_factors(a)};
    k.model.rate *= k.model.sensitivity;
    return k;
}

template <class K>
FibrePopulation<K>::FibrePopulation(const std::vector<FibreKind>& kinds, size_t pads, size_t line) : pads_(pads) {
    for (const FibreKind& k : kinds) {
        const size_t padded = (k.count + line - 1) / line * line;
        kinds_.push_back({.model = k.model,
                          .count = k.count,
                          .endings = k.endings,
                          .padded = padded,
                          .first = count_,
                          .offset = padded_,
                          .constants = {}});
        count_ += k.count;
        endings_ += k.count * k.endings;
        padded_ += padded * k.endings;
    }
    plane_ = pads_ * padded_;
    constexpr size_t fewest = 4; // so that endings stay in a cache for some substeps
    together_ = int(std::max(work_of_block / std::max(plane_, size_t(1)), fewest));
}

template <class K> void FibrePopulation<K>::set_input(size_t pad, const real* inputs) {
    each_ending(pad, [&](size_t n, size_t i) { input_[i] = inputs[n]; });
}

template <class K> bool FibrePopulation<K>::prepare(double dt) {
    if (dt == dt_) return true;
    std::vector<typename K::FibreConstants>& all = next_;
    all.resize(kinds_.size());
    size_t most = 0;
    for (size_t k = 0; dt > 0 && k < kinds_.size(); ++k) {
        if (!fill_fibre_constants<K>(kinds_[k].model, dt, all[k])) return false;
        most = std::max(most, size_t(all[k].substeps));
    }
    if (most > most_substeps_) grow(std::min(most, size_t(together_)));
    most_substeps_ = std::max(most_substeps_, most);
    spikes_.reserve(most_spikes(dt, 1));
    for (size_t k = 0; k < kinds_.size(); ++k) kinds_[k].constants = all[k];
    dt_ = dt;
    substeps_ = int(most);
    if (dt > 0) take_constants();
    return true;
}

template <class K> size_t FibrePopulation<K>::most_spikes(double dt, size_t presses) const {
    double all = 0;
    for (const Kind& k : kinds_) { // the spikes of a fibre are at least its refractory time apart
        const double apart = std::floor(1.01 * dt * double(presses) / k.model.refractory_time) + 1;
        all += double(k.count) * std::min(apart, double(presses) * double(most_substeps_));
    }
    return size_t(std::min(double(pads_) * all, 0x1p62));
}

template <class K> void FibrePopulation<K>::press(size_t first_pad, size_t pads) {
    const size_t first = first_pad * padded_, before = spikes_.size();
    for (int part = 0; part < substeps_; part += together_) {
        const size_t work = size_t(std::min(together_, substeps_ - part)) * pads * padded_;
        if (work_ > 0 && work_ + work > work_of_block) scene::look(), work_ = 0;
        work_ += work;
        step(first_pad, pads, part, together_);
    }
    std::copy_n(input_ + first, pads * padded_, state_ + FIBRE_INPUT * plane_ + first);
    const auto order = [](const FibreFires<real>& s) { return std::tuple(s.pad, s.fibre, s.share); };
    std::ranges::sort(spikes_.begin() + std::ptrdiff_t(before), spikes_.end(), {}, order);
}

// Calls one(number among the pad's endings, index in a plane) for each ending.
template <class K> template <class One> void FibrePopulation<K>::each_ending(size_t pad, One one) const {
    size_t n = 0;
    for (const Kind& k : kinds_)
        for (size_t i = 0; i < k.count; ++i)
            for (size_t e = 0; e < k.endings; ++e) one(n++, at(pad, k, i, e));
}

template <class K> void FibrePopulation<K>::save(size_t pad, real* state) const {
    each_ending(pad, [&](size_t n, size_t i) {
        for (size_t p = 0; p < FIBRE_PLANES; ++p) state[n * FIBRE_PLANES + p] = state_[p * plane_ + i];
    });
}

template <class K> void FibrePopulation<K>::load(size_t pad, const real* state) {
    each_ending(pad, [&](size_t n, size_t i) {
        for (size_t p = 0; p < FIBRE_PLANES; ++p) state_[p * plane_ + i] = state[n * FIBRE_PLANES + p];
    });
}

template <class K> void FibrePopulation<K>::reset(size_t pad) {
    for (size_t p = 0; p < FIBRE_PLANES; ++p) std::fill_n(state_ + p * plane_ + pad * padded_, padded_, real(0));
}

template class FibrePopulation<f32>;
template class FibrePopulation<f64>;

} // namespace dermis::model
