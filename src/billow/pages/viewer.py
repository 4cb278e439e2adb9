"""`billow view` and `billow compare --html`: deployments as a page, with their curves and sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from billow import __version__
from billow.base.errors import InputError
from billow.pages.gas import packed_gas
from billow.pages.html import page, web_file
from billow.pages.mesh import colours, holes
from billow.pages.packed import in_bytes, in_planes, pack, whole_numbers
from billow.pictures.curves import Curve, curve_of, quantities, usual_quantities
from billow.pictures.fields import read_field
from billow.pictures.shown_units import factor_of, shown_unit
from billow.results.blocks import extent, mesh_of
from billow.results.histories import History
from billow.results.obstacles import obstacles_at
from billow.results.result import Result

NO_BAG = InputError.declare(
    "E-PAG-003",
    "there is no bag to show",
    where="the page",
    why="what was given are tables of curves",
    remedy="draw them: billow plot CURVES.csv",
)

MODULES = (
    "elements.js", "tensors.js", "frames.js", "scene.js", "section.js", "gas.js", "plot.js", "clock.js", "viewer.js",
)  # fmt: skip
MOST_BYTES = 7_000_000
"""Of the data of a page, which are a third more in it: with the libraries 10 MB."""
USUAL_FIELDS = ("stress", "gauge_pressure", "contact_force", "half_width")
"""Shown if nobody asks for others, of those that the frames hold."""
MOST_ROWS = 4000
"""Of curves."""


@dataclass(frozen=True)
class Shown:
    """One deployment. fabric: a `FabricFile`, or what offers the same, None for curves alone; result: whose obstacles
    and straps are drawn."""

    label: str
    fabric: object
    result: Result | None = None
    curves: History | None = None
    remark: str = ""


def viewer_page(
    shown: Sequence[Shown], title: str, fields: Sequence[str] = (), table: dict | None = None, notes: Sequence[str] = ()
) -> str:
    """The page. Arguments and errors as `viewer_data`."""
    return page(title, web_file("viewer.html"), MODULES, viewer_data(shown, title, fields, table, notes))


def viewer_data(
    shown: Sequence[Shown], title: str, fields: Sequence[str] = (), table: dict | None = None, notes: Sequence[str] = ()
) -> bytes:
    """What the scripts of the page show.

    fields: of the frames, by the names of `billow render`, besides displacement; table: {"head": texts, "rows": lists
    of texts}; notes: sentences for people
    If the page would be too large, only every second frame is kept, or fewer, and it says so.
    InputError E-PIC-002 for a field that no frames hold, E-PAG-003 if nothing has frames.
    """
    if all(one.fabric is None for one in shown):
        raise NO_BAG()
    every = 1
    while True:
        data, kept = _data(shown, title, fields, table, notes, every)
        if len(data) <= MOST_BYTES or kept <= 2:
            return data
        every *= 2


def _data(shown, title, fields, table, notes, every: int) -> tuple[bytes, int]:
    tensors: dict[str, np.ndarray] = {"colours": colours()}
    sides, notes, kept = [], list(notes), 0
    for k, one in enumerate(shown):
        if one.fabric is None:
            sides.append({"label": one.label, "has_frames": False})
            continue
        frames = np.unique([*range(0, len(one.fabric.times), every), len(one.fabric.times) - 1])
        own, told = _deployment(one, frames, fields)
        tensors |= {f"{k}.{name}": array for name, array in own.items()}
        sides.append(told)
        kept = max(kept, len(frames))
    if every > 1:
        notes.append(f"Only one frame in {every} is shown: with all of them the page would be too large.")
    curves, told, thinned = _curves(shown)
    if thinned > 1:
        notes.append(f"Curves show one of {thinned} rows of the histories.")
    tensors |= curves
    record = {
        "title": title,
        "sides": sides,
        "curves": told,
        "chosen": usual_quantities([one.curves for one in shown if one.curves is not None]),
        "table": table if table and table["rows"] else None,
        "notes": notes + [f"{one.label}: {one.remark}" for one in shown if one.remark],
        "same_mesh": _same_mesh([one.fabric for one in shown if one.fabric is not None]),
        "version": __version__,
    }
    return pack(tensors, record), kept


def _same_mesh(fabrics: list) -> bool:
    """Whether there are several bags, all of the same mesh, whose nodes can be compared one by one."""
    first, *others = fabrics
    return bool(others) and all(
        len(first.reference) == len(other.reference) and np.array_equal(first.triangles, other.triangles)
        for other in others
    )


def _deployment(one: Shown, frames: np.ndarray, fields: Sequence[str]) -> tuple[dict[str, np.ndarray], dict]:
    fabric = one.fabric
    planes, box = in_planes(np.stack([fabric.points(k) for k in frames]))
    tensors = {
        "planes": planes,
        "box": box,
        "times": fabric.times[frames],
        "start": np.asarray(fabric.reference, np.float32),
        "triangles": whole_numbers(fabric.triangles.reshape(-1)),
        "hole": holes(fabric.part, fabric.part_names),
    }
    shown_fields = []
    held = (*getattr(fabric, "point_fields", ()), *getattr(fabric, "cell_fields", ()))
    for name in fields or [usual for usual in USUAL_FIELDS if usual in held]:
        if not held:
            continue  # a surrogate's bag has positions alone
        field = read_field(fabric, name)
        low, high = field.usual_limits
        unit = shown_unit(field.unit, max(abs(low), abs(high)))
        factor = factor_of(field.unit, unit)
        tensors[f"field.{len(shown_fields)}"] = in_bytes(field.values[frames], low, high)
        shown_fields.append({
            "title": field.title, "unit": unit, "low": low / factor, "high": high / factor, "at_nodes": field.at_nodes,
        })  # fmt: skip
    obstacles, gas = [], []
    if one.result is not None:
        if (frames_of_gas := one.result.gas_frames) is not None:
            of_gas, gas = packed_gas(frames_of_gas, fabric.times[frames])
            tensors |= of_gas
        obstacles = _obstacles(one.result, fabric, frames, tensors)
        if one.result.straps is not None:
            straps = one.result.straps
            tensors["strap.planes"], tensors["strap.box"] = in_planes(np.stack([straps.points(k) for k in frames]))
            tensors["strap.lines"] = whole_numbers(straps.lines.reshape(-1))
    return tensors, {"label": one.label, "has_frames": True, "fields": shown_fields, "obstacles": obstacles, "gas": gas}


def _obstacles(result: Result, fabric, frames: np.ndarray, tensors: dict[str, np.ndarray]) -> list[str]:
    """Put obstacles into `tensors`: points in their own axes, triangles, and rotation and centre in each frame; returns
    their names."""
    placed = [{o["name"]: o for o in obstacles_at(result, float(fabric.times[k]))} for k in frames]
    names = [name for name in placed[0] if all(name in frame for frame in placed)]
    if not names:
        return []
    middle, wide = extent(fabric)
    for k, name in enumerate(names):
        first = placed[0][name]
        points, triangles = mesh_of(first, middle, wide)
        own = (points - np.asarray(first["center"])) @ np.asarray(first["rotation"])
        poses = [[*np.ravel(frame[name]["rotation"]), *frame[name]["center"]] for frame in placed]
        tensors[f"obstacle.{k}.points"] = own.astype(np.float32)
        tensors[f"obstacle.{k}.triangles"] = whole_numbers(triangles.reshape(-1))
        tensors[f"obstacle.{k}.poses"] = np.array(poses)
    return names


def _curves(shown: Sequence[Shown]) -> tuple[dict[str, np.ndarray], list[dict], int]:
    """Curves of all deployments, of one quantity in one unit: arrays by "curve.SIDE" and "rows.SIDE", what they are,
    and of how many rows one was kept."""
    found: dict[str, dict[int, Curve]] = {}
    for k, one in enumerate(shown):
        for name in quantities(one.curves) if one.curves is not None else ():
            found.setdefault(name, {})[k] = curve_of(one.curves, name)
    rows = max((len(curve.times) for of in found.values() for curve in of.values()), default=1)
    every = -(-rows // MOST_ROWS)
    tensors: dict[str, np.ndarray] = {}
    told = []
    for name, of in found.items():
        largest = max((abs(c.peak[0]) for c in of.values() if np.isfinite(c.peak[0])), default=0.0)
        si = next(iter(of.values())).unit
        unit = shown_unit(si, largest)
        told.append({"name": name, "title": name.replace("_", " "), "unit": unit, "sides": sorted(of)})
        for k, curve in of.items():
            tensors.setdefault(f"rows.{k}", 1e3 * curve.times[::every])
            values = (curve.values[::every] / factor_of(si, unit)).astype(np.float32)
            tensors.setdefault(f"curves.{k}", []).append(values)
    return {n: np.stack(a) if isinstance(a, list) else a for n, a in tensors.items()}, told, every
