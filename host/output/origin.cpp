// SPDX-License-Identifier: MIT
#include "host/output/origin.hpp"

#include "dermis/version.hpp"
#include "host/output/earlier.hpp"
#include "host/output/json.hpp"
#include "host/output/output.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>

#include <fmt/ranges.h>

namespace dermis::output {
namespace {

// Returns the value of a key, up to the comma or the brace behind it, without quotes; empty for null.
std::string value_of(const Path& file, const std::string& text, const std::string& key) {
    const std::string start = "\"" + key + "\": ";
    const size_t at = text.find(start), first = at + start.size();
    const size_t last = at == text.npos ? text.npos : text.find_first_of(",}", first);
    if (last == text.npos) throw Error(Error::Code::io, "", fmt::format("{}: has no {}", file.string(), key));
    std::string value = text.substr(first, last - first);
    std::erase(value, '"');
    return value == "null" ? "" : value;
}

long long count_of(const Path& file, const std::string& text, const std::string& key) {
    const std::string digits = value_of(file, text, key);
    long long count = 0;
    if (std::from_chars(digits.data(), digits.data() + digits.size(), count).ec != std::errc())
        throw Error(Error::Code::io, "", fmt::format("{}: {} is \"{}\"", file.string(), key, digits));
    return count;
}

} // namespace

Input input_of(const std::string& path) {
    Input input{Path(path).filename().string(), 14695981039346656037u};
    std::ifstream in(path, std::ios::binary);
    for (char block[1 << 16]; in.read(block, sizeof block), in.gcount() > 0;)
        for (std::streamsize i = 0; i < in.gcount(); ++i)
            input.hash = (input.hash ^ static_cast<unsigned char>(block[i])) * 1099511628211u;
    if (!in.eof()) throw Error(Error::Code::io, "", path + ": cannot be read");
    return input;
}

std::string text_of(const Origin& o) {
    std::vector<std::string> overrides, inputs;
    for (const std::string& set : o.overrides) overrides.push_back(json_text(set));
    for (const Input& input : o.inputs)
        inputs.push_back(fmt::format("{{\"file\": {}, \"fnv1a\": \"{:016x}\"}}", json_text(input.name), input.hash));
    return made_by_dermis + fmt::format(R"(
  "version": {}, "commit": {},
  "scene": {},
  "set": [{}], "inputs": [{}],
  "asked": {{"device": {}, "precision": {}, "check": {}}},)",
                                        json_text(version()), json_text(commit()), json_text(o.scene),
                                        fmt::join(overrides, ", "), fmt::join(inputs, ", "), json_text(o.device),
                                        json_text(o.precision), o.check);
}

bool is_finished(const Path& folder, const Scene& scene, const std::string& origin) {
    const std::vector<std::string> names = result_files(scene);
    std::error_code none;
    return begins_with(folder / "summary.json", origin) &&
           std::all_of(names.begin(), names.end(),
                       [&](const std::string& name) { return std::filesystem::is_regular_file(folder / name, none); });
}

Figures figures_of(const Path& folder) {
    const Path file = folder / "summary.json";
    std::ostringstream stream;
    stream << std::ifstream(file).rdbuf();
    std::string text = stream.str();
    text.erase(0, text.find("\n  \"device\": ")); // behind the scene, which may have any words
    const auto value = [&](const char* key) { return value_of(file, text, key); };
    Figures f{.model = value("model"),
              .precision = value("precision"),
              .seconds = value("seconds"),
              .predicted_error = value("predicted_error"),
              .greatest_gain = value("greatest_gain"),
              .kinks = value("kinks")};
    if (value("cross_check").empty()) return f;
    f.compared = count_of(file, text, "cells");
    f.different = count_of(file, text, "different");
    return f;
}

} // namespace dermis::output
