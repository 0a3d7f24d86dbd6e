# SPDX-License-Identifier: MIT
"""blocks.py LANGUAGE FOLDER PAGE: writes each block ```LANGUAGE of a page into FOLDER; a page without one is an error.

C++ that has no main() is put into one, below its includes.
"""
import pathlib
import re
import sys

language, folder, page = sys.argv[1:]
blocks = re.findall(rf"^```{language}\n(.*?)^```$", pathlib.Path(page).read_text(), re.M | re.S)
if not blocks:
    sys.exit(f"{page}: no block of {language}")
pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
for number, block in enumerate(blocks, 1):
    if language == "cpp" and not re.search(r"\bmain\(", block):
        lines = block.splitlines()
        includes = [line for line in lines if line.startswith("#include")]
        rest = [line for line in lines if not line.startswith("#include")]
        block = "\n".join([*includes, "int main() {", *rest, "}", ""])
    pathlib.Path(folder, f"block{number}.{language}").write_text(block)
