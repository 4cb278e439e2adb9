"""The paper's figures from our runs, each beside its number in the paper. They are drawn, not judged, here."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, MaxNLocator, NullFormatter, ScalarFormatter

from billow.base.plot_style import GREY, INK
from billow.injury.criteria import GRAVITY
from billow.reproductions.rom_paper.case_results import CaseResults
from billow.reproductions.rom_paper.tables import break_even
from billow.rom.coupled.impactor_motion import ImpactorMotion
from billow.rom.judge.figures import AXES, SOLVER, SURROGATE
from billow.rom.learn.snapshots import COMPONENTS

Z = 2
MILLI = 1e3
SIZES = ("#8fc1e3", "#2f86c1", "#0a3d62", "#04121f")
"""From few runs to many."""
SHOWN_CLASS = 60
"""Channel frequency class of the accelerations that are drawn."""


def error_against_modes(results: CaseResults) -> Figure:
    """Paper Figures 4 and 9: mean z RMSE against K, one line for each N_DOE."""
    figure = Figure(figsize=(6.6, 4.0), layout="constrained")
    axes = figure.subplots()
    for colour, (size, made) in zip(_shades(results), results.sizes.items(), strict=True):
        counts = made.sweep.counts
        axes.plot(counts, _means(made.sweep), "o-", ms=4, color=colour, label=f"$N_{{DOE}}$ = {size}")
        if made.sweep_forces is not None:
            axes.plot(counts, _means(made.sweep_forces), "s--", ms=3, lw=1.1, color=colour)
    last = results.sizes[results.largest].sweep
    floor = MILLI * last.truncation[..., Z].mean(axis=(1, 2))
    axes.plot(last.counts, floor, ":", color=GREY, lw=1.6, label=f"truncation alone, {results.largest}")
    axes.set(xlabel="modes $K$", ylabel=r"$z$-displacement $\overline{\mathrm{RMSE}}$ [mm]", ylim=(0, None))
    axes.set_xticks(last.counts)
    handles, labels = axes.get_legend_handles_labels()
    if results.case.forces:
        handles.append(Line2D([], [], color=GREY, lw=1.1, ls="--", marker="s", ms=3))
        labels.append("with true forces")
    axes.legend(handles, labels)
    _percent_axis(axes, results)
    return figure


def distribution(results: CaseResults) -> Figure:
    """Paper Figures 5 and 8: the z RMSE of unseen snapshots against K: mean, 10 to 90 %, maximum."""
    count = len(results.sizes)
    figure = Figure(figsize=(max(3.0 * count, 4.4), 3.9), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, count, sharey=True))
    for axes, colour, (size, made) in zip(panels, _shades(results), results.sizes.items(), strict=True):
        counts, sweep = made.sweep.counts, made.sweep
        rows = [sweep.summary(Z, row) for row in range(len(counts))]
        low, mean, high, top = (
            MILLI * np.array([getattr(r, n) for r in rows]) for n in ("p10", "mean", "p90", "maximum")
        )
        axes.fill_between(counts, low, high, color=colour, alpha=0.22, lw=0)
        axes.plot(counts, mean, "o-", ms=4, color=colour)
        axes.plot(counts, top, "^:", ms=3.5, lw=1.0, color=colour)
        axes.set(title=f"$N_{{DOE}}$ = {size}", xlabel="modes $K$", yscale="log")
        axes.set_xticks(counts, [str(c) if c in (1, 4, 8, 12, 16) else "" for c in counts])
        axes.grid(True, which="both")
    panels[0].set_ylabel("$z$-displacement RMSE [mm]")
    _plain_log(panels[0].yaxis, panels[0].get_ylim())
    marks = [Line2D([], [], color=INK, marker="o", ms=4), Patch(color=INK, alpha=0.22, lw=0)]
    marks.append(Line2D([], [], color=INK, marker="^", ms=3.5, lw=1.0, ls=":"))
    figure.legend(marks, ["mean", "10 to 90 % of unseen snapshots", "maximum"], loc="outside lower center", ncols=3)
    return figure


def evaluation_time(results: CaseResults) -> Figure:
    """Paper Figures 6 and 10: time for a number of deployments, by the solver and by surrogates made for it."""
    solver, asked = results.evaluation.timing.simulation, results.inference.whole
    making = {size: made.generation + made.training for size, made in results.sizes.items()}
    reach, smallest = 1.5 * max(results.sizes), min(results.sizes)
    centre = break_even(making[smallest], solver, asked) or smallest
    figure = Figure(figsize=(8.8, 3.7), layout="constrained")
    wide, close = figure.subplots(1, 2)
    for axes, start, stop in ((wide, 0, reach), (close, 0.85 * centre, 1.15 * centre)):
        count = np.array([start, stop])
        axes.plot(count, count * solver / 60.0, color=SOLVER, lw=2.0, label="solver")
        for colour, (size, made) in zip(_shades(results), making.items(), strict=True):
            if axes is wide or size == smallest:
                axes.plot(count, (made + count * asked) / 60.0, color=colour, label=f"surrogate, $N_{{DOE}}$ = {size}")
                if solver > asked:
                    point = made / (solver - asked)
                    axes.plot([point], [point * solver / 60.0], "o", ms=6, color=colour, mec="white", zorder=3)
        axes.set(xlabel="expected deployments", xlim=(start, stop))
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    wide.set(ylabel="time [min]", ylim=(0, None), title="All")
    close.set(title=f"Around $N_{{DOE}}$ = {smallest}")
    point = break_even(making[smallest], solver, asked)
    if point is not None:
        place = (point, point * solver / 60.0)
        close.annotate(f"pays from {point} on", place, (14, -22), textcoords="offset points", color=INK)
    wide.legend(loc="upper left")
    return figure


def force_inputs(results: CaseResults) -> Figure:
    """Paper Figure 7: each component against N_DOE, without forces (solid) and with the true ones (dashed)."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    sizes = list(results.sizes)
    for c, axes in enumerate(figure.subplots(1, 3)):
        for name, style, marker in (("plain", "-", "o"), ("forces", "--", "s")):
            fits = [getattr(made, name) for made in results.sizes.values()]
            each = MILLI * np.array([[f.summary(c).mean for f in size] for size in fits])  # (sizes, seeds)
            axes.plot(sizes, each.mean(axis=1), style, marker=marker, ms=4, color=AXES[c])
            axes.fill_between(sizes, each.min(axis=1), each.max(axis=1), color=AXES[c], alpha=0.15, lw=0)
        axes.set(title=f"${COMPONENTS[c]}$", xlabel="training runs $N_{DOE}$", ylim=(0, None), xticks=sizes)
    figure.axes[0].set_ylabel(r"$\overline{\mathrm{RMSE}}$ [mm]")
    marks = [Line2D([], [], color=INK, marker="o", ms=4), Line2D([], [], color=INK, ls="--", marker="s", ms=4)]
    marks.append(Patch(color=INK, alpha=0.15, lw=0))
    names = ["without forces", "with the true forces of the unseen run", "between seeds"]
    figure.legend(marks, names, loc="outside lower center", ncols=3)
    return figure


