# SPDX-License-Identifier: MIT
"""links.py PAGE ..: every relative link of a page, and of each page that it leads to, leads to a file or folder."""
import pathlib
import re
import sys

broken, seen = [], set()
pages = [pathlib.Path(page).resolve() for page in sys.argv[1:]]
while pages:
    page = pages.pop()
    if page in seen:
        continue
    seen.add(page)
    for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text()):
        target = (page.parent / link).resolve()
        if not target.exists():
            broken.append(f"{page}: {link}")
        elif target.suffix == ".md":
            pages.append(target)
if broken or len(seen) < 5:
    sys.exit("\n".join(broken) or f"only {len(seen)} pages")
print(f"{len(seen)} pages, every link leads somewhere")
