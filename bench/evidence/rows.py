# SPDX-License-Identifier: MIT
"""What the rows of the page EVIDENCE.md have in common: their numbers, the published data, pictures."""
import sys
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

import drawing
import runs
from runs import fitted

CLASSES = {"sa1": "sa1", "ra": "fa1", "pc": "fa2"}  # of the data, and what dermis calls them
DEPTHS = {"sa1": 0.3e-3, "ra": 0.5e-3, "pc": 2e-3}  # m, those of the fit


@dataclass
class Row:
    """What a row's function computes. numbers: those that rows.csv judges, and others, which are compared with the
    expected numbers alone. told: what else words.txt names."""
    numbers: dict
    picture: str = ""
    told: dict = field(default_factory=dict)


def data(name):
    """The rows of a file of published numbers."""
    return runs.table(HERE / name)


def preset(kind, sensitivity="median"):
    return f'type = "{CLASSES[kind]}"\nsensitivity = "{sensitivity}"\nspread = 0'


def r2(ours, published):
    return float(1 - ((ours - published)**2).sum() / ((published - published.mean())**2).sum())


def listed(values, form=".0f"):
    return ", ".join(f"{value:{form}}" for value in values)


def save(figure, picture):
    drawing.small(figure)
    drawing.save(figure, picture)
