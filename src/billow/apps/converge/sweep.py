"""The runs of a convergence study: one case with several numbers of particles, each with several seeds.

    OUT/case.toml            the case as it was given
    OUT/runs/20000_seed2/    one run folder each

Existing runs are not repeated and interrupted ones are continued: the same command continues a study.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from billow.base.errors import BillowError, InputError, NumericalStop
from billow.case.schema import Case
from billow.results.result import Result
from billow.run.case_folder import keep_case
from billow.run.simulate import resume, simulate

NOTHING_TO_COMPARE = InputError.declare(
    "E-CONV-001",
    "there is nothing to compare",
    where="--particles {counts} --seeds {seeds}",
    why="convergence shows between numbers of particles, noise between seeds: at least two of each are needed",
    remedy="billow converge CASE.toml --particles 5e3,1e4,2e4 --seeds 3 --out OUT",
)
NO_PARTICLES = InputError.declare(
    "E-CONV-002",
    "the gas of this case has no particles",
    where="key gas.model",
    why="it is {model!r}",
    remedy='set gas.model = "corpuscular", or give --set gas.model=corpuscular',
)
OTHER_CASE = InputError.declare(
    "E-CONV-003",
    "the folder holds something else",
    where="{folder}",
    why="its case is not the one given, so its runs cannot be compared with new ones",
    cause="the case was changed since its first runs, or the folder belongs to something else",
    remedy="choose another folder with --out, or delete this one",
)

CASE_FILE = "case.toml"


@dataclass(frozen=True)
class Sweep:
    """case: with any number of particles; counts: of particles, ascending; seeds: 1 to so many, for each count."""

    case: Case
    counts: tuple[int, ...]
    seeds: int

    @classmethod
    def of(cls, case: Case, counts: Iterable[float], seeds: int) -> Sweep:
        """Raises InputError E-CONV-001 (nothing to compare), E-CONV-002 (no particles), and those of the case."""
        counts = tuple(sorted({round(count) for count in counts}))
        if len(counts) < 2 or seeds < 2:
            raise NOTHING_TO_COMPARE(counts=",".join(map(str, counts)), seeds=seeds)
        if case.gas.model != "corpuscular":
            raise NO_PARTICLES(model=case.gas.model)
        sweep = cls(case, counts, seeds)
        for count in counts:
            sweep.case_of(count, 1)  # a count outside the range is refused before the first run
        return sweep

    def case_of(self, count: int, seed: int) -> Case:
        """The case of one run."""
        return self.case.vary({"gas.particles": count, "gas.seed": seed})

    def names(self) -> list[tuple[int, int, str]]:
        """Count, seed and folder name of every run, the quick ones first."""
        return [(n, s, f"{n}_seed{s}") for n in self.counts for s in range(1, self.seeds + 1)]


def make_runs(
    sweep: Sweep, folder: Path, progress: Callable[[int, int, str], None], threads: int | None = None
) -> tuple[dict[int, list[Result]], dict[str, str]]:
    """Make the runs that are missing, one after the other: count -> completed results, and name -> why it was stopped.

    progress: called with runs done, all runs, and what comes next.
    Raises InputError E-CONV-003 if the folder holds another case, and errors of the machine as `simulate`.
    """
    _claim(folder, sweep.case)
    runs: dict[int, list[Result]] = {count: [] for count in sweep.counts}
    failed: dict[str, str] = {}
    names = sweep.names()
    for done, (count, seed, name) in enumerate(names):
        progress(done, len(names), f"{count} particles, seed {seed}")
        result = _make(sweep.case_of(count, seed), folder / "runs" / name, threads)
        if result.status == "completed":
            runs[count].append(result)
        else:
            failed[name] = result.record["reason"] or result.status
    progress(len(names), len(names), "comparison")
    return runs, failed


def _make(case: Case, folder: Path, threads: int | None) -> Result:
    if folder.is_dir():
        found = Result.open(folder)
        if found.record["case_digest"] != case.digest():
            raise OTHER_CASE(folder=folder)
        return found
    try:
        if any(folder.with_name(folder.name + ".partial").glob("checkpoint_*")):
            return resume(folder, threads=threads)
        return simulate(case, folder, threads=threads)
    except NumericalStop:  # published with its reason; the others go on
        return Result.open(folder)


def _claim(folder: Path, case: Case) -> None:
    path = folder / CASE_FILE
    if not path.exists():
        (folder / "runs").mkdir(parents=True, exist_ok=True)
        keep_case(case, folder)
    with contextlib.suppress(BillowError):
        if Case.load(path).digest() == case.digest():
            return
    raise OTHER_CASE(folder=folder)
