"""Files that a case names: curves of fabric and inflators are read into it, meshes of the bag are noted with their
digest."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from billow.base.input_file import LARGEST_DATA, require_file
from billow.parts.fabric.curve_file import read_curve_file


def with_files_settled(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The tables of a case, no longer dependent on `folder`, from which relative paths count.

    `fabric.curves.*.loading = "file.csv"` is replaced by the points of that file (likewise unloading, those of
    fabric.parts, and mass_flow and temperature of inflators), so that the effective case is complete in itself. Paths
    of mesh files become absolute, and `digest` beside them holds their SHA-256.
    Whatever does not fit the schema stays as it is, for the schema to refuse.

    Raises InputError E-FAB-001 and E-FAB-002 for curve files that cannot be used.
    """
    fabric, bag = data.get("fabric"), data.get("bag")
    if isinstance(fabric, dict):
        data = {**data, "fabric": _with_curves(fabric, folder)}
    inflators = data.get("inflator")
    if isinstance(inflators, dict):
        data = {**data, "inflator": _with_flow(inflators, folder)}
    elif isinstance(inflators, list):
        data = {**data, "inflator": [_with_flow(one, folder) for one in inflators]}
    if isinstance(bag, dict) and bag.get("shape") == "mesh":
        data = {**data, "bag": _with_digest(bag, folder, "start", "reference")}
    if isinstance(data.get("obstacles"), list):
        data = {**data, "obstacles": [
            _with_digest(one, folder, "file") if isinstance(one, dict) and one.get("shape") == "mesh" else one
            for one in data["obstacles"]
        ]}  # fmt: skip
    return data


def curve_files(data: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Keys of a case whose points come from a file, and its name as written; after `with_files_settled`."""
    fabric = data.get("fabric")
    parts = fabric.get("parts") if isinstance(fabric, dict) else None
    fabrics = {"fabric": fabric}
    fabrics |= {f"fabric.parts.{part}": one for part, one in parts.items()} if isinstance(parts, dict) else {}
    for key, one in fabrics.items():
        curves = one.get("curves") if isinstance(one, dict) else None
        for name, table in curves.items() if isinstance(curves, dict) else ():
            for branch, file in table.items() if isinstance(table, dict) else ():
                if isinstance(file, str):
                    yield f"{key}.curves.{name}.{branch}", file


def files_digest(*paths: Any) -> str:
    """SHA-256 over the contents of files; empty if one cannot be read, which `read_mesh` then explains."""
    digest = hashlib.sha256()
    try:
        for path in filter(None, paths):
            require_file(path, LARGEST_DATA)
            with open(path, "rb") as file:
                digest.update(hashlib.file_digest(file, "sha256").digest())
    except (OSError, TypeError):
        return ""
    return digest.hexdigest()


def _with_curves(fabric: Any, folder: Path) -> Any:
    """The table of a fabric and those of its parts, with the points of the files they name."""
    if not isinstance(fabric, dict):
        return fabric
    read: dict[str, Any] = {}
    if isinstance(fabric.get("curves"), dict):
        read["curves"] = {name: _with_points(name, table, folder) for name, table in fabric["curves"].items()}
    if isinstance(fabric.get("parts"), dict):
        read["parts"] = {part: _with_curves(one, folder) for part, one in fabric["parts"].items()}
    return {**fabric, **read}


def _with_points(name: str, table: Any, folder: Path) -> Any:
    """The table of one direction (warp, weft, shear), with the points of the files it names."""
    if not isinstance(table, dict) or name not in ("warp", "weft", "shear"):
        return table
    x = "angle" if name == "shear" else "strain"
    named = [branch for branch in ("loading", "unloading") if isinstance(table.get(branch), str)]
    return {**table, **{branch: read_curve_file(folder / table[branch], x) for branch in named}}


def _with_flow(inflator: Any, folder: Path) -> Any:
    """The table of an inflator, with the points of the files it names; a temperature may also be a number in a text."""
    if not isinstance(inflator, dict):
        return inflator
    read = {}
    for key in ("mass_flow", "temperature"):
        name = inflator.get(key)
        if isinstance(name, str) and (key == "mass_flow" or name.lower().endswith(".csv")):
            points = read_curve_file(folder / name, "time", key)
            read[key] = {"time": points["time"], "value": points[key]}
    return {**inflator, **read}


def _with_digest(table: dict[str, Any], folder: Path, *keys: str) -> dict[str, Any]:
    """A table with the files under its keys, the first of which it needs, as absolute paths, and their digest."""
    named = [key for key in keys if isinstance(table.get(key), str) and table[key]]
    table = {**table, **{key: str((folder / table[key]).absolute()) for key in named}}
    if isinstance(table.get(keys[0]), str):
        table.setdefault("digest", files_digest(*(table.get(key, "") for key in keys)))
    return table
