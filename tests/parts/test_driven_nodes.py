"""Driven nodes: what moves them is booked, so that a test on the bench balances like any run."""

from __future__ import annotations

import numpy as np
import pytest

from billow.apps.coupon.bench import build_model
from billow.apps.coupon.specimen import PictureFrame, Strip
from billow.parts.fabric.linear_law import LinearFabric
from billow.solver.run import Schedule, run

FABRIC = LinearFabric(800.0, 0.3e-3, 0.40e9, 0.35e9, 0.0, 10e6, compression=False, damping=0.05)
SPECIMENS = {"frame": (PictureFrame(0.1, 0.02), 0.4), "strip": (Strip(0.2, 0.05, 0.0125, "warp"), 0.05)}


@pytest.mark.parametrize("name", SPECIMENS)
def test_the_work_of_the_clamps_is_what_the_fabric_stores_and_turns_to_heat(name):
    specimen, amount = SPECIMENS[name]
    errors = []
    for scale in (1.0, 0.5):
        model = build_model(specimen, FABRIC, lambda time: amount * np.sin(np.pi * time / 0.02) ** 2)
        state = run(model, Schedule(0.01, 1, 20, scale))
        ledger = state.ledger
        assert ledger["drive_work"] > 0.9 * ledger["strain"] > 0.0
        errors.append(ledger.relative_error)
    assert errors[0] < 5e-3
    assert errors[1] < 0.6 * errors[0]  # the work of a step is right to first order


def test_driven_nodes_are_where_their_path_says():
    specimen, amount = SPECIMENS["strip"]
    model = build_model(specimen, FABRIC, lambda time: amount * time / 0.005)
    state = run(model, Schedule(0.005, 1, 10))
    np.testing.assert_allclose(state.positions[model.driven.nodes, :2], specimen.places(amount), atol=1e-12)
