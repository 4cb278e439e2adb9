"""How far a coupled model's answers may be off, and whether it beats ignoring the design: from models that each learn
without one fold of the training runs, and answer for its designs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from billow.injury.criteria import assess
from billow.rom.coupled.impactor import ImpactorMotion
from billow.rom.coupled.injury_metrics import InjuryModel, learn_injury, least_factor, metric_values
from billow.rom.coupled.motion_errors import CURVES, compare_ratings, mean_motion, rate_motion
from billow.rom.surrogate.basis import Z
from billow.rom.surrogate.judgement import HELD_OUT, Judgement

Deploy = Callable[[np.ndarray], ImpactorMotion]
"""From a design (parameters,) to a motion."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """half_widths: name of `CURVES` -> (times, 3), of the interval of level `LEVEL` at each time and axis
    injury: of the injury metrics; of_injury: the judgement of them"""

    half_widths: dict[str, np.ndarray]
    injury: InjuryModel
    of_injury: Judgement


def calibrate(
    runs: tuple[str, ...],
    designs: np.ndarray,
    parameters,
    motions: list[ImpactorMotion],
    folds: list[tuple[str, ...]],
    learn_without: Callable[[tuple[str, ...]], Deploy],
) -> tuple[Calibration, Judgement | None]:
    """What is known of a model of `runs`, and the judgement of its motion, None if no run has a body that is pushed.

    designs: (runs, parameters); motions: of the solver, of each run; learn_without: a model that has not seen a fold
    Raises InputError E-INJ-003 if histories are too coarse for injury metrics.
    """
    values = np.array([metric_values(assess(motion.times, motion.velocity)) for motion in motions])
    errors, held_out, own, mean = {name: [] for name in CURVES}, [], [], []
    for fold in folds:
        deploy, rows = learn_without(fold), [runs.index(run) for run in fold]
        average = mean_motion([motion for run, motion in zip(runs, motions, strict=True) if run not in fold])
        answers = [deploy(designs[row]) for row in rows]
        held_out.append((rows, np.array([metric_values(assess(a.times, a.velocity)) for a in answers])))
        for row, answer in zip(rows, answers, strict=True):
            truth = motions[row]
            for name, curve in CURVES.items():
                errors[name].append(curve(answer) - curve(truth))
            if np.ptp(truth.velocity[:, Z]) > 0.0:  # a body that nothing pushes has no curve to rate
                own.append(rate_motion(answer, truth))
                mean.append(rate_motion(average, truth))
    count = sum(map(len, folds))
    injury, compared = learn_injury(designs, values, held_out, parameters)
    widths = {name: least_factor(np.array(of_one)) for name, of_one in errors.items()}
    judgement = Judgement(HELD_OUT, len(own), compare_ratings(own, mean)) if own else None
    return Calibration(widths, injury, Judgement(HELD_OUT, count, tuple(compared))), judgement
