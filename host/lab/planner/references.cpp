// SPDX-License-Identifier: MIT
#include "host/lab/planner/references.hpp"

#include <cmath>

namespace dermis::plan {

References::References(const Schedule& schedule, const std::vector<Element>& materials, const ResponseRule& rule)
    : materials_(materials), rule_(rule), load_(schedule.load.envelope, schedule.time), held_(materials.size()) {}

bool References::take(const Step& step) {
    if (!step.exact || step.impulse >= 0) return false;
    long double dt = scene::difference<long double>(step.end, step.begin);
    if (std::abs(dt - step.length) <= unit_of_reference * dt) dt = step.length; // that of all steps
    if (dt != length_)
        for (size_t i = 0; i < materials_.size(); ++i)
            held_[i] = exact_coefficients_in<extended>(materials_[i], rule_, dt);
    length_ = dt;
    forced_ = step.forcing != nullptr;
    if (forced_) forcing_ = forcing_over(load_, step.begin, step.end, dt, step.forcing->slope.has_value());
    return true;
}

extended::Coefficients References::coefficients(size_t material) const {
    extended::Coefficients k = held_[material];
    if (forced_) force<extended>(k, materials_[material], rule_, forcing_);
    return k;
}

} // namespace dermis::plan
