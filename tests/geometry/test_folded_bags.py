"""Folded bags: the map keeps lengths and is undone exactly, nothing cuts through anything, all but positions stays."""

from __future__ import annotations

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape, fold_plan
from billow.case.build import build_model
from billow.case.schema import Case
from billow.geometry.crossings import CrossingCount
from billow.geometry.surface import check_closed
from billow.solver.model import start_state
from billow.solver.step_size import stable_dt

SQUARE = {"shape": "square", "side": 0.6, "mouth_radius": 0.05, "element_size": 0.02}
TUBE = {
    "shape": "rectangular", "length": 1.0, "width": 0.16, "mouth_radius": 0.02, "mouth_offset": [-0.42, 0.0],
    "element_size": 0.01,
}  # fmt: skip
LEPORELLO = {"kind": "leporello", "first_line": 0.12, "panel": 0.06}
HALF = {"kind": "half"}


def case(bag, *folds, **settings):
    table = {**bag, "folds": [dict(fold) for fold in folds], **settings}
    return Case.from_dict({"bag": table, "gas": {"model": "none"}, "obstacles": []})


def built(bag, *folds, **settings):
    """Plan, shape at the folded start, and the same bag pressed flat, [m] (nodes, 3)."""
    table = case(bag, *folds, **settings).bag
    plan, shape = fold_plan(table), build_shape(table)
    return plan, shape, plan.unfolded(shape.positions)


def edges(shape):
    """Nodes of every edge of fabric, its length as cut and at the start [m], and whether it is a yarn's."""
    cloth = shape.surface.triangles_of_kind("fabric")
    nodes = shape.surface.triangles[cloth].astype(np.int64)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        cut = shape.reference[cloth][:, b] - shape.reference[cloth][:, a]
        start = shape.positions[nodes[:, b]] - shape.positions[nodes[:, a]]
        yield np.linalg.norm(cut, axis=1), np.linalg.norm(start, axis=1), (np.abs(cut) < 1e-9).any(axis=1)


def tension(shape):
    """Greatest strain of a yarn [-]."""
    return max((start / cut - 1.0)[yarn].max() for cut, start, yarn in edges(shape))


def crossings(shape, positions=None):
    return CrossingCount(shape.surface).total(shape.positions if positions is None else positions)


WAYS = {
    "leporello": (SQUARE, [LEPORELLO]),
    "behind": (SQUARE, [{**LEPORELLO, "over": False}]),
    "one side": (SQUARE, [{**LEPORELLO, "sides": "low", "lines": [0.1, 0.13, 0.24]}]),
    "one stack on the other": (SQUARE, [{**LEPORELLO, "lines": [0.1, 0.22]}]),
    "half": (TUBE, [HALF]),
    "folded twice": (TUBE, [HALF, HALF]),
    "folded twice, to and fro": (TUBE, [{**HALF, "over": False}, HALF]),
    "folded three times": (TUBE, [HALF, HALF, {**HALF, "line": 0.09}]),
    "along": (TUBE, [{**LEPORELLO, "across": "y", "first_line": 0.045, "panel": 0.03}]),
}


@pytest.mark.parametrize("way", WAYS)
def test_one_direction_is_exact(way):
    """No crossing; yarns are stretched only where a panel slopes to its rim, by half (gap/4)^2 / h^2; and unfolding
    gives the flat bag back."""
    bag, folds = WAYS[way]
    plan, shape, flat = built(bag, *folds)
    assert crossings(shape) == 0
    assert tension(shape) < 1.05 * 0.5 * (0.0002 / (0.5 * bag["element_size"])) ** 2
    assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12
    assert np.abs(flat[:, 2] - 0.0002 * np.round(flat[:, 2] / 0.0002)).max() < 1e-12
    corners = shape.reference[shape.surface.triangles_of("front")]
    nodes = shape.surface.triangles[shape.surface.triangles_of("front")]
    assert np.abs(flat[nodes][:, :, :2] - corners).max() < 1e-12
    check_closed(shape.surface, shape.positions, "bag")
    assert shape.surface.volume(shape.positions) > 0.5 * shape.surface.volume(flat) > 0.0


@pytest.mark.parametrize("size", [0.02, 0.01])
def test_two_directions_do_not_cross_and_say_what_they_strain(size):
    across = {**LEPORELLO, "lines": [0.12, 0.235]}
    plan, shape, flat = built(SQUARE, across, {**across, "across": "y"}, element_size=size)
    assert crossings(shape) == 0
    assert plan.layers == 18
    assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12
    assert 0.01 < tension(shape) < 0.5  # an outer layer goes a longer way, and cannot slip in this map