def truncation_and_regression(results: CaseResults) -> Figure:
    """Each component against K at the largest N_DOE: what modes lose, and what networks add."""
    sweep = results.sizes[results.largest].sweep
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    for c, axes in enumerate(figure.subplots(1, 3)):
        for values, style, label in (
            (sweep.rmse, {"ls": "-", "marker": "o", "color": AXES[c]}, "surrogate"),
            (sweep.regression, {"ls": "--", "color": AXES[c], "lw": 1.2}, "regression"),
            (sweep.truncation, {"ls": ":", "color": GREY, "lw": 1.6}, "truncation"),
        ):
            axes.plot(sweep.counts, MILLI * values[..., c].mean(axis=(1, 2)), ms=4, label=label, **style)
        axes.set(title=f"${COMPONENTS[c]}$", xlabel="modes $K$", ylim=(0, None))
        axes.set_xticks(sweep.counts, [str(k) if k in (1, 4, 8, 12, 16) else "" for k in sweep.counts])
    figure.axes[0].set_ylabel(r"$\overline{\mathrm{RMSE}}$ [mm]")
    figure.axes[-1].legend()
    return figure


def learning_curve(results: CaseResults) -> Figure:
    """Mean RMSE of each component against training runs, and the power law through it."""
    figure = Figure(figsize=(5.6, 3.9), layout="constrained")
    axes = figure.subplots()
    sizes = np.array(list(results.sizes), float)
    for c, (axis, colour, mark) in enumerate(zip(COMPONENTS, AXES, "os^", strict=True)):
        curve = results.learning_curve(c)
        axes.plot(sizes, MILLI * np.array(curve.errors), mark, ms=5, color=colour)
        reach = np.array([sizes[0], 2.0 * sizes[-1]])
        axes.plot(reach, MILLI * curve.scale * reach**-curve.rate, "--", lw=1.1, color=colour)
        axes.plot([], [], f"{mark}--", color=colour, lw=1.1, label=f"${axis}$: $N^{{-{curve.rate:.2f}}}$")
    axes.set(xscale="log", yscale="log", xlabel="training runs $N_{DOE}$", ylabel=r"$\overline{\mathrm{RMSE}}$ [mm]")
    axes.set_xticks([*sizes, 2 * sizes[-1]], [f"{n:.0f}" for n in (*sizes, 2 * sizes[-1])])
    axes.xaxis.set_minor_formatter(NullFormatter())
    _plain_log(axes.yaxis, axes.get_ylim())
    axes.legend()
    return figure


