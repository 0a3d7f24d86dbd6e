// SPDX-License-Identifier: MIT
#include "host/lab/output/origin.hpp"

#include "dermis/version.hpp"
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/json.hpp"
#include "host/lab/output/output.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>

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

// Returns the numbers of an object by name, as they stand there; nothing for null.
std::vector<std::pair<std::string, std::string>> numbers_in(const Path& file, const std::string& text,
                                                            const std::string& key) {
    const std::string start = "\"" + key + "\": {";
    const size_t at = text.find(start), end = at == text.npos ? at : text.find('}', at);
    if (end == text.npos) throw Error(Error::Code::io, "", fmt::format("{}: has no {}", file.string(), key));
    std::vector<std::pair<std::string, std::string>> numbers;
    for (size_t name = text.find('"', at + start.size()); name < end;) {
        const size_t colon = text.find("\": ", name + 1), last = std::min(text.find(',', colon), end);
        if (colon >= end) throw Error(Error::Code::io, "", fmt::format("{}: {} is damaged", file.string(), key));
        const std::string number = text.substr(colon + 3, last - colon - 3);
        numbers.emplace_back(text.substr(name + 1, colon - name - 1), number == "null" ? "" : number);
        name = text.find('"', last);
    }
    return numbers;
}

std::string text_in(const Path& file) {
    std::ifstream in = opened(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

// Returns a list of files as JSON.
std::string listed(const std::vector<Contents>& files) {
    std::vector<std::string> list;
    for (const Contents& file : files)
        list.push_back(fmt::format(R"({{"file": {}, "bytes": {}, "fnv1a": "{:016x}"}})", json_text(file.name),
                                   file.bytes, file.hash));
    return fmt::format("[{}]", fmt::join(list, ", "));
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

std::string text_of(const Origin& o) {
    std::vector<std::string> overrides;
    for (const std::string& set : o.overrides) overrides.push_back(json_text(set));
    return made_by_dermis + fmt::format(R"(
  "version": {}, "commit": {},
  "scene": {},
  "set": [{}], "inputs": {},
  "asked": {{"device": {}, "precision": {}, "check": {}}},)",
                                        json_text(version()), json_text(commit()), json_text(o.scene),
                                        fmt::join(overrides, ", "), listed(o.inputs), json_text(o.device),
                                        json_text(o.precision), o.check);
}

std::string files_text(std::vector<Contents> files) {
    std::ranges::sort(files, [](const Contents& a, const Contents& b) { return a.name < b.name; });
    return "\n  \"files\": " + listed(files) + ",";
}

std::string sealed(std::string text) {
    Contents contents;
    contents.add(text.data(), text.size());
    return text + fmt::format(",\n  \"fnv1a\": \"{:016x}\"\n}}\n", contents.hash);
}

bool is_finished(const Path& folder, const Scene& scene, const std::string& origin) {
    if (!begins_with(folder / "summary.json", origin)) return false;
    std::vector<Contents> files;
    for (const std::string& name : result_files(scene)) {
        std::error_code none;
        if (!std::filesystem::is_regular_file(folder / name, none)) return false;
        if (name != "summary.json") files.push_back(contents_of(folder / name));
    }
    const std::string summary = text_in(folder / "summary.json");
    return summary.starts_with(origin + files_text(files)) &&
           summary == sealed(summary.substr(0, summary.rfind(",\n")));
}

bool Figures::wrong() const {
    const bool measured = !measured_error.empty() && !predicted_error.empty();
    return different != 0 || (measured && std::stod(measured_error) > std::stod(predicted_error));
}

std::string summary_of(const Path& folder) {
    std::string text = text_in(folder / "summary.json");
    return text.substr(0, text.find_last_not_of('\n') + 1);
}

Figures figures_of(const Path& folder) {
    const Path file = folder / "summary.json";
    std::string text = text_in(file);
    text.erase(0, text.find("\n  \"device\": ")); // behind the scene, which may have any words
    const auto value = [&](const char* key) { return value_of(file, text, key); };
    Figures f{.model = value("model"),
              .precision = value("precision"),
              .seconds = value("seconds"),
              .predicted_error = value("predicted_error"),
              .measured_error = value("measured_error"),
              .greatest_gain = value("greatest_gain"),
              .kinks = value("kinks")};
    f.outcomes = numbers_in(file, text, "outcomes");
    if (value("cross_check").empty()) return f;
    f.compared = count_of(file, text, "cells");
    f.different = count_of(file, text, "different");
    return f;
}

} // namespace dermis::output
