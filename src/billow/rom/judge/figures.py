"""Figures of errors, times and shapes: those of the ROM paper (4 to 6, 8 to 12) and those that explain them."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, MaxNLocator, NullLocator, ScalarFormatter

from billow.base.plot_style import GREY, INK, styled
from billow.pictures.curve_figure import DASHES, LINES
from billow.pictures.scene import Plane
from billow.pictures.section_figure import draw_bag, draw_obstacles, window_of
from billow.results.obstacles import has_end, obstacles_at
from billow.rom.judge.effects import Effect
from billow.rom.judge.errors import ErrorsByModes
from billow.rom.judge.evaluate import Evaluation
from billow.rom.judge.timing import break_even
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.simple_answers import MEAN_TRAJECTORY
from billow.rom.surrogate.basis import COMPONENTS, Z

SOLVER, SURROGATE = "#22303c", "#0f9d76"
AXES = ("#0072b2", "#d55e00", "#0f9d76")  # x, y, z: distinguishable with any colour vision
SIZES = ("#8fc1e3", "#2f86c1", "#0a3d62", "#04121f")  # from few runs to many
MILLI = 1e3
MIDDLE = Plane(np.array([0.0, 1.0, 0.0]), 0.0)
"""The plane y = 0 of sections."""


def draw(picture: Callable[..., Figure], *arguments) -> bytes:
    """A picture as SVG."""
    with styled():
        buffer = io.BytesIO()
        picture(*arguments).savefig(buffer, format="svg", metadata={"Date": None, "Creator": "Billow"})
    return buffer.getvalue()


def error_against_modes(
    sweeps: dict[int, ErrorsByModes],
    true_forces: dict[int, ErrorsByModes] | None = None,
    reference_length: float | None = None,
) -> Figure:
    """Paper Figures 4 and 9: mean z RMSE against the number of modes, one line for each number of training runs.

    true_forces: of models that see the contact forces of the unseen runs, dashed; reference_length: [m], an axis on
    the right shows errors as a part of it
    """
    figure, axes = new_figure(6.6, 4.0)
    for colour, (size, sweep) in zip(shades(len(sweeps)), sweeps.items(), strict=True):
        axes.plot(sweep.counts, MILLI * sweep.means(Z), "o-", ms=4, color=colour, label=f"{size} training runs")
        if true_forces:
            axes.plot(sweep.counts, MILLI * true_forces[size].means(Z), "s--", ms=3, lw=1.1, color=colour)
    floor = MILLI * sweep.truncation[..., Z].mean(axis=(1, 2))
    axes.plot(sweep.counts, floor, ":", color=GREY, lw=1.6, label=f"truncation alone, {size} runs")
    axes.set(xlabel="modes $K$", ylabel="mean RMSE of $z$ [mm]", ylim=(0, None))
    axes.set_xticks(sweep.counts)
    if true_forces:
        axes.plot([], [], "s--", ms=3, lw=1.1, color=GREY, label="with true forces")
    axes.legend()
    if reference_length:
        part = 0.1 / reference_length
        right = axes.secondary_yaxis("right", functions=(lambda mm: mm * part, lambda percent: percent / part))
        right.set_ylabel(f"of {reference_length:g} m [%]")
    return figure


def error_distribution(sweeps: dict[int, ErrorsByModes]) -> Figure:
    """Paper Figures 5 and 8: the z RMSE of unseen snapshots against the number of modes, for each number of training
    runs."""
    figure, panels = new_figure(max(3.0 * len(sweeps), 4.4), 3.9, len(sweeps), sharey=True)
    panels = np.atleast_1d(panels)
    for axes, colour, (size, sweep) in zip(panels, shades(len(sweeps)), sweeps.items(), strict=True):
        rows = [sweep.summary(Z, row) for row in range(len(sweep.counts))]
        names = ("p10", "mean", "p90", "maximum")
        low, mean, high, top = (MILLI * np.array([getattr(row, name) for row in rows]) for name in names)
        axes.fill_between(sweep.counts, low, high, color=colour, alpha=0.22, lw=0)
        axes.plot(sweep.counts, mean, "o-", ms=4, color=colour)
        axes.plot(sweep.counts, top, "^:", ms=3.5, lw=1.0, color=colour)
        axes.set(title=f"{size} training runs", xlabel="modes $K$", yscale="log")
        mode_ticks(axes, sweep.counts)
        axes.grid(True, which="both")
    panels[0].set_ylabel("RMSE of $z$ [mm]")
    plain_log(panels[0].yaxis, panels[0].get_ylim())
    marks = [Line2D([], [], color=INK, marker="o", ms=4), Patch(color=INK, alpha=0.22, lw=0)]
    marks.append(Line2D([], [], color=INK, marker="^", ms=3.5, lw=1.0, ls=":"))
    figure.legend(marks, ["mean", "10 to 90 % of unseen snapshots", "maximum"], loc="outside lower center", ncols=3)
    return figure


def evaluation_time(making: dict[int, float], simulation: float, inference: float, close_up: int) -> Figure:
    """Paper Figures 6 and 10: time for a number of deployments, by the solver and by surrogates made for the purpose.

    making: number of training runs -> [s] of these runs and of training; simulation, inference: [s] of one deployment
    close_up: the number of training runs around whose break-even point the right panel is drawn
    """
    reach, even = 1.5 * max(making), break_even(making[close_up], simulation, inference)
    reach, centre = max(reach, 1.5 * (even or 0)), even or close_up
    unit, name = (60.0, "min") if reach * simulation > 600.0 else (1.0, "s")
    figure, (wide, close) = new_figure(8.8, 3.7, 2)
    for axes, start, stop in ((wide, 0, reach), (close, 0.85 * centre, 1.15 * centre)):
        count = np.array([start, stop])
        axes.plot(count, count * simulation / unit, color=SOLVER, lw=2.0, label="solver")
        for colour, (size, made) in zip(shades(len(making)), making.items(), strict=True):
            if axes is wide or size == close_up:
                seconds = made + count * inference
                axes.plot(count, seconds / unit, color=colour, label=f"surrogate of {size} runs, training included")
                if simulation > inference:
                    point = made / (simulation - inference)
                    axes.plot([point], [point * simulation / unit], "o", ms=6, color=colour, mec="white", zorder=3)
        axes.set(xlabel="deployments evaluated", xlim=(start, stop))
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    wide.set(ylabel=f"time [{name}]", ylim=(0, None), title="All")
    close.set(title=f"Around the break-even point of {close_up} runs")
    if even is not None:
        place = (even, even * simulation / unit)
        close.annotate(f"pays from {even} on", place, (14, -22), textcoords="offset points", color=INK)
    wide.legend(fontsize=8.5, loc="upper left")
    return figure


def cross_sections(evaluation: Evaluation, dataset: Dataset, run: str) -> Figure:
    """Paper Figure 11: sections y = 0 of an unseen run at six times, solver and surrogate overlaid, z RMSE printed."""
    surrogate, times = evaluation.surrogate, evaluation.surrogate.times
    index = evaluation.test.index(run)
    truth = dataset.snapshots("displacement", [run])[0]
    predicted = surrogate.predict(evaluation.design[index])
    own = getattr(dataset, "own_starts", False)
    start = dataset.starts([run])[0] if own else surrogate.reference
    count = len(times)
    chosen = np.unique(np.linspace(count / 6, count, 6).round().astype(int) - 1)
    window = window_of(MIDDLE, [start + truth[step] for step in chosen])
    rows = -(-len(chosen) // 3)
    height = rows * (8.8 / 3 * np.ptp(window[1]) / np.ptp(window[0]) + 0.35) + 0.7
    figure, panels = new_figure(8.8, height, min(len(chosen), 3) * rows, rows=rows, sharex=True, sharey=True)
    result = dataset.result(run)
    for axes, step in zip(np.ravel(panels), chosen, strict=False):
        draw_obstacles(axes, MIDDLE, [o for o in obstacles_at(result, times[step]) if has_end(o)], window)
        answered = surrogate.start(evaluation.design[index])
        for begun, displacement, colour, width in (
            (start, truth, SOLVER, 2.6), (answered, predicted, SURROGATE, 1.2)
        ):  # fmt: skip
            points = begun + displacement[step]
            draw_bag(axes, MIDDLE, points, surrogate.triangles, colors=colour, linewidths=width)
        error = evaluation.errors["surrogate"][index, step, Z]
        axes.set_title(f"{times[step] * MILLI:.1f} ms    RMSE z {error * MILLI:.1f} mm", fontsize=9)
        axes.set(aspect="equal", xlim=window[0], ylim=window[1])
    figure.supxlabel("x [mm]", fontsize=9.5)
    figure.supylabel("z [mm]", fontsize=9.5)
    lines = [Line2D([], [], color=SOLVER, lw=2.6), Line2D([], [], color=SURROGATE, lw=1.2)]
    figure.legend(lines, ["solver", "surrogate"], loc="outside upper right", ncols=2)
    return figure


def singular_values(evaluation: Evaluation) -> Figure:
    """How fast the singular values fall, and where the basis was cut."""
    figure, axes = new_figure(6.4, 3.2)
    for basis, colour, name in zip(evaluation.surrogate.bases, AXES, COMPONENTS, strict=True):
        values = basis.singular_values
        if values[0] > 0.0:
            axes.semilogy(np.arange(1, len(values) + 1), values / values[0], "o-", ms=3, color=colour, label=name)
    modes = evaluation.surrogate.modes
    axes.axvline(modes + 0.5, color=GREY, lw=1, ls=":")
    place = {"xytext": (5, -4), "textcoords": "offset points", "va": "top"}
    axes.annotate(f"cut after {modes}", (modes + 0.5, 1.0), color=GREY, **place)
    axes.set(xlabel="mode", ylabel="singular value / the first")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend()
    return figure


def error_against_time(evaluation: Evaluation) -> Figure:
    """RMSE of each component over the deployment: mean, 10 to 90 percentile and worst of the unseen runs."""
    figure, panels = new_figure(9.2, 3.3, 3)
    time = evaluation.surrogate.times * MILLI
    for c, (axes, colour) in enumerate(zip(panels, AXES, strict=True)):
        error = evaluation.errors["surrogate"][:, :, c] * MILLI
        low, high = np.percentile(error, (10, 90), axis=0)
        axes.fill_between(time, low, high, color=colour, alpha=0.18, lw=0, label="10 to 90 % of runs")
        axes.plot(time, error.mean(axis=0), color=colour, label="mean")
        axes.plot(time, error.max(axis=0), color=colour, lw=0.9, label="worst run")
        for name, style, width in (("truncation", "--", 1.2), (MEAN_TRAJECTORY, ":", 1.4)):
            mean = evaluation.errors[name][:, :, c].mean(axis=0) * MILLI
            axes.plot(time, mean, style, color=GREY, lw=width, label=f"{name}, mean")
        axes.set(xlabel="time [ms]", title=COMPONENTS[c], ylim=(0, None), xlim=(time[0], time[-1]))
    panels[0].set_ylabel("RMSE [mm]")
    handles, labels = panels[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, fontsize=8.5)
    return figure


def heights(found: list[Effect]) -> Figure:
    """Largest height of the bag while one parameter goes through its range."""
    figure, axes = new_figure(7.4, 3.4)
    for k, effect in enumerate(found):
        style = {"color": LINES[k % len(LINES)], "ls": DASHES[k // len(LINES) % len(DASHES)]}
        axes.plot(np.linspace(0.0, 100.0, len(effect.heights)), MILLI * effect.heights, label=effect.label, **style)
    axes.set(xlabel="part of the range of the parameter [%]", ylabel="largest height [mm]", xlim=(0.0, 100.0))
    figure.legend(loc="outside right upper", fontsize=8.5)
    return figure


def pressures(curves: dict[str, tuple[np.ndarray, np.ndarray]], unseen: tuple[str, ...]) -> Figure:
    """Pressure of the gas in all runs. curves: run -> times [s] and pressure [Pa]; unseen: drawn dark."""
    figure, axes = new_figure(7.4, 3.2)
    for run, (times, pressure) in sorted(curves.items(), key=lambda item: item[0] in unseen):
        dark = run in unseen
        axes.plot(MILLI * times, 1e-3 * pressure, color=INK if dark else "#b9c4cd", lw=1.2 if dark else 0.8)
    axes.set(xlabel="time [ms]", ylabel="pressure [kPa]")
    axes.margins(x=0.0)
    lines = [Line2D([], [], color=INK, lw=1.2), Line2D([], [], color="#b9c4cd", lw=0.8)]
    figure.legend(lines, ["unseen runs", "training runs"], loc="outside upper right", ncols=2)
    return figure


def new_figure(width, height, panels=1, rows=1, **options):
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(rows, -(-panels // rows), **options)


def shades(count: int) -> list[str]:
    """Colours for up to four numbers of training runs, the darkest for the most; more share the darkest."""
    return [SIZES[min(i + max(3 - count, 0), len(SIZES) - 1)] for i in range(count)]


def mode_ticks(axes, counts) -> None:
    """Ticks at all numbers of modes, labels where they do not collide."""
    axes.set_xticks(counts, [str(count) if count in (1, 4, 8, 12, 16) else "" for count in counts])


FEWEST_TICKS = 3


def plain_log(axis, limits) -> None:
    """Ticks of a logarithmic axis within limits, written as numbers: 1, 2, 5 of every decade, or, where these are fewer
    than `FEWEST_TICKS`, round numbers at even distances."""
    ticks = [m * 10.0**e for e in range(-6, 7) for m in (1, 2, 5)]
    ticks = [tick for tick in ticks if limits[0] <= tick <= limits[1]]
    if len(ticks) < FEWEST_TICKS:
        even = MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]).tick_values(*limits)
        ticks = [tick for tick in even if limits[0] <= tick <= limits[1]]
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_major_formatter(ScalarFormatter())
    axis.set_minor_locator(NullLocator())
