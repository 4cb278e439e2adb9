"""The effective area of a passage: its factors, its area terms, what contact blocks, and when it opens."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.apps.verification.gas import AIR, boxes_in_a_row, joined_rooms, run
from billow.geometry.chambers import OUTSIDE
from billow.geometry.surface import area_vectors
from billow.parts.gas.supply.curve import Curve, CurveTable, curve_value
from billow.parts.gas.supply.outflow import ORIFICE
from billow.parts.gas.supply.passages import (
    ABSOLUTE,
    DIFFERENCE,
    FABRIC,
    PRESENT_AREA,
    VENT,
    Passage,
    Passages,
    effective_area,
)
from billow.parts.part import Loads

ROOM = boxes_in_a_row((0.4,))
TRIANGLES, POSITIONS = ROOM.surface.triangles, ROOM.positions
AREAS = np.linalg.norm(area_vectors(TRIANGLES, POSITIONS), axis=1)


def area(passage, *, present=0.02, blocked=0.0, time=0.01, upstream=1.5e5, downstream=1e5):
    return effective_area(Passages((passage,)).table, 0, present, blocked, time, upstream, downstream)


def curve(x, y):
    return Curve(np.array(x, dtype=float), np.array(y, dtype=float))


def test_every_factor_multiplies():
    passage = Passage(
        "vent", VENT, ORIFICE, 0, area=0.03, coefficient=0.5,
        over_time=(curve([0, 0.02], [0, 1]), curve([0, 0.01, 0.02], [1, 3, 1])),
        over_pressure=curve([0, 1e5], [1, 2]), pressure_read=DIFFERENCE, area_terms=PRESENT_AREA,
    )  # fmt: skip
    assert area(passage) == pytest.approx(0.02 * 0.5 * 0.5 * 3.0 * 1.5, rel=1e-14)
    assert area(passage, time=0.0) == 0.0
    assert area(passage, time=1.0) == pytest.approx(0.02 * 0.5 * 1.0 * 1.0 * 1.5, rel=1e-14)  # constant outside


def test_fabric_curves_are_read_at_the_absolute_pressure_upstream():
    passage = Passage("f", FABRIC, ORIFICE, 0, area=2.0, over_pressure=curve([1e5, 2e5], [0.0, 1.0]))
    assert passage.pressure_read == ABSOLUTE
    assert area(passage, upstream=1.25e5, downstream=1.2e5) == pytest.approx(0.5, rel=1e-14)
    assert area(passage, upstream=1e5, downstream=1e4) == 0.0


@given(terms=st.tuples(*[st.floats(-2.0, 2.0)] * 4), stretch=st.floats(0.5, 2.0), ratio=st.floats(1.0, 3.0))
def test_area_terms_of_anagonye_and_wang(terms, stretch, ratio):
    passage = Passage("f", FABRIC, ORIFICE, 0, area=0.5, area_terms=terms)
    x0, x1, x2, x3 = terms
    expected = 0.5 * (x0 + x1 * stretch + x2 * ratio + x3 * stretch * ratio)
    found = area(passage, present=0.5 * stretch, upstream=ratio * 1e5, downstream=1e5)
    assert found == pytest.approx(max(expected, 0.0), rel=1e-12, abs=1e-14)


@given(blocked=st.floats(0.0, 1.0), through=st.floats(0.0, 1.0))
def test_blocked_area_lets_its_share_through(blocked, through):
    passage = Passage("f", FABRIC, ORIFICE, 0, area=0.02, through_blocked=through)
    expected = 0.02 * (1.0 - blocked + blocked * through)
    assert area(passage, blocked=blocked * 0.02) == pytest.approx(expected, rel=1e-12, abs=1e-16)


def test_areas_are_measured_by_the_nodes_that_touch():
    """Every triangle's blocked area is a third of its own for each corner that touches."""
    some = np.array([0, 3, 7, 8])
    rows = (
        Passage("present", VENT, ORIFICE, 0, triangles=some, area_terms=PRESENT_AREA),
        Passage("flat", FABRIC, ORIFICE, 0, triangles=np.arange(12), area=1.0),
        Passage("blockable", FABRIC, ORIFICE, 0, triangles=np.arange(5), area=1.0, through_blocked=0.1),
        Passage("bare", VENT, ORIFICE, 0, area=1.0, through_blocked=0.0),
    )
    passages = Passages(rows)
    assert [row.measured for row in rows] == [True, False, True, False]
    touched = np.zeros((2, len(POSITIONS)), bool)
    touched[0, TRIANGLES[3, :2]] = True
    touched[1, TRIANGLES[3, 1]] = True  # a node that two shapes touch is blocked once
    found = passages.measure(TRIANGLES, POSITIONS, touched)
    assert passages.table.first_chunk.tolist() == [0, 1, 1, 2, 2]
    share = touched.any(axis=0)[TRIANGLES].sum(axis=1) / 3.0
    for line, members in zip(found, (some, np.arange(5)), strict=True):
        assert line == pytest.approx([AREAS[members].sum(), (AREAS * share)[members].sum()], rel=1e-14)
    assert (passages.measure(TRIANGLES, POSITIONS, None)[:, 1] == 0.0).all()


