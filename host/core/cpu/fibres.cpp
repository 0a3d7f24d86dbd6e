// SPDX-License-Identifier: MIT
#include "host/core/cpu/fibres.hpp"

#include "host/core/base/float_environment.hpp"

#include <algorithm>
#include <atomic>
#include <functional>

namespace dermis::cpu {
namespace {

constexpr size_t share = 4096; // endings that a thread takes at a time

int threads_for(const std::vector<model::FibreKind>& kinds, size_t pads, int threads) {
    size_t all = 0;
    for (const model::FibreKind& k : kinds) all += k.count * k.endings;
    return simd::useful_threads(4 * pads * all, threads); // a fibre's step takes longer than a cell's
}

} // namespace

template <class K>
Fibres<K>::Fibres(const std::vector<model::FibreKind>& kinds, size_t pads, int threads, const simd::Isa& isa)
    : model::FibrePopulation<K>(kinds, pads, line), isa_(isa), pool_(threads_for(kinds, pads, threads)) {
    memory_.resize((FIBRE_PLANES + 1) * this->plane_ + line);
    this->state_ = memory_.data() + (-reinterpret_cast<uintptr_t>(memory_.data()) % 64) / sizeof(real);
    this->input_ = this->state_ + FIBRE_PLANES * this->plane_;
    for (size_t pad = 0; pad < pads; ++pad)
        for (size_t k = 0; k < kinds.size(); ++k)
            for (size_t first = 0, last, all = this->kinds_[k].padded; first < all; first = last) {
                last = std::min(first + share / kinds[k].endings / line * line, all);
                tasks_.push_back({.pad = pad, .kind = k, .first = first, .last = last, .fired = 0});
            }
}

template <class K> void Fibres<K>::step(size_t first_pad, size_t pads, int part, int parts) {
    const size_t of_pad = tasks_.size() / this->pads_, begin = first_pad * of_pad, end = begin + pads * of_pad;
    std::atomic<size_t> next = begin;
    const auto work = [&](int) {
        const DefaultFloats guard;
        for (size_t t; (t = next.fetch_add(1)) < end;) {
            Task& task = tasks_[t];
            const auto& kind = this->kinds_[task.kind];
            const size_t first = this->at(task.pad, kind, task.first);
            task.fired = isa_.of<K>().press_fibres({.constants = &kind.constants,
                                                    .first = 0,
                                                    .last = int(task.last - task.first),
                                                    .part = part,
                                                    .end = std::min(part + parts, kind.constants.substeps),
                                                    .endings = int(kind.endings),
                                                    .of_pad = int(kind.padded),
                                                    .state = this->state_ + first,
                                                    .plane = this->plane_,
                                                    .input = this->input_ + first,
                                                    .spikes = raw_.data() + raw_at(task)});
        }
    };
    pool_.each(std::ref(work), false);
    for (size_t t = begin; t < end; ++t) {
        const Task& task = tasks_[t];
        const auto& kind = this->kinds_[task.kind];
        const auto* from = raw_.data() + raw_at(task);
        for (int i = 0; i < task.fired; ++i)
            this->fire(task.pad, kind, task.first + size_t(from[i].fibre), from[i].share);
    }
}

template class Fibres<f32>;
template class Fibres<f64>;

} // namespace dermis::cpu
