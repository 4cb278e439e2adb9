"""Exchange between chambers: exact books and no overshoot, for any passages and any step."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from billow.apps.verification.gas import AIR, GAMMA, boxes_in_a_row, joined_rooms, orifice, run
from billow.geometry.chambers import OUTSIDE
from billow.parts.gas.supply.outflow import GRAEFE, ORIFICE, PERMEABILITY, POROUS_MEDIUM, VELOCITY, orifice_flux
from billow.parts.gas.supply.passages import FABRIC, OPENING, VENT, Passage

ROOMS = boxes_in_a_row((0.4, 0.2, 0.3))
STRENGTH = {ORIFICE: 1.0, GRAEFE: 1.0, POROUS_MEDIUM: 1e-3, VELOCITY: 10.0, PERMEABILITY: 1.0}
"""A coefficient for each law that lets about as much through as an orifice."""

passages = st.lists(
    st.tuples(
        st.sampled_from([(0, 1), (1, 2), (2, 0), (0, OUTSIDE), (1, OUTSIDE), (OUTSIDE, 2)]),
        st.sampled_from(sorted(STRENGTH)),
        st.floats(-6.0, 1.0).map(lambda power: 10.0**power),
    ),
    min_size=1,
    max_size=6,
)
pressures = st.lists(st.floats(2e4, 6e5), min_size=3, max_size=3)
temperatures = st.lists(st.floats(250.0, 1200.0), min_size=3, max_size=3)
shares = st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3)


def made(rows):
    return tuple(
        Passage(
            f"p{k}",
            VENT if OUTSIDE in ends and k % 2 else FABRIC if OUTSIDE in ends else OPENING,
            law,
            *ends,
            area=area,
            coefficient=STRENGTH[law],
        )
        for k, (ends, law, area) in enumerate(rows)
    )


@settings(max_examples=60, deadline=None)
@given(
    rows=passages, pressure=pressures, temperature=temperatures, share=shares, dt=st.sampled_from([1e-6, 1e-4, 1e-2])
)
@example([((1, 2), PERMEABILITY, 1.0)], [2e4] * 3, [250.0] * 3, [0.0, 0.3125, 0.0], 1e-6)  # a gas that was not there
@example([((0, OUTSIDE), ORIFICE, 1.0)] * 3, [144981.0, 101313.0, 101313.0], [250.0] * 3, [1.0, 0.0, 0.0], 1e-6)
@example(
    [((0, 1), ORIFICE, 1.0), ((1, 2), ORIFICE, 1.0), ((OUTSIDE, 2), ORIFICE, 1.0)],
    [2e4] * 3,
    [250.0] * 3,
    [0.0, 1.0, 0.0],
    1e-6,
)  # from where it was not thought to come
def test_any_passages_keep_the_books_and_the_range_of_pressures(rows, pressure, temperature, share, dt):
    """Both gases have the same constant gamma: then pressures answer linearly to flows, and lie between the old ones.
    Only where half of a chamber's mass would leave in one step is its outflow cut, and inflow may lift it."""
    gas = joined_rooms(ROOMS, made(rows), pressure, temperature, share)
    state, way = run(gas, ROOMS, 30, dt)
    totals = gas.totals(state)
    assert totals.mass_error <= 1e-12
    assert totals.energy_error <= 1e-12
    assert (state.masses >= 0.0).all()
    assert (state.temperature > 0.0).all()
    booked = state.start_masses.sum() + totals.drawn_in - totals.vented - totals.leaked
    assert state.masses.sum() == pytest.approx(booked, rel=1e-12)
    low, high = min(*pressure, AIR.pressure), max(*pressure, AIR.pressure)
    if (np.abs(np.diff(way, axis=0)) < 0.2 * way[:-1]).all():  # nothing was cut
        assert way.min() >= low * (1.0 - 1e-9)
        assert way.max() <= high * (1.0 + 1e-9)


