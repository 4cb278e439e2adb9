"""Bags folded at random open by uniform pressure and by particles: crossings of fabric, counted at every frame.

    python benchmarks/random_folds.py --runs FOLDER [--count 20] [--seed 1] [--workers 2] [--out validation/folding]

Draws kinds of folds, lines, directions, gaps between layers, diameters and meshes of 5 to 20 mm; folds that the mesh or
the layers do not allow are drawn again, and counted. Folded in two directions, the flat cut comes in within 4 ms. Runs
what is not in the folder of runs yet, one process each, and writes random_folds.csv: a row a run.
"""

from __future__ import annotations

import argparse
import csv
import math
import random
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

from billow.base.errors import InputError, NumericalStop
from billow.case.build import build_model, require_start_clear
from billow.case.schema import Case
from billow.results.result import Result
from billow.run.simulate import simulate

MODELS = ("uniform-pressure", "corpuscular")
PARTICLES = 10_000
SIZES = ((0.005, 0.40), (0.007, 0.48), (0.010, 0.60), (0.014, 0.70), (0.020, 0.70))
"""Edge of elements and largest diameter of a bag [m]: a fine mesh of a large bag would take hours."""
GAS_PER_AREA = 0.026
"""Mass of gas [kg] for each square metre of the flat bag, which leaves some 20 kPa in the open one."""


def draw(chance: random.Random) -> dict:
    """A bag that may be foldable, as the tables of a case."""
    size, largest = chance.choice(SIZES)
    diameter = round(chance.uniform(0.75, 1.0) * largest, 3)
    axes = chance.choice((("x",), ("y",), ("x", "y"), ("y", "x")))
    bag = {
        "diameter": diameter, "element_size": size, "mouth_radius": 0.03, "vents": {"count": 0}, "straps": {"count": 0},
        "folds": [_fold(chance, axis, diameter, alone=len(axes) == 1) for axis in axes],
    }  # fmt: skip
    if len(axes) > 1:
        bag["birth_time"] = 4e-3
    above = all(fold["over"] for fold in bag["folds"])
    area = math.pi * diameter**2 / 2.0
    flow = {"time": [0.0, 3e-3, 20e-3], "value": [0.0, GAS_PER_AREA * area / 10e-3, 0.0]}
    return {
        "title": "Bag folded at random", "bag": bag, "obstacles": [{"shape": "plate"}] if above else [],
        "inflator": {"mass_flow": flow, "temperature": 500.0, "jets": {"count": 8, "ring_radius": 0.02, "angle": 30.0}},
        "run": {"end_time": 20e-3, "frames": 40, "guard_crossings": True},
    }  # fmt: skip


def _fold(chance: random.Random, axis: str, diameter: float, alone: bool) -> dict:
    """One fold; a roll only where it is alone."""
    kind = chance.choice(("leporello", "leporello", "half", "roll") if alone else ("leporello", "leporello", "half"))
    fold = {"kind": kind, "across": axis, "over": chance.random() < 0.7, "layer_gap": chance.uniform(6e-4, 1.2e-3)}
    if kind == "half":
        return fold | {"side": chance.choice(("low", "high")), "line": chance.uniform(0.2, 0.35) * diameter}
    fold |= {"sides": chance.choice(("both", "both", "low", "high"))}
    if kind == "roll":
        return fold | {"turns": chance.uniform(0.5, 1.5), "core": chance.uniform(0.01, 0.02)}
    return fold | {
        "first_line": chance.uniform(0.16, 0.3) * diameter, "panel": chance.uniform(0.08, 0.16) * diameter,
    }  # fmt: skip


def drawn(count: int, seed: int) -> tuple[list[dict], int]:
    """So many bags that can be folded, and how many drawn ones could not."""
    chance, bags, refused = random.Random(seed), [], 0
    while len(bags) < count:
        data = draw(chance)
        try:
            require_start_clear(build_model(Case.from_dict(data)))
        except InputError:
            refused += 1
            continue
        bags.append(data)
    return bags, refused


def run_one(data: dict, model: str, folder: Path) -> None:
    """Run a case unless it is there; one that had to be stopped is there too."""
    if not folder.exists():
        case = Case.from_dict(data | {"gas": {"model": model, "particles": PARTICLES}})
        try:
            simulate(case, folder, threads=1)
        except NumericalStop as stop:
            print(f"{folder.name}: {stop}", flush=True)


def row_of(number: int, data: dict, model: str, folder: Path) -> dict:
    """What the table says of a run."""
    record, bag = Result.open(folder).record, data["bag"]
    books = record["ledger"]
    return {
        "bag": number, "folds": " then ".join(f"{f['kind']} {f['across']}" for f in bag["folds"]),
        "diameter [mm]": round(1e3 * bag["diameter"]), "elements [mm]": 1e3 * bag["element_size"], "gas": model,
        "steps": record["steps"], "status": record["status"], "verdict": record["quality"]["verdict"],
        "crossings at the worst frame": int(books["crossings_at_worst"]),
        "energy residual [%]": round(100.0 * books["energy_residual_of_largest"], 3),
        "heat of layers, of the gas work [%]": round(100.0 * books["layer_impact_of_gas_work"], 2),
        "particles outside": int(books.get("leaked_particles", 0)),
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=Path, required=True)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("validation/folding"))
    arguments = parser.parse_args()
    arguments.runs.mkdir(parents=True, exist_ok=True)
    bags, refused = drawn(arguments.count, arguments.seed)
    print(f"{len(bags)} bags; {refused} more could not be folded as drawn", flush=True)
    all_runs = [
        (k, data, model, arguments.runs / f"{arguments.seed}-{k:02d}-{model}")
        for k, data in enumerate(bags, 1)
        for model in MODELS
    ]
    with ProcessPoolExecutor(arguments.workers, get_context("spawn")) as pool:  # kernels have started threads
        waiting = {
            pool.submit(run_one, data, model, folder): (k, data, model, folder) for k, data, model, folder in all_runs
        }
        for done in as_completed(waiting):
            done.result()
            print(row_of(*waiting[done]), flush=True)
    rows = [row_of(*run) for run in all_runs]
    arguments.out.mkdir(parents=True, exist_ok=True)
    with (arguments.out / "random_folds.csv").open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)
    crossed = sum(row["crossings at the worst frame"] > 0 for row in rows)
    print(f"{crossed} of {len(rows)} runs have crossings")


if __name__ == "__main__":
    main()
