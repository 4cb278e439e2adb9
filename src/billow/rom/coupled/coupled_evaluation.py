"""Accuracy of a coupled model on unseen runs.

The coupled model uses nothing of the deployment in advance. It is compared with answers that use more, or less:

- `TRUE_CONTACT`: the body moves by the same steps under the contact force that the solver recorded, filtered as the
  forces that were learned. What is lost there is lost to steps, sampling and filter, not to bag or law.
- `TRUE_INPUTS`: the coupled model with the bag of a surrogate that gets the run's true nodal contact forces of the
  previous time. The force on the body still comes from the law.
- `MEAN_MOTION`: the mean motion of all training runs, which ignores the design.
"""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass

import numpy as np

from billow.injury.criteria import Injury, assess
from billow.injury.rating import Rating
from billow.rom.coupled.coupled_answer import CoupledAnswer
from billow.rom.coupled.coupled_model import Coupled
from billow.rom.coupled.impactor import ImpactorMotion, recorded_force
from billow.rom.coupled.injury_metrics import (
    LEVEL,
    METRICS,
    compare,
    compare_intervals,
    injury_record,
    metric_values,
    not_usable,
)
from billow.rom.coupled.motion_errors import (
    CURVES,
    MEAN_MOTION,
    QUANTITIES,
    compare_ratings,
    mean_motion,
    rate_motion,
)
from billow.rom.judge.unseen import UnseenRuns, unseen_runs
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.progress import Announcement, Announcer
from billow.rom.surrogate.basis import Z
from billow.rom.surrogate.force_inputs import previous
from billow.rom.surrogate.judgement import UNSEEN, Judgement
from billow.rom.surrogate.surrogate import Surrogate

COUPLED = "coupled"
TRUE_INPUTS = "true forces as inputs of the bag"
TRUE_CONTACT = "true contact force"


@dataclass(frozen=True, eq=False)
class CoupledEvaluation:
    """Of every unseen run, in the order of `runs`; motions along z, the axis of the bag.

    ratings: answer (`COUPLED` and so on; `TRUE_INPUTS` only on request) -> name of a quantity of `QUANTITIES`
        -> ratings against the solver
    unseen: which runs, and which not; solver, coupled: injury metrics of the solver's motions and of the coupled ones
    answers: of the model, with intervals; inside: name of `CURVES` -> part of the solver's values along z that lie
        inside their intervals; judgement, of_injury: of motion and metrics; inside and of_injury are None without
        intervals; seconds: median wall time of one coupled deployment
    """

    unseen: UnseenRuns
    ratings: dict[str, dict[str, tuple[Rating, ...]]]
    solver: tuple[Injury, ...]
    coupled: tuple[Injury, ...]
    answers: tuple[CoupledAnswer, ...]
    inside: dict[str, float] | None
    judgement: Judgement
    of_injury: Judgement | None
    seconds: float

    @property
    def runs(self) -> tuple[str, ...]:
        """The unseen runs, in the order of everything else."""
        return self.unseen.runs

    def injury_errors(self) -> dict[str, dict[str, float]]:
        """Of each key of `METRICS`: median and largest error of the answers, relative to the solver, and the part of
        the runs whose interval holds the solver's value; that part is missing without intervals."""
        truth = np.array([metric_values(of_run) for of_run in self.solver])
        found = {}
        for k, name in enumerate(METRICS):
            answers = [answer.injury[name] for answer in self.answers]
            known = np.maximum(truth[:, k], 1e-300)
            off = np.abs(np.array([answer.value for answer in answers]) / known - 1.0)
            found[name] = {"median_error": float(np.median(off)), "largest_error": float(off.max())}
            if self.of_injury is not None:
                held = [one.low <= value <= one.high for one, value in zip(answers, truth[:, k], strict=True)]
                found[name]["inside"] = float(np.mean(held))
        return found

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
            "injury_answers": [{name: asdict(one) for name, one in a.injury.items()} for a in self.answers],
            "injury_errors": self.injury_errors(),
            "motion_inside_intervals": self.inside,
            "judgement_of_motion": self.judgement.record(),
            "judgement_of_injury": self.of_injury and self.of_injury.record(),
            "left_out": self.unseen.left_out,
            "reviewed": self.unseen.reviewed,
            "seconds_per_deployment": self.seconds,
        }


