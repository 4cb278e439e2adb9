"""Accuracy of a coupled model on unseen runs: ratings of ISO/TS 18571, and injury metrics next to the solver's.

The coupled model uses nothing of the deployment in advance. It is compared with answers that use more, or less:

- `TRUE_CONTACT`: the body moves by the same steps under the contact force that the solver recorded, filtered as the
  forces that were learned. What is lost there is lost to steps, sampling and filter, not to bag or law.
- `TRUE_INPUTS`: the coupled model with the bag of another surrogate, which gets the run's true nodal contact forces of
  the previous time (the ROM paper's "Model Including Forces"). The force on the body still comes from the law.
- `MEAN_MOTION`: the mean motion of all training runs, which ignores the design.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from billow.injury.criteria import GRAVITY
from billow.injury.motion import Injury, assess
from billow.injury.rating import Rating, rate
from billow.rom.coupled.coupled_model import Coupled
from billow.rom.coupled.impactor import ImpactorMotion, recorded_force
from billow.rom.judge.evaluate import require_unseen
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.progress import Announcement, Announcer
from billow.rom.surrogate.basis import Z
from billow.rom.surrogate.force_inputs import previous
from billow.rom.surrogate.surrogate import Surrogate

QUANTITIES: dict[str, Callable[[ImpactorMotion], tuple[np.ndarray, np.ndarray]]] = {
    "acceleration CFC 60": lambda motion: motion.acceleration(60),
    "acceleration CFC 180": lambda motion: motion.acceleration(180),
    "velocity": lambda motion: (motion.times, motion.velocity),
    "displacement": lambda motion: (motion.times, motion.displacement),
}
"""What is rated: name -> times [s], (samples,), and values, (samples, 3)."""

COUPLED = "coupled"
TRUE_INPUTS = "true forces as inputs of the bag"
TRUE_CONTACT = "true contact force"
MEAN_MOTION = "mean motion"


@dataclass(frozen=True, eq=False)
class CoupledEvaluation:
    """Of every unseen run, in the order of `runs`; all along z, the axis of the bag.

    ratings: answer (`COUPLED` and so on; `TRUE_INPUTS` only on request) -> name of a quantity of `QUANTITIES`
        -> ratings against the solver
    solver, coupled: injury metrics of both
    seconds: median wall time of one coupled deployment
    """

    runs: tuple[str, ...]
    ratings: dict[str, dict[str, tuple[Rating, ...]]]
    solver: tuple[Injury, ...]
    coupled: tuple[Injury, ...]
    seconds: float

    def overall(self, quantity: str, answer: str = COUPLED) -> np.ndarray:
        """Overall rating of each run: [-], (runs,)."""
        return np.array([rating.overall for rating in self.ratings[answer][quantity]])

    def median(self, quantity: str, answer: str = COUPLED) -> float:
        """Median overall rating: [-]."""
        return float(np.median(self.overall(quantity, answer)))

    def worst(self, quantity: str, answer: str = COUPLED) -> float:
        """Worst overall rating: [-]."""
        return float(self.overall(quantity, answer).min())

    def record(self) -> dict:
        """For metrics.json: HIC in g^2.5 s, accelerations in g."""
        ratings = {answer: {q: self._record(q, answer) for q in QUANTITIES} for answer in self.ratings}
        injuries = zip(self.runs, self.solver, self.coupled, strict=True)
        return {
            "runs": list(self.runs),
            "nothing_known_in_advance": True,
            "iso_18571": ratings.pop(COUPLED),
            "iso_18571_of_other_answers": ratings,
            "injury": [{"run": r, "solver": injury_record(s), "coupled": injury_record(c)} for r, s, c in injuries],
            "seconds_per_deployment": self.seconds,
        }

    def _record(self, quantity, answer) -> dict:
        scores = [asdict(r) | {"overall": r.overall} for r in self.ratings[answer][quantity]]
        return {"median": self.median(quantity, answer), "worst": self.worst(quantity, answer), "scores": scores}


def evaluate_coupled(
    dataset: Dataset,
    coupled: Coupled,
    progress: Announcement | None = None,
    *,
    with_forces: Surrogate | None = None,
) -> CoupledEvaluation:
    """Deploy every unseen run of the dataset and compare with the solver.

    progress: called as progress(done, total, run)
    with_forces: a surrogate of the same runs with contact forces as inputs, whose bag gives `TRUE_INPUTS`
    Raises InputError E-ROM-015 without unseen runs, E-INJ-003 if histories are too coarse for injury metrics.
    """
    require_unseen(dataset)
    announce = Announcer(progress, len(dataset.test))
    name = coupled.impactor.name
    seen = [ImpactorMotion.of_run(dataset.result(run), name) for run in coupled.surrogate.runs]
    mean = ImpactorMotion(seen[0].times, *(np.mean([getattr(m, n) for m in seen], 0) for n in ("centre", "velocity")))
    ratings: dict[str, dict[str, list[Rating]]] = {}
    solver, answers, seconds = [], [], []
    for run, design in zip(dataset.test, dataset.design(dataset.test), strict=True):
        announce(f"run {run}")
        result = dataset.result(run)
        truth = ImpactorMotion.of_run(result, name)
        begun = time.perf_counter()
        motion = coupled.deploy(design)
        seconds.append(time.perf_counter() - begun)
        motions = {COUPLED: motion}
        if with_forces is not None:
            bag = _bag_with_true_forces(dataset, run, with_forces, coupled.step_times)
            motions[TRUE_INPUTS] = coupled.deploy(design, bag=bag)
        motions[TRUE_CONTACT] = coupled.replay(design, recorded_force(result, name))
        motions[MEAN_MOTION] = mean
        for answer, moved in motions.items():
            for quantity, curve in QUANTITIES.items():
                times, reference = curve(truth)
                rating = rate(times, curve(moved)[1][:, Z], reference[:, Z])
                ratings.setdefault(answer, {}).setdefault(quantity, []).append(rating)
        solver.append(assess(truth.times, truth.velocity))
        answers.append(assess(motion.times, motion.velocity))
    return CoupledEvaluation(
        runs=tuple(dataset.test),
        ratings={answer: {q: tuple(r) for q, r in of.items()} for answer, of in ratings.items()},
        solver=tuple(solver),
        coupled=tuple(answers),
        seconds=float(np.median(seconds)),
    )


def _bag_with_true_forces(dataset, run, surrogate: Surrogate, times) -> np.ndarray:
    """Nodes at `times`, predicted with the forces the solver found in this very run: [m], (times, nodes, 3).

    Forces are recorded at the trained times only; in between, those of the time before are taken as linear.
    """
    before = previous(dataset.snapshots("contact_force", [run]))[0]
    place = np.interp(times, surrogate.times, np.arange(len(surrogate.times)))
    first = np.minimum(place.astype(int), len(before) - 2)
    part = (place - first).astype(np.float32)[:, None, None]
    forces = (1 - part) * before[first] + part * before[first + 1]
    design = dataset.design([run])[0]
    return surrogate.reference + surrogate.predict(design, times, previous_forces=forces)


def injury_record(injury: Injury) -> dict:
    """Plain numbers: HIC in g^2.5 s, accelerations in g."""
    return {
        "hic15": injury.hic15.value,
        "hic36": injury.hic36.value,
        "clip_3ms_g": injury.clip / GRAVITY,
        "contiguous_clip_3ms_g": injury.contiguous_clip / GRAVITY,
        "peak_g": injury.peak / GRAVITY,
    }
