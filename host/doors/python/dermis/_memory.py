# SPDX-License-Identifier: MIT
"""The memory that this process may still take."""
from __future__ import annotations

import math
from pathlib import Path


def _number(path: Path) -> float:
    """Return the number that a file holds, infinity where it is missing or says "max"."""
    try:
        return float(path.read_text().replace("max", "inf"))
    except (OSError, ValueError):
        return math.inf


def _inactive(path: Path) -> float:
    """Return how much of a control group's memory is files that it can drop."""
    try:
        return float(dict(line.split() for line in path.read_text().splitlines())["inactive_file"])
    except (OSError, KeyError, ValueError):
        return 0.0


def available(proc: str = "/proc", groups: str = "/sys/fs/cgroup") -> float:
    """Return bytes: of the machine, and of each control group, version 1 or 2, that this process is in."""
    free = math.inf
    try:
        for line in Path(proc, "meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                free = 1024.0 * float(line.split()[1])
        lines = Path(proc, "self/cgroup").read_text().splitlines()
    except OSError:
        return free
    for _, controllers, own in (line.split(":", 2) for line in lines):
        if controllers not in ("", "memory"):
            continue
        top = Path(groups, controllers)
        limit, used = (("memory.limit_in_bytes", "memory.usage_in_bytes") if controllers
                       else ("memory.max", "memory.current"))
        group = top / own.lstrip("/")
        for folder in [group, *group.parents]:
            if (most := _number(folder / limit)) < math.inf:
                taken = _number(folder / used) - _inactive(folder / "memory.stat")
                free = min(free, max(0.0, most - taken) if taken < math.inf else most)
            if folder == top:
                break
    return free
