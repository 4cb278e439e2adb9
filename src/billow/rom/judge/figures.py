"""The report's pictures: Figures 4, 5, 6 and 11 of the ROM paper from our runs, and those that show what is behind."""

from __future__ import annotations

import io
from collections.abc import Callable

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from billow.base.plot_style import GREY, STYLE
from billow.rom.judge.evaluate import BASELINES, Evaluation
from billow.rom.judge.obstacle_places import obstacles_at
from billow.rom.judge.sections import cut, super_ellipsoid
from billow.rom.learn.snapshots import COMPONENTS

SOLVER, SURROGATE, OBSTACLE = "#22303c", "#0f9d76", "#c9d2d9"
AXES = ("#0072b2", "#d55e00", "#0f9d76")  # x, y, z: told apart with any colour vision
SIZES = ("#9cc9e8", "#4f9fd0", "#1368a0", "#0a3d62", "#06263d")  # from few runs to many
Z = 2
MILLI = 1e3


def draw(picture: Callable[..., Figure], *arguments) -> bytes:
    """A picture as SVG."""
    with matplotlib.rc_context(STYLE):
        buffer = io.BytesIO()
        picture(*arguments).savefig(buffer, format="svg", metadata={"Date": None, "Creator": "Billow"})
    return buffer.getvalue()


def error_against_modes(evaluation: Evaluation) -> Figure:
    """Paper Figure 4: mean z RMSE against the number of modes, one line for each number of training runs."""
    figure, axes = _figure(6.4, 3.6)
    for colour, model in zip(_shades(evaluation.sweep), evaluation.sweep, strict=True):
        mean = [summaries[Z].mean * MILLI for summaries in model.summaries]
        axes.plot(model.modes, mean, "o-", ms=4, color=colour, label=f"{model.runs} training runs")
    last = evaluation.sweep[-1]
    axes.plot(
        last.modes, last.truncation[:, Z] * MILLI, "--", lw=1.2, color=GREY, label=f"truncation alone, {last.runs} runs"
    )
    axes.set(xlabel="modes K", ylabel="mean RMSE of z [mm]", ylim=(0, None))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    figure.legend(loc="outside lower center", ncols=4, fontsize=8.5)
    return figure


def error_distribution(evaluation: Evaluation) -> Figure:
    """Paper Figure 5: z RMSE, mean and 10 to 90 percentile, against training runs and against modes."""
    figure, (by_runs, by_modes) = _figure(8.6, 3.4, 2, sharey=True)
    chosen = [_nearest_mode(model, evaluation.modes) for model in evaluation.sweep]
    rows = [model.summaries[row][Z] for model, row in zip(evaluation.sweep, chosen, strict=True)]
    _band(by_runs, [model.runs for model in evaluation.sweep], rows)
    last = evaluation.sweep[-1]
    by_runs.set(xlabel="training runs", ylabel="RMSE of z [mm]", title=f"K = {last.modes[chosen[-1]]} modes")
    by_runs.set_xticks([model.runs for model in evaluation.sweep])
    _band(by_modes, last.modes, [summaries[Z] for summaries in last.summaries])
    by_modes.set(xlabel="modes K", title=f"{last.runs} training runs", ylim=(0, None))
    by_modes.legend()
    return figure


def evaluation_time(evaluation: Evaluation) -> Figure:
    """Paper Figure 6: time for a number of deployments, by the solver and by a surrogate made for the purpose."""
    timing = evaluation.timing
    figure, (wide, close) = _figure(8.6, 3.4, 2)
    models = [(m.runs, m.generation + m.training) for m in evaluation.sweep if m.runs < len(evaluation.train)]
    models.append((len(evaluation.train), timing.generation + timing.training))
    reach = 1.5 * models[-1][1] / timing.simulation
    centre = timing.break_even or reach
    for axes, start, stop in ((wide, 0, reach), (close, 0.92 * centre, 1.08 * centre)):
        count = np.array([start, stop])
        axes.plot(count, count * timing.simulation, color=SOLVER, label="solver")
        for colour, (runs, made) in zip(_shades(models), models, strict=True):
            if axes is wide or runs == models[-1][0]:
                seconds = made + count * timing.inference
                axes.plot(count, seconds, color=colour, label=f"surrogate of {runs} runs, training included")
        axes.set(xlabel="deployments evaluated", xlim=(start, stop))
    wide.set(ylabel="time [s]", ylim=(0, None), title="All")
    close.set(title="Around the break-even point")
    if timing.break_even is not None:
        close.axvline(timing.break_even, color=GREY, lw=1, ls=":")
        close.annotate(
            f"{timing.break_even} deployments",
            (timing.break_even, close.get_ylim()[0]),
            (5, 6),
            textcoords="offset points",
            color=GREY,
        )
    wide.legend(fontsize=8.5, loc="upper left")
    return figure


