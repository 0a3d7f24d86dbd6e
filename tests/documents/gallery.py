# SPDX-License-Identifier: MIT
"""gallery.py DERMIS PAGE FOLDER: each command of the gallery that begins with dermis draws the picture above it."""
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

command, page, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
drawn = 0
for picture, text in re.findall(r"^!\[[^]]*\]\(([^)]*)\)\n(.*?)(?=^!\[|\Z)", page.read_text(), re.M | re.S):
    calls = re.findall(r"^    (dermis .*(?:\\\n.*)*)$", text, re.M)
    if not calls:
        continue
    work = folder / pathlib.Path(picture).stem
    shutil.copytree(page.parent, work)
    for call in calls:
        words = shlex.split(call.replace("\\\n", " "))
        done = subprocess.run([command, *words[1:]], cwd=work, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{call}: exit status {done.returncode}: {done.stderr}")
    new = [path for path in work.rglob(pathlib.Path(picture).name) if path.parent != work]
    if len(new) != 1 or new[0].read_bytes()[:4] != b"\x89PNG":
        sys.exit(f"{picture}: not drawn by {calls}")
    drawn += 1
if drawn < 4:
    sys.exit(f"{page}: only {drawn} pictures with a command of dermis")
print(f"{drawn} pictures drawn")
