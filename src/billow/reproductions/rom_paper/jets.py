"""The effect of the jet direction in two gas models: two studies of the same designs, compared by the bag's shape.

In each study the height of every node at every time is fitted by a plane over the designs (least squares, each range
scaled to [0, 1]); the slope along the jet direction is what the whole range of it does to the shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from billow.base.errors import InputError
from billow.base.plot_style import GREY
from billow.reproductions.rom_paper.tables import Table
from billow.results.dataset_files import same_times
from billow.rom.judge.figures import AXES, MILLI, new_figure
from billow.rom.learn.dataset import Dataset
from billow.rom.surrogate.basis import Z
from billow.rom.surrogate.design_space import to_unit

NOT_COMPARABLE = InputError.declare(
    "E-ROM-022",
    "the two studies cannot be compared",
    where="{one} and {other}",
    cause="their parameters, meshes, times or designs differ, or they have too few runs in common",
    remedy="make two studies from one study file and two cases that differ in the gas model alone",
)

RINGS = 24
"""Rings of nodes around the axis over which a shape is averaged for the figure."""


@dataclass(frozen=True, eq=False)
class JetComparison:
    """names: of the two studies; runs: that both have; times: [s], (times,)
    effect: [m], (2, times, nodes), change of height over the whole range of the jet direction
    radius: [m], (nodes,), from the bag's axis in the start shape
    difference: [m], (runs, times), RMSE over nodes between heights of the two studies
    """

    names: tuple[str, str]
    runs: tuple[str, ...]
    label: str
    times: np.ndarray
    radius: np.ndarray
    effect: np.ndarray
    difference: np.ndarray

    @property
    def strength(self) -> np.ndarray:
        """Root mean square over nodes of the effect: [m], (2, times)."""
        return np.sqrt(np.square(self.effect).mean(axis=2))

    @property
    def likeness(self) -> np.ndarray:
        """Cosine between the two effects as fields: [-], (times,); 1 the same shape, 0 nothing in common."""
        size = np.linalg.norm(self.effect, axis=2).prod(axis=0)
        product = (self.effect[0] * self.effect[1]).sum(axis=1)
        return np.divide(product, size, out=np.zeros_like(size), where=size > 0.0)

    @property
    def strongest(self) -> int:
        """Index of the time at which the two together see most of the jet direction."""
        return int(self.strength.sum(axis=0).argmax())

    def table(self) -> Table:
        """At a few times and at the strongest moment."""
        count, rows = len(self.times), []
        for step in sorted({*(np.linspace(count / 5, count, 5).round().astype(int) - 1).tolist(), self.strongest}):
            effects = zip(self.names, MILLI * self.strength[:, step], strict=True)
            cells = {"time [ms]": MILLI * self.times[step]} | {f"{name} [mm]": effect for name, effect in effects}
            between = MILLI * self.difference[:, step].mean()
            rows.append(cells | {"likeness [-]": self.likeness[step], "between the two [mm]": between})
        caption = (
            f"{len(self.runs)} designs that are in both studies. Effect: root mean square over nodes. Likeness: "
            "cosine of the two effects as fields. Last column: RMSE between the heights of one design, mean."
        )
        return Table("jets", f"What the whole range of {self.label.lower()} does to the height", caption, rows)

    def figure(self) -> Figure:
        """Strength over time, and the effect along the radius at its strongest."""
        figure, (left, right) = new_figure(9.0, 3.7, 2)
        ring = np.minimum((self.radius / self.radius.max() * RINGS).astype(int), RINGS - 1)
        count = np.bincount(ring, minlength=RINGS)
        middle = MILLI * np.bincount(ring, self.radius, RINGS)[count > 0] / count[count > 0]
        for name, colour, strength, effect in zip(self.names, AXES[:2], self.strength, self.effect, strict=True):
            left.plot(MILLI * self.times, MILLI * strength, color=colour, label=name)
            profile = np.bincount(ring, effect[self.strongest], RINGS)[count > 0] / count[count > 0]
            right.plot(middle, MILLI * profile, color=colour)
        left.axvline(MILLI * self.times[self.strongest], color=GREY, lw=1, ls=":")
        left.set(xlabel="time [ms]", ylabel="effect on height, RMS over nodes [mm]", ylim=(0, None))
        right.set(xlabel="radius in the flat bag [mm]", ylabel="mean change of height [mm]")
        right.set_title(f"at {MILLI * self.times[self.strongest]:.0f} ms")
        left.legend()
        return figure

    def sentences(self) -> list[str]:
        """A summary in words."""
        step = self.strongest
        sizes = zip(self.strength[:, step], self.names, strict=True)
        first, second = (f"{MILLI * size:.2g} mm with {name}" for size, name in sizes)
        return [
            f"At {MILLI * self.times[step]:.3g} ms, where it matters most, the range of {self.label.lower()} "
            f"moves the fabric's height by {first} and by {second} "
            f"(root mean square over nodes); as fields the two changes have a cosine of {self.likeness[step]:.2f}. The "
            f"same design differs by {MILLI * self.difference.mean():.2g} mm in height between the two, mean over time."
        ]


def compare_jets(one: Dataset, other: Dataset, names: tuple[str, str], parameter: str) -> JetComparison:
    """Compare two datasets of equal designs, meshes and times that differ in the gas model.

    parameter: name of the jet direction among their parameters
    InputError E-ROM-022 if they do not belong together or have too few runs in common for a plane.
    """
    runs = tuple(run for run in (*one.train, *one.test) if run in {*other.train, *other.test})
    labels = {p.name: p.label for p in one.parameters}
    fewest = len(labels) + 2
    if labels.keys() != {p.name for p in other.parameters} or parameter not in labels:
        why = f"both need the same parameters, {parameter} among them"
    elif one.reference.shape != other.reference.shape or not np.allclose(one.reference, other.reference, atol=1e-6):
        why = "their start meshes differ"
    elif not same_times(one.times, other.times):
        why = "their times differ"
    elif len(runs) < fewest:
        why = f"they have {len(runs)} runs in common, and {len(labels)} parameters need {fewest}"
    elif not np.allclose(one.design(runs), other.design(runs), rtol=1e-8):
        why = "runs of the same name have different designs"
    else:
        design = to_unit(one.design(runs), one.parameters)
        plane = np.column_stack([np.ones(len(runs)), design])
        slope = np.linalg.pinv(plane)[1 + list(labels).index(parameter)]  # (runs,): heights -> slope
        effect = np.zeros((2, len(one.times), len(one.reference)))
        difference = []
        for weight, run in zip(slope, runs, strict=True):
            heights = [d.snapshots("displacement", [run])[0, ..., Z].astype(float) for d in (one, other)]
            effect += weight * np.stack(heights)
            difference.append(np.sqrt(np.square(heights[0] - heights[1]).mean(axis=1)))
        radius = np.hypot(one.reference[:, 0], one.reference[:, 1]).astype(float)
        times = np.asarray(one.times, float)
        return JetComparison(names, runs, labels[parameter], times, radius, effect, np.array(difference))
    raise NOT_COMPARABLE(one=names[0], other=names[1], why=why)
