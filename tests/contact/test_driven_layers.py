"""Layers that are pushed by nodes whose motion is given: nothing crosses, and who drives them pays for it."""

import dataclasses

import numpy as np
import pytest
from thrown_sheets import EDGE, model_of, sheet

from billow.case.build import keep_apart
from billow.geometry.crossings import CrossingCount
from billow.parts.driven_nodes import DrivenNodes
from billow.parts.layers import parting
from billow.solver.model import start_state
from billow.solver.step import advance, first_forces
from billow.solver.step_size import stable_dt

UP_AND_ASIDE = np.array([0.2, 0.0, 1.0])


def driven_stack(friction, speed):
    """Model and state of three sheets in a stack, shifted against each other, the lowest driven at `speed` [m/s]."""
    x, y = np.eye(3)[0], np.eye(3)[1]
    sheets = [sheet((0.31 * k * EDGE, 0.23 * k * EDGE, 4e-4 * k), x, y, cells=(5, 5)) for k in range(3)]
    model, of_sheet = model_of(sheets, fixed=(0,))
    nodes = np.flatnonzero(of_sheet == 0)
    places = model.start[nodes]
    driven = DrivenNodes(nodes, model.mass[nodes], lambda time: places + time * speed)
    model = dataclasses.replace(model, driven=driven, layers=keep_apart(model, friction))
    state = start_state(model)
    first_forces(model, state)
    return model, state


@pytest.mark.parametrize(
    ("friction", "speed", "scans"), [(0.0, 20.0, parting.SCANS), (0.3, 20.0, parting.SCANS), (0.0, 150.0, 1)]
)
def test_a_driven_sheet_pushes_a_stack_and_its_drive_pays(friction, speed, scans, monkeypatch):
    """Fast and with one scan only, nodes have to move together in some steps."""
    monkeypatch.setattr(parting, "SCANS", scans)
    model, state = driven_stack(friction, speed * UP_AND_ASIDE)
    free, count = ~model.fixed, CrossingCount(model.surface)
    given, ledger = np.zeros(3), state.ledger
    for _ in range(60):
        dt = 0.5 * stable_dt(model, state)
        advance(model, state, dt)
        given += dt * state.driven.reaction.sum(axis=0)
        assert count.total(state.positions) == 0
    momentum = (model.mass[free, None] * state.velocities[free]).sum(axis=0)
    assert momentum[2] > 0.3 * speed * model.mass[free].sum()
    assert np.abs(momentum - given).max() < 1e-11 * momentum[2]
    assert (state.layers.last_resorts > 0) == (scans == 1)
    if friction:
        assert momentum[0] > 0.01 * momentum[2]
        assert ledger["friction"] > 0.0
    assert ledger["layer_impact"] > 0.1 * ledger["kinetic"]
    assert max(ledger.largest_gain, -ledger.largest_loss) < 1e-3 * ledger["drive_work"]
