"""Laws made from curves in a deployment: the energy balance closes to the order of the scheme, and history is state."""

from __future__ import annotations

import numpy as np
import pytest
from curves import OBLIQUE, fabric

from billow.case.build import build_model, build_schedule
from billow.case.schema import Case
from billow.geometry.assembly import COLUMNS, Corners
from billow.parts.fabric.curve_fabric import _curve_forces
from billow.parts.fabric.membrane import Membrane
from billow.solver.checkpoint import flatten, restore
from billow.solver.model import start_state
from billow.solver.run import Recorder, run

CASE = {
    "bag": {"element_size": 0.05},
    "fabric": {"permeability": 0.0275},
    "run": {"end_time": 0.020, "frames": 2, "histories_per_frame": 4},
}


class Keep(Recorder):
    """A recorder that keeps the leaves of the state at the first frame after the start."""

    def __init__(self):
        self.leaves = None

    def frame(self, model, state) -> None:
        if state.time > 0.0 and self.leaves is None:
            arrays, numbers = flatten(state)
            self.leaves = {path: array.copy() for path, array in arrays.items()}, dict(numbers)


def deploy(law, dt_scale=1.0):
    case = Case.from_dict(CASE).vary({"fabric.law": law, "run.dt_scale": dt_scale})
    model, keep = build_model(case), Keep()
    return model, build_schedule(case.run), keep, run(model, build_schedule(case.run), keep)


@pytest.mark.parametrize("law", ["curves", "curves-shear"])
def test_the_energy_balance_closes_and_better_with_smaller_steps(law):
    """All of it but the gas' trapezoid is of second order; half the step must leave less than 0.6 of the residual."""
    coarse, fine = (deploy(law, scale)[3].ledger for scale in (1.0, 0.5))
    assert coarse.relative_error < 5e-3
    assert fine.relative_error < max(0.6 * coarse.relative_error, 1e-4)
    assert coarse["hysteresis"] > 0.02 * coarse["gas_work"]  # the fabric did turn energy to heat
    assert fine["hysteresis"] == pytest.approx(coarse["hysteresis"], rel=0.05)


@pytest.mark.parametrize("law", ["curves", "curves-shear"])
def test_history_goes_through_a_checkpoint(law):
    """A run continued from a checkpoint ends with the same bits; without its history it does not."""
    model, schedule, keep, straight = deploy(law)
    arrays, numbers = keep.leaves
    membrane = model.fabric.membranes[0]
    assert arrays["fabric.history.0"].shape == membrane.fresh_history().shape
    # Leaves were taken when the frame was recorded, before the run counted on.
    again = run(model, schedule, Keep(), restore(start_state(model), arrays, numbers))
    assert (again.positions == straight.positions).all()
    assert (again.fabric.history[0] == straight.fabric.history[0]).all()
    forgetful = {**arrays, "fabric.history.0": np.zeros_like(arrays["fabric.history.0"])}
    other = run(model, schedule, Keep(), restore(start_state(model), forgetful, numbers))
    assert (other.positions != straight.positions).any()


@pytest.mark.parametrize("switches", [True, False], ids=["curves", "curves-shear"])
def test_serial_and_parallel_give_the_same_bits(switches):
    """Each compilation of a kernel on 5,000 crumpled triangles, loaded, unloaded and loaded again."""
    rng = np.random.default_rng(2)
    node = np.arange(15_000, dtype=np.uint32).reshape(-1, 3)
    flat = np.array([[0.0, 0.0], [0.01, 0.001], [0.002, 0.009]]) + 1e-3 * rng.normal(size=(5000, 3, 2))
    law = fabric(switches_shear=switches, yarn_angle=OBLIQUE)
    membrane = Membrane.build(law, np.arange(5000), flat)
    results = []
    for compiled in (_curve_forces.serial, _curve_forces.parallel):
        history, sums = membrane.fresh_history(), membrane.sums()
        corners, loads = Corners.apart(node), np.empty((15_000, COLUMNS))
        shake = np.random.default_rng(3)
        for size in (1.1, 1.02, 1.2):
            place = np.concatenate([size * flat.reshape(-1, 2), np.zeros((15_000, 1))], axis=1)
            moved = place + 5e-4 * shake.normal(size=place.shape)
            mesh = membrane.for_kernels(moved, shake.normal(size=place.shape))
            compiled(5000, switches, law.table, law._constants, mesh, history, tuple(corners), loads, sums)
        results.append((loads, history, sums))
    for one, two in zip(*results, strict=True):
        assert (one == two).all()
