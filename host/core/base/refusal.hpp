// SPDX-License-Identifier: MIT
// Errors that name a parameter, its value and what is allowed.
#pragma once

#include "dermis/description.hpp"
#include "host/core/base/finite.hpp"
#include "host/core/base/text.hpp"

namespace dermis::scene {

// Returns "[x, y]" of a cell in a map.
inline std::string cell_text(size_t i, int width) {
    return "[" + std::to_string(i % size_t(width)) + ", " + std::to_string(i / size_t(width)) + "]";
}

[[noreturn]] inline void refuse(const std::string& parameter, const std::string& value, const std::string& allowed) {
    throw Error(Error::Code::bad_input, parameter, parameter + " = " + value + "; allowed: " + allowed);
}
inline void need(bool ok, const char* parameter, double value, const std::string& allowed) {
    if (!ok) refuse(parameter, shortest(value), allowed);
}
inline void need(bool ok, const char* parameter, double value,
                 const char* allowed) { // makes no string where nothing is wrong
    if (!ok) refuse(parameter, shortest(value), allowed);
}
inline void need_positive(const char* parameter, double v) {
    need(finite(v) && v > 0, parameter, v, "a finite number > 0");
}
inline void need_not_negative(const char* parameter, double v) {
    need(finite(v) && v >= 0, parameter, v, "a finite number >= 0");
}
inline void need_finite(const char* parameter, double v) { need(finite(v), parameter, v, "a finite number"); }

} // namespace dermis::scene
