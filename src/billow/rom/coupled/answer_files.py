"""One answer of a coupled model on disk: motion as CSV, injury metrics, a figure."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from matplotlib.figure import Figure

from billow.injury.criteria import GRAVITY
from billow.results.atomic import write_atomically
from billow.results.histories import TIME, column_names, write_histories
from billow.rom.coupled.coupled_answer import CoupledAnswer
from billow.rom.coupled.impactor import ImpactorMotion
from billow.rom.coupled.injury_metrics import LEVEL
from billow.rom.coupled.motion_errors import CURVES
from billow.rom.judge.figures import draw, new_figure
from billow.rom.surrogate.basis import Z
from billow.rom.surrogate.prediction import standing_record

SHOWN_CLASS = 60
"""Channel frequency class of the accelerations that are drawn."""


def write_answer(answer: CoupledAnswer, folder: str | Path) -> dict:
    """Write motion.csv, injury.json and motion.svg into a folder and return the content of injury.json.

    Columns as in the histories of a run: "NAME_centre_x [m]" and so on, and "NAME_centre_half_width_x [m]" for the
    intervals; accelerations are means over the interval that ends at the row, the first row repeats the second.
    """
    folder, motion = Path(folder), answer.motion
    folder.mkdir(parents=True, exist_ok=True)
    columns = {TIME: motion.times}
    for title, unit in (("centre", "m"), ("velocity", "m/s"), ("acceleration", "m/s^2")):
        columns |= zip(column_names(answer.name, title, unit, 3), CURVES[title](motion).T, strict=True)
        if answer.half_widths is not None:
            widths = answer.half_widths[title]
            columns |= zip(column_names(answer.name, f"{title}_half_width", unit, 3), widths.T, strict=True)
    write_histories(folder / "motion.csv", columns)
    found = {
        "injury": {name: asdict(metric) for name, metric in answer.injury.items()},
        "level": LEVEL,
        "standing": standing_record(answer.standing),
        "judgement_of_motion": answer.judgement and answer.judgement.record(),
        "judgement_of_injury": answer.of_injury and answer.of_injury.record(),
    }
    write_atomically(folder / "injury.json", json.dumps(found, indent=1, allow_nan=False) + "\n")
    write_atomically(folder / "motion.svg", draw(_figure, answer))
    return found


def _figure(answer: CoupledAnswer) -> Figure:
    """Acceleration, velocity and displacement along the bag's axis, with their intervals."""
    figure, panels = new_figure(10.5, 3.2, 3)
    plot_motion(panels, answer.motion, answer.half_widths)
    return figure


def plot_motion(panels, motion: ImpactorMotion, half_widths=None, **style) -> None:
    """Acceleration, velocity and displacement along the bag's axis against time in three panels; half_widths: shaded,
    as in `CoupledAnswer`."""
    middles, acceleration = motion.acceleration(SHOWN_CLASS)
    curves = (
        (f"acceleration, CFC {SHOWN_CLASS} [g]", f"acceleration CFC {SHOWN_CLASS}", middles, acceleration, 1 / GRAVITY),
        ("velocity [m/s]", "velocity", motion.times, motion.velocity, 1.0),
        ("displacement [mm]", "centre", motion.times, motion.displacement, 1e3),
    )
    for axes, (label, name, times, values, factor) in zip(panels, curves, strict=True):
        times, values = 1e3 * times, factor * values[:, Z]
        (line,) = axes.plot(times, values, **style)
        if half_widths is not None:
            width = factor * half_widths[name][-len(values) :, Z]  # that of a mean stands at the end of its interval
            axes.fill_between(times, values - width, values + width, color=line.get_color(), alpha=0.2, linewidth=0)
        axes.set(xlabel="time [ms]", ylabel=label)
