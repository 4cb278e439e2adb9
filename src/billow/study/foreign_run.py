"""The moving mesh of one run of another solver, in any of the supported formats."""

from __future__ import annotations

import re
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.results.csv_files import read_csv
from billow.study.vtk_frames import SUFFIXES, read_vtk

UNREADABLE_RUN = InputError.declare(
    "E-STU-027",
    "run {run} cannot be read",
    where="{path}",
    cause="a file that is missing, cut short or of another kind, or positions that are not finite",
    remedy="export it again; runs.csv names it, so it must be there",
)


@dataclass(frozen=True, eq=False)
class ForeignRun:
    """positions: [m], (times, nodes, 3) float64; triangles: (triangles, 3) int64 or None; times: [s], (times,) or None
    contact_force: [N], (times, nodes, 3), or None
    """

    positions: np.ndarray
    triangles: np.ndarray | None = None
    times: np.ndarray | None = None
    contact_force: np.ndarray | None = None


def read_run(folder: Path, run: str) -> ForeignRun:
    """A run in `folder`. InputError E-STU-027 if there is none, it cannot be read, or has other shapes than it must."""
    readers = {folder / f"{run}.npz": _read_npz, folder / f"{run}.npy": _read_npy, folder / run: _read_frames}
    path = next((path for path in readers if path.exists()), None)
    try:
        if path is None:
            raise ValueError(f"there is neither {run}.npz nor {run}.npy nor a folder {run}")
        given = readers[path](path)
        shape = given.positions.shape
        if len(shape) != 3 or shape[2] != 3 or shape[0] < 3 or shape[1] < 3:
            raise ValueError(f"positions have shape {shape}; expected (times, nodes, 3) with three or more of both")
        if given.contact_force is not None and given.contact_force.shape != shape:
            raise ValueError(f"contact_force has shape {given.contact_force.shape}, positions have {shape}")
        for name in ("positions", "contact_force"):
            values = getattr(given, name)
            if values is not None and not np.isfinite(values).all():
                frame = int(np.argmin(np.isfinite(values).all(axis=(1, 2))))
                raise ValueError(f"{name} of frame {frame} are not all finite")
        return given
    except (OSError, ValueError, MemoryError) as error:
        raise UNREADABLE_RUN(run=run, path=path or folder / run, why=error) from error


def read_table(path: Path, columns: tuple[str, ...], dtype=float) -> np.ndarray | None:
    """Columns of a CSV file with a header, or the array of the .npy file beside it: (rows, columns); None without both.

    ValueError if it does not hold such columns.
    """
    binary = path.with_suffix(".npy")
    if binary.is_file():
        array = np.load(binary, allow_pickle=False)
        array = array[:, None] if array.ndim == 1 else array
        if array.ndim != 2 or array.shape[1] != len(columns):
            raise ValueError(f"{binary.name} has shape {array.shape}; expected {len(columns)} columns")
        return array.astype(dtype)
    if not path.is_file():
        return None
    header, rows = read_csv(path)
    missing = [name for name in columns if name not in header]
    if missing:
        raise ValueError(f"{path.name} has columns {', '.join(header)}; {', '.join(missing)} missing")
    chosen = [header.index(name) for name in columns]
    try:
        values = [[float(row[k]) for k in chosen] for row in rows]
        return np.array(values, float).reshape(-1, len(columns)).astype(dtype)
    except (ValueError, IndexError) as error:
        raise ValueError(f"{path.name}: {error}") from error


def read_times(folder: Path) -> np.ndarray | None:
    """times.csv (time [s]) or times.npy of a folder: [s], (times,); None if there is neither."""
    times = read_table(folder / "times.csv", ("time [s]",))
    return None if times is None else times[:, 0]


def _read_npy(path: Path) -> ForeignRun:
    return ForeignRun(np.asarray(np.load(path, allow_pickle=False), float))


def _read_npz(path: Path) -> ForeignRun:
    try:
        with np.load(path, allow_pickle=False) as arrays:
            if "positions" not in arrays:
                raise ValueError(f"it holds {', '.join(arrays) or 'nothing'}, no array called positions")
            optional = {
                name: np.asarray(arrays[name], kind) if name in arrays else None
                for name, kind in (("triangles", np.int64), ("times", float), ("contact_force", float))
            }
            return ForeignRun(np.asarray(arrays["positions"], float), **optional)
    except zipfile.BadZipFile as error:
        raise ValueError(f"it is no .npz file ({error})") from error


def _read_frames(folder: Path) -> ForeignRun:
    """One file per frame, in the order of the numbers in their names; all of one kind."""
    frames = sorted(
        (p for p in folder.iterdir() if p.suffix in (".csv", *SUFFIXES) and p.stem != "times"), key=_natural
    )
    kinds = {path.suffix for path in frames}
    if len(kinds) != 1:
        raise ValueError("it holds no frames" if not kinds else f"it mixes {' and '.join(sorted(kinds))} files")
    positions, triangles = [], None
    for path in frames:
        if path.suffix == ".csv":
            points, cells = read_table(path, ("x [m]", "y [m]", "z [m]")), None
        else:
            points, cells = read_vtk(path)
        if positions and (points.shape != positions[0].shape):
            raise ValueError(f"{path.name} has {len(points)} nodes, {frames[0].name} has {len(positions[0])}")
        if positions and cells is not None and not np.array_equal(cells, triangles):
            raise ValueError(f"{path.name} has other triangles than {frames[0].name}")
        positions.append(points)
        triangles = cells
    return ForeignRun(np.stack(positions), triangles, read_times(folder))


def _natural(path: Path) -> list:
    """frame_9 before frame_10."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", path.name)]
