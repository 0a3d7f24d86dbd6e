// SPDX-License-Identifier: MIT
#include "host/lab/study/fields.hpp"

#include <stdexcept>

#include <fmt/format.h>

namespace dermis::study {

void Fields::add(const std::string& name, Value value) {
    if (!values_.try_emplace(name, std::move(value)).second)
        throw std::logic_error(fmt::format("the field {} of claims.md.in is computed twice", name));
}

void Fields::set(const std::string& name, std::string text) { add(name, std::move(text)); }

void Fields::set(const std::string& name, const char* format, double value) {
    set(name, fmt::format(fmt::runtime(format), value));
}

void Fields::verdict(const std::string& name, bool holds) { add(name, holds); }

std::string Fields::filled_in(std::string_view text) const {
    std::string out;
    std::set<std::string> used;
    for (size_t open = text.find('{'); open != text.npos; open = text.find('{')) {
        const size_t close = text.find('}', open);
        if (close == text.npos)
            throw std::logic_error(fmt::format("claims.md.in: no closing brace after {}", text.substr(open, 40)));
        out += text.substr(0, open);
        out += shown(text.substr(open + 1, close - open - 1), used);
        text.remove_prefix(close + 1);
    }
    for (const auto& [name, value] : values_)
        if (!used.count(name)) throw std::logic_error(fmt::format("claims.md.in does not use the field {}", name));
    return out.append(text);
}

std::string Fields::shown(std::string_view field, std::set<std::string>& used) const {
    const size_t question = field.find("? ");
    const std::string name(field.substr(0, question));
    used.insert(name);
    const auto value = values_.find(name);
    if (value == values_.end() || std::holds_alternative<bool>(value->second) != (question != field.npos))
        throw std::logic_error(fmt::format("claims.md.in asks for {{{}}}, which is not computed", field));
    if (const auto* text = std::get_if<std::string>(&value->second)) return *text;
    const size_t slash = field.find(" / ", question);
    if (slash == field.npos)
        throw std::logic_error(fmt::format("claims.md.in: {{{}}} must be {{name? yes / no}}", field));
    return std::string(std::get<bool>(value->second) ? field.substr(question + 2, slash - question - 2)
                                                     : field.substr(slash + 3));
}

} // namespace dermis::study
