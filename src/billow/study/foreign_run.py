"""The moving mesh of one run of another solver, in any of the supported formats."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.base.table_file import read_table, whole_numbers
from billow.study.dyna_run import UNSAID, DynaChoices, is_dyna, read_dyna
from billow.study.frame_order import frame_order
from billow.study.numpy_arrays import read_npy, read_npz
from billow.study.vtk_frames import SUFFIXES, read_vtk

UNREADABLE_RUN = InputError.declare(
    "E-STU-027",
    "run {run} cannot be read",
    where="{path}",
    cause="a file that is missing, cut short or of another kind, or positions that are not finite",
    remedy="export it again; runs.csv names it, so it must be there",
)

NODE = "node"
"""Column of frames in CSV that may stand beside the coordinates."""


LARGEST = 1e30
"""Of positions [m] and forces [N]: what is stored as float32 with room for differences."""


@dataclass(frozen=True, eq=False)
class ForeignRun:
    """positions: [m], (times, nodes, 3) float64; triangles: (triangles, 3) int64 or None; times: [s], (times,) or None
    contact_force: [N], (times, nodes, 3), or None; histories: column -> values at times of their own
    """

    positions: np.ndarray
    triangles: np.ndarray | None = None
    times: np.ndarray | None = None
    contact_force: np.ndarray | None = None
    histories: dict[str, np.ndarray] = field(default_factory=dict)


def read_run(folder: Path, run: str, dyna: DynaChoices = UNSAID) -> ForeignRun:
    """A run in `folder`; dyna: what results of LS-DYNA do not say. InputError E-STU-027 if there is none, it cannot be
    read, or has other shapes than it must."""
    readers = {
        folder / f"{run}.npz": _read_npz,
        folder / f"{run}.npy": _read_npy,
        folder / run: partial(_read_folder, dyna=dyna),
    }
    found = [path for path in readers if path.exists()]
    path = found[0] if found else None
    try:
        if path is None:
            raise ValueError(f"there is neither {run}.npz nor {run}.npy nor a folder {run}")
        if len(found) > 1:
            raise ValueError(f"{found[0].name} and {found[1].name} are both there; remove one")
        given = readers[path](path)
        shape = given.positions.shape
        if len(shape) != 3 or shape[2] != 3 or shape[0] < 3 or shape[1] < 3:
            raise ValueError(f"positions have shape {shape}; expected (times, nodes, 3) with three or more of both")
        if given.contact_force is not None and given.contact_force.shape != shape:
            raise ValueError(f"contact_force has shape {given.contact_force.shape}, positions have {shape}")
        for name in ("positions", "contact_force"):
            values = getattr(given, name)
            if values is None:
                continue
            stored = np.abs(values) <= LARGEST  # not a number is not
            if not stored.all():
                frame = int(np.argmin(stored.all(axis=(1, 2))))
                raise ValueError(f"{name} of frame {frame} are not all finite, or beyond {LARGEST:.0e}")
        if not np.ptp(given.positions[0], axis=0).any():
            raise ValueError("all nodes begin in one place: these are displacements; add the start shape to them")
        return given
    except (OSError, ValueError, MemoryError) as error:
        raise UNREADABLE_RUN(run=run, path=path or folder / run, why=error) from error


def read_columns(path: Path, columns: tuple[str, ...]) -> np.ndarray | None:
    """Columns of a CSV file with a header, or the array of the .npy file beside it: (rows, columns); None without both.

    ValueError or OSError if it does not hold such columns, or there are both.
    """
    binary = path.with_suffix(".npy")
    if binary.exists() and path.exists():
        raise ValueError(f"both {path.name} and {binary.name} are there; remove one")
    if binary.exists():
        array = read_npy(binary)
        array = array[:, None] if array.ndim == 1 else array
        if array.ndim != 2 or array.shape[1] != len(columns):
            raise ValueError(f"{binary.name} has shape {array.shape}; expected {len(columns)} columns")
        return array
    if not path.exists():
        return None
    try:
        return read_table(path).numbers(columns)[0]
    except (OSError, ValueError) as error:
        raise ValueError(f"{path.name}: {error}") from error


def read_times(folder: Path) -> np.ndarray | None:
    """times.csv (time [s]) or times.npy of a folder: [s], (times,); None if there is neither."""
    times = read_columns(folder / "times.csv", ("time [s]",))
    return None if times is None else times[:, 0].astype(float)


def read_triangles(folder: Path) -> np.ndarray | None:
    """triangles.csv (a,b,c) or triangles.npy of a folder: (triangles, 3) int64; None if there is neither."""
    triangles = read_columns(folder / "triangles.csv", ("a", "b", "c"))
    return None if triangles is None else whole_numbers(triangles, "node")


def _read_npy(path: Path) -> ForeignRun:
    return ForeignRun(read_npy(path).astype(float))


def _read_npz(path: Path) -> ForeignRun:
    arrays = read_npz(path)
    if "positions" not in arrays:
        raise ValueError(f"it holds {', '.join(arrays) or 'nothing'}, no array called positions")
    optional = {name: arrays[name].astype(float) for name in ("times", "contact_force") if name in arrays}
    if "triangles" in arrays:
        optional["triangles"] = whole_numbers(arrays["triangles"], "node")
    return ForeignRun(arrays["positions"].astype(float), **optional)


def _read_folder(folder: Path, dyna: DynaChoices) -> ForeignRun:
    if not is_dyna(folder):
        return _read_frames(folder)
    read = read_dyna(folder, dyna)
    return ForeignRun(read.positions, read.triangles, read.times, histories=read.histories)


def _read_frames(folder: Path) -> ForeignRun:
    """One file per frame, in the order of the numbers in their names; all of one kind."""
    files = [p for p in folder.iterdir() if p.suffix.lower() in (".csv", *SUFFIXES) and p.stem != "times"]
    kinds = {path.suffix.lower() for path in files}
    if len(kinds) != 1:
        raise ValueError("it holds no frames" if not kinds else f"it mixes {' and '.join(sorted(kinds))} files")
    if len(files) < 3:
        raise ValueError(f"it holds {len(files)} frame{'' if len(files) == 1 else 's'}; three or more are needed")
    times, files = read_times(folder), sorted(files)
    shared = read_times(folder.parent) if times is None else times
    frames = [files[k] for k in frame_order([path.stem for path in files], shared)]
    positions, triangles = [], None
    for path in frames:
        try:
            points, cells = (_points(path), None) if kinds == {".csv"} else read_vtk(path)
        except (OSError, ValueError) as error:
            raise ValueError(f"{path.name}: {error}") from error
        if positions and points.shape != positions[0].shape:
            raise ValueError(f"{path.name} has {len(points)} nodes, {frames[0].name} has {len(positions[0])}")
        if positions and cells is not None and not np.array_equal(cells, triangles):
            raise ValueError(f"{path.name} has other triangles than {frames[0].name}")
        positions.append(points)
        triangles = cells
    return ForeignRun(np.stack(positions), triangles, times)


def _points(path: Path) -> np.ndarray:
    """Positions of a frame in CSV: [m], (nodes, 3). A column node must count its rows, as triangles do."""
    table = read_table(path)
    if NODE in table.names:
        numbers, lines = table.numbers([NODE])
        wrong = np.flatnonzero(numbers[:, 0] != np.arange(len(numbers)))
        if len(wrong):
            k = wrong[0]
            raise ValueError(f"line {lines[k]} is of node {numbers[k, 0]:g}, not {k}; write nodes from 0 on, in order")
    return table.numbers(("x [m]", "y [m]", "z [m]"))[0]
