"""Layers that start a thousandth of their thickness apart: impulses keep them apart all the same."""

import numpy as np
import pytest
from thrown_sheets import EDGE, model_of, sheet

from billow.geometry.crossings import CrossingCount
from billow.solver.model import start_state
from billow.solver.step import advance, first_forces
from billow.solver.step_size import stable_dt


def squeezed_stack():
    """Five sheets, each shifted against the one below, that the outer two squeeze."""
    x, y = np.eye(3)[0], np.eye(3)[1]
    sheets = [sheet((0.31 * k * EDGE, 0.23 * k * EDGE, 3e-7 * k), x, y, cells=(4, 4)) for k in range(5)]
    model, of_sheet = model_of(sheets)
    state = start_state(model)
    first_forces(model, state)
    state.velocities[of_sheet == 0, 2] = 5.0
    state.velocities[of_sheet == 4, 2] = -5.0
    state.velocities += np.random.default_rng(2).normal(0.0, 0.5, state.velocities.shape)
    return model, state


def test_layers_a_micron_apart_are_pressed_and_part_without_the_last_resort():
    """Thrown about in the squeeze: nodes never have to move together, so that what was tight can open."""
    model, state = squeezed_stack()
    count = CrossingCount(model.surface)
    energy = 0.5 * float((model.mass[:, None] * state.velocities**2).sum())
    for _ in range(40):
        advance(model, state, 0.75 * stable_dt(model, state))
        assert count.total(state.positions) == 0
    assert state.layers.last_resorts == 0
    assert 0.05 * energy < state.ledger["layer_impact"] < energy


@pytest.mark.parametrize("times", [30.0, 1000.0])
def test_impulses_of_the_last_step_are_no_more_than_a_beginning(times):
    """The middle layers of a squeezed stack hold each other by impulses that cancel. As normals turn they do not, and
    however far those of the last step would throw the nodes, these end the step as slow as they began it."""
    model, state = squeezed_stack()
    advance(model, state, 0.75 * stable_dt(model, state))
    fastest = np.linalg.norm(state.velocities, axis=1).max()
    assert (state.layers.impulse > 0.0).sum() > 20
    state.layers.impulse *= times
    before = len(state.layers)
    advance(model, state, 0.75 * stable_dt(model, state))
    assert np.linalg.norm(state.velocities, axis=1).max() < 1.5 * fastest
    assert len(state.layers) < 3 * before
    assert CrossingCount(model.surface).total(state.positions) == 0
