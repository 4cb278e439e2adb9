"""The moving mesh and the histories of a run of LS-DYNA: d3plot families and binout, by the library dynars, which is an
extra, and ASCII files. What is read is checked against itself: nothing in these files names a unit, or says which
shells are the bag.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.base.input_file import require_file
from billow.decks.units import SYSTEMS, Units
from billow.study.dyna_text import read_text

NO_LIBRARY = InputError.declare(
    "E-STU-033",
    "results of LS-DYNA cannot be read here",
    where="{path}",
    why="the library dynars is not installed",
    remedy="install it: pip install 'billow[dyna]'",
)
NOT_SAID = InputError.declare(
    "E-STU-034",
    "the units of the results are not said",
    where="{path}",
    why="a d3plot names none",
    cause="a folder of d3plot files imported as if they were in metres",
    remedy="say them: --units, one of {names}",
)

LARGEST = 20_000_000_000
"""Bytes of one file of a family."""
ABSTAT = {
    "volume": ("volume", "m^3", (0, 3, 0)),
    "pressure": ("pressure", "Pa", (1, -1, -2)),
    "internal_energy": ("internal_energy", "J", (1, 2, -2)),
    "dm_dt_in": ("inflow", "kg/s", (1, 0, -1)),
    "dm_dt_out": ("outflow", "kg/s", (1, 0, -1)),
    "total_mass": ("mass", "kg", (1, 0, 0)),
    "gas_temp": ("temperature", "K", (0, 0, 0)),
}
"""Variable of abstat -> quantity, unit, and powers of mass, length and time."""
LENGTH, SPEED, FORCE = ("m", (0, 1, 0)), ("m/s", (0, 1, -1)), ("N", (1, 1, -2))
BY_ID = {
    "nodout": ("node", {f"{x}_{q}": (f"{q}_{x}", *unit) for x in "xyz" for q, unit in (
        ("displacement", LENGTH), ("velocity", SPEED))}),
    "rbdout": ("rigid", {f"global_{letter}{x}": (f"{q}_{x}", *unit) for x in "xyz" for letter, q, unit in (
        ("d", "displacement", LENGTH), ("v", "velocity", SPEED))}),
    "rcforc": ("contact", {f"{x}_force": (f"force_{x}", *FORCE) for x in "xyz"}),
}  # fmt: skip
"""Branch of binout -> what its ids are called, and variable -> quantity, unit, and powers."""
SAME_TIME = 1e-5
"""By which times may differ: ASCII files have six digits."""
MOST_IDS = 200
"""Of a branch: histories are a table with columns for each."""


@dataclass(frozen=True)
class DynaChoices:
    """units: of the files, None if nobody said. parts: numbers of the parts of the bag, all shells if empty."""

    units: str | None = None
    parts: tuple[int, ...] = ()


UNSAID = DynaChoices()


@dataclass(frozen=True)
class DynaRun:
    """positions: [m], (times, nodes, 3). triangles: (n, 3). times: [s]. histories: column -> values, empty without."""

    positions: np.ndarray
    triangles: np.ndarray
    times: np.ndarray
    histories: dict[str, np.ndarray]


def is_dyna(folder: Path) -> bool:
    return (folder / "d3plot").is_file()


def read_dyna(folder: Path, choices: DynaChoices) -> DynaRun:
    """A run in a folder. Raises InputError E-STU-033, -034; ValueError or OSError, with a sentence, if it is damaged or
    not what it seems."""
    path = folder / "d3plot"
    try:
        import dynars
    except ImportError:
        raise NO_LIBRARY(path=path) from None
    if choices.units is None:
        raise NOT_SAID(path=path, names=", ".join(SYSTEMS))
    units = SYSTEMS[choices.units]
    require_file(path, LARGEST)
    try:
        plot = dynars.D3plot(str(path))
        if plot.filetype != 1:
            raise ValueError(f"its kind of file is {plot.filetype}; a d3plot has 1")
        times = np.array(plot.times(), dtype=float) * units.time
        cells, part = (np.array(array, dtype=np.int64) for array in plot.shell_connectivity())
        numbers = np.array(plot.part_ids(), dtype=np.int64)
        start = np.array(plot.initial_coordinates(), dtype=float)
        moving = np.array(plot.node_coordinates_all(), dtype=float)
    except OSError:
        raise
    except Exception as error:  # the library has no exceptions of its own
        raise ValueError(f"d3plot: {str(error)[:200] or type(error).__name__}") from None
    triangles = _triangles(cells, part, numbers, choices.parts, len(start))
    if moving.shape != (len(times), *start.shape) or len(times) < 1:
        raise ValueError(f"d3plot: {len(times)} times, and positions of shape {moving.shape}")
    size = float(np.ptp(start, axis=0).max())
    if not np.abs(moving[0] - start).max() <= 1e-5 * size:
        raise ValueError("d3plot: its first state is not the start shape; states may be missing, or deleted")
    used = np.unique(triangles)
    return DynaRun(
        moving[:, used] * units.length, np.searchsorted(used, triangles), times, _histories(dynars, folder, units)
    )


def _triangles(
    cells: np.ndarray, part: np.ndarray, numbers: np.ndarray, wanted: tuple[int, ...], nodes: int
) -> np.ndarray:
    """Triangles (n, 3), counted from 0, of the shells of some parts; quads are cut from their first corner."""
    if not len(cells) or cells.min() < 1 or cells.max() > nodes:
        raise ValueError(f"d3plot: a shell names a node that is not among 1 to {nodes}")
    if wanted:
        # Parts are counted in the file; their numbers stand beside.
        own = numbers[part - 1] if len(numbers) and 1 <= part.min() <= part.max() <= len(numbers) else part
        missing = [number for number in wanted if number not in own]
        if missing:
            known = ", ".join(map(str, np.unique(own)[:20]))
            raise ValueError(f"d3plot: no shell belongs to part {missing[0]}; parts with shells are {known}")
        cells = cells[np.isin(own, wanted)]
    halves = np.stack([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]], axis=1)
    whole = np.ones(len(cells) * 2, dtype=bool)
    whole[1::2] = cells[:, 3] != cells[:, 2]
    return halves.reshape(-1, 3)[whole] - 1


def _histories(dynars, folder: Path, units: Units) -> dict[str, np.ndarray]:
    """Histories in SI, of binout and of ASCII files for what binout has not: of the first airbag, and of each node,
    rigid body and contact that was written."""
    found: dict[str, np.ndarray] = {}
    branches = _of_binout(dynars, folder, units, found) if any(folder.glob("binout*")) else set()
    for branch in (*BY_ID, "abstat"):  # times have the most digits in nodout
        path = folder / branch
        if branch in branches or not path.is_file():
            continue
        read = read_text(path)
        if branch == "abstat":
            for name, (quantity, unit, powers) in ABSTAT.items():
                _take(found, read.time, read.values[name], {0: f"{quantity} [{unit}]"}, powers, units, branch)
            continue
        _require_few(branch, read.ids)
        called, variables = BY_ID[branch]
        for name, (quantity, unit, powers) in variables.items():
            columns = {column: f"{called}_{number}_{quantity} [{unit}]" for column, number in enumerate(read.ids)}
            _take(found, read.time, read.values[name], columns, powers, units, branch)
    return found


def _require_few(branch: str, ids: list[int]) -> None:
    if len(ids) > MOST_IDS:
        raise ValueError(f"{branch} has {len(ids)} ids; at most {MOST_IDS} become histories: write fewer")


def _of_binout(dynars, folder: Path, units: Units, found: dict[str, np.ndarray]) -> set[str]:
    """Put into found what binout has; its branches."""
    try:
        binout = dynars.Binout(str(folder / "binout*"))
        branches = binout.read()
        if "abstat" in branches:
            for name, (quantity, unit, powers) in ABSTAT.items():
                if name in binout.read("abstat"):
                    read = binout.read_states("abstat", name)
                    _take(found, read["time"], read["values"], {0: f"{quantity} [{unit}]"}, powers, units, name)
        for branch, (called, variables) in BY_ID.items():
            if branch not in branches:
                continue
            ids = np.asarray(binout.ids(branch)).tolist()
            _require_few(branch, ids)
            # Of the two sides of a contact the first counts.
            first = {number: column for column, number in reversed(list(enumerate(ids)))}
            for name, (quantity, unit, powers) in variables.items():
                if name in binout.read(branch):
                    columns = {column: f"{called}_{number}_{quantity} [{unit}]" for number, column in first.items()}
                    read = binout.read_states(branch, name)
                    _take(found, read["time"], read["values"], columns, powers, units, branch)
    except OSError:
        raise
    except Exception as error:  # as above
        raise ValueError(f"binout: {str(error)[:200] or type(error).__name__}") from None
    return set(branches)


def _take(
    found: dict[str, np.ndarray], time, values, columns: dict[int, str], powers: tuple[int, int, int], units: Units,
    name: str,
) -> None:  # fmt: skip
    """Columns of a variable into the histories. ValueError, with a sentence, if its times are others."""
    table = np.array(values, dtype=float).reshape(len(time), -1)
    time = np.array(time, dtype=float) * units.time
    known = found.setdefault("time [s]", time)
    if len(time) != len(known) or not np.allclose(time, known, rtol=SAME_TIME, atol=1e-9):
        raise ValueError(f"{name} has other times than the rest: write all at one interval")
    m, length, t = powers
    for column, title in columns.items():
        found[title] = table[:, column] * units.mass**m * units.length**length * units.time**t
