"""Curves that a case names by file are read into it, so that the effective case is complete in itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from billow.parts.fabric.curve_file import read_curve_file


def with_curves_inlined(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The case with `fabric.curves.*.loading = "file.csv"` replaced by the points of that file, and the same for
    unloading; paths count from `folder`. What is not as the schema wants it stays, for the schema to refuse.

    Raises InputError E-FAB-001 and E-FAB-002 for files that cannot be used.
    """
    fabric = data.get("fabric")
    curves = fabric.get("curves") if isinstance(fabric, dict) else None
    if not isinstance(curves, dict):
        return data
    read = {
        name: {
            branch: read_curve_file(folder / curve, "angle" if name == "shear" else "strain")
            if isinstance(curve, str) and branch in ("loading", "unloading")
            else curve
            for branch, curve in table.items()
        }
        if isinstance(table, dict) and name in ("warp", "weft", "shear")
        else table
        for name, table in curves.items()
    }
    return {**data, "fabric": {**fabric, "curves": read}}
