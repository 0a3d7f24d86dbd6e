// SPDX-License-Identifier: MIT
#include "host/lab/command/man_page.hpp"

#include "dermis/dermis.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/units.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace dermis::cli {
namespace {

// A text in which nothing is a request of the formatter.
std::string plain(const std::string& text) {
    std::string out;
    for (char c : text) {
        if (c == '\\') out += "\\e";
        else if (c == '-') out += "\\-";
        else if (c == '\n') out += ' ';
        else if ((c == '.' || c == '\'') && out.empty()) out += std::string("\\&") + c;
        else out += c;
    }
    return out;
}

std::string page_of(const CLI::App& command) {
    std::string text, synopsis = "dermis " + command.get_name();
    for (const CLI::Option* o : command.get_options()) {
        const bool positional = o->get_positional();
        const std::string called = positional ? o->get_name(true) : o->get_name();
        std::string kind = o->get_type_size() == 0 ? "" : o->get_type_name();
        if (positional) synopsis += " " + called;
        else if (o->get_required()) synopsis += " " + called + " " + kind;
        if (!o->get_default_str().empty()) kind += (kind.empty() ? "" : ", ") + ("by default " + o->get_default_str());
        text += fmt::format(".TP\n\\fB{}\\fR {}\n{}\n", plain(called), plain(kind), plain(o->get_description()));
    }
    return fmt::format(".SS \"{}\"\n{}.\n{}", plain(synopsis), plain(command.get_description()), text);
}

} // namespace

std::string man_page(const CLI::App& app) {
    std::string text =
        fmt::format(".TH DERMIS 1 \"\" \"dermis {}\" \"User Commands\"\n.SH NAME\ndermis \\- pressure on "
                    "skin in, mechanoreceptor responses out\n.SH SYNOPSIS\n.B dermis\n.I command\n"
                    "[options]\n.SH COMMANDS\n",
                    version());
    for (const CLI::App* command : app.get_subcommands({})) text += page_of(*command);
    text +=
        ".SH KEYS OF A SCENE\nA scene is a TOML file. Each key with its table, and the unit of its number; a text has "
        "another unit of the same kind with it, as \\(dq20 kPa\\(dq. The page host/lab/scenes/README.md says what each "
        "key means.\n.PP\n";
    for (const std::string& key : scene::known_keys()) {
        const std::string unit = scene::unit_of_key(key);
        text += fmt::format("\\fB{}\\fR{}\n.br\n", plain(key), unit.empty() ? "" : plain(" (" + unit + ")"));
    }
    return text +
           ".SH EXIT STATUS\n0: done. 1: failed, cells differ, or a result is off by more than its bound. 2: bad "
           "input.\n";
}

} // namespace dermis::cli
