"""Section 5.3 of the LS-DYNA paper: a window bag of tubes under pressure side by side (its Figures 11 and 12), from
runs of examples/paper/window_tubes_*.toml.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from billow.base.plot_style import styled
from billow.pictures.scene import Plane
from billow.pictures.section import cut
from billow.pictures.section_figure import draw_bag, window_of
from billow.reproductions.gas_paper.gases import label
from billow.results.result import Result

SHOWN = (2e-3, 5e-3, 10e-3, 20e-3)
"""Times [s] of the sections; the paper's Figure 12 is at 10 ms."""
HALF_WAY = -0.06
"""Place of the section along y [m]: half way between the lower edge of the tubes and their gallery."""
WIDTH = 4.2
"""Width of the column of a gas in the figure [inch]."""
COLUMNS = {
    "simulated_ms": "simulated [ms]",
    "highest_pressure_kPa": "highest pressure [kPa]",
    "volume_l": "volume at the end [l]",
    "roundness": "roundness of the tubes at the end",
    "least_round": "least round",
    "crossings": "crossings at worst",
    "particles_outside": "particles put back",
    "energy_residual_percent": "energy residual [%]",
}


def tubes_across(
    start: np.ndarray, points: np.ndarray, triangles: np.ndarray, tubes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Area [m^2] and girth [m] of each tube along the line of fabric that lies half way along them at the start; so
    they do not depend on how the bag has turned.

    start, points: there and now [m], (nodes, 3); triangles: (triangles, 3), normals outwards; tubes: to which each
    belongs, -1 for none.
    """
    segments, which = cut(start, triangles, Plane(np.eye(3)[1], HALF_WAY), points)
    inside = tubes[which] >= 0
    (one, other), tube = segments[inside].transpose(1, 0, 2), tubes[which][inside]
    corners, y = points[triangles[which[inside]]], start[triangles[which[inside]], 1]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    upwards = np.einsum("ij,ijk->ik", y - y.mean(axis=1, keepdims=True), corners)
    middle = np.stack([np.bincount(tube, x) / np.bincount(tube) for x in (0.5 * (one + other)).T], axis=1)[tube]
    vector = 0.5 * np.cross(one - middle, other - middle)
    # One sense around a tube, whatever the order of the ends.
    vector *= np.sign(np.sum(np.cross(normal, other - one) * upwards, axis=1))[:, None]
    area = np.linalg.norm(np.stack([np.bincount(tube, x) for x in vector.T], axis=1), axis=1)
    return area, np.bincount(tube, np.linalg.norm(other - one, axis=1))


def roundness(result: Result, frame: int) -> np.ndarray:
    """4 pi area / girth^2 of each tube: 1 for a circle, 0 for a flat one."""
    bag = result.case_toml["bag"]
    walls = np.linspace(-0.5, 0.5, bag["tubes"] + 1) * bag["length"]
    triangles = result.triangles
    tube = np.searchsorted(walls[1:-1], result.reference[triangles].mean(axis=1)[:, 0])
    panels = [k for k, name in enumerate(result.fabric.part_names) if name in ("front", "rear")]
    is_fabric = np.isin(result.fabric.part, panels)
    area, girth = tubes_across(
        result.reference, result.reference + result.displacement[frame], triangles, np.where(is_fabric, tube, -1)
    )
    return 4.0 * np.pi * area / girth**2


def summary(result: Result) -> dict[str, float]:
    """Numbers of a run, as COLUMNS."""
    last, h = roundness(result, len(result.times) - 1), result.histories
    return {
        "simulated_ms": 1e3 * h["time [s]"][-1],
        "highest_pressure_kPa": 1e-3 * (h["pressure [Pa]"].max() - result.case_toml["ambient"]["pressure"]),
        "volume_l": 1e3 * h["volume [m^3]"][-1],
        "roundness": float(last.mean()),
        "least_round": float(last.min()),
        "crossings": result.ledger["crossings_at_worst"],
        "particles_outside": result.ledger.get("leaked_particles", 0.0),
        "energy_residual_percent": 100.0 * result.ledger["energy_residual_of_largest"],
    }


def sections(results: Mapping[str, Result]) -> Figure:
    """A column for each gas, a row for each time."""
    plane, shapes = Plane(np.eye(3)[1], HALF_WAY), {}
    for name, result in results.items():
        end = result.times[-1]
        reached = [time for time in SHOWN if time <= end + 5e-4] or [end]
        frames = [int(np.abs(result.times - time).argmin()) for time in reached]
        shapes[name] = [(result.times[k], result.reference + result.displacement[k]) for k in frames]
    window = window_of(plane, [points for rows in shapes.values() for _, points in rows])
    (left, right), (bottom, top) = window
    height = WIDTH * (top - bottom) / (right - left) + 0.35  # [inch] of a row with its title
    figure = Figure((WIDTH * len(results), height * len(SHOWN) + 0.3), layout="constrained", dpi=150)
    grid = figure.subplots(len(SHOWN), len(results), squeeze=False, sharex=True, sharey=True)
    for column, (name, rows) in zip(grid.T, shapes.items(), strict=True):
        for axes in column[len(rows) :]:
            axes.set_axis_off()
        for axes, (time, points) in zip(column, rows, strict=False):
            draw_bag(axes, plane, points, results[name].triangles, colors="#0072b2", linewidths=0.7)
            axes.set(xlim=window[0], ylim=window[1], aspect="equal", title=f"{name}, {1e3 * time:.3g} ms")
            axes.tick_params(labelsize=7)
    figure.supxlabel("mm", fontsize=8)
    return figure


def write_tubes(folder: Path, runs: Sequence[Result]) -> Path:
    """Write tubes.md, its figure and its numbers, of runs by one gas each. Returns the page."""
    results = {f"{k + 1}: {label(result)}": result for k, result in enumerate(runs)}
    table = {name: summary(result) for name, result in results.items()}
    (folder / "tubes.json").write_text(json.dumps(table, indent=1) + "\n")
    with styled():
        sections(results).savefig(folder / "tubes_sections.png")
    lines = [
        "# LS-DYNA paper, section 5.3: tubes of a window bag side by side", "",
        "Sections half way along the tubes, of runs of `examples/paper/window_tubes_*.toml`. With the mesh gas of the",
        "paper, patches of fabric stick in each other (Figures 11 and 12). Roundness is 4 pi area over girth squared",
        "of the line of fabric half way along a tube, 1 for a circle.", "",
        f"| | {' | '.join(COLUMNS.values())} |", f"|---|{'---|' * len(COLUMNS)}",
        *(f"| {name} | {' | '.join(f'{row[key]:.4g}' for key in COLUMNS)} |" for name, row in table.items()), "",
        "![sections](tubes_sections.png)",
    ]  # fmt: skip
    page = folder / "tubes.md"
    page.write_text("\n".join(lines) + "\n")
    return page
