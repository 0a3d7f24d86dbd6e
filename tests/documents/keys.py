# SPDX-License-Identifier: MIT
"""keys.py DERMIS PAGE [--write]: the tables of the page are those of the list of keys; --write makes them so.

A table stands below a line <!-- keys of TABLE -->, as `load` or `load.window`, or `top` for the top of a file.
"""
import pathlib
import re
import subprocess
import sys

command, page = sys.argv[1], pathlib.Path(sys.argv[2])
listed = subprocess.run([command, "run", "--keys", "all"], capture_output=True, text=True, check=True).stdout
tables = {(name or "top"): rows for name, rows in
          re.findall(r"^(?:\[(.*?)\]|Top of the file)\n\n((?:\|.*\n)+)", listed, re.M)}
text = page.read_text()
marked = re.compile(r"(<!-- keys of (\S+) -->\n)((?:\|.*\n)*)")
unknown = {name for _, name, _ in marked.findall(text)} ^ tables.keys()
if unknown or not tables:
    sys.exit(f"{page}: in the page or in the list alone: {', '.join(sorted(unknown))}")
right = marked.sub(lambda found: found[1] + tables[found[2]], text)
if "--write" in sys.argv:
    page.write_text(right)
elif right != text:
    sys.exit(f"{page}: other tables than the list of keys; to write them anew: python3 {' '.join(sys.argv)} --write")
print(f"{len(tables)} tables, as the list of keys")
