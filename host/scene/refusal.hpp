// SPDX-License-Identifier: MIT
// Errors that name a parameter, its value and what is allowed.
#pragma once

#include "dermis/dermis.hpp"
#include "host/scene/text.hpp"

#include <cmath>

namespace dermis::scene {

[[noreturn]] inline void refuse(const std::string& parameter, const std::string& value, const std::string& allowed) {
    throw Error(Error::Code::bad_input, parameter, parameter + " = " + value + "; allowed: " + allowed);
}
inline void need(bool ok, const char* parameter, double value, const std::string& allowed) {
    if (!ok) refuse(parameter, shortest(value), allowed);
}
inline void need_positive(const char* parameter, double v) {
    need(std::isfinite(v) && v > 0, parameter, v, "a finite number > 0");
}
inline void need_not_negative(const char* parameter, double v) {
    need(std::isfinite(v) && v >= 0, parameter, v, "a finite number >= 0");
}
inline void need_finite(const char* parameter, double v) { need(std::isfinite(v), parameter, v, "a finite number"); }

} // namespace dermis::scene
