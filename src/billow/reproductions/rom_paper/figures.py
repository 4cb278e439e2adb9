"""The paper's figures from our runs, with their numbers in the paper."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter

from billow.base.plot_style import GREY, INK
from billow.reproductions.rom_paper.case_results import CaseResults
from billow.rom.coupled.answer_files import SHOWN_CLASS, plot_motion
from billow.rom.coupled.impactor import ImpactorMotion
from billow.rom.judge.figures import AXES, MILLI, SOLVER, SURROGATE, mode_ticks, new_figure, plain_log
from billow.rom.surrogate.basis import COMPONENTS


def force_inputs(results: CaseResults) -> Figure:
    """Paper Figure 7: each component against N_DOE, without forces (solid) and with the true ones (dashed)."""
    figure, panels = new_figure(9.0, 3.6, 3)
    sizes = list(results.sizes)
    for c, axes in enumerate(panels):
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
    figure, panels = new_figure(9.0, 3.6, 3)
    for c, axes in enumerate(panels):
        for values, style, label in (
            (sweep.rmse, {"ls": "-", "marker": "o", "color": AXES[c]}, "surrogate"),
            (sweep.regression, {"ls": "--", "color": AXES[c], "lw": 1.2}, "regression"),
            (sweep.truncation, {"ls": ":", "color": GREY, "lw": 1.6}, "truncation"),
        ):
            axes.plot(sweep.counts, MILLI * values[..., c].mean(axis=(1, 2)), ms=4, label=label, **style)
        axes.set(title=f"${COMPONENTS[c]}$", xlabel="modes $K$", ylim=(0, None))
        mode_ticks(axes, sweep.counts)
    figure.axes[0].set_ylabel(r"$\overline{\mathrm{RMSE}}$ [mm]")
    figure.axes[-1].legend()
    return figure


def learning_curve(results: CaseResults) -> Figure:
    """Mean RMSE of each component against training runs, and the power law through it."""
    figure, axes = new_figure(5.6, 3.9)
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
    plain_log(axes.yaxis, axes.get_ylim())
    axes.legend()
    return figure


def recipes(results: CaseResults) -> Figure:
    """Both recipes: how many unseen snapshots have at most a given RMSE, and the error over time."""
    recipe = results.recipe
    c = COMPONENTS.index(recipe.component)
    ours = results.sizes[results.largest].plain[0].rmse[-1, :, :, c]
    figure, (left, right) = new_figure(8.8, 3.6, 2)
    time = MILLI * results.surrogate.times
    for rmse, colour, label in ((recipe.rmse, AXES[1], "the paper's recipe"), (ours, SURROGATE, "ours")):
        values = MILLI * np.sort(rmse, axis=None)
        left.plot(values, np.arange(1, values.size + 1) / values.size * 100.0, color=colour, label=label)
        right.plot(time, MILLI * rmse.mean(axis=0), color=colour)
    left.set(
        xscale="log", xlabel=f"RMSE of ${recipe.component}$ [mm]", ylabel="unseen snapshots below [%]", ylim=(0, 100)
    )
    right.set(xlabel="time [ms]", ylabel=f"mean RMSE of ${recipe.component}$ [mm]", ylim=(0, None))
    plain_log(left.xaxis, left.get_xlim())
    left.legend()
    return figure


def coupled_motion(results: CaseResults) -> Figure:
    """The impactor of two unseen runs, one in the middle of the ratings of acceleration and the worst."""
    found, coupled = results.coupled_evaluation, results.coupled
    overall = found.overall(f"acceleration CFC {SHOWN_CLASS}")
    order = np.argsort(overall)
    chosen = (("typical", order[len(order) // 2]), ("worst", order[0]))
    figure, panels = new_figure(9.0, 5.6, 6, rows=2, sharex=True)
    for row, (kind, index) in zip(panels, chosen, strict=True):
        run = found.runs[index]
        truth = ImpactorMotion.of_run(results.dataset.result(run), coupled.impactor.name)
        answer = coupled.deploy(results.dataset.design([run])[0])
        plot_motion(row, truth, color=SOLVER, lw=2.4)
        plot_motion(row, answer, color=SURROGATE, lw=1.3)
        row[0].set_title(f"Run {run}, {kind}: rating {overall[index]:.2f}")
    marks = [Line2D([], [], color=SOLVER, lw=2.4), Line2D([], [], color=SURROGATE, lw=1.3)]
    figure.legend(marks, ["solver", "coupled model"], loc="outside lower center", ncols=2)
    return figure
