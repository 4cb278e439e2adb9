"""Examples 5.1, 5.2, 5.4, 6.1 and 6.2 of the LS-DYNA paper, by uniform pressure, by particles and on a mesh.

    python benchmarks/paper_examples.py [EXAMPLE ...] --runs FOLDER [--out validation] [--threads 1] [--coarse]

Runs what is not in the folder of runs yet, then draws what the paper shows (shapes or sections, internal energy,
outgoing mass, pressure, motion of the hemisphere) and writes the curves and a table of energies and computing times,
into validation/particles for bags that start flat and validation/folding for folded ones. A run that had to be stopped
is drawn as far as it came, and the table says so. Folded bags are run three times: particles with other seeds, uniform
pressure with slightly other steps. --coarse: elements and particles for a quick look, in tables of their own.
--models: only these of an example; the table keeps the rows of others.
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
from matplotlib.patches import Circle

from billow.base.errors import NumericalStop
from billow.base.plot_style import STYLE
from billow.case.bag.build_bag import build_shape, fold_plan
from billow.case.gas.build_gas import GasNames
from billow.case.schema import Case
from billow.geometry.folding.fold_plan import panel_side
from billow.injury.criteria import mean_acceleration
from billow.injury.filters import channel_filter
from billow.parts.gas.supply.mixture import mixture_enthalpy
from billow.parts.gas.supply.species import AIR, thermo_table
from billow.pictures.scene import Plane
from billow.pictures.section_figure import OBSTACLE, draw_bag
from billow.results.result import Result
from billow.run.simulate import simulate

ROOT = Path(__file__).parents[1]
MODELS = {
    "up": "uniform pressure", "up_no_jets": "uniform pressure without jets", "particles": "particles", "mesh": "mesh",
    **{f"up_{k}": f"uniform pressure, again {k}" for k in (2, 3)},
    **{f"particles_{k}": f"particles, seed {k}" for k in (2, 3)},
}  # fmt: skip
PAIR = ("up", "particles")
THREE = (*PAIR, "mesh")
AGAIN = ("up", "up_2", "up_3", "particles", "particles_2", "particles_3", "mesh")
COLOURS = {"up": "#0072b2", "up_no_jets": "#009e73", "particles": "#d55e00", "mesh": "#cc79a7"}
COARSE = {"bag.element_size": 0.02, "gas.particles": 20_000}
COARSELY = "_coarse"
"""At the end of the names of tables and figures."""
CELLS = {
    "square_two_stage": 0.018, "square_spinning_jet": 0.018, "flat_driver": 0.0085, "folded_tube": 0.010,
    "folded_driver": 0.012,
}  # fmt: skip
"""Edge of a cell of the mesh gas [m]: about 27,000 and 350,000 in a box about bags that start flat, as in the paper;
for folded ones one to two edges of the fabric."""
LIGHT = np.array([-0.35, -0.5, 0.8]) / np.linalg.norm([-0.35, -0.5, 0.8])
SIDE, TOP = (0, 2, 1), (0, 1, 2)
"""Axes of a view: to the right, up, and the one looked along."""

PRESSURE = ("pressure [Pa]", "pressure above ambient [kPa]", 1e-3)
ENERGY = ("gas_energy [J]", "internal energy [kJ]", 1e-3)
OUTGOING = ("vented [kg]", "outgoing mass [g]", 1e3)
ACCELERATION = ("hemisphere_acceleration_z [m/s^2]", "acceleration, CFC 60 [m/s²]", 1.0)
VOLUME = ("volume [m^3]", "volume [l]", 1e3)
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
        "models": ("up", "up_no_jets", "particles", "mesh"),
    },
    "folded_tube": {
        "shapes": {"section": SIDE},
        "times": (0.0, 5e-3, 10e-3, 15e-3, 20e-3),
        "window": ((-0.85, 0.15), (-0.02, 0.98)),
        "curves": (PRESSURE, VOLUME, ENERGY),
        "models": AGAIN,
    },
    "folded_driver": {
        "shapes": {"section": SIDE},
        "times": (0.0, 2e-3, 5e-3, 10e-3, 20e-3, 40e-3),
        "window": ((-0.38, 0.38), (-0.02, 0.65)),
        "curves": (ACCELERATION, VELOCITY, PRESSURE, VOLUME),
        "models": (*AGAIN, "up_no_jets"),
    },
}
"""What the paper's figures 6, 7, 9, 10, 14, 16 and 18 show of each; folded bags, which have a window [m], as sections.
In 6.1 the paper's uniform pressure has no jets (*AIRBAG_HYBRID), ours otherwise pushes with them; both are run
there."""


def load(example: str, model: str, coarse: bool = False) -> Case:
    """One case of a pair, the one by uniform pressure without its jets, one run again, or on
    a mesh: "mesh", or "mesh12" for cells of 12 mm."""
    if model.startswith("mesh"):
        cell = 1e-3 * float(model.removeprefix("mesh")) if model != "mesh" else CELLS[example]
        return load(example, "up", coarse).vary({"gas.model": "mesh", "gas.cell": cell})
    kind, _, again = model.removesuffix("_no_jets").partition("_")
    path = ROOT / "examples" / "paper" / f"{example}_{kind}.toml"
    if model.endswith("_no_jets"):
        without = tomllib.loads(path.read_text())
        without["inflator"]["jets"]["count"] = 0
        case = Case.from_dict(without)
    else:
        case = Case.load(path)
    if again:
        dt_scale = case.run.dt_scale * (1.0 - 0.005 * int(again))
        case = case.vary({"gas.seed": int(again)} if kind == "particles" else {"run.dt_scale": dt_scale})
    return case.vary(COARSE) if coarse else case


def run_once(example: str, model: str, runs: Path, threads: int, coarse: bool) -> tuple[Result, dict]:
    """The run of one case, made if it is not there, and how long it took on how busy a machine."""
    folder = runs / f"{example}_{model}"
    cost = folder.with_suffix(".cost.json")
    if not cost.exists():
        busy, begun, spent = os.getloadavg()[0], time.perf_counter(), time.process_time()
        try:
            simulate(load(example, model, coarse), folder, threads=threads)
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


def draw_section(axes, result: Result, time: float, window: tuple) -> None:
    """What the plane y = 0 cuts of bag and hemisphere at the frame nearest to a time [s]."""
    frame = int(np.abs(result.times - time).argmin())
    plane = Plane(np.array([0.0, 1.0, 0.0]), 1e-6)
    draw_bag(axes, plane, result.reference + result.displacement[frame], result.triangles, colors="#22303c", lw=0.7)
    for obstacle in result.case_toml["obstacles"]:
        if obstacle["shape"] == "super-ellipsoid":
            row, name = int(np.abs(result.histories["time [s]"] - time).argmin()), obstacle["name"]
            x, z = (1e3 * result.histories[f"{name}_centre_{axis} [m]"][row] for axis in "xz")
            axes.add_patch(Circle((x, z), 1e3 * obstacle["radii"], color=OBSTACLE))
    axes.axhline(0.0, color="#9aa5ad", lw=0.8)
    axes.set_aspect("equal")
    axes.set(xlim=1e3 * np.array(window[0]), ylim=1e3 * np.array(window[1]), xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    axes.grid(False)
    axes.set_title(f"{1e3 * result.times[frame]:.1f} ms", fontsize=8)


def openings(result: Result, case: Case) -> np.ndarray:
    """Mean distance [m] of the two panels in each quarter of the folded tube, from the mouth on, (frames, 4)."""
    plan, shape = fold_plan(case.bag), build_shape(case.bag)
    flat = plan.unfolded(shape.positions)
    side, order = panel_side(shape, flat), {}
    for node in np.flatnonzero(side):
        order.setdefault(tuple(flat[node, :2].round(6)), {})[side[node]] = node
    front, rear = np.array([[pair[1.0], pair[-1.0]] for pair in order.values() if len(pair) == 2]).T
    quarter = np.minimum(3, (4.0 * (flat[front, 0] / case.bag.length + 0.5)).astype(int))
    frames = (result.reference + moved for moved in result.displacement)
    apart = [np.linalg.norm(nodes[front] - nodes[rear], axis=1) for nodes in frames]
    return np.array([[row[quarter == k].mean() for k in range(4)] for row in apart])


def draw_openings(results: dict[str, Result], cases: dict[str, Case]) -> Figure:
    """How far each quarter of the tube is open against time, by each gas."""
    shown = [model for model in THREE if model in results]
    figure = Figure((3.5 * len(shown), 2.8), layout="constrained", dpi=150)
    for axes, model in zip(figure.subplots(1, len(shown), sharey=True), shown, strict=True):
        apart = openings(results[model], cases[model])
        for k, shade in enumerate((0.0, 0.25, 0.5, 0.75)):
            axes.plot(1e3 * results[model].times, 1e3 * apart[:, k], color=str(shade), label=f"quarter {k + 1}")
        axes.set(xlabel="time [ms]", title=MODELS[model])
    figure.axes[0].set(ylabel="panels apart [mm]")
    figure.axes[0].legend()
    return figure


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


def draw_shapes(results: dict[str, Result], times: tuple, views: dict, window: tuple | None = None) -> Figure:
    """A row of shapes, or sections in a window [m], for each model and view; a place is empty where a run did not come
    so far."""
    rows = [(model, name) for model in results for name in views]
    figure = Figure((1.9 * len(times), 1.9 * len(rows)), layout="constrained", dpi=150)
    grid = figure.subplots(len(rows), len(times), squeeze=False)
    for (model, name), row in zip(rows, grid, strict=True):
        label = f"{MODELS[model]}, {name}"
        row[0].text(-0.05, 0.5, label, rotation=90, va="center", ha="right", size=7, transform=row[0].transAxes)
        for axes, instant in zip(row, times, strict=True):
            if instant <= results[model].times[-1] + 5e-4:
                if window:
                    draw_section(axes, results[model], instant, window)
                else:
                    draw_shape(axes, results[model], instant, views[name])
            else:
                axes.set_axis_off()
    return figure


def draw_curves(results: dict[str, Result], curves: tuple) -> Figure:
    """Each quantity against time, by both models; cut at three times what uniform pressure reaches, because a run that
    had to be stopped would hide the other."""
    figure = Figure((3.4 * len(curves), 3.0), layout="constrained", dpi=150)
    for axes, (column, label, scale) in zip(figure.subplots(1, len(curves), squeeze=False)[0], curves, strict=True):
        most = np.inf
        for model, result in results.items():
            h = result.histories
            offset = result.case_toml["ambient"]["pressure"] if column == PRESSURE[0] else 0.0
            times, values = h["time [s]"], scale * (h[column] - offset)
            if column == ACCELERATION[0]:
                times, values = mean_acceleration(times, h[VELOCITY[0]])
                values = channel_filter(times, values, 60)
            kind, _, again = model.partition("_") if model not in COLOURS else (model, "", "")
            axes.plot(
                1e3 * times, values, color=COLOURS[kind], lw=0.6 if again else 1.1, alpha=0.5 if again else 1.0,
                label=None if again else MODELS[model],
            )  # fmt: skip
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
    for column in dict.fromkeys([*(column for column, _, _ in curves), "enthalpy_in [J]", "volume [m^3]"]):
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
        "last_volume_l": 1e3 * h["volume [m^3]"][h["time [s]"] > 0.9 * h["time [s]"][-1]].mean(),
        "verdict": record["quality"]["verdict"],
        **cost,
    }
    for key in ("crossings_at_worst", "layer_impact_of_gas_work"):
        if "layer_impact_of_gas_work" in result.ledger:
            row[key] = result.ledger[key]
    if VELOCITY[0] in h:
        row["highest_acceleration_m_s2"] = h[ACCELERATION[0]].max()
        row["last_velocity_m_s"] = h[VELOCITY[0]][-1]
    return row


COLUMNS = {
    "triangles": ("triangles", "{:,}"),
    "simulated": ("simulated_ms", "{:.1f} ms"),
    "energy put in": ("energy_put_in_J", "{:,.1f} J"),
    "highest pressure": ("highest_pressure_kPa", "{:.1f} kPa"),
    "largest volume": ("largest_volume_l", "{:.1f} l"),
    "outgoing mass": ("outgoing_mass_g", "{:.2f} g"),
    "energy residual": ("energy_residual_of_largest", "{:.2%}"),
    "particles put back": ("escaped", "{:.0f}"),
    "crossings": ("crossings_at_worst", "{:.0f}"),
    "heat of layers, of the gas' work": ("layer_impact_of_gas_work", "{:.1%}"),
    "volume at the end": ("last_volume_l", "{:.2f} l"),
    "highest acceleration": ("highest_acceleration_m_s2", "{:.0f} m/s²"),
    "verdict": ("verdict", "{}"),
    "hemisphere at the end": ("last_velocity_m_s", "{:.2f} m/s"),
    "computing time": ("wall_seconds", "{:.0f} s"),
    "processor time": ("processor_seconds", "{:.0f} s"),
}


def write_page(folder: Path) -> None:
    """README.md of the folder, from the tables and figures there are."""
    lines = [
        "# Examples of the LS-DYNA paper, by every gas", "",
        "Written by `benchmarks/paper_examples.py`; cases in [examples/paper](../../examples/paper/README.md).",
        "Computing times are of shared machines; the tables (`*.json`) hold threads and load of each run.",
    ]  # fmt: skip
    for example, name in ((example, example + suffix) for example in EXAMPLES for suffix in ("", COARSELY)):
        path = folder / f"{name}.json"
        if not path.exists():
            continue
        table = json.loads(path.read_text())
        columns = {column: how for column, how in COLUMNS.items() if any(how[0] in row for row in table.values())}
        title = load(example, "up").title + (": a quick look, elements of 20 mm" if name.endswith(COARSELY) else "")
        lines += ["", f"## {title}", "", f"| | {' | '.join(columns)} |", f"|---|{'---|' * len(columns)}"]
        for model, row in table.items():
            cells = [text.format(row[key]) if key in row else "" for key, text in columns.values()]
            lines.append(f"| {MODELS[model]} | {' | '.join(cells)} |")
        shown = [kind for kind in ("shapes", "openings", "curves") if (folder / f"{name}_{kind}.png").exists()]
        lines += [line for kind in shown for line in ("", f"![{kind}]({name}_{kind}.png)")]
    if (folder / "convergence").exists():
        lines += ["", "## How many particles are enough", "", "What `billow converge` found for the case in"]
        lines += ["[convergence](convergence/case.toml):", ""]
        lines += [f"![{name}](convergence/{name}.png)" for name in ("errors", "curves")]
    notes = folder / "notes.md"  # written by hand
    lines += ["", notes.read_text().rstrip()] if notes.exists() else []
    (folder / "README.md").write_text("\n".join(lines) + "\n")


def report(example: str, arguments: argparse.Namespace) -> Path:
    """Run, draw and write one example; returns its folder."""
    shown = EXAMPLES[example]
    out = arguments.out / ("folding" if "window" in shown else "particles")
    out.mkdir(parents=True, exist_ok=True)
    models = [m for m in shown["models"] if not m[-1].isdigit() or int(m[-1]) <= arguments.repeats]
    models = [m for m in models if not arguments.models or m in arguments.models]
    name = example + (COARSELY if arguments.coarse else "")
    cases = {model: load(example, model, arguments.coarse) for model in models}
    made = {model: run_once(example, model, arguments.runs, arguments.threads, arguments.coarse) for model in models}
    results = {model: result for model, (result, _) in made.items()}
    table = {model: summary(cases[model], result, cost) for model, (result, cost) in made.items()}
    path = out / f"{name}.json"
    others = json.loads(path.read_text()) if arguments.models and path.exists() else {}
    path.write_text(json.dumps(others | table, indent=1, default=float) + "\n")
    write_curves(out / f"{name}.csv", results, shown["curves"])
    with matplotlib.rc_context(STYLE):
        window = shown.get("window")
        drawn = {model: result for model, result in results.items() if not window or model in THREE}
        draw_shapes(drawn, shown["times"], shown["shapes"], window).savefig(out / f"{name}_shapes.png")
        draw_curves(results, shown["curves"]).savefig(out / f"{name}_curves.png")
        if example == "folded_tube" and set(PAIR) <= set(results):
            draw_openings(results, cases).savefig(out / f"{name}_openings.png")
    for model, row in table.items():
        print(example, model, " ".join(f"{k}={v}" for k, v in row.items()))
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("examples", nargs="*", metavar="EXAMPLE", help=", ".join(EXAMPLES))
    parser.add_argument("--runs", type=Path, required=True, help="folder of runs; what is there is not run again")
    parser.add_argument("--out", type=Path, default=ROOT / "validation")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--coarse", action="store_true", help="20 mm elements, 20,000 particles")
    parser.add_argument("--repeats", type=int, default=3, choices=(1, 2, 3), help="runs of each folded case")
    parser.add_argument("--models", nargs="+", choices=MODELS, metavar="MODEL", help="only these: " + ", ".join(MODELS))
    arguments = parser.parse_args()
    if unknown := set(arguments.examples) - set(EXAMPLES):
        parser.error(f"no example {unknown.pop()!r}")
    arguments.runs.mkdir(parents=True, exist_ok=True)
    for folder in {report(example, arguments) for example in arguments.examples or EXAMPLES}:
        write_page(folder)


if __name__ == "__main__":
    main()
