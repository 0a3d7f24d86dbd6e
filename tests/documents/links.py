# SPDX-License-Identifier: MIT
"""links.py PAGE ..: every relative link of a page leads to a file or folder."""
import pathlib
import re
import sys

broken = []
for page in map(pathlib.Path, sys.argv[1:]):
    links = re.findall(r"\]\(([^)#:]+)\)", page.read_text())
    if not links:
        sys.exit(f"{page}: no links")
    broken += [f"{page}: {link}" for link in links if not (page.parent / link).exists()]
if broken:
    sys.exit("\n".join(broken))
