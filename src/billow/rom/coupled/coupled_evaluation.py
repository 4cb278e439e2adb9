"""Accuracy of a coupled model on unseen runs, and one answer on disk: motion as CSV, injury metrics, a figure.

The coupled model uses nothing of the deployment in advance. It is compared with answers that use more, or less:

- `TRUE_CONTACT`: the body moves by the same steps under the contact force that the solver recorded, filtered as the
  forces that were learned. What is lost there is lost to steps, sampling and filter, not to bag or law.
- `TRUE_INPUTS`: the coupled model with the bag of a surrogate that gets the run's true nodal contact forces of the
  previous time. The force on the body still comes from the law.
- `MEAN_MOTION`: the mean motion of all training runs, which ignores the design.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from billow.injury.criteria import GRAVITY, Injury, assess
from billow.injury.rating import Rating, rate
from billow.results.atomic import write_atomically
from billow.results.histories import TIME, column_names, write_histories
from billow.rom.coupled.coupled_model import Coupled
from billow.rom.coupled.impactor import ImpactorMotion, recorded_force
from billow.rom.judge.evaluate import require_unseen
from billow.rom.judge.figures import draw, new_figure
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

SHOWN_CLASS = 60
"""Channel frequency class of the accelerations that are drawn."""

COUPLED = "coupled"
TRUE_INPUTS = "true forces as inputs of the bag"
TRUE_CONTACT = "true contact force"
MEAN_MOTION = "mean motion"


@dataclass(frozen=True, eq=False)
class CoupledEvaluation:
    """Of every unseen run, in the order of `runs`; all along z, the axis of the bag.

    ratings: answer (`COUPLED` and so on; `TRUE_INPUTS` only on request) -> name of a quantity of `QUANTITIES`
        -> ratings against the solver
    solver, coupled: injury metrics of both; seconds: median wall time of one coupled deployment
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

        def of(quantity, answer):
            scores = [asdict(r) | {"overall": r.overall} for r in self.ratings[answer][quantity]]
            return {"median": self.median(quantity, answer), "worst": self.worst(quantity, answer), "scores": scores}

        ratings = {answer: {q: of(q, answer) for q in QUANTITIES} for answer in self.ratings}
        injuries = zip(self.runs, self.solver, self.coupled, strict=True)
        return {
            "runs": list(self.runs),
            "nothing_known_in_advance": True,
            "iso_18571": ratings.pop(COUPLED),
            "iso_18571_of_other_answers": ratings,
            "injury": [{"run": r, "solver": injury_record(s), "coupled": injury_record(c)} for r, s, c in injuries],
            "seconds_per_deployment": self.seconds,
        }


def evaluate_coupled(
    dataset: Dataset, coupled: Coupled, progress: Announcement | None = None, *, with_forces: Surrogate | None = None
) -> CoupledEvaluation:
    """Deploy every unseen run of the dataset and compare with the solver.

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
    found = {answer: {q: tuple(r) for q, r in of.items()} for answer, of in ratings.items()}
    return CoupledEvaluation(tuple(dataset.test), found, tuple(solver), tuple(answers), float(np.median(seconds)))


def _bag_with_true_forces(dataset, run, surrogate: Surrogate, times) -> np.ndarray:
    """Nodes at `times`, predicted with the forces the solver found in this very run: [m], (times, nodes, 3). Forces are
    recorded at the trained times only; in between, those of the time before are taken as linear."""
    before = previous(dataset.snapshots("contact_force", [run]))[0]
    place = np.interp(times, surrogate.times, np.arange(len(surrogate.times)))
    first = np.minimum(place.astype(int), len(before) - 2)
    part = (place - first).astype(np.float32)[:, None, None]
    forces = (1 - part) * before[first] + part * before[first + 1]
    return surrogate.reference + surrogate.predict(dataset.design([run])[0], times, previous_forces=forces)


def injury_record(injury: Injury) -> dict:
    """Plain numbers: HIC in g^2.5 s, accelerations in g."""
    return {
        "hic15": injury.hic15.value,
        "hic36": injury.hic36.value,
        "clip_3ms_g": injury.clip / GRAVITY,
        "contiguous_clip_3ms_g": injury.contiguous_clip / GRAVITY,
        "peak_g": injury.peak / GRAVITY,
    }


def write_motion(motion: ImpactorMotion, name: str, folder: str | Path) -> dict:
    """Write motion.csv, injury.json and motion.svg into a folder and return the injury metrics.

    Columns as in the histories of a run: "NAME_centre_x [m]" and so on; accelerations are means over the interval that
    ends at the row, the first row repeats the second.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    means = motion.acceleration()[1]
    means = np.vstack([means[:1], means])
    vectors = ("centre", "m", motion.centre), ("velocity", "m/s", motion.velocity), ("acceleration", "m/s^2", means)
    columns = {TIME: motion.times}
    for title, unit, vector in vectors:
        columns |= zip(column_names(name, title, unit, 3), vector.T, strict=True)
    write_histories(folder / "motion.csv", columns)
    found = injury_record(assess(motion.times, motion.velocity))
    write_atomically(folder / "injury.json", json.dumps(found, indent=1) + "\n")
    write_atomically(folder / "motion.svg", draw(motion_figure, motion))
    return found


def motion_figure(motion: ImpactorMotion) -> Figure:
    """Acceleration, velocity and displacement along the bag's axis."""
    figure, panels = new_figure(10.5, 3.2, 3)
    plot_motion(panels, motion)
    return figure


def plot_motion(panels, motion: ImpactorMotion, **style) -> None:
    """Acceleration, velocity and displacement along the bag's axis against time in three panels."""
    middles, acceleration = motion.acceleration(SHOWN_CLASS)
    curves = {
        f"acceleration, CFC {SHOWN_CLASS} [g]": (middles, acceleration[:, Z] / GRAVITY),
        "velocity [m/s]": (motion.times, motion.velocity[:, Z]),
        "displacement [mm]": (motion.times, 1e3 * motion.displacement[:, Z]),
    }
    for axes, (label, (times, values)) in zip(panels, curves.items(), strict=True):
        axes.plot(1e3 * times, values, **style)
        axes.set(xlabel="time [ms]", ylabel=label)
