"""The measurements quoted in the README: `make bench`.

Everything is measured in this one process, one thread, medians; the machine is named beside the numbers. Ratios are
what carries over to other machines, absolute times are not.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import sys
import time
import tomllib
from pathlib import Path

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from fabric_laws import fabric_laws
from start import start

from billow.case.build import build_model, build_schedule
from billow.case.schema import Case
from billow.cli.demo import CASE
from billow.parts.gas.supply.jets import UPDATE_INTERVAL, aim
from billow.results.dataset import Dataset
from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate.surrogate import Surrogate
from billow.run.recorder import environment
from billow.solver import nodes
from billow.solver.model import start_state
from billow.solver.run import run
from billow.solver.step import advance, first_forces
from billow.solver.step_size import stable_dt

REPEATS = 200
DEMO_SIZE = 0.020  # m; 3,536 triangles
FULL_SIZE = 0.0085  # m; 20,000 triangles of a driver bag 0.70 m across


def median_seconds(*calls, repeats: int = REPEATS) -> list[float]:
    """Median time [s] of each call, taken in turn so that a slow phase of the machine hits all alike."""
    times = np.empty((repeats, len(calls)))
    for call in calls:
        call()
    for row in times:
        for k, call in enumerate(calls):
            begun = time.perf_counter()
            call()
            row[k] = time.perf_counter() - begun
    return list(np.median(times, axis=0))


def driver_case(element_size: float) -> Case:
    """The demo's case on another mesh, with the middle of its design space."""
    changes = {"bag.element_size": element_size, "fabric.permeability": 0.0275, "obstacles.impactor.slope": 5e5}
    return Case.from_dict(tomllib.loads(CASE)).vary(changes)


def step_cost() -> dict[str, str]:
    """A whole step against its pass over the triangles, at 20,000 triangles with the bag in contact."""
    model = build_model(driver_case(FULL_SIZE))
    state = start_state(model)
    first_forces(model, state)
    while state.time < 0.012:
        advance(model, state, stable_dt(model, state))
    dt = 1e-9  # the state hardly moves while it is timed

    work, loads, contact = model.work, model.work.loads, state.bodies.contact

    def membrane() -> None:
        model.fabric.add_forces(state.fabric, state.positions, state.velocities, state.time, 0.0, loads)

    def gather() -> None:
        nodes.gather_and_kick(
            len(model.mass), work.gathering, loads.entries, loads.gauge, loads.node_force, work.corners,
            loads.corner_force.reshape(-1, 3), model.mass, model.inverse_mass, model.gravity, 0.0, contact.touching,
            contact.force, 0.0, state.velocities, state.nodal_force,
        )  # fmt: skip

    whole, kernel, gathered = median_seconds(lambda: advance(model, state, dt), membrane, gather)
    n = model.surface.triangle_count
    # Finding what the jets hit happens every 0.1 ms, not every step; its share is added as an average.
    jets = model.gas.supply.sources[0].jets
    (aiming,) = median_seconds(lambda: aim(jets, model.surface.triangles, state.positions), repeats=20)
    real_dt = stable_dt(model, state)
    whole += aiming * real_dt / UPDATE_INTERVAL
    return {
        "triangles": f"{n}",
        "triangle pass: membrane, area vectors, volumes": f"{1e9 * kernel / n:.1f} ns per triangle",
        "triangle pass with gathering and last kick": f"{1e9 * (kernel + gathered) / n:.1f} ns per triangle",
        "whole step, jets blowing, in contact": f"{1e9 * whole / n:.1f} ns per triangle",
        "whole step / triangle pass (aim: at most 1.6)": f"{whole / kernel:.2f}",
        "whole step / triangle pass with gathering and last kick": f"{whole / (kernel + gathered):.2f}",
    }


