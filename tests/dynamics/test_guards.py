"""A run that has become meaningless is stopped, and the message says where and why."""

from __future__ import annotations

import numpy as np
import pytest
from free_scene import EachStep, free_model

from billow.base.errors import InputError, NumericalStop
from billow.case.build import build_model
from billow.case.schema import Case
from billow.solver.guards import check_state
from billow.solver.run import Schedule, begin, run


def stopped(model, spoil, at_step=20):
    """The stop of a run whose state `spoil(state)` damages after some steps, and the state as it was left."""
    left = []

    def step(model, state):
        left[:] = [state]
        if state.step == at_step:
            spoil(state)

    with pytest.raises(NumericalStop) as caught:
        run(model, Schedule(0.01, 2, 1), EachStep(step))
    return caught.value, left[0]


@pytest.mark.parametrize("node", [0, 100])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("field", ["positions", "velocities"])
def test_a_number_that_is_none_stops_the_run_and_names_its_node(node, bad, field):
    def spoil(state):
        getattr(state, field)[node, 1] = bad

    stop, state = stopped(free_model(), spoil)
    assert stop.code == "E-NUM-001"
    assert stop.exit_code == 3
    assert "node " in stop.where
    assert "part" in stop.where
    assert "step 21" in stop.where
    assert state.step == 21  # at once
    assert f"node {node} " in stop.where  # itself, not one of the neighbours it has spoiled within the step
    assert stop.nodes[0] == node


def test_a_bad_body_is_told_from_a_bad_node():
    def spoil(state):
        state.bodies.motion[0].angular_momentum[0] = np.nan

    stop, _ = stopped(free_model(apart=1.0), spoil)
    assert stop.code == "E-NUM-001"
    assert "rigid body" in stop.where


@pytest.mark.parametrize("squeeze", [-1.0, 1e-5])
def test_a_chamber_that_is_all_but_gone_stops_the_run_by_its_name(small_case, squeeze):
    """Turned inside out; and flat, where the panels' speed opens it again within the step and the gas is too hot."""

    def spoil(state):
        state.positions[:, 2] *= squeeze

    stop, state = stopped(build_model(small_case), spoil)
    assert stop.code == "E-NUM-009"
    assert "chamber bag" in stop.where
    assert state.step == 21
    assert f"{1e3 * state.gas.content.volume[0]:.3g} l of" in stop.what


def test_gas_outside_its_range_stops_the_run(small_case):
    def spoil(state):
        state.gas.content.energy *= 30.0

    stop, _ = stopped(build_model(small_case), spoil)
    assert stop.code == "E-NUM-002"
    assert "K" in stop.what
    assert "inflator" in stop.remedy


def test_energy_from_nowhere_stops_the_run():
    """Three times the stable step: it blows up, and is caught while the numbers are still numbers."""
    model = free_model()
    with pytest.raises(NumericalStop) as caught:
        run(model, Schedule(0.01, 2, 1, dt_scale=3.0))
    assert caught.value.code == "E-NUM-003"
    assert "dt_scale" in caught.value.remedy


@pytest.mark.parametrize(("largest", "step", "stops"), [(5.0, 10, True), (1e-5, 1001, True), (1e-5, 10, False)])
def test_created_energy_stops_a_small_bag_too(largest, step, stops):
    """From 1 J on at once; below, after the first steps, in which the error of the scheme is as large as the energy."""
    model = free_model()
    state = begin(model, Schedule(0.01, 2, 1))
    state.step, state.ledger.largest_energy, state.ledger.residual = step, largest, 0.21 * largest
    if stops:
        with pytest.raises(NumericalStop, match="E-NUM-003"):
            check_state(model, state)
    else:
        check_state(model, state)


def test_a_collapsing_step_stops_the_run():
    """When the next interval is planned, a fabric stretched beyond all bounds leaves no step to take."""

    def step(model, state):
        state.fabric.largest_stretch, state.fabric.squared_rate = 1e6, 1e40

    with pytest.raises(NumericalStop) as caught:
        run(free_model(), Schedule(0.002, 2, 1), EachStep(step))
    assert caught.value.code == "E-NUM-004"
    assert "1e+06" in caught.value.why


@pytest.mark.parametrize("scale", [1.0001, 0.0, -1.0, float("nan"), float("inf")])
def test_a_step_beyond_the_stable_one_cannot_be_asked_for(scale):
    with pytest.raises(InputError, match="dt_scale"):
        Case.from_dict({"run": {"dt_scale": scale}})
