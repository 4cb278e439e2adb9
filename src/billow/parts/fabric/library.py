"""Fabrics that come with Billow, as the `[fabric.curves]` table of a case would describe them.

The numbers, their source and what they are worth stand in the files of `data`.
"""

from __future__ import annotations

import tomllib
from importlib import resources
from typing import Any

FILES = {"nylon66-470dtex": "nylon66_470dtex.toml"}
"""Name in a case -> file."""


def library_curves(name: str) -> dict[str, Any]:
    """Curves of warp, weft and shear: direction -> "loading", "unloading" -> columns."""
    return tomllib.loads((resources.files(__package__) / "data" / FILES[name]).read_text(encoding="utf-8"))
