"""Folded driver bags: the disc's grid has rows on the fold lines up to the rim, and both panels have the same."""

from __future__ import annotations

import numpy as np
import pytest
from test_folded_bags import LEPORELLO, built, crossings, edges, tension

from billow.base.errors import InputError
from billow.geometry.forced_edges import with_edges
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


def drawn(draw):
    """A driver bag with or without vents and straps, folded across both axes in either order."""
    bag = {
        "shape": "driver", "diameter": draw.uniform(0.55, 0.8), "mouth_radius": 0.04,
        "element_size": float(np.exp(draw.uniform(np.log(0.01), np.log(0.02)))),
        "vents": {"count": int(draw.choice([0, 2])), "diameter": 0.03, "distance": draw.uniform(0.12, 0.2)},
        "straps": {"count": int(draw.choice([0, 4])), "stitch_radius": 0.07},
    }  # fmt: skip
    folds = []
    for across in draw.permutation(["x", "y"]):
        lines = np.cumsum([draw.uniform(0.09, 0.14), *draw.uniform(0.04, 0.09, draw.integers(0, 4))])
        lines = lines[lines < 0.46 * bag["diameter"]].tolist()
        sides, over = str(draw.choice(["both", "both", "low", "high"])), bool(draw.random() < 0.7)
        gap = draw.uniform(6e-4, 1.5e-3)
        folds.append(
            {**LEPORELLO, "across": str(across), "sides": sides, "over": over, "layer_gap": gap, "lines": lines}
        )
    return bag, folds


@pytest.mark.parametrize("seed", range(20))
def test_folds_drawn_at_random_across_both_axes_do_not_cross(seed):
    draw, refused = np.random.default_rng(seed), set()
    for _ in range(20):
        bag, folds = drawn(draw)
        try:
            plan, shape, flat = built(bag, *folds)
        except InputError as refusal:
            refused.add(refusal.code)
            continue
        rows = [(axis, row.place) for axis in (0, 1) for row in plan.rows(axis)]
        if not any(plan.vents_on(shape.surface, flat, *row) for row in rows):  # those are warned of
            break
    assert refused <= {"E-GEO-043", "E-GEO-048", "E-GEO-049"}
    assert crossings(shape) == 0
    assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12
    check_closed(shape.surface, shape.positions, "bag")


def test_creases_across_the_stack_have_no_other_nodes_beside_them():
    """Up to the rim: whatever layer lies there bends between the same lines."""
    lines = {**LEPORELLO, "lines": [0.1, 0.145, 0.2, 0.255]}
    plan, shape, flat = built(PLAIN, lines, {**lines, "across": "y"}, element_size=0.01)
    places = np.unique(flat[:, 1].round(9))
    for row in plan.rows(1):
        on_row = np.abs(flat[:, 1] - row.place) < 1e-9
        touching = np.unique(shape.surface.triangles[on_row[shape.surface.triangles].any(axis=1)])
        assert len(np.unique(flat[touching, 1].round(9))) == 3
    assert len(places) > 100


def test_an_edge_can_be_forced_into_a_triangulation():
    """The other diagonal of a square, and a line through a strip of triangles; areas stay."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    turned = with_edges(square, np.array([[0, 1, 2], [0, 2, 3]]), np.array([[1, 3]]))
    assert {tuple(sorted(triangle)) for triangle in turned.tolist()} == {(0, 1, 3), (1, 2, 3)}
    points = np.array([[x, y] for x in range(5) for y in (0.0, 1.0)]) + [[0.0, 0.0]] * 10
    strip = np.array([t for k in range(0, 8, 2) for t in ((k, k + 2, k + 1), (k + 1, k + 2, k + 3))])
    forced = with_edges(points, strip, np.array([[0, 9]]))
    assert any({0, 9} <= set(triangle) for triangle in forced.tolist())
    a, b, c = (points[forced[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert twice.min() > 0.0
    assert twice.sum() == pytest.approx(8.0)


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
