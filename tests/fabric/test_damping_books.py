"""What is booked as damping is what its forces take from the nodes, to rounding."""

from __future__ import annotations

import numpy as np
import pytest

from billow.case.build import build_model, build_schedule
from billow.case.schema import Case
from billow.parts.fabric.fabric import Fabric
from billow.parts.part import DAMPING
from billow.solver.run import begin
from billow.solver.step import advance
from billow.solver.step_size import stable_dt

CASES = {
    "linear": {"bag": {"element_size": 0.06}},
    "curves, steps of all lengths": {
        "bag": {"element_size": 0.06},
        "fabric": {"law": "curves-shear"},
    },
}


@pytest.mark.parametrize("name", list(CASES))
def test_damping_takes_what_is_booked(name, monkeypatch):
    """Nodes move by the mean of the forces at both ends of a step; damping is part of them. Power at the end of each
    step times the step would book some 5 % more than they take."""
    model = build_model(Case.from_dict({"obstacles": [], **CASES[name]}))
    state, taken, last = begin(model, build_schedule(Case().run)), [], {}
    triangles, add_forces = model.surface.triangles, Fabric.add_forces

    def watched(self, fabric, positions, velocities, time, dt, loads):
        still = np.zeros_like(velocities)
        before = self.corner_forces(fabric, positions, velocities) - self.corner_forces(fabric, positions, still)
        if last:
            way = (positions - last["positions"])[triangles]
            taken.append(-0.5 * float(np.sum((before + last["damping"]) * way)))
        last.update(positions=positions.copy(), damping=before)
        return add_forces(self, fabric, positions, velocities, time, dt, loads)

    monkeypatch.setattr(Fabric, "add_forces", watched)
    while state.time < 0.004:
        dt = stable_dt(model, state)
        advance(model, state, dt * (0.6 if "all lengths" in name and state.step % 3 else 1.0))
        if len(taken) == 0:
            start = state.ledger[DAMPING.name]
    booked = state.ledger[DAMPING.name] - start
    assert booked > 0.1
    assert booked == pytest.approx(sum(taken), rel=1e-9)