def test_a_roll_has_the_turns_it_should_have():
    """Rolled up to a line, its length is that of the spiral: r t - pitch t^2 / 4 pi."""
    roll = {"kind": "roll", "turns": 2.0, "core": 0.010, "layer_gap": 0.002}
    plan, shape, flat = built(SQUARE, roll, element_size=0.01)
    spiral = plan.stages[0].curve.pieces[-1]
    angle = 4.0 * np.pi
    assert spiral.end - spiral.begin == pytest.approx(spiral.radius * angle - spiral.pitch * angle**2 / (4.0 * np.pi))
    assert spiral.radius - spiral.pitch * 2.0 == pytest.approx(0.010 + plan.half)
    assert crossings(shape) == 0
    line = flat[:, 0].max() - (spiral.end - spiral.begin)
    again = built(SQUARE, {**roll, "to": line}, element_size=0.01)[1]
    np.testing.assert_allclose(again.positions, shape.positions, atol=1e-9)
    assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12


def drawn(draw):
    """A bag and its folds at random: one or two directions, lines, gaps, sides, elements of 7 to 20 mm."""
    length, width = draw.uniform(0.5, 0.8), draw.uniform(0.2, 0.4)
    bag = {
        "shape": "rectangular", "length": length, "width": width, "mouth_radius": 0.02,
        "element_size": float(np.exp(draw.uniform(np.log(0.007), np.log(0.02)))),
        "mouth_offset": [draw.uniform(-0.1, 0.1), 0.0],
    }  # fmt: skip
    folds = []
    for across, room in (("x", 0.5 * length - 0.1), ("y", 0.5 * width))[: 1 + (draw.random() < 0.4)]:
        lines = np.cumsum([draw.uniform(0.05, 0.12), *draw.uniform(0.03, 0.1, draw.integers(0, 4))])
        common = {"across": across, "over": bool(draw.random() < 0.7), "layer_gap": draw.uniform(6e-4, 2e-3)}
        sides = str(draw.choice(["both", "low", "high"]))
        folds.append({"kind": "leporello", "sides": sides, "lines": lines[lines < room].tolist(), **common})
        if draw.random() < 0.3:
            folds.append({**HALF, "line": draw.uniform(0.06, 0.1), **common})
    return bag, folds


def drawn_until_it_fits(seed):
    """Element size [m] and what `built` makes of it; the codes of the draws that were refused."""
    draw, codes = np.random.default_rng(seed), set()
    for _ in range(50):
        bag, folds = drawn(draw)
        try:
            return bag["element_size"], built(bag, *folds), codes
        except InputError as refusal:
            codes.add(refusal.code)
    raise AssertionError(codes)


@pytest.mark.parametrize("seed", range(20))
def test_folds_drawn_at_random_do_not_cross(seed):
    size, (plan, shape, flat), refused = drawn_until_it_fits(seed)
    assert refused <= {f"E-GEO-{number:03}" for number in (40, 41, 42, 43)}
    assert crossings(shape) == 0
    assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12
    assert shape.surface.volume(shape.positions) > 0.0
    if len(plan.stages) == 1:
        assert tension(shape) < 1.05 * 0.5 * (plan.half / (0.5 * size)) ** 2


def test_all_but_the_positions_is_that_of_the_flat_bag(monkeypatch):
    """Mass, reference and order of nodes, bit by bit, and the step but for rounding: its sums run over elements, whose
    order is that of their places. The flat bag has the rows of the folds, too."""
    folded = case(TUBE, HALF, HALF)
    monkeypatch.setattr("billow.geometry.folding.fold_plan.FoldPlan.applied", lambda plan, shape: shape)
    build_shape.__globals__["_ready_made"].cache_clear()
    flat = build_model(folded)
    monkeypatch.undo()
    build_shape.__globals__["_ready_made"].cache_clear()
    model = build_model(folded)
    np.testing.assert_array_equal(model.mass, flat.mass)
    np.testing.assert_array_equal(model.surface.triangles, flat.surface.triangles)
    np.testing.assert_array_equal(model.fixed, flat.fixed)
    for one, other in zip(model.fabric.membranes, flat.fabric.membranes, strict=True):
        order, same = np.argsort(one.elements), np.argsort(other.elements)
        np.testing.assert_array_equal(one.reference_inverse[:, order], other.reference_inverse[:, same])
        np.testing.assert_allclose(one.squared_rate[order], other.squared_rate[same], rtol=1e-13)
    assert stable_dt(model, start_state(model)) == pytest.approx(stable_dt(flat, start_state(flat)), rel=1e-13)
    assert np.abs(model.start[model.fixed] - flat.start[model.fixed]).max() == 0.0  # the mouth stays where it was


