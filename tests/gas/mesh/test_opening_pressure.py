"""Vents that open at a pressure: at that of the gas beside them."""

from __future__ import annotations

import numpy as np
import pytest

from billow.case.build import build_model, build_schedule
from billow.case.schema import Case
from billow.parts.gas.supply.passages import VENT
from billow.solver.run import Recorder, run

LIMIT = 3e3
INSIDE = 0.004
"""[m] from the vent, at which the gas beside it is read."""


class Vents(Recorder):
    """Mean pressure [Pa] on each vent and whether it is open, step by step."""

    def __init__(self, model):
        rows = model.gas.supply.passages.rows
        self.numbers = [number for number, row in enumerate(rows) if row.kind == VENT]
        self.triangles = [rows[number].triangles for number in self.numbers]
        self.pressure, self.is_open = [], []

    def step(self, model, state):
        corners = state.positions[model.surface.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        inward = -INSIDE * normals / np.linalg.norm(normals, axis=1)[:, None]
        found = []
        for own in self.triangles:
            places = (corners[own] + inward[own, None]).reshape(-1, 3)
            sensors = {str(k): place for k, place in enumerate(places)}
            values = [q.value for q in model.gas.readings(state.gas, sensors) if q.name == "gas_pressure"]
            found.append(np.mean(values) - 101325.0)
        self.pressure.append(found)
        self.is_open.append(state.gas.content.is_open[self.numbers].tolist())


def test_a_vent_opens_when_the_pressure_on_it_reaches_its_own():
    """While the bag grows, cells come and go; where gas was looked up by cells that had moved up, runs stopped."""
    case = Case.from_dict(
        {
            "bag": {"element_size": 0.05, "vents": {"opening_pressure": LIMIT}},
            "gas": {"model": "mesh", "cell": 0.04},
            "obstacles": [],
            "run": {"end_time": 0.02, "frames": 1},
        }
    )
    model = build_model(case)
    vents = Vents(model)
    run(model, build_schedule(case.run), vents)
    assert len(vents.numbers) == 2
    for pressure, is_open in zip(np.transpose(vents.pressure), np.transpose(vents.is_open), strict=True):
        first = int(is_open.argmax())
        assert is_open[first:].all()
        assert pressure[:first].max() < 1.1 * LIMIT
        assert pressure[first] == pytest.approx(LIMIT, rel=0.1)
