// SPDX-License-Identifier: MIT
#include "host/lab/study/fields.hpp"

#include <stdexcept>

#include <fmt/format.h>

namespace dermis::study {
namespace {

void need_used(const std::string& name, const std::set<std::string>& used) {
    if (!used.count(name)) throw std::logic_error(fmt::format("claims.md.in does not use the field {}", name));
}

} // namespace

void Fields::need_new(const std::string& name) const {
    if (texts_.count(name) || verdicts_.count(name))
        throw std::logic_error(fmt::format("the field {} of claims.md.in is computed twice", name));
}

void Fields::set(const std::string& name, std::string text) {
    need_new(name);
    texts_[name] = std::move(text);
}

void Fields::set(const std::string& name, const char* format, double value) {
    set(name, fmt::format(fmt::runtime(format), value));
}

void Fields::verdict(const std::string& name, bool holds) {
    need_new(name);
    verdicts_[name] = holds;
}

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
    for (const auto& [name, value] : texts_) need_used(name, used);
    for (const auto& [name, holds] : verdicts_) need_used(name, used);
    return out.append(text);
}

std::string Fields::shown(std::string_view field, std::set<std::string>& used) const {
    const size_t question = field.find("? ");
    const std::string name(field.substr(0, question));
    used.insert(name);
    if (question == field.npos) {
        const auto text = texts_.find(name);
        if (text == texts_.end())
            throw std::logic_error(fmt::format("claims.md.in asks for {{{}}}, which is not computed", field));
        return text->second;
    }
    const auto holds = verdicts_.find(name);
    if (holds == verdicts_.end())
        throw std::logic_error(fmt::format("claims.md.in asks for the verdict {{{}}}, which is not computed", field));
    const size_t slash = field.find(" / ", question);
    if (slash == field.npos)
        throw std::logic_error(fmt::format("claims.md.in: {{{}}} must be {{name? yes / no}}", field));
    return std::string(holds->second ? field.substr(question + 2, slash - question - 2) : field.substr(slash + 3));
}

} // namespace dermis::study
