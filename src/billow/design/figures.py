"""Figures of response surfaces: how good they are, what responses depend on, optimum and robustness."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from billow.base.plot_style import FAINT, GREY, INK, styled
from billow.design.robust import Chance
from billow.design.sensitivity import Sensitivity
from billow.design.surfaces import ResponseSurfaces
from billow.rom.surrogate.design_space import to_unit

BLUE, ORANGE, GREEN, RED, YELLOW = "#0072b2", "#d55e00", "#0f9d76", "#c0392b", "#e6a700"
LIGHTS = {"green": GREEN, "yellow": YELLOW, "red": RED, "grey": GREY}
CONTOURS = 41


def draw(picture: Callable[..., Figure], *arguments) -> bytes:
    """A picture as SVG; same numbers, same bytes."""
    with styled():
        buffer = io.BytesIO()
        picture(*arguments).savefig(buffer, format="svg", metadata={"Date": None, "Creator": "Billow"})
    return buffer.getvalue()


def _sheet(width: float, height: float, rows: int = 1, columns: int = 1, **options):
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def _grid(count: int, columns: int = 3) -> tuple[int, int]:
    return -(-count // columns), min(count, columns)


def _label(surfaces: ResponseSurfaces, name: str) -> str:
    unit = surfaces.unit(name)
    return name if unit == "-" else f"{name} [{unit}]"


def _axis_label(parameter) -> str:
    return parameter.label if parameter.unit == "-" else f"{parameter.label} [{parameter.unit}]"


def _from_unit(parameter, unit):
    return parameter.low + unit * (parameter.high - parameter.low)


def predicted_against_computed(surfaces: ResponseSurfaces) -> Figure:
    """Every response: runs held out, and unseen runs with their 90 % intervals, against the solver."""
    shown = [k for k, surface in enumerate(surfaces.surfaces) if surface.process is not None]
    rows, columns = _grid(len(shown))
    figure, panels = _sheet(3.3 * columns, 3.1 * rows, rows, columns)
    count = len(surfaces.parameters)
    for axes in panels.ravel()[len(shown) :]:
        axes.set_axis_off()
    for axes, k in zip(panels.ravel(), shown, strict=False):
        surface, name = surfaces.surfaces[k], surfaces.names[k]
        axes.plot(*surface.held_out.T, "o", ms=3, color=GREY, label="held out")
        ends = [surface.held_out.min(), surface.held_out.max()]
        truth = surfaces.unseen[:, count + k]
        known = np.isfinite(truth)
        if known.any():
            found = surface.interval(to_unit(surfaces.unseen[known, :count], surfaces.parameters))
            error = np.abs(found[:, 1:] - found[:, :1]).T
            axes.errorbar(truth[known], found[:, 0], error, fmt="o", ms=4, lw=1, color=BLUE, label="unseen, 90 %")
            ends = [min(ends[0], truth[known].min()), max(ends[1], truth[known].max())]
        axes.plot(ends, ends, color=INK, lw=0.8)
        verdict = surface.verdict
        axes.set_title(f"{name}: {verdict.word}", fontsize=9)
        axes.text(0.03, 0.97, f"Q² {verdict.q2:.3f}\nrmse {verdict.rmse:.3g} {surfaces.units[k]}\n{verdict.runs} runs",
                  transform=axes.transAxes, va="top", fontsize=8)  # fmt: skip
        axes.set(xlabel=f"solver [{surfaces.units[k]}]", ylabel="surface")
    if shown:
        panels[0, 0].legend(loc="lower right", fontsize=8)
    return figure


def sobol_bars(surfaces: ResponseSurfaces, found: list[Sensitivity]) -> Figure:
    """First and total Sobol' indices with the ends of their 90 % intervals."""
    rows, columns = _grid(len(found))
    figure, panels = _sheet(3.4 * columns, (1.0 + 0.32 * len(surfaces.parameters)) * rows, rows, columns, sharey=True)
    places = np.arange(len(surfaces.parameters))[::-1]
    for axes in panels.ravel()[len(found) :]:
        axes.set_axis_off()
    for axes, one in zip(panels.ravel(), found, strict=False):
        for shift, values, colour, label in ((0.2, one.first, BLUE, "first"), (-0.2, one.total, ORANGE, "total")):
            error = np.abs(values[:, 1:] - values[:, :1]).T
            axes.barh(places + shift, np.maximum(values[:, 0], 0.0), 0.36, xerr=error, color=colour, label=label,
                      error_kw={"lw": 1, "ecolor": INK})  # fmt: skip
        axes.set_title(f"{one.response} (Q² {surfaces.verdict(one.response).q2:.2f})", fontsize=9)
        axes.set(xlim=(0, 1), xlabel="part of the variance")
        axes.set_yticks(places, one.names)
        axes.grid(axis="y", visible=False)
    if found:
        panels[0, 0].legend(fontsize=8, loc="lower right")
    return figure


