"""A dataset made from runs of another solver, so that a surrogate can be trained on them.

The folder that is read: docs/rom.md, Runs of another solver. Runs must share mesh and times.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import numpy as np
import tomli_w

from billow.base.errors import InputError
from billow.base.plausible import require_possible
from billow.base.table_file import Table, read_table
from billow.results.atomic import new_folder, new_place, write_atomically
from billow.results.dataset_files import (
    RUN_NAME,
    DatasetRecord,
    Parameter,
    mesh_sha256,
    same_times,
    write_dataset_file,
    write_design,
    write_split,
)
from billow.results.histories import write_histories
from billow.results.run_file import write_run_file
from billow.results.vtkhdf import FabricWriter
from billow.study.dyna_run import DynaChoices
from billow.study.foreign_run import ForeignRun, read_run, read_times, read_triangles

UNUSABLE_TABLE = InputError.declare(
    "E-STU-026",
    "the table of runs cannot be used",
    where="{path}",
    cause="no runs.csv, a column that is not headed name [unit], or values that are not numbers or all the same",
    remedy='write a column "run", one column "name [unit]" for each parameter, and one row for each run',
)
RUN_DOES_NOT_FIT = InputError.declare(
    "E-STU-028",
    "run {run} does not fit the others",
    where="{folder}",
    cause="another mesh, nodes in another order, another start shape, or other times",
    remedy="give all runs one mesh, with nodes in the same order, and the same times; nothing is interpolated",
)
UNKNOWN_MESH_OR_TIMES = InputError.declare(
    "E-STU-029",
    "mesh or times of the runs are not known",
    where="{folder}",
    cause="NumPy or CSV frames without triangles.csv or times.csv beside them",
    remedy="put triangles.csv (a,b,c) and times.csv (time [s]) beside the runs, or both into every .npz",
)

TABLE, SPLIT, SECONDS = "runs.csv", "split", "wall_seconds [s]"
_COLUMN = re.compile(r"([A-Za-z][A-Za-z0-9_]*) \[([^\[\]]+)\]")
_SAME = 1e-6
"""Fraction of the mesh size by which start shapes may differ: text has seven digits."""


def import_runs(
    folder: str | Path,
    out: str | Path,
    *,
    title: str | None = None,
    reference_length: float | None = None,
    test_share: float = 0.2,
    seed: int = 0,
    units: str | None = None,
    parts: tuple[int, ...] = (),
) -> tuple[int, int]:
    """Make a dataset in `out` from the runs in `folder`; returns the numbers of training and test runs.

    title: by default the folder's name; reference_length: [m], to which errors are compared, by default the largest
    extent of the start shape; test_share: part of the runs that is set aside, unless runs.csv has a column split;
    units, parts: of results of LS-DYNA, their system of units and the numbers of the parts that are the bag

    InputError E-STU-026: runs.csv; -027: a run cannot be read; -028: a run does not fit the others; -029: mesh or times
    are unknown; E-UNIT-001: sizes or times in another unit; E-RES-009: `out` exists. Nothing is written unless every
    run is sound.
    """
    folder, out = Path(folder), Path(out)
    new_place(out)
    if reference_length is not None:
        require_possible("bag size", reference_length, "the reference length", "reference_length", "it is in m")
    table = _Table(folder / TABLE)
    split = table.split or _draw_split(list(table.design), test_share, seed)
    with new_folder(out) as partial:
        common = None
        for run in table.design:
            found = read_run(folder, run, DynaChoices(units, parts))
            common = common or _Common(folder, run, found)
            common.check(run, found)
            _write_run(partial / "runs" / run, common, found, table, run)
        write_design(partial, table.parameters, table.design)
        write_split(partial, *split)
        size = float(np.ptp(common.start, axis=0).max())
        mesh, times = mesh_sha256(common.start, common.triangles), tuple(common.times.tolist())
        title, length = title or folder.resolve().name, reference_length or size
        write_dataset_file(partial, DatasetRecord(title, length, seed, mesh, times, table.parameters))
    return len(split[0]), len(split[1])


class _Table:
    """runs.csv. parameters; design: run -> values; split: (train, test) or None; seconds: run -> [s]."""

    def __init__(self, path: Path):
        try:
            self._take(read_table(path))
        except (OSError, ValueError) as error:
            raise UNUSABLE_TABLE(path=path, why=error) from error

    def _take(self, table: Table) -> None:
        if table.names[0] != "run":
            raise ValueError(f"its columns are {', '.join(table.names)}; the first must be run")
        names = [name for name in table.names if name not in ("run", SPLIT, SECONDS)]
        heads = [_COLUMN.fullmatch(name) for name in names]
        if None in heads:
            raise ValueError(f"column {names[heads.index(None)]!r} is not of the form name [unit]")
        if not names:
            raise ValueError("it has no parameter")
        rows = [cells for _, cells in table.rows()]
        runs = [row[0] for row in rows]
        if len(runs) < 3 or len(set(runs)) != len(runs) or not all(map(RUN_NAME.fullmatch, runs)):
            raise ValueError("it needs at least three runs, each with a name of its own made of letters and digits")
        values = table.numbers(names)[0].T
        self.parameters = tuple(_axis(*head.groups(), row) for head, row in zip(heads, values, strict=True))
        self.design = {run: tuple(values[:, k].tolist()) for k, run in enumerate(runs)}
        seconds = table.numbers([SECONDS])[0][:, 0].tolist() if SECONDS in table.names else [0.0] * len(runs)
        self.seconds = dict(zip(runs, seconds, strict=True))
        self.split = None
        if SPLIT in table.names:
            column = table.names.index(SPLIT)
            part = {row[0]: row[column] for row in rows}
            train, test = ([run for run in runs if part[run] == name] for name in ("train", "test"))
            if len(train) + len(test) != len(runs) or len(train) < 2 or not test:
                raise ValueError("column split must say train or test for each run, two train and one test at least")
            self.split = train, test


def _axis(name: str, unit: str, values: np.ndarray) -> Parameter:
    if not values.min() < values.max():
        raise ValueError(f"{name} [{unit}] is the same in every run; leave it out")
    return Parameter(name, name.replace("_", " ").capitalize(), unit, float(values.min()), float(values.max()))


def _draw_split(runs: list[str], share: float, seed: int) -> tuple[list[str], list[str]]:
    """By run, never by snapshot; at least one test run and two training runs."""
    count = min(max(round(share * len(runs)), 1), len(runs) - 2)
    chosen = set(np.random.default_rng(seed).permutation(len(runs))[:count].tolist())
    return [r for k, r in enumerate(runs) if k not in chosen], [r for k, r in enumerate(runs) if k in chosen]


class _Common:
    """What the runs share, taken from the first one, `run`. start: [m], (nodes, 3); triangles; times: [s]."""

    def __init__(self, folder: Path, run: str, first: ForeignRun):
        self._folder, self.run, self.start = folder, run, first.positions[0]
        try:
            shared_times = read_times(folder)
            shared_triangles = read_triangles(folder)
        except (OSError, ValueError) as error:
            raise UNKNOWN_MESH_OR_TIMES(folder=folder, why=error) from error
        self.times = first.times if first.times is not None else shared_times
        self.triangles = first.triangles if first.triangles is not None else shared_triangles
        if self.times is None or self.triangles is None:
            why = f"neither the runs nor the folder hold {'times' if self.times is None else 'triangles'}"
        elif self.times.ndim != 1 or not len(self.times) or not np.isfinite(self.times).all():
            why = "times must be finite numbers, one for each frame"
        elif self.times[0] != 0.0:
            why = f"the first time is {self.times[0]:g} s; it must be 0, that of the start shape"
        elif not (np.diff(self.times) > 0.0).all():
            k = int(np.argmin(np.diff(self.times) > 0.0))
            why = f"times must rise; {self.times[k + 1]:g} s follows {self.times[k]:g} s"
        elif self.triangles.ndim != 2 or self.triangles.shape[1:] != (3,) or not len(self.triangles):
            why = f"triangles have shape {self.triangles.shape}; expected (triangles, 3)"
        elif not 0 <= self.triangles.min() <= self.triangles.max() < len(self.start):
            from_one = self.triangles.min() == 1 and self.triangles.max() == len(self.start)
            hint = "; nodes are counted from 0, not from 1" if from_one else ""
            why = f"a triangle names a node that is not among 0 to {len(self.start) - 1}{hint}"
        elif (twice := (self.triangles == np.roll(self.triangles, 1, axis=1)).any(axis=1)).any():
            why = f"triangle {int(np.argmax(twice))}, counted from 0, has the same node twice"
        else:
            self._require_units()
            return
        raise UNKNOWN_MESH_OR_TIMES(folder=folder, why=why)

    def _require_units(self) -> None:
        where, change = f"{self._folder}, run {self.run}", "convert it; positions are in m, times in s"
        size = float(np.ptp(self.start[np.unique(self.triangles)], axis=0).max())
        require_possible("bag size", size, "the width of the mesh", where, change)
        require_possible("duration of a run", float(self.times[-1]), "the last time", where, change)

    def check(self, run: str, found: ForeignRun) -> None:
        """InputError E-STU-028 if a run does not fit the first one."""
        frames, nodes = found.positions.shape[:2]
        if nodes != len(self.start):
            why = f"it has {nodes} nodes, run {self.run} has {len(self.start)}"
        elif frames != len(self.times):
            why = f"it has {frames} frames for {len(self.times)} times"
        elif found.times is not None and not same_times(found.times, self.times):
            why = f"its times differ from those of run {self.run}"
        elif found.triangles is not None and not np.array_equal(found.triangles, self.triangles):
            why = f"its triangles differ from those of run {self.run}"
        elif (away := np.abs(found.positions[0] - self.start).max()) > _SAME * np.ptp(self.start, axis=0).max():
            why = f"its start shape differs from that of run {self.run} by up to {away:.3g} m"
        else:
            return
        raise RUN_DOES_NOT_FIT(run=run, folder=self._folder, why=why)


def _write_run(folder: Path, common: _Common, found: ForeignRun, table: _Table, run: str) -> None:
    folder.mkdir(parents=True)
    values = dict(zip((p.name for p in table.parameters), table.design[run], strict=True))
    case = tomli_w.dumps({"title": f"Run {run} of another solver", "design": values})
    write_atomically(folder / "case.toml", case)
    start = common.start
    force = np.zeros_like(found.positions) if found.contact_force is None else found.contact_force
    part = np.zeros(len(common.triangles), int)
    with FabricWriter(folder / "fabric.vtkhdf", start, common.triangles, part, ["fabric"]) as frames:
        for time, points, pushed in zip(common.times, found.positions, force, strict=True):
            frames.append(float(time), points, {"displacement": points - start, "contact_force": pushed})
    write_histories(folder / "histories.csv", found.histories or {"time [s]": common.times})
    record = {"status": "completed", "reason": None, "case_digest": hashlib.sha256(case.encode()).hexdigest()}
    write_run_file(folder, {**record, "wall_seconds": table.seconds[run], "ledger": {}})
