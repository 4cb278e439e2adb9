"""Folded driver bags: the disc's grid has rows on the fold lines up to the rim, and both panels have the same."""

from __future__ import annotations

import numpy as np
import pytest
from test_folded_bags import LEPORELLO, built, crossings, edges, tension

from billow.geometry.surface import area_vectors, check_closed

PLAIN = {"shape": "driver", "diameter": 0.7, "vents": {"count": 0}, "straps": {"count": 0}}
EQUIPPED = {"shape": "driver", "diameter": 0.7}
LINES = {**LEPORELLO, "lines": [0.1, 0.16, 0.22, 0.28]}


@pytest.mark.parametrize("bag", [PLAIN, EQUIPPED], ids=["plain", "with vents and straps"])
@pytest.mark.parametrize("size", [0.02, 0.01])
def test_one_direction_is_exact(bag, size):
    plan, shape, flat = built(bag, LINES, element_size=size)
    assert crossings(shape) == 0
    shortest = min(cut.min() for cut, _, _ in edges(shape))
    assert tension(shape) < 1.05 * 0.5 * (0.0002 / shortest) ** 2  # the slope to the rim
    assert shortest > 0.4 * size
    assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12
    check_closed(shape.surface, shape.positions, "bag")
    assert shape.surface.volume(shape.positions) > 0.0
    for row in plan.rows(0):
        on_row = flat[np.abs(flat[:, 0] - row.place) < 1e-9]
        reach = np.hypot(*on_row[:, :2].T).max()
        assert reach == pytest.approx(0.35, abs=1e-12)  # up to the rim


@pytest.mark.parametrize("size", [0.02, 0.01])
def test_two_directions(size):
    lines = {**LEPORELLO, "lines": [0.12, 0.205]}
    plan, shape, flat = built(PLAIN, lines, {**lines, "across": "y"}, element_size=size)
    assert crossings(shape) == 0
    assert plan.layers == 18
    assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12


def test_mouth_vents_and_straps_are_those_of_the_flat_bag():
    size = 0.01
    _, shape, flat = built(EQUIPPED, LINES, element_size=size)
    surface = shape.surface
    on_ring = np.hypot(*flat[shape.fixed, :2].T)
    assert on_ring.max() == pytest.approx(0.05, abs=1e-12)
    for vent in ("vent_1", "vent_2"):
        areas = area_vectors(surface.triangles[surface.triangles_of(vent)].astype(np.int64), flat)
        assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(np.pi * 0.0175**2, rel=1e-9)
    assert len(shape.straps) == 4
    for strap in shape.straps:
        np.testing.assert_allclose(np.hypot(*flat[strap.bars[:, 0], :2].T), 0.08, atol=1e-9)
        np.testing.assert_allclose(np.hypot(*flat[strap.bars[:, 1], :2].T), 0.05, atol=1e-9)
