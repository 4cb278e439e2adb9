"""Figures of a convergence study: how errors fall, the curves with their noise, and the final shapes overlaid."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, PercentFormatter

from billow.apps.converge.measures import Convergence, millisecond_means
from billow.base.plot_style import GREY, png, styled
from billow.pictures.section_figure import draw_bag
from billow.results.histories import History
from billow.results.result import Result
from billow.rom.judge.figures import MIDDLE

LINES = ("#0072b2", "#d55e00", "#0f9d76", "#8e5ea2", "#b8860b", "#4f5b66", "#c2185b")  # one for each quantity
FEW, MANY = np.array([0.61, 0.79, 0.91]), np.array([0.02, 0.15, 0.25])  # colours of few and of many particles
MILLI, KILO = 1e3, 1e-3


def draw_errors(found: Sequence[Convergence]) -> bytes:
    """Deviation and noise of one run over the number of particles, as PNG."""
    with styled():
        figure = Figure(figsize=(9.2, 4.2), layout="constrained")
        left, right = figure.subplots(1, 2, sharex=True, sharey=True)
        for one, colour in zip(found, itertools.cycle(LINES), strict=False):
            left.loglog(one.counts, one.deviation, "o-", color=colour, ms=4, label=one.quantity.name.split(" [")[0])
            right.loglog(one.counts, one.noise, "o-", color=colour, ms=4)
        counts = found[0].counts
        top = max(one.deviation[0] for one in found)
        for axes in (left, right):
            axes.loglog(counts, 1.3 * top * np.sqrt(counts[0] / counts), color=GREY, lw=0.9, ls=":")
            axes.annotate("N$^{-1/2}$", (counts[0], 1.3 * top), color=GREY, xytext=(4, 3), textcoords="offset points")
            axes.set(xlabel="particles", xticks=counts)
            axes.set_xticklabels([f"{count:,}" for count in counts])
            axes.xaxis.set_minor_formatter(NullFormatter())
            axes.yaxis.set_major_formatter(PercentFormatter(1.0))
            axes.yaxis.set_minor_formatter(NullFormatter())
        left.set_title("One run, off the mean of the largest count")
        right.set_title("Noise: one run, off by its seed alone")
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)
        return png(figure)


def draw_curves(runs: Mapping[int, Sequence[Result]]) -> bytes:
    """Means over the seeds with bands of one standard deviation, a line for each count, as PNG."""
    any_run = next(iter(runs.values()))[0]
    panels = [
        ("Pressure, absolute [kPa]", lambda h: (h.time, KILO * h.of("").pressure)),
        ("Volume [l]", lambda h: (h.time, MILLI * h.of("").volume)),
    ]
    for name in any_run.free_obstacles:
        panels.append((f"{name}: speed [m/s]", lambda h, n=name: (h.time, np.linalg.norm(h.of(n).velocity.T, axis=0))))
        panels.append((f"{name}: acceleration, 1 ms mean [m/s$^2$]", lambda h, n=name: _acceleration(h, n)))
    with styled():
        rows = -(-len(panels) // 2)
        figure = Figure(figsize=(9.2, 2.9 * rows), layout="constrained")
        for axes, (title, curve) in zip(np.ravel(figure.subplots(rows, 2)), panels, strict=False):
            for (count, results), colour in zip(runs.items(), np.linspace(FEW, MANY, len(runs)), strict=True):
                pairs = [curve(result.histories) for result in results]
                time, values = MILLI * pairs[0][0], np.array([value for _, value in pairs])
                mean, spread = values.mean(axis=0), values.std(axis=0, ddof=1)
                axes.fill_between(time, mean - spread, mean + spread, color=colour, alpha=0.18, lw=0)
                axes.plot(time, mean, color=colour, lw=1.2, label=f"{count:,}")
            axes.set(title=title, xlabel="time [ms]")
        figure.legend(*axes.get_legend_handles_labels(), title="particles", loc="outside right upper")
        return png(figure)


def draw_shapes(runs: Mapping[int, Sequence[Result]]) -> bytes:
    """Sections y = 0 through the last shapes of all runs, as PNG."""
    with styled():
        figure = Figure(figsize=(9.2, 0.4 + 2.1 * -(-len(runs) // 2)), layout="constrained")
        grid = figure.subplots(-(-len(runs) // 2), 2, squeeze=False)
        best = runs[max(runs)]
        for axes, (count, results) in zip(np.ravel(grid), runs.items(), strict=False):
            for result in best:
                draw_bag(axes, MIDDLE, result.fabric.points(-1), result.triangles, colors=GREY, linewidths=0.7)
            for result in results:
                points = result.fabric.points(-1)
                draw_bag(axes, MIDDLE, points, result.triangles, colors=LINES[0], linewidths=1.0, alpha=0.8)
            axes.autoscale()
            axes.set(title=f"{count:,} particles", aspect="equal", xlabel="x [mm]", ylabel="z [mm]")
        for axes in np.ravel(grid)[len(runs) :]:
            axes.set_axis_off()
        figure.suptitle("Last shape, plane y = 0; grey: the largest count", x=0.01, ha="left", fontsize=9.5)
        return png(figure)


def _acceleration(history: History, name: str) -> tuple[np.ndarray, np.ndarray]:
    middle, mean = millisecond_means(history.time, history.of(name).velocity.T)
    return middle, np.linalg.norm(mean, axis=0)
