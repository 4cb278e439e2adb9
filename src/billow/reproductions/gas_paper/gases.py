"""Examples 5.1, 5.2 and 6.1 of the LS-DYNA paper by several gases, a column for each; or one example on meshes of
several cell sizes. From runs of examples/paper/square_*.toml and flat_driver_*.toml, or of any other case."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from billow.base.plot_style import styled
from billow.injury.filters import channel_filter
from billow.pictures.scene import Plane
from billow.pictures.section_figure import draw_bag, window_of
from billow.results.result import Result

SHOWN = (0.0, 0.2, 1.0 / 3.0, 2.0 / 3.0, 1.0)
"""Times of the shapes, as parts of the shortest run."""
WIDTH, ROW = 13.0, (1.2, 1.7)
"""Of a figure, and bounds of the height of a row of sections [inch]."""
CURVES = (
    ("gas_energy [J]", "internal energy [kJ]", 1e-3, 0.0),
    ("vented [kg]", "outgoing mass [g]", 1e3, 0.0),
    ("pressure [Pa]", "pressure above ambient [kPa]", 1e-3, 1.0),
    ("volume [m^3]", "volume [l]", 1e3, 0.0),
)
"""Column, label, scale, and how many times the ambient pressure is taken off."""
CFC = 60
"""Channel class of the acceleration, as the paper's curves look."""
PUBLISHED = {
    "Square bag, two stages": (21, 2010, 161),
    "Square bag with a vent": (21, 3148, 372),
    "Flat driver": (2546, 110050, 13584),
}
"""Computing times [s] that the paper gives for 5.1, 5.2 and 6.1 (SMP, AMD 2.8 GHz), by the beginning of the title of
our case: uniform pressure, ALE, particles."""
METHODS = {"uniform-pressure": 0, "mesh": 1, "corpuscular": 2}
COLUMNS = {
    "pressure_kPa": "pressure above ambient at the end [kPa]",
    "highest_kPa": "highest [kPa]",
    "volume_l": "volume at the end [l]",
    "outgoing_g": "outgoing mass [g]",
    "energy_kJ": "internal energy at the end [kJ]",
    "apart_percent": "pressure, rms difference from the first in the second half [%]",
    "acceleration_m_s2": f"highest acceleration of what it strikes, CFC {CFC} [m/s²]",
    "velocity_m_s": "its velocity at the end [m/s]",
}


def label(result: Result) -> str:
    """What the gas of a run is, with its particles or cells."""
    gas = result.case_toml["gas"]
    if gas["model"] == "mesh":
        scheme = ", donor" if gas["advection"] == "donor" else ""
        return f"mesh, {1e3 * gas['cell']:g} mm{scheme}"
    return f"{gas['particles']:,} particles" if gas["model"] == "corpuscular" else gas["model"].replace("-", " ")


