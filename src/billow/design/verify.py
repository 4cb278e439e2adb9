"""An optimum is run in the solver before it is called one: it is added to the study and the surfaces are made again, at
most so many rounds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.design.measures import measure
from billow.design.optimum import Goal, Optimum, optimise
from billow.design.robust import scattered
from billow.design.surfaces import ResponseSurfaces
from billow.results.dataset import Dataset
from billow.rom.surrogate.design_space import from_unit, to_unit
from billow.study.study import Study

NO_RUN = InputError.declare(
    "E-DES-033",
    "the optimum could not be simulated",
    where="{folder}, run {run}",
    cause="a design at which the case does not hold, or at which the run is in doubt",
    remedy="see what the study says of run {run}; exclude such designs by a limit or a narrower range",
)
MOST_ROUNDS = 3


@dataclass(frozen=True, eq=False)
class Round:
    """One proposal and what the solver said. optimum; run: its name in the study; computed: response -> value of the
    solver; doubts: criteria of quality that the run did not pass"""

    optimum: Optimum
    run: str
    computed: dict[str, float]
    doubts: tuple[str, ...] = ()

    def inside(self, name: str) -> bool:
        """Whether a computed value lies in its predicted interval."""
        _, low, high = self.optimum.responses[name]
        return bool(low <= self.computed[name] <= high)

    @property
    def outside(self) -> list[str]:
        """Responses whose computed values lie outside their intervals: of ten of 90 % it is one on average."""
        return [name for name in self.optimum.responses if not self.inside(name)]

    @property
    def broken(self) -> list[str]:
        """Limits of the goal that the computed values do not keep to."""
        goal = self.optimum.goal
        return [name for name, limit in goal.below.items() if not self.computed[name] <= limit] + [
            name for name, limit in goal.above.items() if not self.computed[name] >= limit
        ]

    @property
    def holds(self) -> bool:
        """Whether the run is sound, the goal lies in its interval, and all limits are kept."""
        return not self.doubts and not self.broken and self.inside(self.optimum.goal.response)


def verified(
    surfaces: ResponseSurfaces,
    goal: Goal,
    folder: str | Path,
    rounds: int = MOST_ROUNDS,
    progress: Callable[[str], None] | None = None,
) -> tuple[list[Round], ResponseSurfaces]:
    """Optimise, run the optimum in the study's folder, and make the surfaces again with it, until one holds.

    Returns the rounds and the last surfaces. InputError E-DES-033: the optimum did not run; errors as `optimise`,
    `respond` and `Study.run`.
    """
    made: list[Round] = []
    for number in range(min(rounds, MOST_ROUNDS)):
        optimum = optimise(surfaces, goal, unsound(folder, surfaces))
        study = Study.open(folder)
        row = tuple(
            v.stepped(value) for v, value in zip(study.definition.variables, optimum.design.values(), strict=True)
        )
        study, run = study.with_run(row)
        study.run(workers=1)
        dataset = Dataset.open(folder)
        if run in dataset.missing:
            raise NO_RUN(folder=folder, run=run, why=dataset.missing[run])
        result = dataset.result(run)
        computed = {response.name: measure(result, response, Path(folder)) for response in surfaces.responses}
        made.append(Round(optimum, run, computed, dataset.doubts(run)))
        surfaces = ResponseSurfaces.train(folder, surfaces.responses)
        if progress is not None:
            progress(_line(number + 1, made[-1], surfaces))
        if made[-1].holds:
            break
    return made, surfaces


@dataclass(frozen=True)
class Shift:
    """Runs near one design against the surface before it knew them: mean of computed less predicted, and the standard
    error of that mean, in the response's unit."""

    response: str
    mean: float
    error: float


def scatter_runs(
    surfaces: ResponseSurfaces,
    design: Mapping[str, float],
    scatter: Mapping[str, float],
    folder: str | Path,
    count: int,
    seed: int = 0,
) -> tuple[list[Shift], ResponseSurfaces]:
    """Run so many designs of the scatter about a design in the study's folder, and make the surfaces again with them.

    Near one design the error of a surface is much the same everywhere, and moves a chance of exceeding a limit far; a
    dozen runs there show it. InputError E-DES-040, -041: the scatter; E-DES-033: fewer than two runs are sound; errors
    as `respond` and `Study.run`.
    """
    unit, _ = scattered(surfaces, design, scatter, count, seed)
    study = Study.open(folder)
    names = []
    for row in from_unit(unit, surfaces.parameters):
        values = tuple(v.stepped(value) for v, value in zip(study.definition.variables, row, strict=True))
        study, run = study.with_run(values)
        names.append(run)
    study.run()
    again = ResponseSurfaces.train(folder, surfaces.responses)
    rows = [again.runs.index(run) for run in dict.fromkeys(names) if run in again.runs]
    if len(rows) < 2:
        raise NO_RUN(folder=folder, run=names[0], why=f"of {count} runs about the design {len(rows)} are sound")
    shifts = []
    for k, surface in enumerate(surfaces.surfaces):
        computed = again.values[rows, k]
        if surface.verdict.usable and np.isfinite(computed).all():
            away = computed - surface.value(to_unit(again.designs[rows], surfaces.parameters))
            error = float(away.std(ddof=1) / np.sqrt(len(rows)))
            shifts.append(Shift(surfaces.names[k], float(away.mean()), error))
    return shifts, again


def unsound(folder: str | Path, surfaces: ResponseSurfaces) -> np.ndarray:
    """Training designs whose runs failed or are in doubt, (designs, parameters) in [0, 1]."""
    dataset = Dataset.open(folder)
    return to_unit(dataset.design([run for run in dataset.left_out if run in dataset.train or _failed(dataset, run)]),
                   surfaces.parameters)  # fmt: skip


def _failed(dataset: Dataset, run: str) -> bool:
    return dataset.missing.get(run, "not run yet") != "not run yet"


def _line(number: int, one: Round, surfaces: ResponseSurfaces) -> str:
    name = one.optimum.goal.response
    value, low, high = one.optimum.responses[name]
    held = "inside" if one.inside(name) else "outside"
    others = [other for other in one.outside if other != name]
    held += f"; outside their intervals, too: {', '.join(others)}" if others else ""
    broken = f"; broken: {', '.join(one.broken)}" if one.broken else ""
    doubts = f"; in doubt: {', '.join(one.doubts)}" if one.doubts else ""
    return (
        f"round {number}, run {one.run}: {name} predicted {value:.4g} ({low:.4g} to {high:.4g}), "
        f"computed {one.computed[name]:.4g} {surfaces.unit(name)}, {held}{broken}{doubts}"
    )
