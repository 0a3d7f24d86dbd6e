// SPDX-License-Identifier: MIT
#include "host/core/cpu/fibres.hpp"

#include "host/core/base/float_environment.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>

namespace dermis::cpu {
namespace {

template <class T> T* aligned(std::vector<T>& memory, size_t numbers) {
    memory.assign(numbers + 64 / sizeof(T), 0);
    const auto address = reinterpret_cast<uintptr_t>(memory.data());
    return memory.data() + (-address % 64) / sizeof(T);
}

} // namespace

template <class K>
Fibres<K>::Fibres(const std::vector<FibreKind>& kinds, size_t pads, int threads, const simd::Isa& isa)
    : pads_(pads), isa_(isa), pool_([&] {
          size_t all = 0;
          for (const FibreKind& k : kinds) all += k.count;
          return simd::useful_threads(pads * all * 2, threads);
      }()) {
    for (const FibreKind& k : kinds) {
        const size_t padded = (k.count + line - 1) / line * line;
        kinds_.push_back({.model = k.model,
                          .count = k.count,
                          .padded = padded,
                          .first = count_,
                          .offset = padded_,
                          .constants = {}});
        count_ += k.count;
        padded_ += padded;
    }
    plane_ = pads_ * padded_;
    state_ = aligned(memory_, plane_ * simd::fibre_planes);
    input_ = aligned(inputs_, plane_);
    for (size_t pad = 0; pad < pads_; ++pad)
        for (size_t k = 0; k < kinds_.size(); ++k)
            for (size_t first = 0; first < kinds_[k].padded; first += share)
                tasks_.push_back({.pad = pad,
                                  .kind = k,
                                  .first = first,
                                  .last = std::min(first + share, kinds_[k].padded),
                                  .fired = 0});
}

template <class K> void Fibres<K>::set_input(size_t pad, const real* inputs) {
    for (const Kind& k : kinds_) std::copy_n(inputs + k.first, k.count, input_ + at(pad, k, 0));
}

template <class K> bool Fibres<K>::prepare(double dt) {
    if (dt == dt_) return true;
    std::vector<typename K::FibreConstants> all(kinds_.size());
    int most = most_substeps_;
    for (size_t k = 0; dt > 0 && k < kinds_.size(); ++k) {
        if (!plan::fill_fibre_constants<K>(kinds_[k].model, dt, all[k])) return false;
        most = std::max(most, all[k].substeps);
    }
    if (most > most_substeps_) {
        raw_.resize(plane_ * size_t(most));
        spikes_.resize(pads_ * count_ * size_t(most));
        most_substeps_ = most;
    }
    for (size_t k = 0; k < kinds_.size(); ++k) kinds_[k].constants = all[k];
    dt_ = dt;
    return true;
}

template <class K> void Fibres<K>::press(size_t first_pad, size_t pads) {
    const DefaultFloats guard;
    if (dt_ == 0) {
        std::copy_n(input_ + first_pad * padded_, pads * padded_,
                    state_ + size_t(simd::fibre_input) * plane_ + first_pad * padded_);
        return;
    }
    const size_t of_pad = tasks_.size() / pads_, begin = first_pad * of_pad, end = begin + pads * of_pad;
    std::atomic<size_t> next = begin;
    const auto work = [&](int) {
        const DefaultFloats thread_guard;
        for (size_t t; (t = next.fetch_add(1)) < end;) {
            Task& task = tasks_[t];
            const Kind& kind = kinds_[task.kind];
            const size_t first = at(task.pad, kind, task.first);
            task.fired = isa_.of<K>().press_fibres({.constants = &kind.constants,
                                                    .first = 0,
                                                    .last = int(task.last - task.first),
                                                    .state = state_ + first,
                                                    .plane = plane_,
                                                    .input = input_ + first,
                                                    .spikes = raw_.data() + first * size_t(most_substeps_)});
        }
    };
    pool_.each(std::ref(work), false);
    for (size_t t = begin; t < end; ++t) {
        const Task& task = tasks_[t];
        const Kind& kind = kinds_[task.kind];
        const simd::FibreSpike<real>* from = raw_.data() + at(task.pad, kind, task.first) * size_t(most_substeps_);
        for (int i = 0; i < task.fired; ++i)
            spikes_[fired_++] = {int(task.pad), int(kind.first + task.first + size_t(from[i].fibre)), from[i].share};
    }
}

template <class K> template <class One> void Fibres<K>::each_number(size_t pad, One one) const {
    size_t n = 0;
    for (const Kind& k : kinds_)
        for (size_t i = 0; i < k.count; ++i)
            for (size_t p = 0; p < simd::fibre_planes; ++p, ++n) one(n, p * plane_ + at(pad, k, i));
}

template <class K> void Fibres<K>::save(size_t pad, real* state) const {
    each_number(pad, [&](size_t n, size_t i) { state[n] = state_[i]; });
}

template <class K> void Fibres<K>::load(size_t pad, const real* state) {
    each_number(pad, [&](size_t n, size_t i) { state_[i] = state[n]; });
}

template <class K> void Fibres<K>::reset(size_t pad) {
    for (size_t p = 0; p < simd::fibre_planes; ++p) std::fill_n(state_ + p * plane_ + pad * padded_, padded_, real(0));
}

template class Fibres<f32>;
template class Fibres<f64>;

} // namespace dermis::cpu
