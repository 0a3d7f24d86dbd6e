// SPDX-License-Identifier: MIT
#include "host/lab/schedule/references.hpp"

#include "host/core/model/coefficients_in.hpp"

namespace dermis::model {

long double p3_of(long double z) { // its power series, to 2^-113
    long double sum = 1;
    for (int k = 28; k > 3; --k) sum = 1 - z / k * sum;
    return sum / 6;
}

template Phi<long double> phi(long double);
template extended::Coefficients exact_coefficients_in<extended>(const Element&, const ResponseRule&, long double);
template void join_loads<extended>(extended::Coefficients*, size_t, bool, long double);
template extended::Coefficients bend(extended::Coefficients&, const Element&, const ResponseRule&, long double,
                                     long double);

f64::Coefficients difference(const f64::Coefficients& a, const extended::Coefficients& b) {
    f64::Coefficients d;
#define SUBTRACT(name) d.name = double(a.name - b.name);
    COEFFICIENTS(SUBTRACT)
#undef SUBTRACT
    return d;
}

References::References(const Schedule& schedule, const std::vector<Element>& materials, const ResponseRule& rule)
    : materials_(materials), rule_(rule), load_(schedule.load.envelope, schedule.time), held_(materials.size()) {}

bool References::take(const Step& step) {
    if (!step.exact || step.impulse >= 0) return false;
    long double dt = scene::difference<long double>(step.end, step.begin);
    before_ = step.before == 0 ? 0 : scene::difference<long double>(step.begin, step.led);
    if (std::abs(dt - step.length) <= unit_of_reference * dt) dt = step.length; // the length of all such steps
    if (std::abs(before_ - step.before) <= unit_of_reference * before_) before_ = step.before;
    if (dt != length_)
        for (size_t i = 0; i < materials_.size(); ++i)
            held_[i] = exact_coefficients_in<extended>(materials_[i], rule_, dt);
    length_ = dt;
    forced_ = step.forcing != nullptr;
    if (forced_) forcing_ = forcing_over(load_, step.begin, step.end, dt, step.forcing->slope.has_value(), step.begin);
    return true;
}

extended::Coefficients References::coefficients(size_t material, extended::Coefficients& past) const {
    extended::Coefficients k = held_[material];
    past = bend(k, materials_[material], rule_, length_, before_);
    if (forced_) force<extended>(k, materials_[material], rule_, forcing_);
    return k;
}

} // namespace dermis::model
