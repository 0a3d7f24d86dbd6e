// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <variant>

namespace dermis::study {

// The named values of claims.md.in: {name} is a text, and {name? yes / no} is a verdict in one of its two wordings.
// The template and the computation must agree on the names: otherwise std::logic_error names the field.
class Fields {
  public:
    void set(const std::string& name, std::string text);
    void set(const std::string& name, const char* format, double value);
    void verdict(const std::string& name, bool holds);

    std::string filled_in(std::string_view text) const;

  private:
    using Value = std::variant<std::string, bool>; // a text or a verdict
    void add(const std::string& name, Value);
    std::string shown(std::string_view field, std::set<std::string>& used) const;

    std::map<std::string, Value> values_;
};

} // namespace dermis::study
