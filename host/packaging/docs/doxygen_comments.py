# SPDX-License-Identifier: MIT
"""A filter of Doxygen: prints a header whose plain comments are Doxygen's. A comment before a declaration belongs to it,
one behind a declaration too, with the lines that continue it."""
import re
import sys


def text_of(comment):
    if comment.startswith("    "):
        return comment  # code, as in Markdown
    return re.sub(r"([*<>#\\@]|_\b)", r"\\\1", comment)


def lines_of(source):
    behind = None  # the column of a comment behind code, which the next line may continue
    at_top = True
    for line in source.splitlines():
        found = re.match(r'^((?:[^"/]|"(?:[^"\\]|\\.)*"|/(?!/))*)//( ?)(.*)$', line)
        if not found or "SPDX" in line:
            behind = None
            at_top = at_top and (not line.strip() or "SPDX" in line)
            yield line
            continue
        code, comment = found[1], found[3]
        if code.strip():
            behind = len(code)
            yield f"{code}///< {text_of(comment)}"
        elif behind == len(code):
            yield f"{code}///< {text_of(comment)}"
        else:
            if at_top:
                yield "/// \\file"
            at_top = False
            behind = None
            yield f"{code}/// {text_of(comment)}"


print("\n".join(lines_of(open(sys.argv[1], encoding="utf-8").read())))
