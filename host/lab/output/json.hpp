// SPDX-License-Identifier: MIT
// JSON: summary.json, and what the command answers to programs. A key is the name of the member that it shows.
#pragma once

#include "dermis/dermis.hpp"

#include <nlohmann/json.hpp>

// Sets keys of `json`, an object or null, to the members of `from` that have their names. Null is made an object
// first, because the library leaves one that it makes by itself damaged if memory runs out.
#define DERMIS_KEYS(json, from, ...)                                                                                   \
    do {                                                                                                               \
        nlohmann::ordered_json& nlohmann_json_j = json;                                                                \
        if (nlohmann_json_j.is_null()) nlohmann_json_j = nlohmann::ordered_json::object();                             \
        const auto& nlohmann_json_t = from;                                                                            \
        NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(NLOHMANN_JSON_TO, __VA_ARGS__))                                       \
    } while (false)

namespace dermis {
namespace output {

using Json = nlohmann::ordered_json; // its keys keep their order; a number that is not finite is written as null

// Returns its lines, without the end of the last one. Bytes that are not UTF-8, as of a file's name, are replaced.
inline std::string text_of(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace); }

// Prints these lines.
inline void print(const Json& json) { std::puts(text_of(json).c_str()); }
// Makes texts that are empty null.
inline void empty_as_null(Json& json, std::initializer_list<const char*> keys) {
    for (const char* key : keys)
        if (json[key] == "") json[key] = Json();
}

} // namespace output

// What a conversion to Json calls.
template <class Named> void to_json(output::Json& json, Named value) requires std::is_enum_v<Named> {
    json = name(value);
}
inline void to_json(output::Json& json, const Figure& f) {
    DERMIS_KEYS(json, f, value, least, greatest);
    json["within"] = std::isnan(f.value) ? output::Json() : output::Json(!f.outside());
}
inline void to_json(output::Json& json, const Report& r) {
    DERMIS_KEYS(json, r, strain, indentation, gain, cells_per_ridge, retardation_times, sign_changed, vibration,
                fine_load);
}
inline void to_json(output::Json& json, const Candidate& c) {
    DERMIS_KEYS(json, c, model, precision, device, steps, dispatches, bytes, seconds, error, refused);
    output::empty_as_null(json, {"refused"});
}

} // namespace dermis
