"""How good a coupled model is on unseen runs: ratings of ISO/TS 18571, and injury metrics beside the solver's."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from billow.errors import InputError
from billow.injury.criteria import GRAVITY
from billow.injury.motion import Injury, assess
from billow.injury.rating import Rating, rate
from billow.rom.coupled import Coupled
from billow.rom.impactor_motion import ImpactorMotion

Z = 2
QUANTITIES = ("acceleration CFC 60", "acceleration CFC 180", "velocity", "displacement")


@dataclass(frozen=True, eq=False)
class CoupledEvaluation:
    """Of every unseen run, in the order of `runs`; all along z, the axis of the bag.

    ratings: name of a quantity of `QUANTITIES` -> ratings against the solver
    typical: the same for the mean motion of all training runs, which ignores the design
    solver, coupled: injury metrics of both
    seconds: median wall time of one coupled deployment
    """

    runs: tuple[str, ...]
    ratings: dict[str, tuple[Rating, ...]]
    typical: dict[str, tuple[Rating, ...]]
    solver: tuple[Injury, ...]
    coupled: tuple[Injury, ...]
    seconds: float

    def median(self, quantity: str, typical: bool = False) -> float:
        """Median overall rating: [-]."""
        return float(np.median([r.overall for r in (self.typical if typical else self.ratings)[quantity]]))

    def worst(self, quantity: str, typical: bool = False) -> float:
        """Worst overall rating: [-]."""
        return min(r.overall for r in (self.typical if typical else self.ratings)[quantity])

    def record(self) -> dict:
        """For metrics.json: HIC in g^2.5 s, accelerations in g."""
        return {
            "runs": list(self.runs),
            "nothing_known_in_advance": True,
            "iso_18571": {
                q: {
                    "median": self.median(q),
                    "worst": self.worst(q),
                    "median_of_mean_motion": self.median(q, typical=True),
                    "worst_of_mean_motion": self.worst(q, typical=True),
                    "scores": [asdict(r) | {"overall": r.overall} for r in self.ratings[q]],
                }
                for q in QUANTITIES
            },
            "injury": [
                {"run": run, "solver": injury_record(s), "coupled": injury_record(c)}
                for run, s, c in zip(self.runs, self.solver, self.coupled, strict=True)
            ],
            "seconds_per_deployment": self.seconds,
        }


def evaluate_coupled(
    dataset, coupled: Coupled, progress: Callable[[int, int, str], None] | None = None
) -> CoupledEvaluation:
    """Deploy every unseen run of the dataset and compare with the solver.

    progress: called as progress(done, total, run)
    Raises InputError E-ROM-015 without unseen runs, E-INJ-003 if histories are too coarse for injury metrics.
    """
    if not dataset.test:
        raise InputError(
            "E-ROM-015",
            "there are no unseen runs to compare with",
            where=coupled.surrogate.title or "dataset",
            why="the dataset has no completed test run",
            remedy="ask for test runs in study.toml, or finish the study: billow study STUDY.toml --out FOLDER",
        )
    name = coupled.impactor.name
    seen = [ImpactorMotion.of_run(dataset.result(run), name) for run in coupled.surrogate.training["runs"]]
    mean = ImpactorMotion(seen[0].times, *(np.mean([getattr(m, n) for m in seen], 0) for n in ("centre", "velocity")))
    ratings, typical = ({q: [] for q in QUANTITIES} for _ in range(2))
    solver, answers, seconds = [], [], []
    for done, (run, design) in enumerate(zip(dataset.test, dataset.design(dataset.test), strict=True)):
        if progress is not None:
            progress(done, len(dataset.test), f"run {run}")
        truth = ImpactorMotion.of_run(dataset.result(run), name)
        begun = time.perf_counter()
        motion = coupled.deploy(design)
        seconds.append(time.perf_counter() - begun)
        for quantity in QUANTITIES:
            ratings[quantity].append(_rating(quantity, motion, truth))
            typical[quantity].append(_rating(quantity, mean, truth))
        solver.append(assess(truth.times, truth.velocity))
        answers.append(assess(motion.times, motion.velocity))
    return CoupledEvaluation(
        runs=tuple(dataset.test),
        ratings={q: tuple(r) for q, r in ratings.items()},
        typical={q: tuple(r) for q, r in typical.items()},
        solver=tuple(solver),
        coupled=tuple(answers),
        seconds=float(np.median(seconds)),
    )


def injury_record(injury: Injury) -> dict:
    """Plain numbers: HIC in g^2.5 s, accelerations in g."""
    return {
        "hic15": injury.hic15.value,
        "hic36": injury.hic36.value,
        "clip_3ms_g": injury.clip / GRAVITY,
        "contiguous_clip_3ms_g": injury.contiguous_clip / GRAVITY,
        "peak_g": injury.peak / GRAVITY,
    }


def _rating(quantity: str, motion: ImpactorMotion, truth: ImpactorMotion) -> Rating:
    return rate(_times(quantity, truth), _curve(quantity, motion), _curve(quantity, truth))


def _times(quantity, motion):
    return motion.acceleration()[0] if quantity.startswith("acceleration") else motion.times


def _curve(quantity, motion):
    if quantity.startswith("acceleration"):
        return motion.acceleration(int(quantity.split()[-1]))[1][:, Z]
    return getattr(motion, quantity)[:, Z]