def prognosis(surfaces: ResponseSurfaces, found: list[Sensitivity]) -> Figure:
    """Matrix of responses against parameters: total index, and Q2 of the surface in the last column."""
    names = [parameter.name for parameter in surfaces.parameters]
    figure, panels = _sheet(1.9 + 0.95 * (len(names) + 1), 1.5 + 0.4 * len(found))
    axes = panels[0, 0]
    values = np.array([[*one.total[:, 0], surfaces.verdict(one.response).q2] for one in found])
    axes.imshow(np.clip(values, 0, 1), cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for (row, column), value in np.ndenumerate(values):
        axes.text(column, row, f"{max(value, 0.0):.2f}", ha="center", va="center", fontsize=8.5,
                  color="white" if value > 0.6 else INK)  # fmt: skip
    axes.set_xticks(range(len(names) + 1), [*names, "Q²"], rotation=30, ha="right")
    axes.set_yticks(range(len(found)), [one.response for one in found])
    axes.axvline(len(names) - 0.5, color="white", lw=3)
    axes.grid(visible=False)
    return figure


def main_effect_curves(surfaces: ResponseSurfaces, name: str, places: np.ndarray, effects: np.ndarray) -> Figure:
    """Mean response against each parameter, with the mean 90 % interval; runs as points."""
    rows, columns = _grid(len(surfaces.parameters))
    figure, panels = _sheet(3.1 * columns, 2.5 * rows, rows, columns, sharey=True)
    values = surfaces.values[:, surfaces.index(name)]
    for axes in panels.ravel()[len(surfaces.parameters) :]:
        axes.set_axis_off()
    for k, (axes, parameter) in enumerate(zip(panels.ravel(), surfaces.parameters, strict=False)):
        x = _from_unit(parameter, places[k])
        axes.plot(surfaces.designs[:, k], values, ".", ms=4, color=GREY)
        axes.fill_between(x, effects[k, :, 1], effects[k, :, 2], color=BLUE, alpha=0.18, lw=0)
        axes.plot(x, effects[k, :, 0], color=BLUE)
        axes.set_xlabel(_axis_label(parameter))
        if parameter.levels:
            axes.set_xticks(range(len(parameter.levels)), parameter.levels)
        else:
            axes.locator_params(axis="x", nbins=5)  # labels such as 0.0225 would overlap
    for axes in panels[:, 0]:
        axes.set_ylabel(_label(surfaces, name))
    return figure


def response_surface(surfaces: ResponseSurfaces, name: str, two: tuple[int, int], middle: np.ndarray, limits) -> Figure:
    """Contours over two parameters, the others at `middle` (parameters,) in [0, 1]; hatched where a limit is broken.

    limits: (response, limit, 1 for below or -1 for above)
    """
    figure, panels = _sheet(5.4, 4.1)
    axes, grid = panels[0, 0], np.linspace(0.0, 1.0, CONTOURS)
    points = np.tile(middle, (CONTOURS * CONTOURS, 1))
    points[:, two[0]], points[:, two[1]] = (part.ravel() for part in np.meshgrid(grid, grid))
    x, y = (_from_unit(surfaces.parameters[k], grid) for k in two)
    surface = surfaces.usable(name)
    filled = axes.contourf(x, y, surface.value(points).reshape(CONTOURS, -1), 14, cmap="viridis")
    figure.colorbar(filled, ax=axes, label=_label(surfaces, name))
    for response, limit, side in limits:
        end = surfaces.usable(response).interval(points)[:, 2 if side > 0 else 1].reshape(CONTOURS, -1)
        beyond = side * (end - limit)
        if beyond.max() > 0.0:
            axes.contourf(x, y, beyond, [0.0, beyond.max() + 1e-12], colors="none", hatches=["//"])
            axes.contour(x, y, beyond, [0.0], colors="white", linewidths=1.4)
    beyond = surfaces.beyond(points).reshape(CONTOURS, -1)
    if beyond.max() > 0.0:
        axes.contourf(x, y, beyond, [1e-9, beyond.max() + 1e-8], colors=["white"], alpha=0.65)
    axes.set(xlabel=_axis_label(surfaces.parameters[two[0]]), ylabel=_axis_label(surfaces.parameters[two[1]]))
    axes.grid(visible=False)
    return figure


def pareto_front(surfaces: ResponseSurfaces, names: tuple[str, str], front: np.ndarray) -> Figure:
    """Two responses that are traded against each other: the runs, and the front that the surfaces promise."""
    figure, panels = _sheet(5.0, 3.8)
    axes = panels[0, 0]
    x, y = (surfaces.values[:, surfaces.index(name)] for name in names)
    axes.plot(x, y, "o", ms=4, color=GREY, label="runs")
    if len(front):
        axes.plot(*front.T, "-o", ms=3, lw=1.2, color=ORANGE, label="front of the surfaces")
    best = non_dominated(np.column_stack([x, y]))
    axes.plot(x[best], y[best], "o", ms=6, mfc="none", color=BLUE, label="best runs")
    axes.set(xlabel=_label(surfaces, names[0]), ylabel=_label(surfaces, names[1]))
    axes.legend(fontsize=8)
    return figure


def non_dominated(values: np.ndarray) -> np.ndarray:
    """Rows (n, goals) than which no other is better in one goal and as good in all: (n,) bool."""
    worse = (values[None] <= values[:, None]).all(axis=2) & (values[None] < values[:, None]).any(axis=2)
    return ~worse.any(axis=1) & np.isfinite(values).all(axis=1)


def parallel_coordinates(surfaces: ResponseSurfaces, name: str) -> Figure:
    """Every run as a line over the parameters and the response, coloured by the response."""
    figure, panels = _sheet(1.2 + 1.1 * (len(surfaces.parameters) + 1), 3.4)
    axes, values = panels[0, 0], surfaces.values[:, surfaces.index(name)]
    known = np.isfinite(values)
    share = (values[known] - values[known].min()) / max(np.ptp(values[known]), 1e-300)
    lines = np.column_stack([to_unit(surfaces.designs[known], surfaces.parameters), share])
    import matplotlib

    colours = matplotlib.colormaps["viridis"](share)
    for line, colour in zip(lines, colours, strict=True):
        axes.plot(line, color=colour, lw=1.0, alpha=0.8)
    axes.set_xticks(range(lines.shape[1]), [*(p.name for p in surfaces.parameters), name], rotation=25, ha="right")
    axes.set_yticks([0, 1], ["low", "high"])
    axes.grid(axis="y", visible=False)
    return figure


def optimum_history(surfaces: ResponseSurfaces, rounds) -> Figure:
    """Best design of each generation, and what the solver said of the last: one line for each round."""
    figure, panels = _sheet(6.0, 3.4)
    axes = panels[0, 0]
    goal = rounds[0].optimum.goal
    begun = 0
    for number, one in enumerate(rounds, start=1):
        history = one.optimum.generations
        x = begun + np.arange(len(history))
        axes.plot(x, history, color=BLUE, lw=1.4, label="surface" if number == 1 else None)
        begun += len(history)
        value, low, high = one.optimum.responses[goal.response]
        target = 0.0 if goal.target is None else goal.target[1]
        seen = [abs(v - target) if goal.target is not None else v for v in (value, low, high)]
        axes.errorbar(
            [begun], seen[:1], [[abs(seen[0] - seen[1])], [abs(seen[2] - seen[0])]], fmt="o", color=BLUE, capsize=4
        )
        if one.run:
            computed = one.computed[goal.response]
            computed = abs(computed - target) if goal.target is not None else computed
            axes.plot(
                [begun], [computed], "D", color=GREEN if one.holds else RED, label="solver" if number == 1 else None
            )
            axes.annotate(f" run {one.run}", (begun, computed), fontsize=8)
        begun += 8
    axes.set(xlabel="generation", ylabel=_label(surfaces, goal.response))
    axes.legend(fontsize=8)
    return figure


def robustness_histograms(chances: list[Chance]) -> Figure:
    """Scattered responses with percentiles, limit, and the chance of breaking it."""
    rows, columns = _grid(len(chances))
    figure, panels = _sheet(3.4 * columns, 2.7 * rows, rows, columns)
    for axes in panels.ravel()[len(chances) :]:
        axes.set_axis_off()
    for axes, one in zip(panels.ravel(), chances, strict=False):
        axes.hist(one.values, 60, color=LIGHTS[one.light], alpha=0.55, density=True)
        for place in one.percentiles[[0, 2]]:
            axes.axvline(place, color=INK, lw=0.8, ls=":")
        axes.axvline(one.percentiles[1], color=INK, lw=1.0)
        if one.broken:
            for place in (one.limit.above, one.limit.below):
                if place is not None:
                    axes.axvline(place, color=RED, lw=1.6)
            told = f"P({one.broken}) = {one.with_error:.3g}\n({one.low:.2g} to {one.high:.2g})"
            axes.text(0.97, 0.96, told, transform=axes.transAxes, ha="right", va="top", fontsize=8)
        axes.set_title(one.response, fontsize=9)
        axes.set(xlabel="" if one.unit == "-" else f"[{one.unit}]", yticks=[])
        axes.grid(visible=False)
    return figure


def correlation_matrix(surfaces: ResponseSurfaces, ranks: np.ndarray) -> Figure:
    """Scatter of responses against parameters and each other, with Spearman's rank correlation."""
    columns = np.column_stack([to_unit(surfaces.designs, surfaces.parameters), surfaces.values])
    names = [*(p.name for p in surfaces.parameters), *surfaces.names]
    first = len(surfaces.parameters)
    shown = range(first, len(names))
    figure, panels = _sheet(1.15 * len(names) + 0.8, 1.1 * len(surfaces.names) + 0.8, len(surfaces.names), len(names))
    for row, k in enumerate(shown):
        for column in range(len(names)):
            axes, r = panels[row, column], ranks[k, column]
            axes.set(xticks=[], yticks=[])
            if column == k:
                known = columns[:, k][np.isfinite(columns[:, k])]
                axes.hist(known, 12, color=FAINT, edgecolor=GREY)
            else:
                axes.plot(columns[:, column], columns[:, k], ".", ms=2, color=BLUE if column < first else GREY)
                if np.isfinite(r):
                    axes.set_title(f"{r:.2f}", fontsize=7, color=RED if abs(r) > 0.5 else INK, pad=1, loc="right")
            if column == 0:
                axes.set_ylabel(surfaces.names[row], fontsize=7, rotation=0, ha="right")
            if row == len(surfaces.names) - 1:
                axes.set_xlabel(names[column], fontsize=7, rotation=25, ha="right")
    return figure


def anthill(surfaces: ResponseSurfaces, name: str, k: int) -> Figure:
    """One response against the parameter it depends on most, coloured by the feasible side of its limit."""
    figure, panels = _sheet(4.6, 3.4)
    axes, values = panels[0, 0], surfaces.values[:, surfaces.index(name)]
    limit = surfaces.response(name).limit
    fine = np.ones(len(values), bool)
    fine &= values <= limit.below if limit.below is not None else True
    fine &= values >= limit.above if limit.above is not None else True
    for side, colour, label in ((fine, GREEN, "within its limit"), (~fine, RED, "beyond")):
        if side.any() and (limit.below is not None or limit.above is not None):
            axes.plot(surfaces.designs[side, k], values[side], "o", ms=4, color=colour, label=label)
        elif side.any():
            axes.plot(surfaces.designs[side, k], values[side], "o", ms=4, color=BLUE)
    for place in (limit.below, limit.above):
        if place is not None:
            axes.axhline(place, color=RED, lw=1.2)
    axes.set(xlabel=_axis_label(surfaces.parameters[k]), ylabel=_label(surfaces, name))
    if limit.below is not None or limit.above is not None:
        axes.legend(fontsize=8)
    return figure