def evaluate_coupled(
    dataset: Dataset, coupled: Coupled, progress: Announcement | None = None, *, with_forces: Surrogate | None = None
) -> CoupledEvaluation:
    """Deploy every unseen run of the dataset and compare with the solver.

    with_forces: a surrogate of the same runs with contact forces as inputs, whose bag gives `TRUE_INPUTS`
    Raises InputError E-ROM-015 without unseen runs, E-INJ-003 if histories are too coarse for injury metrics.
    """
    unseen = unseen_runs(dataset)
    coupled, name = coupled.despite_verdict(), coupled.impactor.name
    announce = Announcer(progress, len(unseen.runs))
    seen = [ImpactorMotion.of_run(dataset.result(run), name) for run in coupled.surrogate.runs]
    mean = mean_motion(seen)
    ratings: dict[str, list[dict[str, Rating]]] = {}
    truths, answers, seconds = [], [], []
    for run, design in zip(unseen.runs, dataset.design(unseen.runs), strict=True):
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
            ratings.setdefault(answer, []).append(rate_motion(moved, truth))
        truths.append(truth)
        answers.append(coupled.answer(design))
    inside = None
    if coupled.calibration is not None:
        inside = {name: _inside(answers, truths, name) for name in CURVES}
    solver = tuple(assess(truth.times, truth.velocity) for truth in truths)
    return CoupledEvaluation(
        unseen=unseen,
        ratings={answer: {q: tuple(of_run[q] for of_run in of) for q in QUANTITIES} for answer, of in ratings.items()},
        solver=solver,
        coupled=tuple(assess(answer.motion.times, answer.motion.velocity) for answer in answers),
        answers=tuple(answers),
        inside=inside,
        judgement=Judgement(UNSEEN, len(unseen.runs), compare_ratings(ratings[COUPLED], ratings[MEAN_MOTION])),
        of_injury=_judge_injury(coupled, seen, solver, answers),
        seconds=float(np.median(seconds)),
    )


def describe_evaluation(found: CoupledEvaluation) -> str:
    """Lines for people: ratings beside other answers, errors and intervals of the metrics, which runs, the verdict."""
    lines = [f"{len(found.runs)} unseen runs; ISO/TS 18571 ratings against the solver, median and worst"]
    lines.append(f"  {'':<20} {'  '.join(f'{answer:<20}' for answer in found.ratings)}")
    lost = {one.measure for one in found.judgement.lost}
    for quantity in QUANTITIES:
        pairs = [f"{found.median(quantity, a):.3f}  {found.worst(quantity, a):.3f}" for a in found.ratings]
        worse = "worse than ignoring the design" if f"rating of {quantity}" in lost else ""
        lines.append(f"  {quantity:<20} {'  '.join(f'{pair:<20}' for pair in pairs)}  {worse}".rstrip())
    lines += [
        f"  {TRUE_CONTACT}: the same steps under the force the solver recorded: the best a perfect law can reach;",
        f"  {MEAN_MOTION}: mean of the training runs, which ignores the design",
    ]
    lines.append(f"injury metrics of the answers: median and largest error; {100 * LEVEL:.0f} % intervals that hold")
    lost = not_usable(found.of_injury) if found.of_injury else set()
    for name, errors in found.injury_errors().items():
        held = f"{errors['inside'] * len(found.runs):.0f} of {len(found.runs)}" if "inside" in errors else "no interval"
        off = f"{100 * errors['median_error']:.3g} %  {100 * errors['largest_error']:.3g} %"
        source = found.answers[0].injury[name].source
        worse = "; NOT USABLE" if METRICS[name] in lost else ""
        lines.append(f"  {METRICS[name]:<26} {off:<20} {held:<12} {source}{worse}")
    if found.inside is not None:
        parts = ", ".join(f"{name} {100 * part:.0f} %" for name, part in found.inside.items())
        lines.append(f"part of the solver's values along z inside their intervals: {parts}")
    return "\n".join(
        [*lines, *found.unseen.sentences(), f"motion {found.judgement}", f"one deployment takes {found.seconds:.3g} s"]
    )


def _inside(answers: list[CoupledAnswer], truths: list[ImpactorMotion], name: str) -> float:
    """Part of the values of a curve along z that lie inside their intervals."""
    pairs = zip(answers, truths, strict=True)
    off = [np.abs(CURVES[name](answer.motion) - CURVES[name](truth))[:, Z] for answer, truth in pairs]
    return float((np.array(off) <= answers[0].half_widths[name][:, Z]).mean())


def _judge_injury(coupled: Coupled, seen: list[ImpactorMotion], solver, answers) -> Judgement | None:
    """The metrics of the answers beside the mean of the training runs, None without intervals."""
    if coupled.calibration is None:
        return None
    logs = coupled.calibration.injury.logs
    values = np.array([metric_values(of_run) for of_run in solver])
    own = logs(np.array([[metric.value for metric in answer.injury.values()] for answer in answers]))
    mean = logs(np.array([metric_values(assess(motion.times, motion.velocity)) for motion in seen])).mean(axis=0)
    off = (np.sqrt(np.square(guess - logs(values)).mean(axis=0)) for guess in (own, mean))
    low, high = (np.array([[getattr(m, end) for m in a.injury.values()] for a in answers]) for end in ("low", "high"))
    held = ((low <= values) & (values <= high)).sum(axis=0)
    return Judgement(UNSEEN, len(answers), (*compare(*off), *compare_intervals(held, len(answers))))


def _bag_with_true_forces(dataset, run, surrogate: Surrogate, times) -> np.ndarray:
    """Nodes at `times`, predicted with the forces the solver found in this very run: [m], (times, nodes, 3). Forces are
    recorded at the trained times only; in between, those of the time before are taken as linear."""
    before = previous(dataset.snapshots("contact_force", [run]))[0]
    place = np.interp(times, surrogate.times, np.arange(len(surrogate.times)))
    first = np.minimum(place.astype(int), len(before) - 2)
    part = (place - first).astype(np.float32)[:, None, None]
    forces = (1 - part) * before[first] + part * before[first + 1]
    return surrogate.reference + surrogate.predict(dataset.design([run])[0], times, previous_forces=forces)
