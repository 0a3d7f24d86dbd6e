# SPDX-License-Identifier: MIT
"""keys.py DERMIS PAGE FOLDER: every key that the reader of scenes knows has a line in the tables of the page."""
import pathlib
import re
import subprocess
import sys

command, page, folder = sys.argv[1:]
empty = pathlib.Path(folder, "empty.toml")
empty.parent.mkdir(parents=True)
empty.write_text("")
sections = dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", pathlib.Path(page).read_text(), re.M | re.S))
names = [heading[1:-1] for heading in sections if re.fullmatch(r"\[\w+\]", heading)]


def known(section):
    """The keys of a section, from the error that names them."""
    key = f"{section}.no_such_key" if section else "no_such_key"
    run = subprocess.run([command, "run", empty, "--out", folder, "--set", f"{key}=1"], capture_output=True, text=True)
    found = re.search(r"no such key here; known: (.*)", run.stderr)
    if run.returncode != 2 or not found:
        sys.exit(f"{key}: not refused with the known keys: {run.stderr}")
    return set(found.group(1).split(", "))


def listed(heading):
    """The keys in the first column of a section's table."""
    return set(re.findall(r"`(\w+)`", " ".join(re.findall(r"^\|([^|]*)\|", sections[heading], re.M))))


missing = []
for name in names:
    missing += [f"[{name}] {key}" for key in sorted(known(name) ^ listed(f"[{name}]"))]
top = listed("Top of the file") | set(names)
missing += sorted(known("") ^ top)
if missing:
    sys.exit(f"{page}: in the page or in the reader alone: {', '.join(missing)}")
print(f"{len(names)} sections, every key listed")
