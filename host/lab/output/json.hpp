// SPDX-License-Identifier: MIT
// JSON: summary.json, and what the command answers to programs.
#pragma once

#include "dermis/dermis.hpp"

#include <nlohmann/json.hpp>

namespace dermis {

inline void to_json(nlohmann::ordered_json& json, const KelvinVoigt& e) {
    json = {{"modulus", e.modulus}, {"viscosity", e.viscosity}};
}

namespace output {

using Json = nlohmann::ordered_json; // its keys keep their order; a number that is not finite is written as null

// Returns its lines, without the end of the last one. Bytes that are not UTF-8, as of a file's name, are replaced.
inline std::string text_of(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace); }

// Returns null for an empty text.
inline Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

} // namespace output
} // namespace dermis
