// SPDX-License-Identifier: MIT
// The nerve fibres of a run. Their inputs are computed apart from the run's outputs: by the exact method in double, in
// the cells of the fibres alone, at stops so close that lines between them miss little of the load and of what the
// material makes of it. So neither the model of the run nor Time::step changes a spike.
#pragma once

#include "dermis/run.hpp"

namespace dermis {

constexpr double share_of_fibres = 0.5; // of the progress of a run that has fibres

// Returns the spikes of a scene by time, then by fibre. afferents: the scene's, validated. threads: as for Device::cpu.
std::vector<FiredSpike> spikes_of(const Scene&, const std::vector<Afferents>& afferents, int threads);

} // namespace dermis
