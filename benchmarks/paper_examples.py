"""Examples 5.1, 5.2 and 6.1 of the LS-DYNA paper, by uniform pressure, by particles and on a mesh.

    python benchmarks/paper_examples.py [EXAMPLE ...] --runs FOLDER [--out validation/particles] [--threads 1]

Runs what is not in the folder of runs yet, then draws what the paper shows (shapes, internal energy, outgoing mass,
pressure, motion of the hemisphere) and writes the curves and a table of energies and computing times. A run that had to
be stopped is drawn as far as it came, and the table says so.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import time
import tomllib
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from billow.base.errors import NumericalStop
from billow.base.plot_style import STYLE
from billow.case.gas.build_gas import GasNames
from billow.case.schema import Case
from billow.injury.criteria import mean_acceleration
from billow.injury.filters import channel_filter
from billow.parts.gas.supply.mixture import mixture_enthalpy
from billow.parts.gas.supply.species import AIR, thermo_table
from billow.results.result import Result
from billow.run.simulate import simulate

ROOT = Path(__file__).parents[1]
MODELS = {
    "up": "uniform pressure",
    "up_no_jets": "uniform pressure without jets",
    "particles": "particles",
    "mesh": "mesh",
}
THREE = ("up", "particles", "mesh")
COLOURS = {"up": "#0072b2", "up_no_jets": "#009e73", "particles": "#d55e00", "mesh": "#cc79a7"}
CELLS = {"square_two_stage": 0.018, "square_spinning_jet": 0.018, "flat_driver": 0.0085}
"""Edge of a cell of the mesh gas [m]: about 27,000 and 350,000 in a box about the bag, as in the paper."""
LIGHT = np.array([-0.35, -0.5, 0.8]) / np.linalg.norm([-0.35, -0.5, 0.8])
SIDE, TOP = (0, 2, 1), (0, 1, 2)
"""Axes of a view: to the right, up, and the one looked along."""

PRESSURE = ("pressure [Pa]", "pressure above ambient [kPa]", 1e-3)
ENERGY = ("gas_energy [J]", "internal energy [kJ]", 1e-3)
OUTGOING = ("vented [kg]", "outgoing mass [g]", 1e3)
ACCELERATION = ("hemisphere_acceleration_z [m/s^2]", "acceleration, CFC 60 [m/s²]", 1.0)
VELOCITY = ("hemisphere_velocity_z [m/s]", "velocity [m/s]", 1.0)

EXAMPLES = {
    "square_two_stage": {
        "shapes": {"side": SIDE},
        "times": (0.0, 1e-3, 3e-3, 10e-3),
        "curves": (ENERGY, PRESSURE),
        "models": THREE,
    },
    "square_spinning_jet": {
        "shapes": {"top": TOP, "side": SIDE},
        "times": (2e-3, 4.5e-3, 7e-3, 9.5e-3, 15e-3),
        "curves": (OUTGOING, PRESSURE, ENERGY),
        "models": THREE,
    },
    "flat_driver": {
        "shapes": {"side": SIDE},
        "times": (2e-3, 5e-3, 10e-3, 20e-3, 40e-3),
        "curves": (ACCELERATION, VELOCITY, PRESSURE, ENERGY),
        "models": tuple(MODELS),
    },
}
"""What the paper's figures 6, 7, 9, 10 and 16 show of each. In 6.1 the paper's uniform pressure has no jets
(*AIRBAG_HYBRID), ours otherwise pushes with them; both are run there."""


def load(example: str, model: str) -> Case:
    """One case of a pair, the one by uniform pressure without its jets, or on a mesh, "mesh" or "mesh12" for cells of
    12 mm."""
    if model.startswith("mesh"):
        cell = 1e-3 * float(model.removeprefix("mesh")) if model != "mesh" else CELLS[example]
        return load(example, "up").vary({"gas.model": "mesh", "gas.cell": cell})
    path = ROOT / "examples" / "paper" / f"{example}_{model.removesuffix('_no_jets')}.toml"
    if not model.endswith("_no_jets"):
        return Case.load(path)
    without = tomllib.loads(path.read_text())
    without["inflator"]["jets"]["count"] = 0
    return Case.from_dict(without)


def run_once(example: str, model: str, runs: Path, threads: int) -> tuple[Result, dict]:
    """The run of one case, made if it is not there, and how long it took on how busy a machine."""
    folder = runs / f"{example}_{model}"
    cost = folder.with_suffix(".cost.json")
    if not cost.exists():
        busy, begun, spent = os.getloadavg()[0], time.perf_counter(), time.process_time()
        try:
            simulate(load(example, model), folder, threads=threads)
        except NumericalStop as stop:
            print(stop)
        cost.write_text(
            json.dumps(
                {
                    "wall_seconds": round(time.perf_counter() - begun, 1),
                    "processor_seconds": round(time.process_time() - spent, 1),
                    "threads": threads,
                    "load_before_and_after": [busy, os.getloadavg()[0]],
                }
            )
        )
    return Result.open(folder), json.loads(cost.read_text())


def draw_shape(axes, result: Result, time: float, view: tuple[int, int, int]) -> None:
    """The fabric at the frame nearest to a time [s], shaded, farthest triangles first."""
    frame = int(np.abs(result.times - time).argmin())
    right, up, along = view
    corners = (result.reference + result.displacement[frame])[result.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    towards = 1.0 if view == TOP else -1.0  # seen from above, or from the front
    order = np.argsort(towards * corners[:, :, along].mean(axis=1))
    grey = (0.3 + 0.65 * np.abs(normals @ LIGHT))[order]
    axes.add_collection(
        PolyCollection(
            corners[order][:, :, [right, up]],
            facecolors=np.column_stack([0.85 * grey, 0.93 * grey, grey]),
            edgecolors="face",
            linewidths=0.1,
        )
    )
    for obstacle in result.case_toml["obstacles"]:
        if obstacle["shape"] == "super-ellipsoid":
            rows = int(np.abs(result.histories["time [s]"] - time).argmin())
            name, angle = obstacle["name"], np.linspace(-np.pi, 0.0)  # the lower half
            place = [result.histories[f"{name}_centre_{axis} [m]"][rows] for axis in "xyz"]
            radius = obstacle["radii"]
            axes.plot(place[right] + radius * np.cos(angle), place[up] + radius * np.sin(angle), color="#22303c", lw=1)
    axes.set_aspect("equal")
    axes.set(xlim=(-0.38, 0.38), ylim=(-0.38, 0.38) if view == TOP else (-0.25, 0.45), xticks=[], yticks=[])
    axes.grid(False)
    axes.set_title(f"{1e3 * result.times[frame]:.1f} ms", fontsize=8)


def draw_shapes(results: dict[str, Result], times: tuple, views: dict) -> Figure:
    """A row of shapes for each model and view; a place is empty where a run did not come so far."""
    rows = [(model, name) for model in results for name in views]
    figure = Figure((1.9 * len(times), 1.9 * len(rows)), layout="constrained", dpi=150)
    grid = figure.subplots(len(rows), len(times), squeeze=False)
    for (model, name), row in zip(rows, grid, strict=True):
        row[0].text(-0.05, 0.5, f"{MODELS[model]}, {name}", rotation=90, va="center", transform=row[0].transAxes)
        for axes, instant in zip(row, times, strict=True):
            if instant <= results[model].times[-1] + 5e-4:
                draw_shape(axes, results[model], instant, views[name])
            else:
                axes.set_axis_off()
    return figure


def draw_curves(results: dict[str, Result], curves: tuple) -> Figure:
    """Each quantity against time, by both models; cut at three times what uniform pressure reaches, because a run that
    had to be stopped would hide the other."""
    figure = Figure((3.4 * len(curves), 3.0), layout="constrained", dpi=150)
    for axes, (column, label, scale) in zip(figure.subplots(1, len(curves), squeeze=False)[0], curves, strict=True):
        for model, result in results.items():
            h = result.histories
            offset = result.case_toml["ambient"]["pressure"] if column == PRESSURE[0] else 0.0
            times, values = h["time [s]"], scale * (h[column] - offset)
            if column == ACCELERATION[0]:
                times, values = mean_acceleration(times, h[VELOCITY[0]])
                values = channel_filter(times, values, 60)
            axes.plot(1e3 * times, values, color=COLOURS[model], lw=1.1, label=MODELS[model])
            if model == "up":
                most = 3.0 * np.abs(values).max()
        low, high = axes.get_ylim()
        axes.set(xlabel="time [ms]", ylabel=label, ylim=(max(low, -most), min(high, most)))
    axes.legend()
    return figure


def write_curves(path: Path, results: dict[str, Result], curves: tuple) -> None:
    """The same numbers as CSV, on the rows of the run that came farthest."""
    longest = max((result.histories["time [s]"] for result in results.values()), key=len)
    columns = {"time [s]": longest}
    for column, _, _ in (*curves, ("enthalpy_in [J]", "", 1.0), ("volume [m^3]", "", 1.0)):
        for model, result in results.items():
            values = result.histories[column]
            columns[f"{model} {column}"] = np.append(values, np.full(len(longest) - len(values), np.nan))
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(columns)
        table.writerows([f"{value:.6g}" for value in row] for row in zip(*columns.values(), strict=True))


def air_enthalpy(case: Case) -> float:
    """Of the surroundings [J/kg]."""
    gas = GasNames.of(case)
    return mixture_enthalpy(thermo_table(list(gas.species)), gas.mass_fractions(AIR), case.ambient.temperature)


def summary(case: Case, result: Result, cost: dict) -> dict:
    """One row of the table."""
    h, record = result.histories, result.record
    drawn = h["drawn_in [kg]"][-1]
    gauge = h["pressure [Pa]"] - result.case_toml["ambient"]["pressure"]
    row = {
        "status": result.status,
        "reason": record.get("reason"),
        "simulated_ms": 1e3 * h["time [s]"][-1],
        "triangles": len(result.triangles),
        "energy_put_in_J": h["enthalpy_in [J]"][-1] - drawn * air_enthalpy(case),
        "air_drawn_in_g": 1e3 * drawn,
        "mass_put_in_g": 1e3 * h["injected [kg]"][-1],
        "outgoing_mass_g": 1e3 * h["vented [kg]"][-1],
        "highest_pressure_kPa": 1e-3 * gauge.max(),
        "largest_volume_l": 1e3 * h["volume [m^3]"].max(),
        "energy_residual_of_largest": result.ledger["energy_residual_of_largest"],
        "escaped": result.ledger.get("leaked_particles", 0),
        **cost,
    }
    if VELOCITY[0] in h:
        row["highest_acceleration_m_s2"] = h[ACCELERATION[0]].max()
        row["last_velocity_m_s"] = h[VELOCITY[0]][-1]
    return row


COLUMNS = {
    "simulated": ("simulated_ms", "{:.1f} ms"),
    "energy put in": ("energy_put_in_J", "{:,.1f} J"),
    "highest pressure": ("highest_pressure_kPa", "{:.1f} kPa"),
    "largest volume": ("largest_volume_l", "{:.1f} l"),
    "outgoing mass": ("outgoing_mass_g", "{:.2f} g"),
    "energy residual": ("energy_residual_of_largest", "{:.2%}"),
    "particles put back": ("escaped", "{:.0f}"),
    "hemisphere at the end": ("last_velocity_m_s", "{:.2f} m/s"),
    "computing time": ("wall_seconds", "{:.0f} s"),
    "processor time": ("processor_seconds", "{:.0f} s"),
}


def write_page(folder: Path) -> None:
    """README.md of the folder, from the tables and figures there are."""
    lines = [
        "# Examples of the LS-DYNA paper, by uniform pressure and by particles", "",
        "Written by `benchmarks/paper_examples.py`; cases in [examples/paper](../../examples/paper/README.md).",
        "Computing times are of shared machines; the tables (`*.json`) hold threads and load of each run.",
    ]  # fmt: skip
    for example, shown in EXAMPLES.items():
        path = folder / f"{example}.json"
        if not path.exists():
            continue
        table = json.loads(path.read_text())
        lines += ["", f"## {load(example, 'up').title}", "", f"| | {' | '.join(COLUMNS)} |"]
        lines += [f"|---|{'---|' * len(COLUMNS)}"]
        for model in (name for name in shown["models"] if name in table):
            cells = [text.format(table[model][key]) if key in table[model] else "" for key, text in COLUMNS.values()]
            lines.append(f"| {MODELS[model]} | {' | '.join(cells)} |")
        lines += ["", f"![shapes]({example}_shapes.png)", "", f"![curves]({example}_curves.png)"]
    if (folder / "convergence").exists():
        lines += ["", "## How many particles are enough", "", "What `billow converge` found for the case in"]
        lines += ["[convergence](convergence/case.toml):", ""]
        lines += [f"![{name}](convergence/{name}.png)" for name in ("errors", "curves")]
    (folder / "README.md").write_text("\n".join(lines) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("examples", nargs="*", metavar="EXAMPLE", help=", ".join(EXAMPLES))
    parser.add_argument("--runs", type=Path, required=True, help="folder of runs; what is there is not run again")
    parser.add_argument("--out", type=Path, default=ROOT / "validation" / "particles")
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    if unknown := set(arguments.examples) - set(EXAMPLES):
        parser.error(f"no example {unknown.pop()!r}")
    arguments.runs.mkdir(parents=True, exist_ok=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    for example in arguments.examples or EXAMPLES:
        shown = EXAMPLES[example]
        made = {model: run_once(example, model, arguments.runs, arguments.threads) for model in shown["models"]}
        results = {model: result for model, (result, _) in made.items()}
        table = {model: summary(load(example, model), result, cost) for model, (result, cost) in made.items()}
        (arguments.out / f"{example}.json").write_text(json.dumps(table, indent=1, default=float) + "\n")
        write_curves(arguments.out / f"{example}.csv", results, shown["curves"])
        with matplotlib.rc_context(STYLE):
            draw_shapes(results, shown["times"], shown["shapes"]).savefig(arguments.out / f"{example}_shapes.png")
            draw_curves(results, shown["curves"]).savefig(arguments.out / f"{example}_curves.png")
        for model, row in table.items():
            print(example, model, " ".join(f"{k}={v}" for k, v in row.items()))
    write_page(arguments.out)


if __name__ == "__main__":
    main()
