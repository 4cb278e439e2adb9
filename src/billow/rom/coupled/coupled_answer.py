"""One answer of a coupled model, with how far it can be trusted, in memory and as text."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.rom.coupled.impactor import ImpactorMotion
from billow.rom.coupled.injury_metrics import LEVEL, METRICS, Estimate
from billow.rom.surrogate.basis import Z
from billow.rom.surrogate.design_space import Standing
from billow.rom.surrogate.judgement import Judgement
from billow.rom.surrogate.prediction import describe_judgement, describe_standing, standing_record


@dataclass(frozen=True, eq=False)
class CoupledAnswer:
    """name: of the obstacle; motion: how it moves
    half_widths: name of `CURVES` -> (times, 3), of intervals that hold the solver's value with probability `LEVEL` at
        each time and axis; None if the model has none
    injury: key of `METRICS` -> estimate with its interval; standing: of the design among those learned from
    judgement: of the motion; of_injury: of the metrics, on runs that were not learned from; None if nobody looked
    """

    name: str
    motion: ImpactorMotion
    half_widths: dict[str, np.ndarray] | None
    injury: dict[str, Estimate]
    standing: Standing | None
    judgement: Judgement | None
    of_injury: Judgement | None


def describe_answer(answer: CoupledAnswer, insisted: bool) -> str:
    """Lines for people. insisted: show metrics that are not usable too."""
    lines = [f"{answer.name}:"]
    for name, metric in answer.injury.items():
        shown = f"  {METRICS[name]:<26}"
        if metric.low is None:
            lines.append(f"{shown} {metric.value:<9.4g} no interval")
        elif metric.usable or insisted:
            not_usable = "" if metric.usable else "; NOT USABLE, see the verdict"
            interval = f"{metric.low:.4g} to {metric.high:.4g} ({100 * LEVEL:.0f} %), {metric.source}"
            lines.append(f"{shown} {metric.value:<9.4g} {interval}{not_usable}")
        else:
            lines.append(f"{shown} not usable, see the verdict")
    end = f"{answer.motion.velocity[-1, Z]:.2f}"
    off = "no interval" if answer.half_widths is None else f"± {answer.half_widths['velocity'][-1, Z]:.2f}"
    lines.append(f"  {'speed at the end [m/s]':<26} {end:<9} {off}")
    lines += describe_standing(standing_record(answer.standing))
    lines.append(f"motion {describe_judgement(answer.judgement, 'billow couple evaluate STUDY')}")
    if answer.of_injury is not None:
        told = describe_judgement(answer.of_injury, "billow couple evaluate STUDY")
        lines.append(f"injury {told if answer.of_injury.lost else told.split(';')[0]}")
    return "\n".join(lines)
