"""What pictures are made of: runs, predicted deployments, and curves of tests, by their paths."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.base.input_file import LARGEST_DATA
from billow.base.table_file import read_table
from billow.base.units import CONVERSIONS
from billow.results.atomic import PARTIAL
from billow.results.histories import TIME, History, read_histories
from billow.results.journal import JOURNAL, history_so_far
from billow.results.ownership import in_use
from billow.results.result import Result
from billow.results.vtkhdf import FabricFile

NOTHING_TO_DRAW = InputError.declare(
    "E-PIC-006",
    "{path} cannot be drawn",
    where="billow {command}",
    cause="a misspelt path, or a file of another kind",
    remedy="give the folder of a run, a deployment.vtkhdf of `billow predict`, or a table of curves (CSV)",
)
NOT_CURVES = InputError.declare(
    "E-PIC-007",
    "{name} is no table of curves",
    where="{path}",
    cause="a header without units, text among the numbers, or times that do not rise",
    remedy="give a CSV file: a header such as time [ms],impactor_acceleration_z [g], then a row for each instant",
)

_HEADER = re.compile(r"\s*(.*\S)\s*\[\s*([^\[\]]*\S)\s*\]\s*")


@dataclass(frozen=True)
class Source:
    """One run, prediction or test. path: as it was given; label: what pictures call it."""

    path: Path
    label: str
    result: Result | None = None
    curves: History | None = None
    frames: FabricFile | None = None

    @cached_property
    def histories(self) -> History | None:
        """Its curves, None if it has none."""
        return self.result.histories if self.result is not None else self.curves

    @property
    def fabric(self) -> FabricFile | None:
        """Its frames, None if it has none."""
        return self.result.fabric if self.result is not None else self.frames


def open_source(path: Path, command: str, label: str | None = None) -> Source:
    """A source by its path. command: for messages.

    InputError E-PIC-006 (nothing of the kind), E-PIC-007 (no table); errors of `Result.open` and `FabricFile`.
    """
    label = label or path.name or str(path)
    if path.suffix.lower() == ".vtkhdf" and path.is_file():
        return Source(path, label, frames=FabricFile(path))
    if path.suffix.lower() == ".csv" and path.is_file():
        return Source(path, label, curves=read_curves(path))
    if (curves := running_histories(path)) is not None:
        return Source(path, f"{label}, so far", curves=curves)
    if path.is_dir() or not path.exists():
        return Source(path, label, Result.open(path))
    raise NOTHING_TO_DRAW(path=path, command=command, why="it is neither a folder nor a .vtkhdf or .csv file")


def running_histories(path: Path) -> History | None:
    """Curves of a run that goes on, or was interrupted, up to now; None for any other path. path: its --out folder."""
    journal = _partial(path) / JOURNAL
    return None if path.exists() or not journal.is_file() else history_so_far(journal)


def is_running(path: Path) -> bool:
    """Whether a run goes on now. path: its --out folder."""
    return not path.exists() and in_use(_partial(path))


def _partial(path: Path) -> Path:
    absolute = path.absolute()  # "." has a name only in full
    return absolute.parent / f"{absolute.name}{PARTIAL}"


def open_sources(paths: Sequence[Path], command: str) -> list[Source]:
    """Sources with labels that tell them apart. Errors as `open_source`."""
    return [open_source(path, command, label) for path, label in zip(paths, labels(paths), strict=True)]


def labels(paths: Sequence[Path]) -> list[str]:
    """Names that tell paths apart: their last parts, as many as that needs, and a number where a path comes twice."""
    whole = [path.absolute().parts for path in paths]
    count = 1
    while count < max(map(len, whole)) and len({parts[-count:] for parts in whole}) < len(set(whole)):
        count += 1
    found = ["/".join(parts[-count:]) for parts in whole]
    many, seen = Counter(found), Counter()
    for k, name in enumerate(found):
        if many[name] > 1:
            seen[name] += 1
            found[k] = f"{name} ({seen[name]})"
    return found


def read_curves(path: Path) -> History:
    """Curves of a CSV file in SI: histories of Billow, or those of a test, in the units that its header names.

    InputError E-PIC-007 if it is no table whose first column is a time, or its times do not rise.
    """
    try:
        table = read_table(path, LARGEST_DATA)
        if table.names[0] == TIME:
            return read_histories(path)
        values, lines = table.numbers()
        columns: dict[str, np.ndarray] = {}
        for k, text in enumerate(table.names):
            name, unit, factor = _column(text)
            if k == 0 and (name.lower(), unit) != ("time", "s"):
                raise ValueError(f"its first column is {text!r}; expected time [s] or time [ms]")
            columns[f"{name if k else 'time'} [{unit}]"] = factor * values[:, k]
        steps = np.diff(columns[TIME])
        if (steps <= 0.0).any():
            raise ValueError(
                f"the time in line {lines[1 + int(np.argmax(steps <= 0.0))]} does not come after the one before"
            )
    except (OSError, ValueError) as error:
        raise NOT_CURVES(name=path.name, path=path, why=error) from None
    return History(columns)


def _column(text: str) -> tuple[str, str, float]:
    """Name, unit of SI and its factor of a header. A unit that is not known is kept as it is."""
    match = _HEADER.fullmatch(text)
    if match is None:
        raise ValueError(f"column {text!r} has no unit, such as 'force [N]'")
    name, unit = match[1].strip().replace(" ", "_"), match[2]
    for si, factors in CONVERSIONS.items():
        if unit in factors and (unit, si) != ("g", "kg"):  # in a crash test, g is an acceleration
            return name, si, factors[unit]
    return name, unit, 1.0
