// SPDX-License-Identifier: MIT
// The manual page of the command, from its parser and the keys of scenes.
#pragma once

#include <string>

#include <CLI/App.hpp>

namespace dermis::cli {

// Returns the page as man(1) reads it.
std::string man_page(const CLI::App&);

} // namespace dermis::cli
