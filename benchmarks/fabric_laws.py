"""What a triangle costs with each fabric law: `python benchmarks/fabric_laws.py`, and part of `make bench`.

One process, one thread, laws taken in turn, medians of processor time. The states are those of a driver bag of about
20,000 triangles in contact, 1 ms of its deployment, so that crumpled, taut, loading and unloading triangles are mixed
as they are in a run.
"""

from __future__ import annotations

import os
import time
import tomllib

os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np

from billow.case.build import build_model
from billow.case.fabric.build_fabric import build_fabric
from billow.case.schema import Case
from billow.cli.demo import CASE
from billow.geometry.assembly import COLUMNS
from billow.parts.fabric.membrane import Membrane
from billow.solver.model import Model
from billow.solver.run import Schedule, begin
from billow.solver.step import advance
from billow.solver.step_size import stable_dt

ELEMENT_SIZE = 0.0085  # m; 20,000 triangles of a driver bag 0.70 m across
FROM, UNTIL = 0.020, 0.021  # s
STATES, ROUNDS = 16, 12
LAWS = {"linear": "FORM 0", "curves": "FORM 4", "curves-shear": "FORM 14"}


def deployment() -> tuple[Model, list[tuple[np.ndarray, np.ndarray]]]:
    """A model and positions [m] and velocities [m/s] of its bag at some moments of its deployment."""
    model = build_model(Case.from_dict(tomllib.loads(CASE)).vary({"bag.element_size": ELEMENT_SIZE}))
    state = begin(model, Schedule(UNTIL, 1, 1))
    moments, states = np.linspace(FROM, UNTIL, STATES), []
    while len(states) < STATES:
        advance(model, state, stable_dt(model, state))
        if state.time >= moments[len(states)]:
            states.append((state.positions.copy(), state.velocities.copy()))
    return model, states


def fabric_laws() -> dict[str, str]:
    """Nanoseconds per triangle and evaluation of each law, and their ratio to the linear one."""
    model, states = deployment()
    elements, corners = model.fabric.membranes[0].elements, model.fabric.assembly.corners[0]
    flat = _flat_corners(model.fabric.membranes[0])

    def use(law: str):
        membrane = Membrane.build(build_fabric(Case.from_dict({"fabric": {"law": law}}).fabric), elements, flat)
        history, sums = membrane.fresh_history(), membrane.sums()
        loads, fabric = np.zeros((len(model.fabric.assembly.entry), COLUMNS)), membrane.fabric
        return lambda x, v: fabric.add_forces(membrane, corners, x, v, history, loads, sums)

    calls = [use(law) for law in LAWS]
    times = np.empty((ROUNDS, STATES, len(calls)))
    for one_round in times:  # the first one compiles, and strains the fabric for the first time
        for (positions, velocities), row in zip(states, one_round, strict=True):
            for k, call in enumerate(calls):
                begun = time.thread_time()
                call(positions, velocities)
                row[k] = time.thread_time() - begun
    median = np.median(times[1:], axis=(0, 1)) / len(elements)
    lines = {
        f"{law} law ({form})": f"{1e9 * t:.1f} ns per triangle"
        for (law, form), t in zip(LAWS.items(), median, strict=True)
    }
    ratios = {f"{law} / linear": f"{t / median[0]:.2f}" for law, t in list(zip(LAWS, median, strict=True))[1:]}
    return {"fabric triangles": f"{len(elements)}"} | lines | ratios


def _flat_corners(membrane: Membrane) -> np.ndarray:
    """Corners that have the flat edges of a membrane, [m], (n, 3, 2): Dm from Dm^-1."""
    rows = membrane.reference_inverse.T.reshape(-1, 2, 2)
    edges = np.linalg.inv(rows)
    return np.stack([np.zeros((len(edges), 2)), edges[:, :, 0], edges[:, :, 1]], axis=1)


if __name__ == "__main__":
    for what, value in fabric_laws().items():
        print(f"| {what} | {value} |")