def cross_sections(evaluation: Evaluation, surrogate, dataset, run: str) -> Figure:
    """Paper Figure 11: sections y = 0 at six times, solver and surrogate overlaid, z RMSE printed.

    surrogate: the one evaluated; run: name of an unseen run of the dataset
    """
    index = evaluation.test.index(run)
    truth = dataset.snapshots("displacement", [run])[0]
    predicted = surrogate.predict(evaluation.design[index])
    count = len(evaluation.times)
    chosen = np.unique(np.linspace(count / 6, count, 6).round().astype(int) - 1)
    reached = (surrogate.reference + truth[chosen]).reshape(-1, 3) * MILLI
    margin = 0.08 * np.ptp(reached[:, 0])
    window = np.array([(reached[:, k].min() - margin, reached[:, k].max() + margin) for k in (0, 2)])
    rows = -(-len(chosen) // 3)
    height = rows * (8.8 / 3 * np.ptp(window[1]) / np.ptp(window[0]) + 0.35) + 0.7
    figure, panels = _figure(8.8, height, min(len(chosen), 3) * rows, rows=rows, sharex=True, sharey=True)
    result = dataset.result(run) if hasattr(dataset, "result") else None
    for axes, step in zip(np.ravel(panels), chosen, strict=False):
        for obstacle in obstacles_at(result, evaluation.times[step]) if result else ():
            _fill_outline(axes, obstacle, window)
        for displacement, colour, width in ((truth, SOLVER, 2.6), (predicted, SURROGATE, 1.2)):
            segments = cut(surrogate.reference + displacement[step], surrogate.triangles) * MILLI
            axes.add_collection(LineCollection(segments, colors=colour, linewidths=width, capstyle="round"))
        error = evaluation.errors["surrogate"][index, step, Z]
        axes.set_title(f"{evaluation.times[step] * MILLI:.1f} ms    RMSE z {error * MILLI:.1f} mm", fontsize=9)
        axes.set(aspect="equal", xlim=window[0], ylim=window[1])
    figure.supxlabel("x [mm]", fontsize=9.5)
    figure.supylabel("z [mm]", fontsize=9.5)
    lines = [Line2D([], [], color=SOLVER, lw=2.6), Line2D([], [], color=SURROGATE, lw=1.2)]
    figure.legend(lines, ["solver", "surrogate"], loc="outside upper right", ncols=2)
    return figure


def singular_values(evaluation: Evaluation) -> Figure:
    """How fast the singular values fall, and where the basis was cut."""
    figure, axes = _figure(6.4, 3.2)
    for values, colour, name in zip(evaluation.singular_values, AXES, COMPONENTS, strict=True):
        if values[0] > 0.0:
            axes.semilogy(np.arange(1, len(values) + 1), values / values[0], "o-", ms=3, color=colour, label=name)
    axes.axvline(evaluation.modes + 0.5, color=GREY, lw=1, ls=":")
    axes.annotate(
        f"cut after {evaluation.modes}",
        (evaluation.modes + 0.5, 1.0),
        (5, -4),
        textcoords="offset points",
        va="top",
        color=GREY,
    )
    axes.set(xlabel="mode", ylabel="singular value / the first")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend()
    return figure


def error_against_time(evaluation: Evaluation) -> Figure:
    """RMSE of each component over the deployment: mean, 10 to 90 percentile and worst of the unseen runs."""
    figure, panels = _figure(9.2, 3.3, 3)
    time = evaluation.times * MILLI
    for c, (axes, colour) in enumerate(zip(panels, AXES, strict=True)):
        error = evaluation.errors["surrogate"][:, :, c] * MILLI
        low, high = np.percentile(error, (10, 90), axis=0)
        axes.fill_between(time, low, high, color=colour, alpha=0.18, lw=0, label="10 to 90 % of runs")
        axes.plot(time, error.mean(axis=0), color=colour, label="mean")
        axes.plot(time, error.max(axis=0), color=colour, lw=0.9, label="worst run")
        floor = evaluation.errors["truncation"][:, :, c].mean(axis=0) * MILLI
        axes.plot(time, floor, "--", color=GREY, lw=1.2, label="truncation, mean")
        mean_trajectory = evaluation.errors[BASELINES[0]][:, :, c].mean(axis=0) * MILLI
        axes.plot(time, mean_trajectory, ":", color=GREY, lw=1.4, label=f"{BASELINES[0]}, mean")
        axes.set(xlabel="time [ms]", title=COMPONENTS[c], ylim=(0, None), xlim=(time[0], time[-1]))
    panels[0].set_ylabel("RMSE [mm]")
    handles, labels = panels[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, fontsize=8.5)
    return figure


def _figure(width, height, panels=1, rows=1, **options):
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(rows, -(-panels // rows), **options)


def _shades(models) -> list[str]:
    return list(SIZES[: len(models)]) if len(models) <= len(SIZES) else [SIZES[-1]] * len(models)


def _nearest_mode(model, modes) -> int:
    return int(np.abs(np.array(model.modes) - modes).argmin())


def _band(axes, x, summaries):
    mean, low, high = (np.array([getattr(s, k) for s in summaries]) * MILLI for k in ("mean", "p10", "p90"))
    axes.fill_between(x, low, high, color=AXES[Z], alpha=0.18, lw=0, label="10 to 90 % of unseen snapshots")
    axes.plot(x, mean, "o-", ms=4, color=AXES[Z], label="mean")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))


def _fill_outline(axes, obstacle, window):
    x, z = np.meshgrid(*(np.linspace(*limits, 300) for limits in window))
    level = super_ellipsoid(obstacle, x / MILLI, z / MILLI)
    if level.min() < 0.0:
        axes.contourf(x, z, level, levels=[-1.0, 0.0], colors=[OBSTACLE])