def whole_runs() -> dict[str, str]:
    """Time loops of 50 ms on one thread: the demo's mesh, the same with self-contact, and 20,000 triangles."""
    rows = {}
    demo = driver_case(DEMO_SIZE)
    apart = demo.vary({"fabric.self_contact": True})
    for name, case, repeats in (
        ("", demo, 5), (", layers apart by springs", apart, 3), ("", driver_case(FULL_SIZE), 1),
    ):  # fmt: skip
        model, seconds = build_model(case), []
        for _ in range(repeats):
            begun = time.process_time()
            state = run(model, build_schedule(case.run))
            seconds.append(time.process_time() - begun)
        rows[f"run of 50 ms, {model.surface.triangle_count} triangles{name}"] = (
            f"{np.median(seconds):.2f} s of processor time, {state.step} steps, "
            f"energy residual {100.0 * state.ledger.relative_error:.2f} %"
        )
    return rows


def inference(study: Path) -> dict[str, str]:
    """One deployment against copying its output, training time of both recipes, speed-up over the solver."""
    dataset = Dataset.open(study)
    begun = time.perf_counter()
    surrogate = train(dataset, Recipe(calibrate=False))  # as the paper's recipe, which has no intervals
    trained = time.perf_counter() - begun
    paper_epochs = 300
    paper = train(dataset, Recipe("paper", epochs=paper_epochs))
    paper_seconds = paper.training["network_seconds"] / paper_epochs * 15_000
    design = np.array([0.5 * (p.low + p.high) for p in dataset.parameters])
    output = surrogate.predict(design)
    flat = np.ascontiguousarray(output)
    copy = np.empty_like(flat)
    big = _at_full_size(surrogate)
    big_output = np.ascontiguousarray(big.predict(design))
    big_copy = np.empty_like(big_output)
    predict, copying, big_predict, big_copying = median_seconds(
        lambda: surrogate.predict(design),
        lambda: np.copyto(copy, flat),
        lambda: big.predict(design),
        lambda: np.copyto(big_copy, big_output),
    )
    solver = float(np.median([_deployment_seconds() for _ in range(3)]))
    return {
        f"inference, {surrogate.nodes} nodes": f"{1e3 * predict:.2f} ms, {predict / copying:.1f} x copying its output",
        f"inference, {big.nodes} nodes (aim: at most 4 x)": (
            f"{1e3 * big_predict:.2f} ms, {big_predict / big_copying:.1f} x copying its output"
        ),
        f"training, default recipe, {len(surrogate.training['runs'])} runs": f"{trained:.1f} s with POD",
        "training, paper's recipe (15,000 epochs, extrapolated from 300)": f"{paper_seconds:.0f} s",
        "default recipe's share of the paper's training time": f"1/{paper_seconds / trained:.0f}",
        "solver / surrogate, one deployment": (
            f"{solver / predict:,.0f} x ({solver:.1f} s against {1e3 * predict:.2f} ms)"
        ),
    }


def _deployment_seconds() -> float:
    """One deployment of the demo's mesh, here and now: those of the study shared the machine with others."""
    case = driver_case(0.020)
    model = build_model(case)
    begun = time.perf_counter()
    run(model, build_schedule(case.run))
    return time.perf_counter() - begun


def _at_full_size(surrogate: Surrogate) -> Surrogate:
    """The same networks with bases of 10,000 nodes; what the modes look like does not matter for time."""
    nodes_wanted = 10_000
    repeat = -(-nodes_wanted // surrogate.nodes)

    def widen(basis):
        modes = np.ascontiguousarray(np.tile(basis.modes, (1, repeat))[:, :nodes_wanted])
        return dataclasses.replace(basis, modes=modes)

    return dataclasses.replace(
        surrogate,
        bases=tuple(widen(basis) for basis in surrogate.bases),
        reference=np.tile(surrogate.reference, (repeat, 1))[:nodes_wanted],
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--study", type=Path, default=Path("demo/study"), help="a finished study (default: the demo's)")
    study = parser.parse_args().study
    if not (study / "dataset.toml").exists():
        sys.exit(f"{study} holds no finished study; run `make demo` first, or give one with --study")
    machine = environment()
    print(f"{machine['processor']}, {machine['cores']} cores, Python {machine['python']}, numba {machine['numba']}")
    print("one process, one thread, medians\n\n| what | measured |\n|---|---|")
    for measure in (step_cost, fabric_laws, start, lambda: inference(study), whole_runs):
        for what, value in measure().items():
            print(f"| {what} | {value} |", flush=True)


if __name__ == "__main__":
    main()
