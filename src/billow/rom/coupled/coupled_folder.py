"""Answers of a coupled model on disk: motion as CSV, injury metrics, a figure."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from billow.injury.criteria import GRAVITY
from billow.injury.motion import assess
from billow.results.atomic import write_atomically
from billow.results.histories import TIME, column_names, write_histories
from billow.rom.coupled.coupled_evaluation import injury_record
from billow.rom.coupled.impactor import ImpactorMotion
from billow.rom.judge.figures import draw, new_figure
from billow.rom.surrogate.basis import Z

SHOWN_CLASS = 60
"""Channel frequency class of the accelerations that are drawn."""


def write_motion(motion: ImpactorMotion, name: str, folder: str | Path) -> dict:
    """Write motion.csv, injury.json and motion.svg into a folder and return the injury metrics.

    Columns as in the histories of a run: "NAME_centre_x [m]" and so on; accelerations are means over the interval that
    ends at the row, the first row repeats the second.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    _, acceleration = motion.acceleration()
    acceleration = np.vstack([acceleration[:1], acceleration])
    vectors = (
        ("centre", "m", motion.centre),
        ("velocity", "m/s", motion.velocity),
        ("acceleration", "m/s^2", acceleration),
    )
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
