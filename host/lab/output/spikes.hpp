// SPDX-License-Identifier: MIT
// The files and the line that tell of a run's spikes.
#pragma once

#include "dermis/run.hpp"

namespace dermis::output {

// Returns spikes.npy: a structured array with the fields time, float64, and afferent, uint32.
std::string spikes_npy(const Result&);
// Returns afferents.csv: a line for each fibre, with its spikes and its mean rate over the duration, Hz.
std::string afferents_csv(const Scene&, const Result&);
// Returns psth.csv: the mean rate of the fibres of each entry of Scene::afferents, Hz, in bins from `time` on, of the
// longer of Time::step and 1 ms; the last bin ends with the run.
std::string psth_csv(const Scene&, const Result&);
// Returns a line with the number of spikes and the fibre of the greatest rate; empty without fibres.
std::string spikes_line(const Scene&, const Result&);

} // namespace dermis::output