@settings(max_examples=25, deadline=None)
@given(rows=passages, pressure=pressures, temperature=temperatures, share=shares)
def test_outflow_is_split_by_passage(rows, pressure, temperature, share):
    gas = joined_rooms(ROOMS, made(rows), pressure, temperature, share)
    totals = gas.totals(run(gas, ROOMS, 20, 1e-4)[0])
    assert sum(totals.vented_by.values()) == pytest.approx(totals.vented, rel=1e-12)
    assert sum(totals.leaked_by.values()) == pytest.approx(totals.leaked, rel=1e-12)
    named = [*totals.vented_by, *totals.leaked_by, *totals.passed]
    assert sorted(named) == sorted(row.name for row in gas.supply.passages.rows)


def test_small_steps_give_the_flow_of_the_state_half_way():
    hole = orifice("hole", 0, OUTSIDE, 1e-3)
    room = boxes_in_a_row((0.4,))
    gas = joined_rooms(room, (hole,), [3e5], [600.0], [0.5])
    rt = 300.0 * 600.0
    for dt in (1e-5, 1e-6):
        state, _ = run(gas, room, 1, dt)
        out = gas.totals(state).vented
        explicit = dt * 1e-3 * orifice_flux(3e5, AIR.pressure, GAMMA, rt)
        # Half-way through the step p/sqrt(T), to which choked flow is proportional, is lower by half of this.
        lower = 0.5 * (GAMMA + 1.0) * explicit / state.start_masses.sum()
        assert out == pytest.approx(explicit * (1.0 - 0.5 * lower), rel=lower**2)


def test_stiff_exchange_does_not_disturb_what_is_slow():
    """Two rooms joined by 1 m^2 empty through a small vent as one room of their volume does."""
    both, one = boxes_in_a_row((0.4, 0.2)), boxes_in_a_row((0.6,))
    vent = orifice("vent", 1, OUTSIDE, 2e-4)
    split = joined_rooms(both, (orifice("hole", 0, 1, 1.0), vent), [3e5, 3e5], [600.0, 600.0], [0.5, 0.5])
    whole = joined_rooms(one, (orifice("vent", 0, OUTSIDE, 2e-4),), [3e5], [600.0], [0.5])
    state, way = run(split, both, 200, 1e-3)
    alone = run(whole, one, 200, 1e-3)[0]
    assert alone.pressure[0] < 0.7 * 3e5
    assert state.pressure == pytest.approx(alone.pressure[0] * np.ones(2), rel=1e-5)
    assert np.ptp(way[1:], axis=1).max() < 1.0  # Pa


def test_porous_walls_between_rooms_pass_gas_and_do_not_leak_it():
    wall = Passage("wall", FABRIC, PERMEABILITY, 0, 1, area=0.06, coefficient=0.5)
    gas = joined_rooms(ROOMS, (wall,), [3e5, 1e5, 1e5], [600.0, 300.0, 300.0], [1.0, 0.0, 0.5])
    state, way = run(gas, ROOMS, 2000, 1e-4)
    totals = gas.totals(state)
    assert totals.leaked == totals.vented == totals.drawn_in == 0.0
    assert totals.passed["wall"] == pytest.approx(state.start_masses[0].sum() - state.masses[0].sum(), rel=1e-12)
    assert state.pressure[0] == pytest.approx(state.pressure[1], rel=1e-9)
    assert state.masses[2] == pytest.approx(state.start_masses[2], rel=1e-15)
    assert (np.diff(way[:, 0]) <= 1e-6).all()


def test_reverse_flow_brings_ambient_air():
    hole = orifice("hole", 0, OUTSIDE, 1e-3)
    room = boxes_in_a_row((0.4,))
    gas = joined_rooms(room, (hole,), [2e4], [300.0], [1.0])
    state, _ = run(gas, room, 2000, 1e-4)
    totals = gas.totals(state)
    assert totals.vented == 0.0
    assert totals.drawn_in == pytest.approx(state.masses.sum() - state.start_masses.sum(), rel=1e-12)
    assert state.masses[0, 1] == pytest.approx(0.5 * totals.drawn_in, rel=1e-12)  # the heavy half of the air
    assert state.pressure[0] == pytest.approx(AIR.pressure, rel=1e-9)
