# SPDX-License-Identifier: MIT
"""Finds the error branches of C++ text: what throws, what calls a function that only throws, checks that may, and handlers."""

import bisect
import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Site:
    path: str
    first: int  # the lines of its statement, or of its handler's body
    last: int
    kind: str  # "throw", "call" or "catch"
    name: str  # the function that is called


def without_text(code):
    """The code with blanks in place of comments and literals, so that every other character stays where it was."""
    pattern = r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\''
    return re.sub(pattern, lambda m: re.sub(r"[^\n]", " ", m[0]), code, flags=re.S)


# Functions that return only if something is right.
CHECKS = r"need(?:_\w+)?|check|check_made|check_submitted"


def never_return(code):
    """The names of the functions of a file that only throw."""
    return set(re.findall(r"\[\[noreturn\]\][^;{}()]*?\b(\w+)\(", without_text(code)))


def end_of(text, start, opening, closing):
    """Where what opens at `start` closes."""
    depth = 0
    for i in range(start, len(text)):
        depth += (text[i] in opening) - (text[i] in closing)
        if depth <= 0 and text[i] in closing:
            return i
    return len(text) - 1


def end_of_statement(text, start):
    depth = 0
    for i in range(start, len(text)):
        depth += (text[i] in "({[") - (text[i] in ")}]")
        if depth < 0 or (text[i] == ";" and depth == 0):
            return i
    return len(text) - 1


def is_called(text, start):
    """Whether the name before a bracket is called there, not declared, and is no member of a parser's option."""
    before = text[max(0, start - 80):start]
    if re.search(r"^\s*->$", before.splitlines()[-1]):
        return False
    word = re.search(r"([\w>*&]+)\s+$", re.sub(r"[\w:]+::$|[\w)\]]+(\.|->)$", "", before))
    return not word or word[1] in ("return", "else", "do", "case")


def sites_of(path, code, never):
    """Every error branch of a file. never: functions that only throw. A handler that holds another branch is none itself."""
    text = without_text(code)
    starts = [i + 1 for i, c in enumerate(text) if c == "\n"]

    def line(at):
        return bisect.bisect_right(starts, at) + 1

    found = []
    for m in re.finditer(r"\bthrow\b", text):
        found.append(Site(path, line(m.start()), line(end_of_statement(text, m.start())), "throw", ""))
    for m in re.finditer(rf"\b({'|'.join(sorted(never))}|{CHECKS})\s*\(", text):
        if is_called(text, m.start()):
            found.append(Site(path, line(m.start()), line(end_of_statement(text, m.start())), "call", m[1]))
    for m in re.finditer(r"\bcatch\s*\([^)]*\)\s*\{", text):
        first, last = line(m.end() - 1), line(end_of(text, m.end() - 1, "{", "}"))
        if not any(first <= site.first <= last for site in found):
            found.append(Site(path, first, last, "catch", ""))
    return sorted(set(found), key=lambda site: site.first)