def motion(result: Result) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times [s]; of the first free obstacle, along z, acceleration [m/s^2], filtered, and velocity [m/s]."""
    h, name = result.histories, result.free_obstacles[0]
    acceleration = channel_filter(h["time [s]"], h[f"{name}_acceleration_z [m/s^2]"], CFC)
    return h["time [s]"], acceleration, h[f"{name}_velocity_z [m/s]"]


def summary(results: Sequence[Result]) -> list[dict[str, float]]:
    """Numbers of each run at the end of the shortest, as COLUMNS."""
    end, table = min(float(result.times[-1]) for result in results), []
    late = np.linspace(0.5 * end, end, 201)
    first = np.interp(late, results[0].histories["time [s]"], results[0].histories["pressure [Pa]"])
    for result in results:
        h, ambient = result.histories, result.case_toml["ambient"]["pressure"]
        pressure = np.interp(late, h["time [s]"], h["pressure [Pa]"])
        last = {name: float(np.interp(end, h["time [s]"], h[name])) for name, *_ in CURVES}
        apart = np.sqrt(np.mean((pressure - first) ** 2)) / np.mean(first - ambient)
        table.append(
            {
                "pressure_kPa": 1e-3 * (last["pressure [Pa]"] - ambient),
                "highest_kPa": 1e-3 * float(h["pressure [Pa]"].max() - ambient),
                "volume_l": 1e3 * last["volume [m^3]"],
                "outgoing_g": 1e3 * last["vented [kg]"],
                "energy_kJ": 1e-3 * last["gas_energy [J]"],
                "apart_percent": 100.0 * float(apart),
            }
        )
        if result.free_obstacles:
            times, acceleration, velocity = motion(result)
            table[-1] |= {
                "acceleration_m_s2": float(acceleration[times <= end].max()),
                "velocity_m_s": float(np.interp(end, times, velocity)),
            }
    return table


def figure_of(results: Mapping[str, Result]) -> Figure:
    """Sections through the middle, a column for each run and a row for each time; below, the curves."""
    plane, end = Plane(np.eye(3)[1], 1e-6), min(float(result.times[-1]) for result in results.values())
    frames = {
        name: [int(np.abs(result.times - share * end).argmin()) for share in SHOWN] for name, result in results.items()
    }
    shapes = {
        name: [results[name].reference + results[name].displacement[k] for k in some] for name, some in frames.items()
    }
    window = window_of(plane, [points for rows in shapes.values() for points in rows])
    (left, right), (low, high) = window
    width, tall = WIDTH / max(len(results), 3), (high - low) / (right - left)
    rows_high = len(SHOWN) * (0.3 + np.clip(width * tall, *ROW))
    figure = Figure((WIDTH, rows_high + 3.2), layout="constrained", dpi=150)
    above, below = figure.subfigures(2, 1, height_ratios=(rows_high, 3.2))
    grid = above.subplots(len(SHOWN), len(results), squeeze=False)
    for column, (name, rows) in zip(grid.T, shapes.items(), strict=True):
        for axes, points, k in zip(column, rows, frames[name], strict=True):
            draw_bag(axes, plane, points, results[name].triangles, colors="#0072b2", linewidths=0.7)
            title = f"{1e3 * results[name].times[k]:.1f} ms"
            title = f"{name}\n{title}" if axes is column[0] else title
            axes.set(xlim=window[0], ylim=window[1], aspect="equal", title=title)
            axes.set_axis_off()
    moves = all(result.free_obstacles for result in results.values())
    curves = [curve for curve in CURVES if any(result.histories[curve[0]].any() for result in results.values())]
    row = below.subplots(1, len(curves) + 2 * moves)  # a bag without a way out lets nothing out
    for axes, (name, text, scale, off) in zip(row, curves, strict=False):
        for run, result in results.items():
            h = result.histories
            axes.plot(1e3 * h["time [s]"], scale * (h[name] - off * result.case_toml["ambient"]["pressure"]), label=run)
        axes.set(xlabel="time [ms]", ylabel=text)
    for run, result in results.items() if moves else ():
        times, *both = motion(result)
        for axes, curve in zip(row[-2:], both, strict=True):
            axes.plot(1e3 * times, curve, label=run)
    for axes, text in zip(row[-2:] if moves else (), ("acceleration [m/s²]", "velocity [m/s]"), strict=False):
        axes.set(xlabel="time [ms]", ylabel=text)
    below.axes[0].legend(fontsize=7)
    return figure


def on_the_way(results: Mapping[str, Result]) -> list[str]:
    """Lines of a table of each run's curves at the times of the shapes."""
    end = min(float(result.times[-1]) for result in results.values())
    times = [share * end for share in SHOWN[1:]]
    lines = [f"| | {' | '.join(f'{1e3 * time:.3g} ms' for time in times)} |", f"|---|{'---|' * len(times)}"]
    for column, text, scale, off in reversed(CURVES):
        for name, result in results.items():
            h, away = result.histories, off * result.case_toml["ambient"]["pressure"]
            values = scale * (np.interp(times, h["time [s]"], h[column]) - away)
            if values.any():
                lines.append(f"| {text}, {name} | {' | '.join(f'{value:.3g}' for value in values)} |")
    for name, result in results.items() if all(result.free_obstacles for result in results.values()) else ():
        moments, _, velocity = motion(result)
        values = " | ".join(f"{value:.3g}" for value in np.interp(times, moments, velocity))
        lines.append(f"| velocity of what it strikes [m/s], {name} | {values} |")
    return lines


def times_taken(results: Mapping[str, Result]) -> list[str]:
    """Lines of a table of computing times, ours and the paper's if it gives any."""
    title = next(iter(results.values())).case_toml["title"]
    published = next((times for start, times in PUBLISHED.items() if title.startswith(start)), None)
    lines = [
        "| | simulated [ms] | clock [s] | processor [s] | threads | the paper, SMP, AMD 2.8 GHz [s] |",
        "|---|---|---|---|---|---|",
    ]
    for name, result in results.items():
        record, method = result.record, METHODS.get(result.case_toml["gas"]["model"])
        theirs = "" if published is None or method is None else f"{published[method]:,}"
        spent = f"{record['processor_seconds']:.0f}" if "processor_seconds" in record else ""
        lines.append(
            f"| {name} | {1e3 * record['simulated_time']:.3g} | {record['wall_seconds']:.0f} | {spent} | "
            f"{record['threads']} | {theirs} |"
        )
    return lines


def write_gases(folder: Path, runs: Sequence[Result]) -> Path:
    """Write gases.md, its figure and its numbers, of runs of one case by several gases or on several meshes. Returns
    the page."""
    names = [f"{k + 1}: {label(result)}" for k, result in enumerate(runs)]
    table, named = dict(zip(names, summary(runs), strict=True)), dict(zip(names, runs, strict=True))
    (folder / "gases.json").write_text(json.dumps(table, indent=1) + "\n")
    with styled():
        figure_of(named).savefig(folder / "gases.png")
    shown = {key: text for key, text in COLUMNS.items() if all(key in row for row in table.values())}
    lines = [
        f"# {runs[0].case_toml['title'] or 'One case'} by several gases", "",
        "Numbers at the end of the shortest run.", "",
        f"| | {' | '.join(shown.values())} |", f"|---|{'---|' * len(shown)}",
        *(f"| {name} | {' | '.join(f'{row[key]:.4g}' for key in shown)} |" for name, row in table.items()), "",
        *on_the_way(named), "",
        *times_taken(named), "",
        "![sections and curves](gases.png)",
    ]  # fmt: skip
    page = folder / "gases.md"
    page.write_text("\n".join(lines) + "\n")
    return page
