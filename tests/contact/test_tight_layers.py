"""Layers that start a thousandth of their thickness apart: impulses keep them apart all the same."""

import numpy as np
from thrown_sheets import EDGE, model_of, sheet

from billow.geometry.crossings import CrossingCount
from billow.solver.model import start_state
from billow.solver.step import advance, first_forces
from billow.solver.step_size import stable_dt


def test_layers_a_micron_apart_are_pressed_and_part_without_the_last_resort():
    """Five sheets, each shifted against the one below, squeezed by the outer two and thrown about: nodes never have to
    move together, so that what was tight can open."""
    x, y = np.eye(3)[0], np.eye(3)[1]
    sheets = [sheet((0.31 * k * EDGE, 0.23 * k * EDGE, 3e-7 * k), x, y, cells=(4, 4)) for k in range(5)]
    model, of_sheet = model_of(sheets)
    state = start_state(model)
    first_forces(model, state)
    state.velocities[of_sheet == 0, 2] = 5.0
    state.velocities[of_sheet == 4, 2] = -5.0
    state.velocities += np.random.default_rng(2).normal(0.0, 0.5, state.velocities.shape)
    count = CrossingCount(model.surface)
    energy = 0.5 * float((model.mass[:, None] * state.velocities**2).sum())
    for _ in range(40):
        advance(model, state, 0.75 * stable_dt(model, state))
        assert count.total(state.positions) == 0
    assert state.layers.last_resorts == 0
    assert 0.05 * energy < state.ledger["layer_impact"] < energy
