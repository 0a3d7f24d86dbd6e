// SPDX-License-Identifier: MIT
#include "host/core/cpu/backend.hpp"

#include "host/core/base/cores.hpp"
#include "host/core/cpu/stream.hpp"
#include "host/lab/march/cpu_march.hpp"

namespace dermis::cpu {
namespace {

class CpuBackend : public plan::Backend {
  public:
    CpuBackend(int threads, const simd::Isa& isa) : threads_(threads), isa_(isa) {}

    plan::Capabilities capabilities() const override {
        const int threads = threads_ ? threads_ : simd::cores();
        plan::Capabilities c;
        c.name = "cpu";
        c.f64 = true;
        c.threads = threads;
        c.cell_step = 1.8e-9 / threads; // measured on two cores of a server
        return c;
    }

    std::unique_ptr<plan::Stepper> stepper(const plan::PreparedSkin& skin, const plan::Schedule& schedule,
                                           Precision precision, plan::Stepper::Sink sink) override {
        return cpu::stepper(skin, schedule, precision, threads_, std::move(sink), isa_);
    }

    std::unique_ptr<plan::Stream> stream(const plan::StreamedSkin& skin) override {
        return cpu::stream(skin, threads_, isa_);
    }

  private:
    const int threads_;
    const simd::Isa& isa_;
};

} // namespace

std::unique_ptr<plan::Backend> backend(int threads, const simd::Isa& isa) {
    return std::make_unique<CpuBackend>(threads, isa);
}

} // namespace dermis::cpu
