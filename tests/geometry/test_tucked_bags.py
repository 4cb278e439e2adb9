"""A tuck: the rim lies between the panels, four layers where two were, lengths are kept and nothing crosses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_folded_bags import SQUARE, TUBE, built, case, crossings, edges, tension

from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model, require_start_clear
from billow.geometry.folding import tuck
from billow.geometry.folding.fold_plan import panel_side
from billow.geometry.surface import check_closed

TUCK = {"kind": "tuck", "depth": 0.08}
ACROSS = {"kind": "leporello", "across": "y", "lines": [0.12, 0.18]}
DRIVER = {"shape": "driver", "diameter": 0.7, "vents": {"count": 0}, "straps": {"count": 0}}

WAYS = {
    "both sides": (SQUARE, [TUCK]),
    "one side": (SQUARE, [{**TUCK, "sides": "low"}]),
    "along y": (SQUARE, [{**TUCK, "across": "y"}]),
    "round": (DRIVER, [{**TUCK, "depth": 0.06}]),
    "mouth aside": (TUBE, [{**TUCK, "sides": "high"}]),
    "half gap": (SQUARE, [{**TUCK, "layer_gap": 0.0004}]),
}


@pytest.mark.parametrize("size", [0.02, 0.01])
@pytest.mark.parametrize("way", WAYS)
def test_lengths_are_kept_and_nothing_crosses(way, size):
    """Yarns grow only where an outer panel slopes to its rim, by half (3 half)^2 / e^2 over the narrowest element e
    there, and beside the crease, where the inner rims are drawn in, by half the square of that slope."""
    bag, folds = WAYS[way]
    plan, shape, flat = built(bag, *folds, element_size=size)
    assert crossings(shape) == 0
    assert plan.layers == 4
    rise = 0.5 * (3.0 * plan.half / (0.5 * size)) ** 2
    assert tension(shape) < 1.05 * rise + 0.5 * tuck.SLOPE**2
    assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12
    for cut, unfolded, _ in edges(replace(shape, positions=flat * [1.0, 1.0, 0.0])):
        np.testing.assert_allclose(unfolded, cut, atol=1e-12)
    check_closed(shape.surface, shape.positions, "bag")
    assert shape.surface.volume(shape.positions) > 0.0
    require_start_clear(build_model(case(bag, *folds, element_size=size)))


def test_the_rim_lies_where_it_was_pushed_to():
    """Creases at the rim less the depth; the rim as far again inwards, at mid height; from outside to inside four
    layers a quarter of the height apart, and the mouth where it was."""
    plan, shape, flat = built(SQUARE, {**TUCK, "sides": "high"})
    half, arc = plan.half, 0.5 * np.pi * plan.half
    rim = np.abs(flat[:, 0] - 0.3) < 1e-9
    np.testing.assert_allclose(shape.positions[rim, 0], 0.3 - 2.0 * 0.08, atol=1e-12)
    np.testing.assert_allclose(shape.positions[rim, 2], 3.0 * half, atol=half / 50.0)
    assert shape.positions[:, 0].max() == pytest.approx(0.22 - arc + half, abs=1e-12)
    inside = np.abs(shape.positions[:, :2] - [0.18, 0.0]).max(axis=1) < 0.035
    levels = np.unique((shape.positions[inside, 2] / half).round(1))
    np.testing.assert_allclose(levels, [0.0, 2.0, 4.0, 6.0])
    order = shape.positions[inside, 2].round(5).argsort(kind="stable")
    side, back = panel_side(shape, flat)[inside][order], (flat[inside, 0] > 0.22)[order]
    layers = list(dict.fromkeys(zip(side, back, strict=True)))
    assert layers == [(-1.0, False), (-1.0, True), (1.0, True), (1.0, False)]
    assert np.abs(shape.positions[shape.fixed] - flat[shape.fixed]).max() == 0.0


def test_a_passenger_bag_with_side_panels():
    """Tucked, its rims are side panels of 0.16 m between front and rear; its vents ride along."""
    bag, tuck = {"shape": "passenger", "element_size": 0.025}, {**TUCK, "across": "y"}
    plan, shape, flat = built(bag, tuck, {"kind": "leporello", "across": "x", "lines": [0.15, 0.33]})
    assert crossings(shape) == 0
    assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12
    assert np.ptp(shape.positions[:, 1]) == pytest.approx(0.9 - 2.0 * 0.08, abs=0.001)


@pytest.mark.parametrize("bag", [SQUARE, DRIVER], ids=["square", "round"])
@pytest.mark.parametrize("size", [0.02, 0.01])
def test_what_is_tucked_is_folded_across(bag, size):
    lines = {**ACROSS, "lines": [0.12, 0.205]} if bag is DRIVER else ACROSS
    plan, shape, flat = built(bag, {**TUCK, "depth": 0.06}, lines, element_size=size)
    assert crossings(shape) == 0
    assert plan.layers >= 12
    assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12
    assert not plan.keeps_lengths


@pytest.mark.parametrize("seed", range(10))
def test_tucks_drawn_at_random_do_not_cross(seed):
    draw, refused = np.random.default_rng(seed), set()
    for _ in range(20):
        length, width = draw.uniform(0.4, 0.8), draw.uniform(0.25, 0.5)
        bag = {
            "shape": "rectangular", "length": length, "width": width, "mouth_radius": 0.02,
            "element_size": float(np.exp(draw.uniform(np.log(0.007), np.log(0.02)))),
            "mouth_offset": [draw.uniform(-0.05, 0.05), 0.0],
        }  # fmt: skip
        gap = {"layer_gap": draw.uniform(4e-4, 2e-3)}
        folds = [{**TUCK, "depth": draw.uniform(0.03, 0.12), "sides": str(draw.choice(["both", "low"])), **gap}]
        if draw.random() < 0.5:
            folds.append({**ACROSS, "lines": [draw.uniform(0.06, 0.1)], **gap})
        try:
            plan, shape, flat = built(bag, *folds)
        except InputError as refusal:
            refused.add(refusal.code)
            continue
        assert crossings(shape) == 0
        assert np.abs(plan.folded(flat) - shape.positions).max() < 1e-12
        break
    else:
        pytest.fail(f"all refused: {refused}")
    assert refused <= {f"E-GEO-{number:03}" for number in (40, 41, 42, 43)}


def test_inner_rims_that_are_not_drawn_in_cross(monkeypatch):
    """What the slip is for."""
    monkeypatch.setattr(tuck, "SLOPE", -tuck.SLOPE)
    build_shape.__globals__["_ready_made"].cache_clear()
    shape = build_shape(case(SQUARE, TUCK).bag)
    build_shape.__globals__["_ready_made"].cache_clear()
    assert crossings(shape) > 10


@pytest.mark.parametrize(
    ("folds", "code"),
    [
        ([{**TUCK, "depth": 0.14}], "E-GEO-041"),  # the rim would lie on the mouth
        ([{**TUCK, "depth": 0.02}], "E-GEO-041"),  # shallower than an element
        ([TUCK, {"kind": "leporello", "lines": [0.16]}], "E-GEO-043"),  # a crease through the inner sleeve
        ([ACROSS, TUCK], "E-CASE-005"),
        ([TUCK, TUCK], "E-CASE-005"),
    ],
)
def test_tucks_that_cannot_be(folds, code):
    with pytest.raises(InputError, match=code):
        built(SQUARE, *folds)
