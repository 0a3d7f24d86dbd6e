// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/base/cores.hpp"
#include "host/core/cpu/fibres.hpp"
#include "host/core/cpu/stream.hpp"

namespace dermis::cpu {

// The CPU path.
class CpuBackend : public model::Backend {
  public:
    // threads: 0 = one per core.
    explicit CpuBackend(int threads, const simd::Isa& isa = simd::best()) : threads_(threads), isa_(isa) {}
    model::Capabilities capabilities() const override {
        const int threads = threads_ ? threads_ : simd::cores();
        return {.name = "cpu", .f64 = true, .threads = threads, .cell_step = 1.8e-9 / threads}; // measured on two cores
    }
    std::unique_ptr<model::Stream> stream(const model::StreamedSkin& skin) override {
        return cpu::stream(skin, threads_, isa_);
    }
    std::unique_ptr<model::FibrePopulation<f32>> fibres(const std::vector<model::FibreKind>& kinds,
                                                        size_t pads) override {
        return std::make_unique<Fibres<f32>>(kinds, pads, threads_, isa_);
    }

    const simd::Isa& isa() const { return isa_; }

  private:
    const int threads_;
    const simd::Isa& isa_;
};

} // namespace dermis::cpu