def test_a_touched_vent_closes_and_its_blocked_area_is_told():
    hole = np.array([AREAS.argmin()])
    vent = Passage("vent", VENT, ORIFICE, 0, triangles=hole, coefficient=0.01, area_terms=PRESENT_AREA)
    blocked = replace(vent, through_blocked=0.0)
    lost = {}
    for name, row, touched in (
        ("free", blocked, []),
        ("ignored", vent, TRIANGLES[hole[0]]),
        ("two corners", blocked, TRIANGLES[hole[0], :2]),
        ("closed", blocked, TRIANGLES[hole[0]]),
    ):
        gas = joined_rooms(ROOM, (row,), [2e5], [300.0], [0.5])
        ROOM.touched = np.isin(np.arange(len(POSITIONS)), touched)[None]
        totals = gas.totals(run(gas, ROOM, 1, 1e-6)[0])
        lost[name], seen = totals.vented, totals.blocked_area
        share = 0.0 if name == "ignored" else len(touched) / 3.0
        assert seen == pytest.approx(share * AREAS[hole[0]], rel=1e-12)
    ROOM.touched = None
    assert lost["free"] == lost["ignored"] > 0.0
    assert lost["two corners"] == pytest.approx(lost["free"] / 3.0, rel=1e-4)  # the flow's own effect on the pressure
    assert lost["closed"] == 0.0


@pytest.mark.parametrize(
    ("opens_at", "bursts_at", "pressure", "opens"),
    [
        (0.0, np.inf, AIR.pressure, 0),
        (1e4, np.inf, AIR.pressure + 1.1e4, 0),
        (1e4, np.inf, AIR.pressure + 0.9e4, None),
        (np.inf, 4.5e-4, 2e5, 4),
        (1e5, 4.5e-4, AIR.pressure + 5e4, 4),
        (1e4, 4.5e-4, AIR.pressure + 5e4, 0),
    ],
)
def test_a_vent_opens_at_its_pressure_or_its_time_whichever_is_first(opens_at, bursts_at, pressure, opens):
    vent = Passage("vent", VENT, ORIFICE, 0, OUTSIDE, area=1e-6, opens_at=opens_at, bursts_at=bursts_at)
    gas = joined_rooms(ROOM, (vent,), [pressure], [300.0], [0.5])
    state, loads = gas.start(ROOM), Loads(0, ROOM.surface)
    first = None
    for k in range(10):
        gas.advance(state, ROOM, k * 1e-4, 1e-4, loads)
        first = k if first is None and state.is_open[0] else first
    assert first == opens


def test_a_vent_stays_open_when_the_pressure_has_gone():
    vent = Passage("vent", VENT, ORIFICE, 0, area=1e-2, opens_at=1e4)
    gas = joined_rooms(ROOM, (vent,), [AIR.pressure + 1.5e4], [300.0], [0.5])
    state, _ = run(gas, ROOM, 2000, 1e-4)
    assert state.is_open[0]
    assert state.pressure[0] == pytest.approx(AIR.pressure, rel=1e-6)


@given(
    curves=st.lists(
        st.lists(st.tuples(st.floats(0.1, 1.0), st.floats(-5.0, 5.0)), min_size=1, max_size=5), min_size=1, max_size=4
    ),
    at=st.floats(-1.0, 6.0),
)
def test_curves_in_a_table_are_the_curves(curves, at):
    made = [curve(np.cumsum([gap for gap, _ in points]), [y for _, y in points]) for points in curves]
    table = CurveTable.build(made)
    for k, one in enumerate(made):
        expected = np.interp(at, one.x, one.y)
        assert curve_value(table, k, at) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert curve_value(table, -1, at) == 1.0