def recipes(results: CaseResults) -> Figure:
    """Both recipes: how many unseen snapshots have at most a given RMSE, and the error over time."""
    recipe = results.recipe
    c = COMPONENTS.index(recipe.component)
    ours = results.sizes[results.largest].plain[0].rmse[-1, :, :, c]
    figure = Figure(figsize=(8.8, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    time = MILLI * results.evaluation.times
    for rmse, colour, label in ((recipe.rmse, AXES[1], "the paper's recipe"), (ours, SURROGATE, "ours")):
        values = MILLI * np.sort(rmse, axis=None)
        left.plot(values, np.arange(1, values.size + 1) / values.size * 100.0, color=colour, label=label)
        right.plot(time, MILLI * rmse.mean(axis=0), color=colour)
    left.set(
        xscale="log", xlabel=f"RMSE of ${recipe.component}$ [mm]", ylabel="unseen snapshots below [%]", ylim=(0, 100)
    )
    right.set(xlabel="time [ms]", ylabel=f"mean RMSE of ${recipe.component}$ [mm]", ylim=(0, None))
    _plain_log(left.xaxis, left.get_xlim())
    left.legend()
    return figure


def coupled_motion(results: CaseResults) -> Figure:
    """The impactor of two unseen runs, one in the middle of the ratings of acceleration and the worst."""
    found, coupled = results.coupled_evaluation, results.coupled
    overall = found.overall(f"acceleration CFC {SHOWN_CLASS}")
    order = np.argsort(overall)
    chosen = (("typical", order[len(order) // 2]), ("worst", order[0]))
    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    panels = figure.subplots(2, 3, sharex=True)
    for row, (kind, index) in zip(panels, chosen, strict=True):
        run = found.runs[index]
        truth = ImpactorMotion.of_run(results.dataset.result(run), coupled.impactor.name)
        answer = coupled.deploy(results.dataset.design([run])[0])
        for motion, colour, width in ((truth, SOLVER, 2.4), (answer, SURROGATE, 1.3)):
            middles, acceleration = motion.acceleration(SHOWN_CLASS)
            row[0].plot(MILLI * middles, acceleration[:, Z] / GRAVITY, color=colour, lw=width)
            row[1].plot(MILLI * motion.times, motion.velocity[:, Z], color=colour, lw=width)
            row[2].plot(MILLI * motion.times, MILLI * motion.displacement[:, Z], color=colour, lw=width)
        row[0].set_title(f"Run {run}, {kind}: rating {overall[index]:.2f}")
        labels = (f"acceleration, CFC {SHOWN_CLASS} [g]", "velocity [m/s]", "displacement [mm]")
        for axes, label in zip(row, labels, strict=True):
            axes.set_ylabel(label)
    for axes in panels[1]:
        axes.set_xlabel("time [ms]")
    marks = [Line2D([], [], color=SOLVER, lw=2.4), Line2D([], [], color=SURROGATE, lw=1.3)]
    figure.legend(marks, ["solver", "coupled model"], loc="outside lower center", ncols=2)
    return figure


def _means(sweep):
    return MILLI * sweep.rmse[..., Z].mean(axis=(1, 2))


def _shades(results):
    count = len(results.sizes)
    return [SIZES[min(i + max(3 - count, 0), len(SIZES) - 1)] for i in range(count)]


def _percent_axis(axes, results):
    """On the right, the same as a part of the reference length."""
    part = 0.1 / results.reference_length
    right = axes.secondary_yaxis("right", functions=(lambda mm: mm * part, lambda percent: percent / part))
    right.set_ylabel(f"of the strap, {results.reference_length:g} m [%]")


def _plain_log(axis, limits):
    """Ticks 1, 2, 5 of every decade within limits, written as numbers."""
    ticks = [m * 10.0**e for e in range(-6, 7) for m in (1, 2, 5)]
    axis.set_major_locator(FixedLocator([t for t in ticks if limits[0] <= t <= limits[1]]))
    axis.set_major_formatter(ScalarFormatter())
    axis.set_minor_formatter(NullFormatter())
