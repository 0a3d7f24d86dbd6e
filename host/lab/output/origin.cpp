// SPDX-License-Identifier: MIT
#include "host/lab/output/origin.hpp"

#include "dermis/version.hpp"
#include "host/core/base/text.hpp"
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/output.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

namespace dermis::output {
namespace {

std::string text_in(const Path& file) {
    std::ifstream in = opened(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

// Returns a JSON object's text up to its last brace.
std::string opening(const Json& json) {
    const std::string text = text_of(json);
    return text.substr(0, text.size() - 2);
}

std::string hex(uint64_t hash) { return fmt::format("{:016x}", hash); }

// Returns a text with its hash as last key; `text` is all before that.
std::string with_hash(std::string text) {
    Contents contents;
    contents.add(text.data(), text.size());
    return text + fmt::format(",\n  \"fnv1a\": \"{}\"\n}}\n", hex(contents.hash));
}

// Calls `take` with a folder's summary.json.
template <class Take> auto taken_from(const Path& folder, const Take& take) {
    const Path file = folder / "summary.json";
    try {
        return take(Json::parse(text_in(file)));
    } catch (const Json::exception& e) {
        throw Error(Error::Code::io, "", fmt::format("{}: {}", file.string(), e.what()));
    }
}

// Returns a value as a table has it: a text without quotes, nothing for null.
std::string in_table(const Json& value) {
    if (value.is_number_float()) return shortest(value.get<double>());
    return value.is_null() ? "" : value.is_string() ? value.get<std::string>() : value.dump();
}

} // namespace

void Contents::add(const char* more, size_t count) {
    bytes += count;
    for (size_t i = 0; i < count; ++i) hash = fnv1a(hash, static_cast<unsigned char>(more[i]));
}

Contents contents_of(const Path& path) {
    Contents contents{path.filename().string()};
    std::ifstream in(path, std::ios::binary);
    for (char block[1 << 16]; in.read(block, sizeof block), in.gcount() > 0;) contents.add(block, size_t(in.gcount()));
    if (!in.eof()) throw Error(Error::Code::io, "", path.string() + ": cannot be read");
    return contents;
}

void to_json(Json& json, const Contents& c) { json = {{"file", c.name}, {"bytes", c.bytes}, {"fnv1a", hex(c.hash)}}; }

Json origin_of(const std::string& scene, const Json& asked, const std::vector<std::string>& set,
               const std::vector<Contents>& inputs) {
    return {{"program", "dermis"}, {"version", version()}, {"commit", commit()}, {"scene", scene},
            {"set", set},          {"inputs", inputs},     {"asked", asked}};
}

void add_files(Json& origin, std::vector<Contents> files) {
    std::ranges::sort(files, {}, &Contents::name);
    origin["files"] = files;
}

std::string sealed(const Json& summary) { return with_hash(opening(summary)); }

bool is_finished(const Path& folder, const Scene& scene, Json origin) {
    if (!begins_with(folder / "summary.json", opening(origin))) return false;
    std::vector<Contents> files;
    for (const std::string& name : result_files(scene)) {
        std::error_code none;
        if (!std::filesystem::is_regular_file(folder / name, none)) return false;
        if (name != "summary.json") files.push_back(contents_of(folder / name));
    }
    add_files(origin, files);
    const std::string summary = text_in(folder / "summary.json");
    return summary.starts_with(opening(origin) + ",") && summary == with_hash(summary.substr(0, summary.rfind(",\n")));
}

Json summary_of(const Path& folder) {
    return taken_from(folder, [](Json&& summary) { return std::move(summary); });
}

Figures figures_of(const Path& folder) {
    return taken_from(folder, [](Json&& summary) {
        if (summary.at("cross_check").is_null()) summary["cross_check"] = {{"cells", 0}, {"different", 0}};
        Figures figures;
        for (const auto& [column, place] : figure_columns)
            figures.values.push_back(in_table(summary.at(Json::json_pointer(place))));
        for (const auto& [name, value] : summary.at("outcomes").items())
            figures.outcomes.emplace_back(name, in_table(value));
        const auto error = [&](const char* key) {
            const Json& value = summary["plan"][key];
            return value.is_null() ? std::nan("") : value.get<double>();
        };
        figures.wrong = summary["cross_check"]["different"] != 0 || error("measured_error") > error("predicted_error");
        return figures;
    });
}

} // namespace dermis::output
