"""`billow export-d3plot`: frames of a run as a d3plot of LS-DYNA, by the library dynars."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from billow.decks.units import SYSTEMS
from billow.results.atomic import FOLDER_EXISTS, new_place, write_atomically
from billow.results.result import Result
from billow.study.dyna_run import NO_LIBRARY

LONGEST_TITLE = 40
FIRST = 1
"""Number of the first node. The library writes what it is given: from 0 on, every shell would have wrong nodes."""


def export_d3plot(result: Result, path: str | Path, units: str = "kg-mm-ms") -> dict[int, str]:
    """Write positions and velocities of all frames in one file, single precision. Returns the names of the parts by
    their number in it: it holds none.

    Raises InputError E-STU-033 without the library, E-RES-009 if path exists.
    """
    path = new_place(path)
    if path.is_dir():
        raise FOLDER_EXISTS(folder=path, why="it is a folder, and a file is to be written")
    try:
        import dynars
    except ImportError:
        raise NO_LIBRARY(path=path) from None
    system, fabric = SYSTEMS[units], result.fabric
    length, speed = (system.of_si(1.0, dimension) for dimension in ("length", "velocity"))
    title = str(result.record.get("title") or result.folder.name)
    plot = dynars.D3plotWriter(_single(fabric.reference, length), title=title[:LONGEST_TITLE])
    triangles = fabric.triangles.astype(np.int64) + FIRST
    part = fabric.part.astype(np.int64) + 1
    plot.add_shells(np.ascontiguousarray(triangles[:, [0, 1, 2, 2]]), part)
    plot.set_ids(part_ids=np.arange(1, len(fabric.part_names) + 1, dtype=np.int32))
    moving = fabric.point_data("velocity") if "velocity" in fabric.point_fields else None
    for k, (time, points) in enumerate(zip(fabric.times, fabric.each_points(), strict=True)):
        velocity = {} if moving is None else {"vel": _single(moving[k], speed)}
        plot.add_state(system.of_si(float(time), "time"), _single(points, length), **velocity)
    with TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent) as folder:
        made = Path(folder, "d3plot")
        plot.write(str(made))
        write_atomically(path, made.read_bytes())
    return dict(enumerate(fabric.part_names, 1))


def _single(values: np.ndarray, factor: float) -> np.ndarray:
    return np.ascontiguousarray(np.asarray(values, dtype=float) * factor, dtype=np.float32)
