"""The floor of a study: some of its designs run again with a change that has no meaning.

A bag that crumples and bounces carries differences of rounding on to millimetres. Made again with a step that is 1 %
shorter, a run is another sample of what the design does: its distance from the first is what no model can foresee.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from billow.base.errors import InputError
from billow.results.dataset import Dataset
from billow.results.floor_file import Floor
from billow.results.result import Result
from billow.study.attempt import Runner
from billow.study.study import Study

NO_FLOOR = InputError.declare(
    "E-STU-170",
    "the floor of the study cannot be measured",
    where="{folder}",
    cause="a study that was not run, a change of mesh or times, or one that changes nothing",
    remedy="make the runs first: billow study STUDY.toml --out FOLDER; change a number that does not matter",
)
DESIGNS = 5
SHORTER = 0.99
"""Of the step."""
SAME_START = 1e-6
"""[m] By which nodes may start elsewhere: a change of 1e-9 of a size is one of the floor, another mesh is none."""
FOLDER = "floor"


def measure_floor(
    folder: str | Path,
    designs: int = DESIGNS,
    changes: Mapping[str, Any] | None = None,
    say: Callable[[str], None] = lambda line: None,
    threads: int | None = None,
    runner: Runner | None = None,
) -> Floor:
    """Run so many designs of a study again, and write floor.json and floor.csv into its folder.

    designs: evenly from the test runs, then from the training runs; changes: entries of the case, by default a step 1 %
    shorter, and of particles another seed; say: called with a line for each run; runs that are there already are kept.
    InputError E-STU-170; errors as `Study.open`, `Dataset.open`, `Case.vary` and `simulate`.
    """
    if runner is None:
        from billow.run.simulate import simulate as runner
    study, dataset = Study.open(folder), Dataset.open(folder)
    known = (*dataset.test, *dataset.trusted)
    if not known or designs < 1:
        raise NO_FLOOR(folder=folder, why=f"{designs} designs are asked for, and {len(known)} runs are complete")
    pool = dataset.test if len(dataset.test) >= designs else known
    chosen = [pool[k] for k in np.unique(np.linspace(0, len(pool) - 1, min(designs, len(pool))).astype(int))]
    floors, told = [], {}
    for run in chosen:
        case = study.case(run)
        entries = dict(changes) if changes else _usual(case)
        told = {key: f"{value:.12g}" if isinstance(value, float) else str(value) for key, value in entries.items()}
        again = case.vary(entries)
        if again.digest() == case.digest():
            raise NO_FLOOR(folder=folder, why=f"{told} is what run {run} has already")
        place = Path(folder, FOLDER, f"{run}-{again.digest()[:12]}")
        if not place.is_dir():
            place.parent.mkdir(exist_ok=True)
            runner(again, place, threads=threads)
        floors.append(_differences(dataset, run, Result.open(place)))
        say(f"run {run} again with {', '.join(f'{k} = {v}' for k, v in told.items())}: "
            f"z differs by {1e3 * 2.0**0.5 * floors[-1][:, 2].mean():.3g} mm")  # fmt: skip
    floor = Floor(told, tuple(chosen), dataset.times, np.array(floors))
    floor.write(folder)
    return floor


def _usual(case) -> dict[str, Any]:
    """A step 1 % shorter, and of a gas of particles another seed."""
    content = case.to_dict()
    entries: dict[str, Any] = {"run.dt_scale": SHORTER * content["run"]["dt_scale"]}
    if content["gas"]["model"] == "corpuscular":
        entries["gas.seed"] = content["gas"]["seed"] + 1
    return entries


def _differences(dataset: Dataset, run: str, again: Result) -> np.ndarray:
    """[m], (times, 3), as `Floor.rmse`."""
    truth = dataset.snapshots("displacement", [run])[0]
    if not _same_start(dataset, run, again):
        why = f"made again, run {run} starts from another mesh: what both differ by is more than the floor"
        raise NO_FLOOR(folder=again.folder, why=why)
    other = again.fabric.point_data("displacement")[-len(dataset.times) :]
    if again.status != "completed" or other.shape != truth.shape:
        why = f"run {run} made again is {again.status}, with {other.shape[0]} frames of {other.shape[1]} nodes"
        raise NO_FLOOR(folder=again.folder, why=why)
    return np.sqrt(np.square(other.astype(float) - truth).mean(axis=1) / 2.0)


def _same_start(dataset: Dataset, run: str, again: Result) -> bool:
    start, other = dataset.starts([run])[0], again.fabric.reference
    if start.shape != other.shape or not np.array_equal(again.fabric.triangles, dataset.triangles):
        return False
    return bool(np.abs(start - other).max() <= SAME_START)
