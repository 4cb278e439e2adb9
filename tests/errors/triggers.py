"""For every code, the smallest thing a user, a disk or a cluster can do that brings it about.

Each function raises the error, or returns what a study has recorded, or returns a concern. `here` offers a folder,
sound files (`here.bench`) and `here.patch`, pytest's monkeypatch. Every file triggers_*.py beside this one is read.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path

from here import Here

TRIGGERS: dict[str, Callable[[Here], object]] = {}

for file in sorted(Path(__file__).parent.glob("triggers_*.py")):
    found = importlib.import_module(file.stem).TRIGGERS
    assert not TRIGGERS.keys() & found.keys(), f"{file.name} brings about a code that another file does too"
    TRIGGERS |= found