def test_every_crease_has_one_row_of_nodes_in_both_panels():
    table = case(TUBE, HALF, HALF).bag
    plan, shape = fold_plan(table), build_shape(table)
    flat = plan.unfolded(shape.positions)
    rows = plan.rows(0)
    assert len(rows) == 3  # the first fold's, and the second's through two sheets
    for row in rows:
        on_row = np.abs(flat[:, 0] - row.place) < 1e-9
        front, rear = on_row & (flat[:, 2] > 0.0003), on_row & (flat[:, 2] < 0.0001)
        assert on_row.sum() > 10
        np.testing.assert_allclose(np.sort(flat[front, 1]), np.sort(flat[rear, 1]), atol=1e-12)
        assert not (np.abs(np.abs(flat[:, 0] - row.place) - 0.5 * row.beside) < 0.49 * row.beside).any()


def test_a_mesh_without_rows_on_the_lines_crosses(monkeypatch):
    """What the rows are for."""
    monkeypatch.setattr("billow.geometry.folding.fold_plan.FoldPlan.rows", lambda plan, across: ())
    build_shape.__globals__["_ready_made"].cache_clear()
    shape = build_shape(case(SQUARE, {**LEPORELLO, "first_line": 0.127}).bag)
    build_shape.__globals__["_ready_made"].cache_clear()
    assert crossings(shape) > 10


def test_a_plan_folds_where_it_is_told():
    """A leporello in x: the outline ends at the first lines, plus what a turn is deep less what its arc takes."""
    _, shape, _ = built(SQUARE, LEPORELLO)
    radius, half = 0.0006, 0.0002
    reach = 0.12 - 0.5 * np.pi * radius + radius + half
    assert np.ptp(shape.positions[:, 0]) == pytest.approx(2.0 * reach, abs=1e-9)
    assert np.ptp(shape.positions[:, 1]) == pytest.approx(0.6, abs=1e-12)
    sheets = 4  # the one with the mouth, and three panels of 60 mm on either side
    assert np.ptp(shape.positions[:, 2]) == pytest.approx(2.0 * radius * (sheets - 1) + 2.0 * half, abs=1e-9)


def test_folds_are_varied_by_their_number():
    folded = case(SQUARE, LEPORELLO, {**LEPORELLO, "across": "y"}).vary({"bag.folds.2.panel": 0.08})
    assert [fold.panel for fold in folded.bag.folds] == [0.06, 0.08]
    with pytest.raises(InputError, match="E-CASE-006"):
        folded.vary({"bag.folds.3.panel": 0.08})


def test_a_study_can_vary_a_panel_within_one_topology():
    narrow, wide = (built(SQUARE, {**LEPORELLO, "panel": panel}, element_size=0.01)[1] for panel in (0.058, 0.062))
    np.testing.assert_array_equal(narrow.surface.triangles, wide.surface.triangles)
    assert np.abs(narrow.positions - wide.positions).max() > 0.001


def test_elements_beside_a_wide_turn_end_beyond_it():
    """Three half folds of 4 mm elements: the outer turns are longer than an element to either side of their rows."""
    plan, _, flat = built(TUBE, HALF, HALF, {**HALF, "line": 0.09}, element_size=0.004)
    wide = [row for row in plan.rows(0) if row.beside > 0.004]
    assert len(wide) >= 2
    for row in wide:
        away = np.abs(flat[:, 0] - row.place)
        assert away[away > 1e-9].min() > row.beside - 1e-9


def test_both_panels_have_the_same_nodes_around_the_mouth():
    """A thick stack folded close to the mouth: other elements beside the crease in the rear panel would cut the
    front."""
    bag = {**TUBE, "length": 0.85, "width": 0.243, "element_size": 0.0133, "mouth_offset": [-0.085, 0.0]}
    along = {"kind": "leporello", "lines": [0.05], "sides": "high", "layer_gap": 0.0018}
    _, shape, flat = built(bag, along, {**LEPORELLO, "across": "y", "lines": [0.049, 0.088], "layer_gap": 0.001})
    assert crossings(shape) == 0
    front, rear = (flat[np.abs(flat[:, 2] - z) < 1e-9][:, :2] for z in (flat[:, 2].max(), 0.0))
    np.testing.assert_allclose(front[np.lexsort(front.T.round(9))], rear[np.lexsort(rear.T.round(9))], atol=1e-12)


def test_a_turn_does_not_close_around_a_crease():
    """The elements of the outer turn would cut through the crease that ends inside it."""
    lines = {"kind": "leporello", "lines": [0.08, 0.148, 0.192, 0.258], "sides": "high", "layer_gap": 0.00067}
    bag = {**TUBE, "length": 0.684, "width": 0.377, "element_size": 0.0136, "mouth_offset": [-0.049, 0.0]}
    with pytest.raises(InputError, match="E-GEO-043"):
        built(bag, lines, {**HALF, "line": 0.061, "layer_gap": 0.00067})
